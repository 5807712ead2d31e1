"""The study as a whole: its loops, its claims, its items and its pictures."""

import csv

import pytest

from leadscrew.catalogue import study
from leadscrew.studies.grey_turning.runs import Loops
from tests.budget import WHOLE
from tests.studies.contract import WholeStudy, plain
from tests.studies.whole import whole

TABLE = study("grey_turning")


def test_some_controllers_run_at_a_fixed_depth_and_every_scenario_runs():
    kinds = ("paper.gpfc_printed_s9", "corrected.tfc_s6", "ours.smith_f", "ours.tfc_ff", "ours.constant_force")
    pairs = [(name, "fig6_fixed_depth") for name in kinds] + [("corrected.tfc_s6", s) for s in TABLE.scenarios]
    for name, scenario in pairs:
        assert TABLE.loop(name, scenario).signals["output"] is not None, (name, scenario)


@pytest.mark.slow
def test_every_controller_fits_into_scenarios_of_all_kinds():
    for i, name in enumerate(TABLE.controllers):
        for j, scenario in enumerate(TABLE.scenarios):
            if WHOLE or (i + j) % 3 == 0:
                assert TABLE.loop(name, scenario).signals["output"] is not None, (name, scenario)


def test_loops_that_differ_in_values_share_a_program():
    loops = Loops()
    first = loops.get("corrected.tfc_s6", "fig6_fixed_depth")
    second = loops.get("corrected.tfc_s9", "fig9_falling_depth", machine="plant_n")
    assert second.program is first.program and second.sheet["plant.depth.steps"].default == 3


def test_every_item_of_the_paper_has_a_row_that_says_where_it_is_or_why_not():
    with (TABLE.folder / "paper_items.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = " ".join(row["item"] for row in rows)
    assert len(rows) == len({row["item"] for row in rows})
    wanted = ["equation 1", "equations 2 to 8", *(f"equation {n}" for n in (9, 10, 11, 12, 15, 16, 17, 18)), "13, 14"]
    wanted += ["table 1", *(f"figure {n}" for n in (1, 2, 3, 4, 5, 6, 7, 8, 9, 11)), "figure 10a", "figures 10b, 10c"]
    assert [w for w in wanted if w not in names] == []
    assert all(row["where"] or row["status"].startswith("not done: ") for row in rows)


@pytest.fixture(scope="module")
def result():
    return whole(TABLE.name)


@pytest.mark.xdist_group("whole grey_turning")
class TestWhole(WholeStudy):
    study = TABLE
    plain_axes = frozenset({"ablation", "one_step_errors"})
    least_findings = 10


@pytest.mark.slow
@pytest.mark.xdist_group("whole grey_turning")
def test_fitted_numbers_say_so_and_the_paper_s_rows_have_verdicts(result):
    claims = plain(TABLE, result.claims)
    for name in ("falling_overshoot_tfc", "falling_overshoot_b", "fixed_overshoot_tfc", "fixed_overshoot_b"):
        assert claims[name].basis == "fitted to this number" and claims[name].verdict == "reproduced with change"
    for name in ("fixed_rise_b", "fixed_rise_gain", "fixed_steady_b", "literal_11_breaks", "same_first_2_s"):
        assert claims[name].verdict == "not reproduced", name
