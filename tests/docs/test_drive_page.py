"""The tables of the page on real drives hold what the study measures now."""

import pytest

from leadscrew.studies.fsmc_ballscrew.claims_drive import (
    EMPTY,
    FULL,
    HOLDING,
    LONG_S,
    SUB_MICROMETRE,
    inertias,
    said,
    table,
)
from leadscrew.studies.fsmc_ballscrew.driven import DRIVES, Found, errors_um, survivors
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from tests.docs.snippets import ROOT

TEXT = (ROOT / "docs" / "drive_realism.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def loops():
    return Loops()


def rows(first):
    """Cells of the rows of the table whose head begins with this word."""
    lines = TEXT.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {first} |"))
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            return
        yield [cell.strip() for cell in line.strip("|").split("|")]


@pytest.mark.slow
def test_the_table_of_drives_is_the_one_of_the_study(loops):
    found = table(loops)
    measured = [
        [DRIVES[drive].said, *(" / ".join(said(f) for f in found[name, drive]) for name in SUB_MICROMETRE)]
        for drive in DRIVES
    ]
    assert list(rows("drive")) == measured


@pytest.mark.slow
def test_the_settings_that_hold_leave_what_the_page_says(loops):
    measured = [
        [f"`{name}`", DRIVES[drive].said, " / ".join(said(errors_um(loops, name, s, drive)) for s in SINES)]
        for name, drive in HOLDING.items()
    ]
    assert list(rows("controller")) == measured


@pytest.mark.slow
def test_so_many_runs_survive_a_sample_of_delay(loops):
    robust, default, made = (
        survivors(loops, name, "sine_fast", "delay", seconds=LONG_S)
        for name in ("ours.pd_dob_robust", "ours.pd_dob", "ours.pd_dob_delay")
    )
    assert f"{robust} of `ours.pd_dob_robust` and {default} of `ours.pd_dob` stay" in TEXT.replace("\n", " ")
    assert made == 8


def test_the_errors_with_an_empty_table_are_those_of_the_study(loops):
    wide, fast = (
        [said(Found(e, 0.0)) for e in inertias(loops, "ours.pd_dob_robust", s, [FULL, EMPTY])] for s in SINES[1:]
    )
    words = f"goes from {wide[0]} to {wide[1]} and from {fast[0]} to {fast[1]}"
    assert words in TEXT.replace("\n", " ")


def test_every_block_of_the_page_exists():
    from leadscrew import catalogue

    named = [cells[0].strip("`") for cells in rows("block")]
    assert len(named) == 5
    assert all(name in catalogue.BLOCKS or name in catalogue.MAKERS for name in named)
