"""Test moves: inside every limit, told as predicted, what no move can tell, files that other programs read."""

import math
import re
import stat
import subprocess

import numpy as np
import pytest

from leadscrew.identify.excite import Limits, Move, Stroke, check, information, path_of, propose, sampled, write
from leadscrew.identify.excite.belief import keys_of
from leadscrew.identify.excite.files import Machine, reference_csv
from leadscrew.identify.excite.information import columns_of
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused
from tests.identify.excite_beliefs import LIMITS, believed


@pytest.fixture(scope="module")
def whole():
    return propose(LIMITS, believed("mass", "friction", "stribeck", "presliding", "backlash", "delay"))


def test_every_sample_keeps_position_speed_acceleration_and_jerk(whole):
    time, x, v, a, _ = whole.samples
    assert x.min() >= 0.0 and x.max() <= 0.3 and np.abs(v).max() <= 0.2 and np.abs(a).max() <= 2.0
    # Not what the move says of itself: differences of its positions.
    speed = np.diff(x) / 1e-3
    acceleration = np.diff(speed) / 1e-3
    assert np.abs(speed).max() <= 0.2 and np.abs(acceleration).max() <= 2.0
    assert np.abs(np.diff(acceleration) / 1e-3).max() <= 20.0
    assert np.abs(speed - 0.5 * (v[1:] + v[:-1])).max() <= 2e-5
    assert time[-1] <= 90.0 and whole.move.duration <= 90.0
    assert x[0] == x[-1] == pytest.approx(0.15)


def test_both_passes_are_the_same_so_that_a_hold_out_meets_what_the_training_met(whole):
    strokes = [s._replace(rest=0.0) for s in whole.move.strokes]
    half = len(strokes) // 2
    assert strokes[:half] == strokes[half:]
    purposes = {s.purpose for s in strokes}
    assert purposes >= {"sliding", "speeding up", "creeping", "pre-sliding", "lost motion"}
    for purpose in ("sliding", "creeping"):
        ends = np.array([0.15, *(s.end for s in whole.move.strokes)])
        ways = {
            np.sign(b - a)
            for a, b, s in zip(ends[:-1], ends[1:], whole.move.strokes, strict=True)
            if s.purpose == purpose
        }
        assert ways == {-1.0, 1.0}
        assert len({round(s.speed, 9) for s in strokes if s.purpose == purpose}) >= 3


def test_a_sample_outside_a_limit_is_refused_with_its_time_and_value():
    move = Move(0.15, (Stroke(0.25, 0.2, 0.1, "sliding"),), LIMITS)
    seen = sampled(move, 1e-3)
    check(seen, LIMITS)
    for change, said in (
        ({"high": 0.2}, r"position of 200\.\d+ mm at 1\.\d+ s: outside of 0 to 200"),
        ({"speed": 0.1}, r"speed of 10\d\.\d+ mm/s"),
        ({"acceleration": 1.0}, r"acceleration of 10\d\d.* mm/s\^2"),
        ({"jerk": 10.0}, r"jerk of 19600 mm/s\^3"),
    ):
        with pytest.raises(ValueRefused, match=said):
            check(seen, LIMITS._replace(**change), 1000.0, "mm")


def test_the_move_is_the_same_path_in_a_loop_of_ours():
    move = Move(0.15, (Stroke(0.20, 0.1, 0.1, "sliding"), Stroke(0.14, 0.2, 0.2, "sliding")), LIMITS)
    seen, block = sampled(move, 1e-3), path_of(move)
    plan = block.prepare(block.params, 1e-3)
    from leadscrew.references._path import path_xy

    ours = [path_xy(plan, t).x for t in seen.time[::7]]
    for k, name in enumerate(("position", "velocity", "acceleration")):
        assert [m[k] for m in ours] == pytest.approx(1000.0 * getattr(seen, name)[::7], abs=1e-7)


def brute(move, belief, key, step):
    """Response of the position to a change of one parameter by integrating both axes under the same drive."""
    seen = sampled(move, belief.period)
    v, a = seen.velocity, seen.acceleration
    one = belief.values

    def force(at):
        return (
            at["mass"] * a
            + at["offset"]
            + np.sign(v) * at["friction.forward.coulomb"]
            + at["friction.forward.viscous"] * v
        )

    drive, other = force(one), dict(one)
    for k in (key, key.replace("forward", "backward")):
        other[k] = one[k] + step
    h, fine = belief.period, 20
    x = w = 0.0
    found = np.zeros(len(v))
    for k in range(len(v)):
        found[k] = x
        # Deviation from the planned motion: both axes slide the same way, stop together.
        if v[k] == 0.0:
            w = 0.0
            continue
        for _ in range(fine):
            push = drive[k] - other["offset"] - np.sign(v[k]) * other["friction.forward.coulomb"]
            push -= other["friction.forward.viscous"] * (v[k] + w)
            w += h / fine * (push / other["mass"] - a[k])
            x += h / fine * w
    return found / step


def test_the_information_is_that_of_positions_simulated_with_a_parameter_changed():
    # One stroke inside one window that begins at rest: only the start position is free.
    limits = LIMITS._replace(jerk=0.0)
    belief = believed("mass", "friction", "offset", noise=2e-6)
    move = Move(0.15, (Stroke(0.17, 0.1, 0.05, "sliding"),), limits)
    got = information(move, belief)
    seen = sampled(move, 1e-3)
    columns = list(columns_of(belief))
    keys = ["mass", "offset", "friction.forward.coulomb", "friction.forward.viscous"]
    responses = [brute(move, belief, k, 1e-4 * max(abs(belief.values[k]), 1.0)) for k in keys]
    expected = np.zeros((4, 4))
    for first in range(0, len(seen.time), 500):
        part = np.array([r[first : first + 500] for r in responses])
        going = seen.velocity[first] != 0.0
        base = np.ones((1, part.shape[1]))
        if going:
            t = 1e-3 * np.arange(part.shape[1])
            end = np.flatnonzero(seen.velocity[first : first + 500] == 0.0)
            t = np.minimum(t, t[end[0]]) if len(end) else t
            rate = belief.values["friction.forward.viscous"] / 95.0
            base = np.vstack([base, (1.0 - np.exp(-rate * t)) / rate])
        part = part - (part @ np.linalg.pinv(base)) @ base
        expected += part @ part.T / 4e-12
    mine = [columns.index(c) for c in ("mass", "offset", "coulomb", "viscous")]
    assert got.sensor[np.ix_(mine, mine)] == pytest.approx(expected, rel=0.06)


@pytest.mark.slow
def test_a_finer_sensor_a_longer_test_and_a_faster_axis_tell_more():
    def half(key, limits=LIMITS, **more):
        found = propose(limits, believed("mass", "friction", **more))
        return next(p.half for p in found.predicted if p.key == key)

    assert half("mass", noise=1e-3) == pytest.approx(2.0 * half("mass", noise=5e-4), rel=0.01)
    slow = LIMITS._replace(speed=0.02)
    assert half("friction.forward.viscous", slow, noise=1e-4) > 5.0 * half("friction.forward.viscous", noise=1e-4)


def test_what_no_move_within_the_limits_tells_is_said_with_what_would():
    slow = Limits(0.0, 0.01, 0.002, 0.05, 0.0, 10.0)
    found = propose(slow, believed("mass", "friction", force_noise=0.4))
    said = {p.key: p for p in found.predicted}
    viscous = said["friction.forward.viscous"]
    assert viscous.verdict == "not identifiable"
    assert "at the top speed of 2 mm/s it is 0.392 of 20.4 N" in viscous.why and "higher top speed" in viscous.why
    assert said["mass"].verdict != "identifiable" and "4.66 N beside 20 of friction" in said["mass"].why
    coulomb = said["friction.forward.coulomb"]
    assert coulomb.verdict != "identifiable" and "trades with viscous friction, which reaches 0.392 N" in coulomb.why


@pytest.mark.slow
def test_an_offset_beside_friction_by_direction_is_said_to_be_beyond_any_motion():
    found = propose(LIMITS, believed("offset", "friction", symmetric=False))
    offset = next(p for p in found.predicted if p.key == "offset")
    assert offset.verdict == "not identifiable" and math.isinf(offset.half) and "no motion separates them" in offset.why
    assert all(p.verdict == "identifiable" for p in found.predicted if p.key != "offset")


@pytest.mark.slow
def test_a_target_that_is_not_met_by_one_part_of_each_kind_adds_those_that_tell_most():
    loose = propose(LIMITS, believed("mass", "friction", noise=2e-4))
    tight = propose(LIMITS, believed("mass", "friction", noise=2e-4), target_percent=0.25)
    assert sum(tight.parts.values()) > sum(loose.parts.values()) and tight.move.duration > loose.move.duration
    for p, q in zip(tight.predicted, loose.predicted, strict=True):
        assert p.half < q.half


@pytest.mark.parametrize(
    ("limits", "belief", "said"),
    [
        (LIMITS._replace(low=0.3, high=0.0), believed("mass"), "travel 0.3 to 0 m"),
        (LIMITS._replace(speed=0.0), believed("mass"), "top speed = 0"),
        (LIMITS._replace(acceleration=math.nan), believed("mass"), "top acceleration = nan"),
        (LIMITS._replace(jerk=-1.0), believed("mass"), "jerk = -1"),
        (LIMITS._replace(duration=4e3), believed("mass"), r"duration = 4000 s: allowed range is \[1, 3600\]"),
        (LIMITS._replace(duration=1.6), believed("mass"), "the shortest test takes"),
        (LIMITS, believed("mass", mass=0.0), "--guess mass=100"),
        (LIMITS, believed("mass", noise=0.0), "--encoder-step"),
        (LIMITS, believed("stribeck", stribeck_speed=0.0), "--guess stribeck_speed=VALUE"),
        (LIMITS, believed("static", stribeck_speed=0.0), "--guess stribeck_speed=VALUE"),
        (LIMITS, believed("backlash", backlash=0.0), "--guess backlash=VALUE"),
        (LIMITS, believed("mass", coulomb=-1.0), "friction.forward.coulomb = -1.0"),
    ],
)
def test_what_allows_no_test_is_refused_in_a_sentence(limits, belief, said):
    with pytest.raises(ValueRefused, match=said):
        propose(limits, belief)


def test_names_are_keys_or_short_for_several():
    assert keys_of(["delay", "coulomb"]) == ("delay_s", "friction.forward.coulomb", "friction.backward.coulomb")
    with pytest.raises(NameUnknown, match=r"'frction'.*friction"):
        keys_of(["frction"])


def test_the_folder_holds_a_reference_a_program_and_a_recorder_that_agree(tmp_path):
    found = propose(LIMITS._replace(duration=12.0), believed("mass", "friction"))
    write(found, tmp_path / "test", Machine("Z", drive_unit="A"))
    names = {p.name for p in (tmp_path / "test").iterdir()}
    assert names == {"reference.csv", "move.ngc", "record.hal", "record.sh", "proposal.json", "README.md"}
    table = np.loadtxt(tmp_path / "test" / "reference.csv", delimiter=",", skiprows=1)
    assert table[:, 1] == pytest.approx(1000.0 * found.samples.position, abs=1e-8)
    program = (tmp_path / "test" / "move.ngc").read_text()
    ends = [float(x) for x in re.findall(r"^G1 Z([-\d.]+) F", program, re.M)]
    stops = table[np.flatnonzero((table[:-1, 2] != 0.0) & (table[1:, 2] == 0.0)) + 1, 1]
    assert ends[0] == pytest.approx(150.0) and ends[1:] == pytest.approx(stops, abs=1e-6)
    assert "G0" not in program.split() and "G61.1" in program
    hal = (tmp_path / "test" / "record.hal").read_text()
    assert "net z-pos-cmd => sampler.0.pin.0" in hal and hal.index("loadrt") < hal.index("net") < hal.index("addf")
    script = tmp_path / "test" / "record.sh"
    assert script.stat().st_mode & stat.S_IXUSR
    assert subprocess.run(["sh", "-n", script], check=False).returncode == 0
    assert "drive [A]" in script.read_text()
    assert reference_csv(found).startswith("time [s],position [mm]")
    with pytest.raises(ValueRefused, match="axis = 'Q'"):
        write(found, tmp_path / "other", Machine("Q"))
    with pytest.raises(DataError, match="exists already"):
        write(found, tmp_path / "test")


def test_a_move_keeps_a_fiftieth_of_the_travel_away_from_each_end():
    for low, high, reach in ((0.0, 1.0, (0.02, 0.98)), (-3.0, -1.0, (-2.96, -1.04)), (1.0, 2.0, (1.02, 1.98))):
        assert Limits(low, high, 1.0, 1.0).reach == pytest.approx(reach)
