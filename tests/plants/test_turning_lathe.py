"""The whole lathe against the force plant, SciPy's integration of its drives, and hand-worked balances."""

import math

import numpy as np
import pytest

from leadscrew import Loop, controller
from leadscrew.plants._turning import turning
from leadscrew.plants._turning.radial import Cross, CrossServo, cross_hold, moved_across
from leadscrew.plants._turning.spindle import Spindle, SpindleMotor, spindle_hold, turned_on
from leadscrew.plants._turning.workpiece import Workpiece, checked, stock_at, stretches
from leadscrew.plants._turning_lathe import turning_lathe
from leadscrew.references._cutting_program import cutting_force
from leadscrew.references._lathe_program import LatheDrive
from leadscrew.sensors._load_cell import load_cell
from leadscrew.util.errors import ValueRefused

FEED_V = 35.5 / 150.0


@controller()
def held(command, feedback):
    """Constant voltages: 1,200 1/min, 35.5 mm/min, the depth as it is."""
    return LatheDrive(8.0 + 0.0 * command, FEED_V, 0.0)


@controller()
def feed_alone(command, feedback):
    return FEED_V + 0.0 * command


def lathe(**changes):
    loop = Loop(reference=cutting_force, controller=held, plant=turning_lathe, sensor=load_cell(noise_n=0.0),
                period=0.02, substeps=20, metrics={})  # fmt: skip
    return loop.using({f"plant.{key}": value for key, value in changes.items()})


@pytest.mark.slow
def test_without_droop_the_force_is_that_of_the_force_plant():
    other = Loop(reference=cutting_force, controller=feed_alone, plant=turning, sensor=load_cell(noise_n=0.0),
                 period=0.02, substeps=20, metrics={})  # fmt: skip
    mine = lathe(**{"spindle.droop": 0.0}).run(1.0)
    assert mine["actual.force"] == pytest.approx(other.run(1.0)["actual.force"], abs=1e-9)


def test_the_torque_slows_the_spindle_by_the_droop_and_the_chip_grows():
    free, loaded = lathe(**{"spindle.droop": 0.0, "runout": 0.0}), lathe(**{"spindle.droop": 25.0, "runout": 0.0})
    a, b = free.run(4.0), loaded.run(4.0)
    torque, rpm, force = (b[f"actual.{key}"][-1] for key in ("torque", "rpm", "force"))
    assert torque == pytest.approx(force * 50.0 / 2000.0)
    assert rpm == pytest.approx(1200.0 - 25.0 * torque, abs=0.01)
    assert b["actual.power"][-1] == pytest.approx(torque * rpm * 2.0 * math.pi / 60.0)
    assert force / a["actual.force"][-1] == pytest.approx((1200.0 / rpm) ** 0.77, rel=1e-5)


def test_inverter_and_motor_are_their_differential_equations():
    from scipy.integrate import solve_ivp

    motor, torque, u = SpindleMotor(droop=20.0, inertia=0.1), 4.0, 6.0
    late = 0.1 * 20.0 * math.pi / 30.0

    def rates(t, x):
        return (150.0 * u - x[0]) / 0.3, (x[0] - 20.0 * torque - x[1]) / late

    truth = solve_ivp(rates, (0.0, 1.0), (300.0, 500.0), rtol=1e-10, atol=1e-9).y[:, -1]
    for dt, off in ((1e-3, 1.5), (1e-4, 0.15)):
        plan, s = spindle_hold(motor, dt), Spindle(300.0, 500.0)
        for _ in range(round(1.0 / dt)):
            s = turned_on(plan, s, u, torque)
        assert (s.field, s.rpm) == pytest.approx(truth, abs=off)


def test_the_cross_slide_is_exact_at_any_step():
    from scipy.signal import lsim

    t = np.linspace(0.0, 0.3, 4)
    _, _, x = lsim(([[0.0, 1.0], [0.0, -1.0 / 0.03]], [[0.0], [5.0 / 0.03]], np.eye(2), np.zeros((2, 1))),
                   np.full(4, 0.2), t)  # fmt: skip
    for steps in (3, 300):
        plan, s = cross_hold(CrossServo(), 0.3 / steps), Cross()
        for _ in range(steps):
            s = moved_across(plan, s, 0.2)
        assert s == pytest.approx(tuple(x[-1]), rel=1e-9)


def test_the_volume_removed_is_that_of_the_ring_that_is_gone():
    run = lathe(stiffness=1e9, runout=0.0).run(3.0, record=["actual", "plant.removed"])
    cut = run["actual.travel"][-1] - 35.5 / 1200.0 / 2.0
    assert run["plant.removed"][-1] == pytest.approx(math.pi * 50.0 * 1.0 * cut, rel=2e-3)


def test_a_bar_with_shoulders_and_a_hard_stretch_is_where_it_is():
    work = stretches([1.0, 2.0], [-0.6, 0.2], [0.0, 0.5])
    changes = {f"work.{key}": value for key, value in work.items()}
    run = lathe(**changes, **{"work.starts": 0.5, "work.ends": 3.0, "runout": 0.0, "spindle.droop": 0.0}).run(6.0)
    way, force = run["actual.travel"], run["actual.force"]
    steady = 2256.3 * (35.5 / 1200.0) ** 0.77
    for at, expected in ((0.3, 0.0), (0.95, 1.0), (1.8, 0.4), (2.8, 1.8), (3.2, 0.0)):
        assert np.interp(at, way, force) == pytest.approx(expected * steady, rel=2e-3, abs=1e-9), at


def test_a_bar_that_cannot_be_is_refused():
    with pytest.raises(ValueRefused, match="2 places, 1 extra"):
        stretches([0.0, 1.0], [0.0])
    with pytest.raises(ValueRefused, match="must rise"):
        checked(Workpiece(**stretches([2.0, 1.0], [0.0, 0.0])))
    with pytest.raises(ValueRefused, match=r"work.ends = 1.0 .* behind work.starts = 2.0"):
        lathe(**{"work.starts": 2.0, "work.ends": 1.0}).run(0.1)
    with pytest.raises(ValueRefused, match=r"servo.dead_time_s = 0.1 \(turning_lathe\): less than 64 steps"):
        lathe(**{"servo.dead_time_s": 0.1}).run(0.1)
    assert stock_at(Workpiece(), 5.0) == (0.0, 0.0, 1.0)


def test_a_step_of_a_revolution_is_refused_and_a_quick_servo_is_none():
    with pytest.raises(ValueRefused, match=r"spindle.max_speed = 60000.0 1/min \(turning_lathe\): at most 59765.6"):
        lathe(**{"spindle.max_speed": 60000.0}).run(0.1)
    with pytest.raises(ValueRefused, match=r"start.rpm = 60000.0 1/min \(turning_lathe\)"):
        lathe(**{"start.rpm": 60000.0}).run(0.1)
    assert math.isfinite(lathe(**{"servo.rate": 5000.0}).run(0.2)["actual.force"][-1])


@pytest.mark.sweep
def test_compiled_and_plain_python_give_the_same_bits():
    loop = lathe(**{"spindle.droop": 20.0})
    plain, fast = loop.run(0.3, engine="python"), loop.run(0.3)
    assert all(np.array_equal(plain[name], fast[name]) for name in plain.signals)


def test_a_bar_and_its_stretches_begin_at_their_places_and_the_bar_ends_before_its_end():
    bar = Workpiece(starts=1.0, ends=3.0, **stretches([1.5, 2.0], [0.25, 0.5], [0.0, 0.1]))
    places = (0.999, 1.0, 1.499, 1.5, 2.0, 2.999, 3.0)
    assert [stock_at(bar, x) for x in places] == [
        (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.25, 0.0, 1.0), (0.5, 0.1, 1.0), (0.5, 0.1, 1.0),
        (0.5, 0.1, 0.0),
    ]  # fmt: skip
    for harder, fits in ((-0.99, True), (-1.0, False)):
        if fits:
            assert checked(Workpiece(**stretches([1.0], [0.0], [harder]))).harder[0] == harder
        else:
            with pytest.raises(ValueRefused, match="each above -1"):
                checked(Workpiece(**stretches([1.0], [0.0], [harder])))
