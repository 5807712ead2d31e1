"""The numbers of the page on constant force are what the study measures now."""

from pathlib import Path

import numpy as np
import pytest

from leadscrew.studies.grey_turning.beyond import BEST, NAMES, SLOW_ENTRY, TRIED, beyond_of, high, iae_change
from leadscrew.studies.grey_turning.runs import Loops

PAGE = Path(__file__).parents[2] / "docs" / "constant_force.md"
TABLE = ("tfc", "tfc_ff", "gain_normalised", "inversion", "inversion_cautious", "constant_force")


@pytest.fixture(scope="module")
def found():
    return beyond_of(Loops())


def rows(columns):
    """Rows of the page's tables with so many columns, by what stands first."""
    cells = (line.split("|") for line in PAGE.read_text(encoding="utf-8").splitlines())
    return {c[1].strip(" `"): [x.strip() for x in c[2:-1]] for c in cells if len(c) == columns + 2}


def measured(found, name):
    """A controller in the first table: entry, stairs, and the 300 draws, on plant F."""
    entry, drawn, tfc = found.entry(name), found.drawn(name), found.drawn("tfc")
    if name == "tfc_ff":
        steps = found.stairs(name, "plant_f_radial", TRIED).of(BEST)
    else:
        steps = found.stairs(name, "plant_f_radial").of(0)
    first = f"{np.mean(entry.reading.overshoot):.2f}", f"{np.mean(entry.reading.rise_s):.3f}"
    stairs = f"{steps.worst:.1f} / {steps.true_worst:.1f}"
    change = "" if name == "tfc" else f"{iae_change(drawn, tfc):+.0f}"
    return [*first, f"{entry.peak.mean():.1f}", stairs, f"{high(drawn):.1f}", f"{drawn.bad.sum()}", change]


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLE)
def test_the_table_of_the_page_is_measured(found, name):
    assert rows(8)[NAMES[name]] == measured(found, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tfc", "tfc_ff", "constant_force"])
def test_iron_and_the_slow_entry_are_measured(found, name):
    iron, slow = found.entry(name, "plant_f_iron"), found.entry(name, scenario=SLOW_ENTRY)
    read = [v for e in (iron, slow) for v in (np.mean(e.reading.overshoot), e.peak.mean(), np.mean(e.reading.rise_s))]
    assert rows(5)[NAMES[name]] == [
        f"{read[0]:.1f} / {read[1]:.1f}", f"{read[2]:.2f}", f"{read[3]:.1f} / {read[4]:.1f}", f"{read[5]:.2f}"
    ]  # fmt: skip


@pytest.mark.slow
def test_the_metal_removal_of_the_page_is_measured():
    from leadscrew.studies.grey_turning.removal import OURS, Removal

    text, accounts = " ".join(PAGE.read_text(encoding="utf-8").split()), Removal().accounts("falling")
    for name in (OURS, "corrected.tfc_stfc", "corrected.gpfc_b_sg"):
        assert f"{accounts[name].gain:.2f} (`{name}`)" in text, name
