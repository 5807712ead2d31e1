"""The study as a whole: its loops, its claims, its items and its pictures."""

import csv

import pytest

from leadscrew.catalogue import study
from leadscrew.studies.npid_xytable.runs import Loops
from tests.budget import WHOLE
from tests.studies.contract import WholeStudy
from tests.studies.whole import whole

TABLE = study("npid_xytable")


@pytest.mark.slow
def test_every_controller_runs_under_cutting_and_every_scenario_runs():
    pairs = [(name, "spindle_1000") for name in TABLE.controllers] + [("paper.pid", s) for s in TABLE.scenarios]
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
    first, second = (loops.get("paper.pid", s) for s in ("spindle_1000", "spindle_3000"))
    third = loops.get("ours.pid_ms_185", "constant_load")
    assert second.program is first.program and third.sheet["disturbance.first.amplitude"].default > 0.0


def test_every_item_of_the_paper_has_a_row_that_says_where_it_is_or_why_not():
    with (TABLE.folder / "paper_items.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    names = [row["item"] for row in rows]
    assert len(names) == len(set(names))
    wanted = {f"equation {n}" for n in range(1, 6)} | {"table I", "table II"}
    assert wanted <= set(names)
    assert all(row["where"] or row["status"].startswith("not done: ") for row in rows)


@pytest.fixture(scope="module")
def result():
    return whole(TABLE.name)


@pytest.mark.xdist_group("whole npid_xytable")
class TestWhole(WholeStudy):
    study = TABLE
    missed = frozenset(
        {
            "chatter_m6_describing_size",
            "m4_rows_no_spindle",
            "m4_rows_15mm",
            "m4_rows_15mm_no_spindle",
        }
    )
