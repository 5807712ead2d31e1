"""Claims about the controller that learns its friction: that they are made, and what they rest on."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from leadscrew.plants.ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.beaten import OURS, Runs, slip_foreseen_wrong, wander
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from tests.studies.whole import claims_of

PAGE = Path(__file__).parents[2] / "docs" / "friction_compensation.md"


def test_a_slip_foreseen_half_a_step_wrong_is_the_momentum_that_its_damping_leaves():
    """Speed ``c dx / J`` at once, ``c`` the damping of the last element; then friction 1080 1/s slows it down."""
    slip = slip_foreseen_wrong(5.0)
    damping = math.sqrt(1e5) * 9802.0 / 1e5
    speed = damping * 5e-6 / TRAVEL_MM_PER_RAD / INERTIA
    rate = 0.4 / INERTIA
    assert slip.travel == pytest.approx(1e3 * TRAVEL_MM_PER_RAD * 2.0 * 0.3189 * 6.24 / 9802.0, rel=1e-6)
    free = [1e3 * TRAVEL_MM_PER_RAD * speed * -math.expm1(-rate * t) / rate for t in (2.5e-4, 5e-4)]
    assert 0.6 * free[0] < slip.one < free[0] and 0.6 * free[1] < slip.two < free[1]
    assert slip_foreseen_wrong(0.0).two < 1e-3


def test_the_path_that_never_repeats_has_the_speed_and_acceleration_of_its_position():
    p, h = wander.params, 1e-5
    for t in (0.3, 7.1, 33.3):
        before, now, after = (wander.step(p, t + k * h) for k in (-1, 0, 1))
        assert (after.position - before.position) / (2 * h) == pytest.approx(now.velocity, abs=1e-6)
        assert (after.velocity - before.velocity) / (2 * h) == pytest.approx(now.acceleration, abs=1e-5)


@pytest.mark.slow
def test_peaks_are_counted_around_reversals_and_not_at_the_start():
    runs = Runs(Loops())
    e = np.abs(runs.error(OURS, "sine_fast"))
    peaks = runs.by_reversal(OURS, "sine_fast")
    assert len(peaks) == 24
    assert peaks[0] == e[200:2000].max() and peaks[5] == e[10000:12000].max()
    assert np.abs(runs.error(OURS, "sine_fast"))[0] == e[0]


@pytest.fixture(scope="module")
def claims():
    found = claims_of("fsmc_ballscrew").items()
    return {name.removeprefix("beaten_"): c for name, c in found if name.startswith("beaten_")}


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_what_is_required_holds(claims):
    assert [name for name, c in claims.items() if c.kind == "required" and not c.passed] == []
    assert all(c.verdict == "cannot be checked" and c.paper is None for c in claims.values())


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_the_moonshots_that_are_reached_stay_reached(claims):
    """Peaks on three truths and both circles; on Maxwell slip they are not, as the bound says."""
    missed = {name for name, c in claims.items() if c.kind == "moonshot" and not c.passed}
    assert missed == {"gms_sine_slow", "gms_sine_wide", "gms_sine_fast"}
    assert sum(c.kind == "moonshot" for c in claims.values()) == 14


@pytest.mark.slow
@pytest.mark.xdist_group("whole fsmc_ballscrew")
def test_the_page_tells_the_numbers_of_the_claims(claims):
    rows = re.findall(r"^\| (\w+) \| ([0-9.]+) \|$", PAGE.read_text(), re.MULTILINE)
    assert len(rows) == 9
    for name, told in rows:
        assert claims[name].measured == pytest.approx(float(told), rel=0.05), name
