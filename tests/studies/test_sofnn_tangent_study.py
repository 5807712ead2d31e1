"""The study sofnn_tangent as a user meets it: its loops, its items, what is read off a run."""

import math

import numpy as np
import pytest

from leadscrew.resolve import study
from leadscrew.studies.lab import Lab
from leadscrew.studies.sofnn_tangent import scenarios
from leadscrew.studies.sofnn_tangent.claims import changed, changed_deviation
from leadscrew.studies.sofnn_tangent.cuts import NONE, PID, cells
from leadscrew.studies.sofnn_tangent.experiments import _answer
from leadscrew.studies.sofnn_tangent.laws import folded, jumps, passed_areas, sets_of
from tests.budget import WHOLE
from tests.studies.tangent_lab import lab

STUDY = study("sofnn_tangent")


# ---- loops
def test_controllers_and_scenarios_fit():
    kinds = list(STUDY.controllers) if WHOLE else ["paper.sofnn_pnn", "corrected.sofc", "corrected.fnn"]
    for name, scenario in [(k, "wave_fabric") for k in kinds] + [("ours.pid", s) for s in STUDY.scenarios]:
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
    single = lab().loop(NONE, "wave_leather").run(9.25, replicate=3)
    assert single.metrics["rms_error"] == strong.rms[0, 1, 0]


def test_a_change_of_material_leaves_the_first_half_as_it_was():
    e = changed_deviation(lab(), PID, "flower")[0]
    plain = lab().run(PID, "flower_fabric")["actual.deviation"][1 : e.size + 1]
    half = e.size // 2
    assert np.array_equal(plain[:half], e[:half]) and not np.array_equal(plain[half + 5 :], e[half + 5 :])
    assert changed(lab(), PID, "flower").after > 1.2 * changed(lab(), PID, "flower").before


# ---- the paper
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


def test_a_step_response_worked_by_hand():
    """Half a second of rest, then -4, -2, -1, 0.5, -0.1 deg and rest: settled after the fourth sample."""
    e = np.concatenate([np.full(50, 9.0), [-4.0, -2.0, -1.0, 0.5, -0.1], np.zeros(20)])
    assert _answer(e, 50) == pytest.approx((0.076, 0.04))
    assert math.isinf(_answer(np.concatenate([np.zeros(50), np.full(50, -4.13)]), 50)[1])
