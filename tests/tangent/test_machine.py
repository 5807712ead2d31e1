"""The simulated cutter: the process of the study's loop, by hand on straight lines, and geometry of the cut line."""

import math

import numpy as np
import pytest

from leadscrew.paths import shapes
from leadscrew.paths.path import Path
from leadscrew.paths.segments import Line
from leadscrew.tangent import machine
from leadscrew.tangent.machine import Scan, marks_of, scanned
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import Stroke, Table, strokes_of
from leadscrew.util.errors import ValueRefused

PLAIN = Settings()


def straight(angle=0.0, table=None):
    a = math.radians(angle)
    path = Path([Line((0.0, 0.0), (200.0 * math.cos(a), 200.0 * math.sin(a)))])
    return Stroke(path, path.length, **({} if table is None else {"table": table}))


def test_on_a_straight_line_what_is_left_is_bias_and_fibre_worked_by_hand():
    (cut,) = machine.cut([straight(30.0)], PLAIN, "leather", seed=None)
    steady = -(0.4 * math.sin(math.radians(60.0)) + 0.8)
    assert cut.error[-1] == pytest.approx(14.0 * math.tanh(steady / 14.0), abs=1e-6)
    assert cut.seconds == pytest.approx(4.0) and cut.travel[-1] == pytest.approx(200.0)
    drift = math.hypot(cut.x[-1] - 200.0 * math.cos(math.pi / 6), cut.y[-1] - 100.0)
    assert drift == pytest.approx(200.0 * math.radians(-steady), rel=0.01) == cut.distance[-1]


def test_an_offset_turns_the_cut_by_the_gain_of_the_material_from_the_plunge_on():
    table = Table(np.zeros(1), np.full(1, 4.0))
    free, turned = (machine.cut([straight(0.0, t)], PLAIN, "foam", seed=None)[0] for t in (None, table))
    assert turned.error - free.error == pytest.approx(np.full(free.error.size, 3.0))


def test_the_cut_line_has_the_tangent_that_it_is_said_to_have():
    (cut,) = machine.cut(strokes_of([shapes.wave()], PLAIN), PLAIN, "foam", seed=2)
    slope = np.degrees(np.arctan2(np.diff(cut.y), np.diff(cut.x)))
    middle = 0.5 * (cut.heading[1:] + cut.heading[:-1])
    assert np.abs((slope - middle + 180.0) % 360.0 - 180.0).max() < 0.02
    assert np.hypot(np.diff(cut.x), np.diff(cut.y)).sum() == pytest.approx(cut.travel[-1], rel=1e-4)


def test_it_is_the_process_of_the_digest_s_golden_run():
    """Section 6: wave, fabric, no noise, no control: 1.1797 deg rms, 2.9196 at most, e[200] = 1.3751."""
    (cut,) = machine.cut(strokes_of([shapes.wave()], PLAIN), PLAIN, "fabric", seed=None)
    assert math.sqrt(np.mean(cut.error[:923] ** 2)) == pytest.approx(1.1797, rel=1e-3)
    assert np.abs(cut.error).max() == pytest.approx(2.9196, rel=1e-3)
    assert cut.error[200] == pytest.approx(1.3751, rel=1e-3)


def test_a_piece_is_the_same_with_its_seed_and_another_with_another():
    runs = [machine.cut([straight()], PLAIN, seed=k)[0].error for k in (1, 1, 2)]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert np.std(runs[0] - runs[2]) > 0.1
    assert np.std(runs[0][50:]) == pytest.approx(0.2, abs=0.08)


def test_a_lowered_feed_takes_its_time():
    slow = Settings(swivel=100.0)
    (cut,) = machine.cut(strokes_of([shapes.rounded_rectangle()], slow), slow, seed=None)
    assert cut.seconds == pytest.approx(240.0 / 50.0 + 4 * 0.9, rel=1e-3)


def test_a_scan_has_the_noise_and_the_place_that_were_asked_for():
    cuts = machine.cut(strokes_of([shapes.flower()], PLAIN), PLAIN)
    scan = Scan(0.05, 10.0, -4.0, 90.0, 5)
    ((x, y),) = scanned(cuts, scan)
    assert np.std(x - (10.0 - cuts[0].y)) == pytest.approx(0.05, rel=0.1)
    assert np.std(y - (cuts[0].x - 4.0)) == pytest.approx(0.05, rel=0.1)
    for px, py, sx, sy in marks_of(strokes_of([shapes.flower()], PLAIN), scan):
        assert (sx, sy) == pytest.approx((10.0 - py, px - 4.0), abs=0.25)


def test_an_unknown_material_is_refused_with_the_known_ones():
    with pytest.raises(ValueRefused, match="'felt': expected fabric, leather, foam"):
        machine.cut([straight()], PLAIN, "felt")
