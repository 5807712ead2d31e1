"""The page on the force guard: its tables hold what the study measures now, its lines are those of the example."""

import re
from pathlib import Path

import numpy as np
import pytest

from leadscrew.kernel.sheet import entries
from leadscrew.studies.grey_turning import guarding
from leadscrew.studies.grey_turning.runs import Loops

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "force_guard.md"


@pytest.fixture(scope="module")
def loops():
    return Loops()


def table(header):
    """Cells of the rows of the table that begins with a header."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith(header))
    for line in lines[at + 2 :]:
        if not line.startswith("|"):
            return
        yield [c.strip() for c in line.strip("|").split("|")]


def number(cell):
    return float(re.match(r"-?[\d.]+", cell)[0])


def test_the_parameters_and_their_defaults_are_those_of_the_block():
    said = {row[0].strip("`"): number(row[1]) for row in table("| parameter |")}
    own = [e for e in entries(guarding.SLOW_GUARD.params) if not e.key.startswith("inner.")]
    assert said == {e.key: float(e.default) for e in own}


@pytest.mark.slow
def test_the_latencies_are_those_of_the_study(loops):
    spots = guarding.doubling(loops)
    late = spots.held() - spots.crossed()
    force = spots.run["actual.force"][:, round(1e3 * guarding.SPOT_S) - 100 :].max(axis=1) / (0.01 * guarding.FORCE_N)
    rows = list(table("| lathe |"))
    assert len(rows) == 4
    for row, case in zip(rows, guarding.CASES, strict=False):
        assert (row[0], row[1]) == (case.machine.replace("_f", " F").replace("_n", " N"), f"every {case.looks} ms")
        mine = spots.of(case)
        dead = 20 if case.machine == "plant_n" else 0
        found = [late[mine].max() + dead, *(np.max(spots.slowed(s)[mine]) for s in (0.5, 0.05)), force[mine].mean()]
        assert [number(c) for c in row[2:]] == [round(float(x)) for x in found], row
    free = force[spots.of(guarding.CASES[4])].mean()
    assert f"Without guard the peak is {free:.0f} % on plant F" in PAGE.read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_broken_load_cells_do_what_the_table_says(loops):
    found = guarding.broken(loops)
    rows = list(table("| fault |"))
    assert [r[0] for r in rows] == [f.name for f in guarding.FAULTS]
    for row, held, feed, force in zip(rows, found.held_ms, found.feed, found.force, strict=True):
        ms = "ms" if held.max() < 100 else "s"
        said = (
            "never" if np.isnan(held).any() else f"{held.max():.0f} ms" if ms == "ms" else f"{held.max() / 1e3:.0f} s"
        )
        assert row[1:4] == [said, f"{feed.max():.0f} mm/min", f"{force.max():.0f} N"], row


@pytest.mark.slow
def test_frozen_load_cells_do_what_the_table_says(loops):
    found = guarding.frozen(loops)
    rows = list(table("| cell stands at |"))
    assert [number(r[0]) for r in rows] == [round(100 * x) for x in guarding.FROZEN_AT]
    for row, held, feed in zip(rows, found.held_s, found.feed, strict=True):
        said = "never" if np.isnan(held).any() else f"{held.min():.1f} to {held.max():.1f} s"
        assert row[1:] == [said, f"{feed.max():.0f} mm/min"], row
    assert f"{guarding.doubted(loops)[0]} of {guarding.doubted(loops)[1]} draws" in PAGE.read_text(encoding="utf-8")


def test_the_lines_for_linuxcnc_are_those_of_the_example():
    text = PAGE.read_text(encoding="utf-8")
    block = next(b for b in re.findall(r"```text\n(.*?)```", text, re.S) if "net override" in b)
    example = (ROOT / "examples" / "turning_guard.hal").read_text(encoding="utf-8").splitlines()
    assert [line for line in block.splitlines() if line not in example] == []


@pytest.mark.slow
def test_noise_holds_the_feed_as_often_as_the_page_says(loops):
    held = guarding.for_nothing(loops)
    minutes = guarding.QUIET * guarding.QUIET_S / 60.0
    said = f"{held[2, 1]:.0f} times in {minutes:.1f} min"
    assert held[:2].sum() == 0 and said in PAGE.read_text(encoding="utf-8") and held[2, 2] == 0
