"""Circles sampled in time: rest, ramps, creep and overlap are left out, play is no encoder jump, and a jump is found.

The circles are generated here; what they must give follows from what was put in: harmonics from the second on leave the
least-squares centre where it is, so that G is their range.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from leadscrew.analysis.circular.diagnosis import LOST, diagnose
from leadscrew.analysis.circular.file import read_circles
from leadscrew.analysis.circular.quantities import quantities
from leadscrew.util.errors import DataError
from tests.budget import some

UM = 1e-3


def recording(
    radius=100.0, feed=3000.0, rate=1000.0, ramp=0.2, dwell=0.0, creep=0.0, feed_in=0.0, sign=1, turns=1.0, start=0.0,
    missing=0.0, noise=0.0, seed=0, deviation=lambda angle: 0.0 * angle,
):  # fmt: skip
    """X and y in mm of a circle that a control recorded: lengths of faults in um, ramp and dwell in s."""
    speed, length = feed / 60.0, radius * (2.0 * math.pi * turns - math.radians(missing))
    ramp = min(ramp, 0.2 * length / speed)
    end = length / speed + ramp
    t = np.arange(0.0, end, 1.0 / rate)
    path = speed * (t - 0.5 * ramp)
    if ramp:
        path = np.where(t < ramp, 0.5 * speed / ramp * t**2, path)
        path = np.where(t > end - ramp, length - 0.5 * speed / ramp * (end - t) ** 2, path)
    rest = int(dwell * rate)
    angle = start + sign * np.concatenate((np.zeros(rest), path / radius, np.full(rest + 1, length / radius)))
    r = radius + UM * deviation(angle)
    x, y = r * np.cos(angle), r * np.sin(angle)
    x[x.size - rest :] += creep * UM * np.linspace(0.0, 1.0, rest)
    if feed_in:
        inwards = np.linspace(radius - feed_in, r[0], max(int(feed_in / speed * rate), 2), endpoint=False)
        x, y = np.append(inwards * np.cos(start), x), np.append(inwards * np.sin(start), y)
    rng = np.random.default_rng(seed)
    return x + noise * UM * rng.normal(size=x.size), y + noise * UM * rng.normal(size=y.size)


def saved(tmp_path, x, y):
    file = tmp_path / "circle.csv"
    np.savetxt(file, np.column_stack((x, y)), delimiter=",", header="x_mm,y_mm", comments="", fmt="%.7f")
    return file


def g_of(test):
    q = quantities(test)
    return (q.ccw or q.cw).circular


def drawn(rng):
    """One recording at random: what it was made with, and the rate limited to 20,000 rows."""
    made = {
        "radius": rng.uniform(10.0, 150.0), "feed": rng.uniform(200.0, 6000.0), "sign": rng.choice([-1, 1]),
        "ramp": rng.choice([0.0, 0.05, 0.2, 0.5]), "dwell": rng.uniform(0.0, 3.0), "creep": rng.choice([0.0, 50.0]),
        "turns": rng.choice([1.0, 1.3, 2.2]), "start": rng.uniform(0.0, 2.0 * math.pi),
        "missing": rng.choice([0.0, 1.0]), "noise": rng.choice([0.0, rng.uniform(0.3, 3.0)]),
    }  # fmt: skip
    made["feed_in"] = rng.choice([0.0, 0.3]) * made["radius"]
    seconds = 2.0 * math.pi * made["radius"] / (made["feed"] / 60.0)
    return {k: v.item() if hasattr(v, "item") else v for k, v in made.items()}, float(
        np.clip(10.0 ** rng.uniform(2.0, 4.0), 400.0 / seconds, 20000.0 / seconds)
    )


@pytest.mark.parametrize("seed", some(range(200), 20))
def test_g_of_a_recording_is_that_of_even_angles_and_nothing_counts_as_a_jump(tmp_path, seed):
    rng = np.random.default_rng(40_000 + seed)
    made, rate = drawn(rng)
    sizes, phases = rng.uniform(2.0, 30.0, 3), rng.uniform(0.0, 2.0 * math.pi, 3)

    def deviation(angle):
        return sum(s * np.cos(n * angle + p) for n, s, p in zip((2, 3, 4), sizes, phases, strict=True))

    x, y = recording(**made, rate=rate, seed=seed, deviation=deviation)
    expected = float(np.ptp(deviation(2.0 * math.pi * np.arange(36000) / 36000)))
    found = g_of(read_circles(saved(tmp_path, x, y), made["radius"], made["feed"]))
    # Noise widens the range of radii, by up to five of its standard deviations at either end.
    assert -0.001 * expected <= found - expected <= 0.001 * expected + 10.0 * made["noise"]


def of_a_table(rng):
    """Deviation with squareness, cyclic error, play and stick motion at the reversals."""
    square, lead, cyclic, play, stick = rng.uniform((-50, 2, 0, 0, 0), (50, 20, 2, 10, 10))
    rise, decay = rng.uniform((0.2, 0.5), (2.0, 5.0))

    def deviation(angle):
        um = 0.5 * square * np.sin(2.0 * angle) + cyclic * np.cos(angle) * np.sin(
            2.0 * math.pi * 50.0 / lead * np.cos(angle)
        )
        for quarter in range(4):
            since = np.degrees(np.mod(angle - quarter * math.pi / 2.0, 2.0 * math.pi))
            um = um + stick * np.where(since < rise, (since / rise) ** 2, np.exp(-(since - rise) / decay))
            um = um + play * (quarter % 2) * (since < 90.0) * np.cos(np.radians(since))
        return um

    return deviation


def jump_found(tmp_path, seed):
    """Whether a recording without a jump is accepted, and refused when an axis loses counts on the last turn."""
    rng = np.random.default_rng(50_000 + seed)
    made, rate = drawn(rng)
    made |= {"creep": 0.0, "feed_in": 0.0}
    x, y = recording(**made, rate=rate, seed=seed, deviation=of_a_table(rng))
    (turn,) = read_circles(saved(tmp_path, x, y), made["radius"], made["feed"]).turns
    which, point = int(rng.integers(2)), 0
    while not point or abs(math.remainder(turn.angle[point] - which * math.pi / 2.0, math.pi)) < math.radians(3.0):
        point = int(rng.uniform(0.1, 0.9) * turn.x_mm.size)
    at = int(np.flatnonzero(np.hypot(x - turn.x_mm[point], y - turn.y_mm[point]) < 1e-6)[-1])
    (x, y)[which][at:] += UM * max(5.0, 8.0 * made["noise"])
    try:
        read_circles(saved(tmp_path, x, y), made["radius"], made["feed"])
    except DataError as error:
        return "an encoder jump" in str(error)
    return False


def test_play_and_glitches_are_no_jump_and_jumps_are_found(tmp_path):
    """Not within 3 degrees of the axis's own reversal, where a jump looks as play does. One in twenty may hide: along
    the path a jump by one step looks as a row that is missing.
    """
    seeds = some(range(100), 10)
    missed = [seed for seed in seeds if not jump_found(tmp_path, seed)]
    assert len(missed) <= len(seeds) // 20, missed


def test_a_perfect_circle_with_ramps_is_accepted(tmp_path):
    test = read_circles(saved(tmp_path, *recording()), 100.0, 3000.0)
    assert g_of(test) < 0.01
    assert any("ramp" in n for n in test.notes())


def test_a_dwell_of_thirteen_thousand_rows_does_not_move_the_centre(tmp_path):
    angle = 2.0 * math.pi * np.arange(3600) / 3600
    r = 100.0 + 0.3 * np.cos(2.0 * angle)
    x, y = r * np.cos(angle), r * np.sin(angle)
    x, y = (np.append(v, np.full(13_000, v[-1])) for v in (x, y))
    test = read_circles(saved(tmp_path, x, y), 100.0)
    assert g_of(test) == pytest.approx(600.0, abs=0.01)
    assert any("13001 of 16600 rows are at rest" in n for n in test.notes())


def test_creep_after_the_turn_does_not_count(tmp_path):
    still, creeping = (
        g_of(read_circles(saved(tmp_path, *recording(dwell=d, creep=c, noise=0.3)), 100.0))
        for d, c in ((0, 0), (2, 50))
    )
    assert creeping == pytest.approx(still, abs=0.6)


def test_a_slow_loop_is_named_and_no_scale(tmp_path):
    """A first-order lag of 2.4618 1/s at 0.5 rad/s draws 98 mm instead of 100."""
    test = read_circles(saved(tmp_path, *recording(radius=98.0, feed=2940.0, noise=0.3)), 100.0, 3000.0)
    faults = diagnose(test)
    assert faults[LOST].um == pytest.approx(-2000.0, abs=0.1)
    assert faults[LOST].more["gain_1_s"] == pytest.approx(2.4618, rel=1e-3)
    assert abs(faults["scale X"].more["ppm"]) < 1.0 and abs(faults["scale Y"].more["ppm"]) < 1.0


def test_a_missing_degree_is_a_note_and_a_missing_centre_is_named(tmp_path):
    x, y = recording(missing=1.0, ramp=0.0, rate=200.0)
    file = saved(tmp_path, x, y)
    assert any("covers 359.1 degrees" in n for n in read_circles(file, 100.0).notes())
    file = saved(tmp_path, x + 350.0, y - 40.0)
    with pytest.raises(DataError, match=r"lies around \(350,-40\) mm.*--centre 350,-40"):
        read_circles(file, 100.0)


def test_sizes_of_many_points_are_those_of_few(tmp_path):
    """The shapes are searched on means, the sizes fitted to all points."""
    table = of_a_table(np.random.default_rng(3))
    few, many = (
        diagnose(read_circles(saved(tmp_path, *recording(rate=rate, noise=0.1, deviation=table)), 100.0))
        for rate in (140.0, 1200.0)
    )
    for name in ("scale X", "cyclic error X"):
        assert many[name].um == pytest.approx(few[name].um, abs=0.05)
