"""Figure 11 of the paper: rough rules with and without prediction."""

import numpy as np
import pytest
from turning_oracle import Fuzzy, Lathe, run
from turning_runs import reproduction

from leadscrew.controllers.grey_fuzzy.rule_tables import TABLES
from leadscrew.studies.grey_turning.claims_rough import rough_claims, settling_s
from leadscrew.studies.grey_turning.figures_rough import rough_pictures
from leadscrew.studies.grey_turning.reproduction import Cuts, Grid

WEAK = """
-3 -3 -3 -3 -3 -2 -2
-3 -3 -2 -2 -2 -1 -1
-2 -2 -1 -1 -1  0  0
-1 -1  0  0  0  1  1
 0  0  1  1  1  2  2
 1  1  2  2  2  3  3
 2  2  3  3  3  3  3"""
"""clip(round(i + 0.34 j), -3, 3), worked by hand."""
RULES = [[int(x) for x in row.split()] for row in WEAK.strip().splitlines()]


@pytest.fixture(scope="module")
def found():
    return reproduction()


@pytest.fixture(scope="module")
def claims(found):
    return {c.id.removeprefix("grey_turning."): c for c in rough_claims(found.loops, found)}


def test_the_weak_table_is_the_one_worked_by_hand():
    np.testing.assert_array_equal(TABLES["weak_ec"], RULES)


@pytest.mark.slow
@pytest.mark.parametrize(("law", "reading"), [("tfc", ""), ("b", "B")])
def test_a_second_program_finds_the_same_contrast(found, law, reading):
    theirs = run(Fuzzy((28.0, 15.4, 0.0214), reading, RULES), 3.0, Lathe())["y"]
    late = 100.0 * np.abs(theirs[-50:] - 150.0).mean() / 150.0
    ours = found.fixed[f"weak_{law}"].steady()
    assert abs(late - ours.mean()) < 4.0 * ours.std()


def test_all_that_is_required_is_met(claims):
    assert [(k, c.measured, c.target) for k, c in claims.items() if c.kind == "required" and not c.passed] == []
    assert [k for k, c in claims.items() if c.paper is None and c.verdict != "cannot be checked"] == []


def test_what_was_picked_for_its_contrast_is_said_to_be(claims):
    for name in ("rough_rules", "rough_weak_overshoot_tfc", "rough_weak_steady_b"):
        assert claims[name].basis == "fitted to this number", name
    assert "picked" in claims["rough_rules"].reason and claims["rough_rules"].verdict == "reproduced with change"


def test_a_response_has_settled_from_its_last_sample_outside_the_band():
    y = np.array([[0.0, 150.0, 160.0, 151.0, 149.0], [150.0] * 5])
    cuts = Cuts(y, y, y, y, 0.5)
    np.testing.assert_allclose(settling_s(cuts), [1.5, 0.0])


def test_a_pair_is_bad_by_overshoot_or_by_steady_error():
    grid = Grid(
        ("t",), ("a", "b", "c"), {"tfc": np.array([[31.0, 5.0, 5.0]])}, {"tfc": np.array([[0.0, 6.0, 4.0]])}, {}
    )
    np.testing.assert_array_equal(grid.bad("tfc"), [[True, True, False]])


def test_counts_of_the_grid_add_up(found, claims):
    t, b = found.grid.bad("tfc"), found.grid.bad("b")
    assert claims["rough_grid_bad_tfc"].measured == t.sum()
    assert t.sum() - b.sum() == claims["rough_grid_rescued"].measured - claims["rough_grid_spoiled"].measured


def test_pictures_of_figure_11_can_be_drawn(found):
    for picture in rough_pictures(found.loops, found):
        assert picture.draw().axes and picture.caption
