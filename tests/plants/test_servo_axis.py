"""The identified axis against solutions worked by hand and by SciPy, and against its twin with bristles."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from leadscrew import Loop
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.plants._servo_axis import ServoAxisParams, servo_axis, servo_axis_start, servo_axis_step
from leadscrew.plants._servo_axis_lugre import servo_axis_lugre
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.sensors._counts import axis_reading
from tests.controllers.emps_cascade import emps_cascade

PLAIN = ServoAxisParams(mass=2.0, force_per_drive=1.0, offset=0.0, per_si=1.0)
DT = 1e-3


def side(coulomb=0.0, static=None, viscous=0.0, speed=1e-3):
    return Sliding(coulomb, coulomb if static is None else static, speed, viscous)


def driven(params, drive, load=0.0, dt=DT):
    """Positions, speeds and tables from the start on, one row more than drives."""
    plan, s = servo_axis_step(params, dt), servo_axis_start(params)
    rows = [s]
    for u in drive:
        s = servo_axis.step(plan, s, u, load, dt)
        rows.append(s)
    return np.array(rows).T


def test_without_friction_it_falls_along_a_parabola():
    x, v, _ = driven(PLAIN._replace(friction=TwoSided(side(), side()), offset=1.0), np.full(1000, 5.0))
    assert v[-1] == pytest.approx((5.0 - 1.0) / 2.0, rel=1e-12)
    assert x[-1] == pytest.approx(0.5 * 2.0, rel=1e-12)


def test_it_slides_to_a_stop_after_the_distance_that_friction_allows_and_stays():
    stop = PLAIN._replace(friction=TwoSided(side(3.0), side(3.0)), start_speed=0.3)
    x, v, _ = driven(stop, np.zeros(400))
    assert x[-1] == pytest.approx(0.3**2 * 2.0 / (2.0 * 3.0), rel=1e-12)
    assert v[-1] == 0.0 and np.flatnonzero(v == 0.0)[0] == 200


def test_at_rest_it_bears_what_static_friction_of_that_direction_bears_and_no_more():
    rough = PLAIN._replace(friction=TwoSided(side(2.0, 3.0), side(4.0, 5.0)), offset=0.5)
    for push, moves in ((3.49, False), (3.51, True), (-4.49, False), (-4.51, True)):
        x, v, _ = driven(rough, np.full(50, push))
        assert bool(x[-1] != 0.0) is moves, push
        assert v[-1] == 0.0 or np.sign(v[-1]) == np.sign(push)


def test_viscous_friction_is_exact_at_any_step():
    oiled = PLAIN._replace(friction=TwoSided(side(1.0, viscous=40.0), side(1.0, viscous=40.0)), start_speed=0.1)
    for dt in (1e-4, 1e-3, 2e-2):
        n = round(0.2 / dt)
        x, v, _ = driven(oiled, np.full(n, 9.0), dt=dt)
        end, rate = 8.0 / 40.0, 40.0 / 2.0
        t = n * dt
        assert v[-1] == pytest.approx(end + (0.1 - end) * np.exp(-rate * t), rel=1e-11)
        assert x[-1] == pytest.approx(end * t + (0.1 - end) * (1.0 - np.exp(-rate * t)) / rate, rel=1e-11)


def test_through_reversals_it_stays_with_a_fine_solution_of_scipy():
    """SciPy stops at every zero of the speed, and goes on where the drive is larger than static friction."""
    f = TwoSided(side(2.0, 2.6, 6.0, 0.02), side(3.0, 3.9, 4.0, 0.03))
    params = PLAIN._replace(friction=f, offset=-0.4)
    drive = 12.0 * np.sin(2 * np.pi * 1.3 * np.arange(1500) * DT)
    x, v, _ = driven(params, drive)

    def rate(t, y, u, way):
        s = f.forward if way > 0 else f.backward
        level = s.coulomb + (s.static - s.coulomb) * np.exp(-((y[1] / s.stribeck_speed) ** 2))
        return [y[1], (u + 0.4 - way * level - s.viscous * y[1]) / 2.0]

    def stops(t, y, u, way):
        return y[1] * way

    stops.terminal, stops.direction = True, -1
    y, found = np.zeros(2), [0.0]
    for u in drive:
        left, push = DT, u + 0.4
        while left > 1e-12:
            way = np.sign(y[1]) if y[1] != 0.0 else np.sign(push)
            if y[1] == 0.0 and -f.backward.static <= push <= f.forward.static:
                break
            start = y if y[1] != 0.0 else np.array([y[0], way * 1e-12])
            s = solve_ivp(rate, (0.0, left), start, args=(u, way), events=stops, rtol=1e-9, atol=1e-13)
            y, left = s.y[:, -1].copy(), left - s.t[-1]
            if s.status == 1:
                y[1] = 0.0
        found.append(y[0])
    assert np.max(np.abs(x - found)) < 2e-4 * np.ptp(found)
    assert np.sum(v == 0.0) > 20


def test_the_table_follows_through_the_play():
    loose = PLAIN._replace(friction=TwoSided(side(1.0), side(1.0)), backlash=2e-3)
    drive = np.concatenate([np.full(300, 3.0), np.full(700, -3.0)])
    x, _, table = driven(loose, drive)
    assert np.max(np.abs(x - table)) == pytest.approx(1e-3, abs=1e-15)
    assert x[300] - table[300] == pytest.approx(1e-3) and x[-1] - table[-1] == pytest.approx(-1e-3)


def test_a_load_pushes_at_the_axis():
    free = PLAIN._replace(friction=TwoSided(side(), side()), force_per_drive=10.0)
    assert driven(free, np.full(10, 0.3), load=1.0)[1][-1] == pytest.approx(4.0 / 2.0 * 10 * DT)


@pytest.mark.slow
def test_with_stiff_bristles_it_moves_as_without():
    common = {
        "reference": eased_sine_motion(amplitude=20.0, frequency=0.5),
        "controller": emps_cascade, "period": 1e-3, "sensor": axis_reading(resolution=0.0), "metrics": {},
    }  # fmt: skip
    plain = Loop(plant=servo_axis, **common).run(6.0)
    bristles = Loop(plant=servo_axis_lugre, method="rodas", **common).run(6.0)
    gap = np.abs(plain["actual.position"] - bristles["actual.position"])
    assert np.max(gap) < 0.02 and np.ptp(plain["actual.position"]) > 39.0
