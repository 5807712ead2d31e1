"""The numbers on the page that tells the story of the tangential knife are the study's."""

import re
from pathlib import Path

import pytest

from tests.studies.whole import claims_of, together

pytestmark = together("sofnn_tangent")

PAGE = (Path(__file__).parents[2] / "docs" / "tangent.md").read_text(encoding="utf-8")
PAPER = {
    "the network has 2": (["weights_18:.0f", "weights_25:.0f"], {"2-6-1"}),
    "levels are whole": (["rounding_dead_zone:.1f"], set()),
    "better than without": (
        ["literal_reduction_none:.1f", "literal_lower_than_none:.0f", "contour_favours:.0f"],
        {"9"},
    ),
    "better than rules": (
        ["literal_reduction_fixed:.1f", "literal_lower_than_fixed:.0f", "literal_raises_max:.0f"],
        {"9"},
    ),
    "good adaptive": (["change_literal_gain:.0f"], set()),
    "training off line": (["training_worth:.1f", "mamdani_mean:.3f", "table_fnn_mean:.3f"], set()),
    "the rules are learned": (["recall_share_median:.0f"], set()),
}
"""Rows beside the paper by how they begin: claims in the text, and numbers that say where."""
EQUAL = ("observer", "paper", "pid", "sofnn", "sofc", "fixed")
BEYOND = ("feed_forward_piece_1", "feed_forward_piece_3", "m1_piece_3", "m1_piece_6", "texture_floor_fabric")
NUMBER = re.compile(r"(?<![\w.-])\d+(?:\.\d+)?(?![\w-])")


def cells(first: str) -> list[list[str]]:
    """Rows of the table whose first heading begins so."""
    lines = PAGE[PAGE.index(f"| {first}") :].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


@pytest.fixture(scope="module")
def m():
    return {name: c.measured for name, c in claims_of("sofnn_tangent").items()}


def test_the_rows_beside_the_paper_are_measured(m):
    rows = cells("the paper")
    assert len(rows) == len(PAPER)
    for row, (begin, (names, places)) in zip(rows, PAPER.items(), strict=True):
        assert row[0].startswith(begin)
        shown = {f"{m[n.split(':')[0]]:{n.split(':')[1]}}" for n in names}
        assert set(NUMBER.findall(row[1])) - places - {"2-6-1"} <= shown, row
        assert all(s in row[1] for s in shown), row


def test_the_law_that_is_best_at_equal_effort_stands_first(m):
    shown = [row[1] for row in cells("law")]
    assert shown == [f"{m[f'equal_{name}']:.3f}" for name in EQUAL] == sorted(shown)
    assert f"{m['contour_observer']:.1f} times as far" in PAGE


def test_what_knows_the_line_has_the_deviations_of_the_page(m):
    assert [row[1] for row in cells("controller")] == [f"{m[name]:.2f}" for name in BEYOND]
