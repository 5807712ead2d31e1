"""The study sofnn_tangent as a user meets it: its loops, its items, what is read off a run."""

import math

import numpy as np
import pytest

from leadscrew.catalogue import study
from leadscrew.neural.performance import GOLDEN
from leadscrew.studies import results
from leadscrew.studies.lab import Lab
from leadscrew.studies.sofnn_tangent import scenarios
from leadscrew.studies.sofnn_tangent.claims import changed, changed_deviation
from leadscrew.studies.sofnn_tangent.cuts import NONE, PID, PNN, Recall, cells, stays_within
from leadscrew.studies.sofnn_tangent.experiments import _answer
from leadscrew.studies.sofnn_tangent.laws import folded, jumps, passed_areas, sets_of
from tests.budget import WHOLE
from tests.studies.tangent_lab import lab

STUDY = study("sofnn_tangent")


# ---- loops
def test_every_scenario_runs_and_controllers_of_all_kinds_fit():
    kinds = ("paper.sofnn_pnn", "corrected.sofc", "corrected.fnn", "ours.pid")
    pairs = [(name, "wave_fabric") for name in kinds] + [("ours.pid", s) for s in STUDY.scenarios]
    for name, scenario in pairs:
        assert STUDY.loop(name, scenario).signals["output"] is not None, (name, scenario)


@pytest.mark.slow
def test_every_controller_fits_into_every_scenario():
    for i, name in enumerate(STUDY.controllers):
        for j, scenario in enumerate(STUDY.scenarios):
            if WHOLE or (i + j) % 3 == 0:
                assert STUDY.loop(name, scenario).signals["output"] is not None, (name, scenario)


def test_scenarios_on_different_lines_and_materials_share_a_program():
    """Otherwise the study takes minutes, as each program is compiled."""
    first = lab().loop("ours.pid", "wave_fabric").program
    assert lab().loop("ours.pid_fast", "flower_foam").program is first
    assert lab().loop("ours.pid", "flower_laps").program is first


def test_lines_have_the_lengths_that_their_scenarios_run_for():
    for name, length in scenarios.LENGTHS_MM.items():
        assert scenarios.shape(name).length * scenarios.LAPS[name] == pytest.approx(length, abs=1e-3)
        assert abs(scenarios.samples_of(name) - len(scenarios.line(name).heading)) <= 1
        assert STUDY.scenarios[f"{name}_fabric"].duration_s == pytest.approx((scenarios.samples_of(name) + 1) * 0.01)


def test_a_cell_has_textures_of_its_own_and_every_controller_meets_the_same():
    mild, strong = (cells(lab(), name, runs=3, lines=("wave",)) for name in ("ours.pid_mild", NONE))
    assert mild.rms.shape == (1, 3, 3) and len(set(mild.rms.ravel())) == 9
    again = cells(Lab(STUDY), NONE, runs=3, lines=("wave",))
    assert np.array_equal(again.rms, strong.rms)
    single = lab().loop(NONE, "wave_leather").run(9.25, run=3)
    assert single.metrics["rms_error"] == strong.rms[0, 1, 0]


def test_a_change_of_material_leaves_the_first_half_as_it_was():
    e = changed_deviation(lab(), PID, "flower")[0]
    plain = lab().run(PID, "flower_fabric")["actual.deviation"][1 : e.size + 1]
    half = e.size // 2
    assert np.array_equal(plain[:half], e[:half]) and not np.array_equal(plain[half + 5 :], e[half + 5 :])
    assert changed(lab(), PID, "flower").after > 1.2 * changed(lab(), PID, "flower").before


# ---- the paper
def test_every_numbered_part_of_the_paper_is_an_item():
    text = (STUDY.folder / "paper_items.csv").read_text(encoding="utf-8")
    items = {line.split(",")[0] for line in text.splitlines()}
    wanted = [f"figure {i}" for i in range(1, 8)] + [f"equation {i}" for i in range(1, 4)]
    wanted += [f"step {i}" for i in range(1, 8)] + ["table 1", "area I", "area II", "area III"]
    assert {*wanted, "conclusion 1", "conclusion 2"} <= items and len(text.splitlines()) == 111


def test_the_verdicts_of_the_key_claims_are_those_that_follow_from_their_numbers():
    found = results.evaluate(STUDY, key=True)
    verdicts = {c.id.removeprefix("sofnn_tangent."): c.verdict for c in found.claims}
    assert verdicts["cells_better_than.nothing"] == "reproduced"
    assert verdicts["cells_better_than.fixed_rules"] == verdicts["change_by_learning"] == "reproduced with a change"
    assert verdicts["cells_memorised"] == "not reproduced"


# ---- worked by hand
def test_the_set_of_a_level_is_the_nearest_and_half_way_it_is_both():
    names = [sets_of(v) for v in (-2.0, 0.0, 2.71, 3.0, -2.63, -0.56, 9.0)]
    assert names == ["NS", "ZO", "PS", "PS or PM", "NS", "ZO", "PB"]


def test_areas_are_told_by_the_signs_of_deviation_and_rate():
    e = np.array([-5.0, -3.0, -1.0, 0.5, 0.8, 0.6, 0.2, -0.1])
    ec = np.array([-1.0, 0.5, 0.8, 0.9, 0.3, -0.2, -0.3, -0.3])
    assert passed_areas(e, ec) == ["I", "II", "III"]
    assert passed_areas(np.full(5, -1.0), np.full(5, 0.1)) == ["I"]
    assert passed_areas(np.full(5, -1.0), np.full(5, -0.1)) == []


def test_an_angle_folded_to_the_half_circle_jumps_where_it_passes_the_vertical():
    heading = np.array([80.0, 88.0, 92.0, 100.0, 92.0, 88.0, 45.0])
    assert folded(heading) == pytest.approx([80.0, 88.0, -88.0, -80.0, -88.0, 88.0, 45.0])
    assert jumps(folded(heading)) == 2 and jumps(heading) == 0
    assert jumps(folded(np.linspace(0.0, 720.0, 1000))) == 4


def test_the_time_to_stay_within_a_band_is_that_after_the_last_sample_outside():
    row = np.array([9.0, 3.0, 1.0, -2.5, 1.9, 0.0])
    assert stays_within(row, 2.0) == 4 and stays_within(row, 2.0, since=4) == 0
    assert math.isnan(stays_within(row[:4], 2.0))


def test_a_step_response_worked_by_hand():
    """Half a second of rest, then -4, -2, -1, 0.5, -0.1 deg and rest: settled after the fourth sample."""
    e = np.concatenate([np.full(50, 9.0), [-4.0, -2.0, -1.0, 0.5, -0.1], np.zeros(20)])
    assert _answer(e, 50) == pytest.approx((0.076, 0.04))
    assert math.isinf(_answer(np.concatenate([np.zeros(50), np.full(50, -4.13)]), 50)[1])


def test_the_share_that_is_kept_counts_from_the_held_prior():
    assert Recall(1.16, 1.00, 0.46, 0.84).kept == pytest.approx(100.0 * 16.0 / 54.0)


def test_a_network_given_to_the_papers_controller_is_the_one_that_corrects():
    from leadscrew.studies.sofnn_tangent.claims import with_net

    pushed = GOLDEN._replace(out_bias=0.03)
    loop = lab().loop(PNN, "straight").using(with_net(pushed))
    assert loop.blocks["controller"].params.net.out_bias == 0.03
