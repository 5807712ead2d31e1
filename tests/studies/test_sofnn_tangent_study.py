"""The study as a whole: its loops, its claims, its items and its pictures."""

import csv

import numpy as np
import pytest

from leadscrew.catalogue import study
from leadscrew.studies.sofnn_tangent import lines
from leadscrew.studies.sofnn_tangent.runs import Loops
from tests.budget import WHOLE
from tests.studies.contract import WholeStudy
from tests.studies.whole import whole

TABLE = study("sofnn_tangent")


def test_every_scenario_runs_and_controllers_of_all_kinds_fit():
    kinds = ("paper.sofnn_pnn", "corrected.sofc", "corrected.fnn", "ours.pid")
    pairs = [(name, "wave_fabric") for name in kinds] + [("ours.pid", s) for s in TABLE.scenarios]
    for name, scenario in pairs:
        assert TABLE.loop(name, scenario).signals["output"] is not None, (name, scenario)


@pytest.mark.slow
def test_every_controller_fits_into_every_scenario():
    for i, name in enumerate(TABLE.controllers):
        for j, scenario in enumerate(TABLE.scenarios):
            if WHOLE or (i + j) % 3 == 0:
                assert TABLE.loop(name, scenario).signals["output"] is not None, (name, scenario)


def test_scenarios_on_different_lines_and_materials_share_a_program():
    loops = Loops()
    first = loops.get("ours.pid", "wave_fabric")
    assert loops.get("ours.pid_fast", "flower_foam").program is first.program
    assert loops.get("ours.pid", "flower_laps").program is first.program


def test_lines_have_the_lengths_that_their_scenarios_run_for():
    for name, length in lines.LENGTHS_MM.items():
        assert lines.shape(name).length * lines.LAPS[name] == pytest.approx(length, abs=1e-3)
        assert abs(lines.samples_of(name) - len(lines.line(name).heading)) <= 1
        assert TABLE.scenarios[f"{name}_fabric"].duration_s == pytest.approx((lines.samples_of(name) + 1) * 0.01)


@pytest.mark.slow
def test_a_cell_has_textures_of_its_own_and_every_controller_meets_the_same():
    loops = Loops()
    mild, strong = (loops.cells(name, runs=3, lines=("wave",)) for name in ("ours.pid_mild", "paper.uncompensated"))
    assert mild.rms.shape == (1, 3, 3) and len(set(mild.rms.ravel())) == 9
    again = Loops().cells("paper.uncompensated", runs=3, lines=("wave",))
    assert np.array_equal(again.rms, strong.rms)
    single = loops.get("paper.uncompensated", "wave_leather").run(9.25, run=3)
    assert single.metrics["rms_error"] == strong.rms[0, 1, 0]


def test_every_item_of_the_paper_has_a_row_that_says_where_it_is_or_why_not():
    with (TABLE.folder / "paper_items.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = " ".join(row["item"] for row in rows)
    assert len(rows) == len({row["item"] for row in rows})
    wanted = ["equation 1", "equation 2", "equation 3", "table 1", *(f"figure {n}" for n in range(1, 8))]
    wanted += [f"step {n}" for n in range(1, 8)]
    assert [w for w in wanted if w not in names] == []
    assert all(row["where"] or row["status"].startswith("not done: ") for row in rows)


@pytest.fixture(scope="module")
def result():
    return whole(TABLE.name)


@pytest.mark.xdist_group("whole sofnn_tangent")
class TestWhole(WholeStudy):
    study = TABLE
    plain_axes = frozenset(
        {"comparison_cells", "comparison_contour", "comparison_equal", "held_rules", "workflow_ratios"}
    )
    least_findings = 10
    missed = frozenset({"m2_mismatch_prior_rms"})
