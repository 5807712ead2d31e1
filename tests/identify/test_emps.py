"""EMPS, a real ball-screw axis: what others published of it, by a simulator of the tests, and what the product says.

The published figures: with the published parameters force to position is 5.28 mm off (root mean square) over the file,
a symmetric fit reaches 2.41 to 2.61 mm, and with the known cascade closed the position is 3.04 um off.
"""

import numpy as np
import pytest
from scipy.optimize import least_squares

from tests.identify.axis_oracle import Axis, closed_loop, moved, open_loop, rms, windowed
from tests.identify.emps import PUBLISHED, emps

HALF = 12420


@pytest.fixture(scope="module")
def log():
    return emps()


def speed_at(log, k):
    """By a parabola through nine samples, at the edge or around."""
    first = max(k - 4, 0)
    near = slice(first, first + 9)
    return float(np.polyfit(log.time[near] - log.time[k], log.position[near], 2)[1])


def fit(log, last, guess):
    """Mass, friction, offset and start speed by SciPy, from the measured first position."""
    force, y = log.force[:last], log.position[:last]
    scale = np.array([95.0, 203.0, 20.0, 3.0, 0.01])

    def left(p):
        q = p * scale
        return open_loop(Axis(*q[:4]), force, log.period, y[0], q[4]) - y

    best = least_squares(left, np.array([*guess, speed_at(log, 0)]) / scale, diff_step=1e-4, max_nfev=40)
    return Axis(*(best.x * scale)[:4]), float(best.x[4] * scale[4]), rms(best.fun)


def product_values(axis):
    """Keys of the plant."""
    sides = {f"friction.{s}.{n}": v for s in ("forward", "backward")
             for n, v in (("coulomb", axis.coulomb), ("static", axis.coulomb), ("viscous", axis.viscous),
                          ("stribeck_speed", 0.001))}  # fmt: skip
    return {"mass": axis.mass, "offset": axis.offset, "backlash": 0.0, **sides}


def product_log(log):
    from leadscrew.logs.arrays import axis_log

    return axis_log(log.time, log.force, log.position, log.command)


def test_the_oracle_slides_and_stops_as_worked_by_hand():
    """2 kg at 1 m/s under Coulomb friction of 4 N stops after 0.5 s and 0.25 m; a push of 3 N then does not move it."""
    axis = Axis(mass=2.0, viscous=1e-5, coulomb=4.0, offset=0.0)
    x, v = moved(0.0, 1.0, 0.0, 0.25, axis)
    assert (x, v) == pytest.approx((0.1875, 0.5), rel=1e-4)
    x, v = moved(0.0, 1.0, 0.0, 1.0, axis)
    assert (x, v) == (pytest.approx(0.25, rel=1e-4), 0.0)
    assert moved(x, v, 3.0, 1.0, axis) == (x, 0.0)
    assert moved(0.0, 0.0, 6.0, 1.0, axis) == pytest.approx((0.5, 1.0), rel=1e-4)


def test_published_parameters_give_the_published_errors(log):
    """From the first difference as start speed; from rest it would be 6.7 mm, so the start decides here."""
    start = float(log.position[1] - log.position[0]) / log.period
    x = open_loop(PUBLISHED, log.force, log.period, log.position[0], start)
    assert 1e3 * rms(x - log.position) == pytest.approx(5.28, abs=0.03)
    at_rest = open_loop(PUBLISHED, log.force, log.period, log.position[0])
    assert 1e3 * rms(at_rest - log.position) > 6.5
    wrong_sign = open_loop(PUBLISHED._replace(offset=3.165), log.force, log.period, log.position[0], start)
    assert 1e3 * rms(wrong_sign - log.position) > 100.0
    x = closed_loop(PUBLISHED, log.command, log.period, log.kp, log.kv * log.gain, log.position[0], start)
    assert 1e6 * rms(x - log.position) == pytest.approx(3.04, rel=0.06)


@pytest.mark.slow
def test_a_symmetric_fit_by_scipy_reaches_the_published_error_only_with_a_free_start_speed(log):
    guess = (93.9, 192.7, 21.64, -3.316)
    free, start, error = fit(log, len(log.time), guess)
    assert 1e3 * error <= 2.61
    assert free.mass == pytest.approx(PUBLISHED.mass, rel=0.05)
    x = open_loop(free, log.force, log.period, log.position[0], speed_at(log, 0))
    assert 1e3 * rms(x - log.position) > 2.61
    assert abs(start - speed_at(log, 0)) > 0.003
    # the loop that was active took its speed over two periods; with the axis's own speed this model misses 3.1 um
    gains = (log.kp, log.kv * log.gain, log.position[0], speed_at(log, 0))
    as_was, own = (closed_loop(free, log.command, log.period, *gains, over) for over in (2, 0))
    assert 1e6 * rms(as_was - log.position) <= 2.0
    assert 1e6 * rms(own - log.position) > 3.1


@pytest.mark.slow
def test_a_symmetric_fit_to_the_first_half_holds_on_the_second(log):
    found, _, error = fit(log, HALF, tuple(PUBLISHED))
    x = open_loop(found, log.force[HALF:], log.period, log.position[HALF], speed_at(log, HALF))
    assert 1e3 * error < 1.9
    assert 1e3 * rms(x - log.position[HALF:]) < 2.0 * 2.61
    x = closed_loop(found, log.command, log.period, log.kp, log.kv * log.gain, log.position[0], speed_at(log, 0))
    assert 1e6 * rms(x - log.position) <= 3.1


@pytest.mark.slow
def test_windows_of_the_test_and_of_the_product_find_the_same_axis(log):
    """Two programs, two simulators: within their standard errors, which they agree on too."""
    from leadscrew.identify.axis.refine import refine

    ours = windowed(log.force, log.position, log.period, PUBLISHED, 250)
    keys = ("mass", "friction.forward.viscous", "friction.forward.coulomb", "offset")
    theirs = refine(product_log(log), product_values(PUBLISHED), keys, symmetric=True, window_s=0.25)
    for key, value, spread, published in zip(keys, ours.axis, ours.spread, PUBLISHED, strict=True):
        assert abs(theirs.values[key] - value) < 3.0 * np.hypot(spread, theirs.standard_error[key]), key
        assert 0.3 < theirs.standard_error[key] / spread < 3.0, key
        assert abs(value - published) < 5.0 * spread, key


@pytest.mark.slow
def test_the_product_simulates_the_axis_as_the_oracle_does_sample_by_sample(log):
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.identify.axis.simulation import simulate_closed, simulate_open, start_state

    start = (float(log.position[0]), speed_at(log, 0))
    values, read = product_values(PUBLISHED), product_log(log)
    theirs = simulate_open(read, values, 0.0, start)
    ours = open_loop(PUBLISHED, log.force, log.period, *start)
    assert np.abs(theirs - ours).max() < 2e-6
    for over in (1, 2):
        theirs = simulate_closed(read, values, Cascade(kp=log.kp, kv=log.kv * log.gain, over=over))
        ours = closed_loop(PUBLISHED, log.command, log.period, log.kp, log.kv * log.gain, *start_state(read), over)
        assert np.abs(theirs - ours).max() < 2e-8
