"""The numbers on the page of constant cutting force are the study's."""

import re
from pathlib import Path

import pytest

from tests.studies.whole import claims_of

PAGE = (Path(__file__).parents[2] / "docs" / "turning.md").read_text(encoding="utf-8")
TEXT = " ".join(PAGE.split())
NUMBER = re.compile(r"(?<![\w.])[+-]?\d[\d,]*(?:\.\d+)?")

PAPER = {
    "overshoot 48.6": (["falling_overshoot_tfc:.1f", "falling_overshoot_b:.1f"], set()),
    "overshoot 2.7": (["fixed_overshoot_tfc:.1f", "fixed_overshoot_b:.1f"], set()),
    "rise time 0.5": (["fixed_rise_tfc:.2f", "fixed_rise_b:.2f"], set()),
    "steady error 1.7": ([], {"1.5", "2"}),
    "smoother feed": (["rougher:.0f"], set()),
    "roughly chosen rules": (["mc_rules_bad_tfc:.0f", "mc_rules_bad_gpfc:.0f"], {"250"}),
    "equation (11)": (["literal_11_force:.0f"], set()),
    "the product makes": ([], set()),
}
"""Rows of the table beside the paper by how they begin: claims in the order of the text; numbers that say where."""
PREDICTORS = {
    "GM(1,1), reading B": "gpfc_b",
    "straight line through four samples": "line",
    "line through two samples": "two_point",
    "Smith predictor": "smith",
    "GM(1,1) with a model of its residuals": "residual",
    "DGM(1,1)": "dgm",
    "GM(1,1) with the exponential correction": "exponential",
    "GM(1,1), reading A": "gpfc_a",
    "GM(1,1), two samples ahead": "gm_h2",
    "grey Verhulst model": "verhulst",
}
COSTS = {"a cut of 1.5 s": "short", "a cut of 3 s": "long", "ten times the penalty on overshoot": "overshoot"}
BEATEN = {
    "corrected.tfc_stfc": ("tuned_overshoot_tfc", "tuned_rise_tfc", "ff_dip_none", "mc_corrected_tfc_stfc"),
    "ours.constant_force": ("m1_overshoot", "m1_rise", "m2_filtered", "m3_p90"),
}


def table(first: str) -> dict[str, list[str]]:
    """Cells of the table whose first heading begins so, by their first cell."""
    lines = PAGE[PAGE.index(f"| {first}") :].split("\n\n")[0].splitlines()[2:]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {row[0].strip("`"): row[1:] for row in rows}


@pytest.fixture(scope="module")
def m():
    found = {name: c.measured for name, c in claims_of("grey_turning").items()}
    found["rougher"] = 100.0 * (found["activity_steady_s9_b"] / found["activity_steady_s9_tfc"] - 1.0)
    return found


def test_the_tables_have_their_rows():
    assert {key for row in table("the paper") for key in PAPER if row.startswith(key)} == set(PAPER)
    assert len(table("the paper")) == len(PAPER)
    assert {"GM(1,1), reading B", "line through two samples"} < set(table("predictor")) <= set(PREDICTORS)
    assert set(table("cost")) == set(COSTS) and set(table("controller")) == set(BEATEN)


@pytest.mark.slow
@pytest.mark.xdist_group("whole grey_turning")
def test_every_number_beside_the_paper(m):
    for row, (cell,) in table("the paper").items():
        claims, places = next(value for key, value in PAPER.items() if row.startswith(key))
        expected = [format(m[name], digits) for name, digits in (each.split(":") for each in claims)]
        assert [n for n in NUMBER.findall(cell) if n not in places] == expected, row
    first = m["falling_activity_first_b"] / m["falling_activity_first_tfc"]
    assert ("half the activity in the entry" in PAGE) == (0.45 < first < 0.55)


@pytest.mark.slow
@pytest.mark.xdist_group("whole grey_turning")
def test_what_predictors_are_worth(m):
    for row, cells in table("predictor").items():
        assert cells == [f"{m[f'ablation_{plant}_{PREDICTORS[row]}']:+.1f}" for plant in "fn"], row


@pytest.mark.slow
@pytest.mark.xdist_group("whole grey_turning")
def test_what_they_are_worth_under_other_costs(m):
    for row, cells in table("cost").items():
        names = [f"ablation_{plant}_{law}_{COSTS[row]}" for law in ("gpfc_b", "two_point") for plant in "fn"]
        assert cells == [f"{m[name]:+.1f}" for name in names], row


@pytest.mark.slow
@pytest.mark.xdist_group("whole grey_turning")
def test_what_beats_it(m):
    for row, cells in table("controller").items():
        overshoot, rise, stairs, tail = (abs(m[name]) for name in BEATEN[row])
        assert cells == [f"{overshoot:.1f}", f"{rise:.2f}", f"{stairs:.1f}", f"{tail:.1f}"], row


@pytest.mark.slow
@pytest.mark.xdist_group("whole grey_turning")
def test_what_the_text_says_of_random_plants_and_the_guard(m):
    assert f"{m['a10_bad_tfc']:.1f} % are bad" in TEXT and f"{m['a10_bad_gpfc']:.1f} % under the GPFC" in TEXT
    assert f"within {m['guard_hold_20ms']:.0f} ms" in TEXT
