"""The numbers of the page on limit cycles are those that the library gives now."""

import re
from pathlib import Path

import pytest

from leadscrew.analysis.stability.describing import biggest
from leadscrew.studies.npid_xytable import chatter as c
from leadscrew.studies.npid_xytable import chatter_theory as theory
from leadscrew.studies.npid_xytable.runs import Loops

TEXT = (Path(__file__).parents[2] / "docs" / "limit_cycles.md").read_text(encoding="utf-8")
PAGE = " ".join(TEXT.split())


@pytest.fixture(scope="module")
def rows():
    return c.rows_for(Loops())


def test_the_table_of_loads(rows):
    said = [[x.strip() for x in line.strip("|").split("|")] for line in TEXT.splitlines() if re.match(r"\| \d", line)]
    found = []
    for load, size, hz in zip(c.LOADS_UM, rows.table.peak_to_peak_um, rows.table.hz, strict=True):
        if size > c.QUIET_UM:
            one, many = (biggest(theory.predicted(load * c.TAKEN_OVER, many=k)) for k in (False, True))
            cells = [f"{load:g}", f"{size:.2f}", f"{hz:.1f}"]
            for cycle in (one, many):
                cells += [f"{1e3 * cycle.peak_to_peak:.2f}", f"{cycle.frequency_hz:.1f}"]
            found.append(cells)
    assert said == found


def test_the_edges_of_the_hysteresis(rows):
    assert f"chatters from 2.8 um to {theory.fold_um():.1f} um" in PAGE
    assert f"starts at {theory.load_of(3.0):.2f} um only" in PAGE
    assert rows.edges["up_ends"] == pytest.approx(theory.fold_um(), abs=0.15)
    assert rows.edges["down_starts"] == pytest.approx(theory.load_of(3.0), abs=0.1)
    assert rows.kicks[1e-4] < c.QUIET_UM and rows.kicks[1e-3] > 5.0


def test_the_vibration_that_only_the_supply_ends(rows):
    foreseen, simulated = theory.saturated_um(*c.PERTURBED["gain"]), rows.perturbed["gain"][0]
    assert f"{foreseen:.0f} um rms at the table; simulated on a sine of 1 mm: {simulated:.0f} um" in PAGE


def test_limits_of_gain_and_slope():
    assert f"between {theory.threshold_um():.2f} um and 3 um" in PAGE
    assert f"less dead time: {theory.delay_threshold_ms():.3f} ms" in PAGE
    steepest = min(x for x in (k / 1000.0 for k in range(1, 3000)) if theory.slope(x, x) > theory.linear().gain_limit())
    assert f"the gain is then {theory.curve(1e-3 * steepest, steepest) / (1e-3 * steepest):.2f} at most" in PAGE


@pytest.mark.slow
def test_the_gain_behind_the_pid(rows):
    loads, found = rows.behind
    assert f"{found.peak_to_peak_um[loads.tolist().index(6.0)]:.1f} um at 6 um of load" in PAGE
    assert (found.peak_to_peak_um < c.QUIET_UM).sum() == 28
