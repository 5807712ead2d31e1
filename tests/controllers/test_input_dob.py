"""The disturbance observer: its filters by SciPy, its loop by python-control, and what it cannot do."""

import control
import numpy as np
import pytest
from scipy import signal

from leadscrew.analysis.stability.loop import sampled_loop
from leadscrew.controllers._input_dob import delay_weights, input_dob, tustin
from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers._response import plant_response
from leadscrew.disturbances._sine_load import sine_load
from leadscrew.disturbances._step_load import step_load
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, XY_TABLE, table_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.table_axis import PERIOD, lines_um, table_axis, tried

RNG = np.random.default_rng(8)
SILENT = table_pid(kp=0.0, ki=0.0, kd=0.0)
W = 2.0 * np.pi * np.array([0.7, 2.1, 7.7, 40.0, 200.0])


def test_the_filters_are_scipys_by_tustin():
    w, k = 100.0, 100.0**2 / 69380.0
    for b in ((k, k * 144.8, k * 166.3), (0.0, 0.0, w * w)):
        num, den = signal.bilinear(b, [1.0, 2.0 * w, w * w], fs=1.0 / PERIOD)
        found = tustin(b, w, PERIOD)
        assert found[:3] == pytest.approx(num, rel=1e-9) and (1.0, *found[3:]) == pytest.approx(den, rel=1e-12)


def test_the_output_is_delayed_by_the_dead_time_and_half_a_period():
    assert delay_weights(0.775e-3 / PERIOD + 0.5) == pytest.approx((0.0, 0.95, 0.05, 0.0, 0.0))
    assert delay_weights(0.5) == (1.0, 0.0, 0.0, 0.0, 0.0) and delay_weights(4.0)[3] == 1.0
    with pytest.raises(ValueRefused, match=r"delay of 5.5 periods \(input_dob\)"):
        delay_weights(5.5)


def test_the_found_disturbance_is_the_equation_run_by_scipy():
    """With a silent inner law ``u = -d``, so ``d`` is the two filters on the feedback and on its own past."""
    p = input_dob(SILENT, bandwidth=300.0, model=XY_TABLE).prepare(
        input_dob(SILENT, bandwidth=300.0, model=XY_TABLE).params, PERIOD
    )
    y = RNG.normal(size=300)
    f, g = p.inverse, p.filter
    inverse = (np.array(f[:3]), np.array([1.0, f.a1, f.a2]))
    needed = signal.lfilter(*inverse, y)
    # d = needed - G(z) (0.95 z^-2 + 0.05 z^-3) u,  u = -d:  d (1 - G(z) (...)) = needed
    path = np.convolve(g[:3], [0.0, 0.0, 0.95, 0.05])
    den = np.concatenate([[1.0, g.a1, g.a2], np.zeros(3)]) - path
    expected = -signal.lfilter([1.0, g.a1, g.a2], den, needed)
    found = tried(input_dob(SILENT, bandwidth=300.0, model=XY_TABLE), np.zeros(300), y)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("name", [name for name in TUNINGS if "pid_dob" in name])
def test_its_loop_is_python_controls(name):
    """The controller is one transfer function of the feedback: ``-(C + Q P^-1) / (1 - Q z^-2.05)``."""
    block = TUNINGS[name]
    p = block.prepare(block.params, PERIOD)
    z = control.tf([1.0, 0.0], [1.0], PERIOD)
    k = p.inner
    law = k.kp + k.ki * PERIOD * z / (z - 1) + k.kd * (z - 1) / (PERIOD * z)

    def second(f):
        return control.tf(list(f[:3]), [1.0, f.a1, f.a2], PERIOD)

    delayed = (0.95 * z + 0.05) / z**3
    points = np.exp(1j * W * PERIOD)
    whole = (law(points) + second(p.inverse)(points)) / (1.0 - second(p.filter)(points) * delayed(points))
    loop = sampled_loop(table_axis(block))
    assert loop.response(W) == pytest.approx(whole * plant_response(XY_TABLE, PERIOD, W), rel=1e-6)


@pytest.mark.slow
def test_it_finds_a_constant_load_and_takes_it_off():
    """The printed gains alone leave load / Kp = 7.6 um for minutes."""
    left = [
        1e3 * abs(table_axis(block, amplitude=0.0, disturbance=step_load(size=0.01)).run(1.0)["true_error"][-1])
        for block in (table_pid, TUNINGS["ours.pid_dob_60"])
    ]
    assert left[0] == pytest.approx(1e3 * 0.01 / 1.32, rel=0.01) and left[1] < 0.01


@pytest.mark.slow
def test_it_cannot_remove_the_following_error_of_the_believed_plant():
    plain, observed = (
        lines_um(table_axis(block).run(20.0), [0.7])[0] for block in (table_pid, TUNINGS["ours.pid_dob_150"])
    )
    assert observed == pytest.approx(plain, rel=1e-4) and plain == pytest.approx(7.12, abs=0.01)


@pytest.mark.slow
def test_a_slow_observer_makes_a_fast_line_worse():
    load = sine_load(amplitude=1e-3, frequency=7.7)
    plain, slow, fast = (
        lines_um(table_axis(block, amplitude=0.0, disturbance=load).run(12.0), [7.7])[0]
        for block in (table_pid, TUNINGS["ours.pid_dob_60"], TUNINGS["ours.pid_dob_150"])
    )
    assert slow > 1.05 * plain and fast < 0.7 * plain


@pytest.mark.slow
def test_feed_forward_belongs_inside():
    """Outside the observer takes it for a disturbance, and takes it off again as far as it can."""
    inside = input_dob(inverse_feed_forward(table_pid, **INVERSE), bandwidth=150.0, model=XY_TABLE)
    outside = inverse_feed_forward(input_dob(table_pid, bandwidth=150.0, model=XY_TABLE), **INVERSE)
    a, b = (lines_um(table_axis(block).run(20.0), [0.7])[0] for block in (inside, outside))
    assert a < 0.01 < 0.1 < b


def test_a_limit_does_not_wind_it_up():
    loop = table_axis(
        input_dob(table_pid, 150.0, lower=-0.02, upper=0.02, model=XY_TABLE),
        amplitude=0.0,
        disturbance=step_load(size=0.03),
    )
    run = loop.run(1.0, record=("output", "controller"))
    assert np.abs(run["output"]).max() == 0.02
    assert abs(run["controller.observer.disturbance"][-1]) < 0.04


@pytest.mark.parametrize(
    "block", [TUNINGS["ours.pid_dob_100"], input_dob(inverse_feed_forward(table_pid, **INVERSE), model=XY_TABLE)]
)
def test_from_rest_it_takes_over_without_a_bump(block):
    from leadscrew.references._motion import Motion

    here = Motion(0.3) if block.step.takes_motion else 0.3
    p = block.prepare(block.params, PERIOD)
    s, u = block.step(p, block.align(p, here, 0.3, 0.0123), here, 0.3, PERIOD)
    assert s.observer.disturbance == pytest.approx(0.0, abs=1e-15)
    if not block.step.takes_motion:
        assert u == pytest.approx(0.0123, abs=1e-12)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = table_axis(
        input_dob(table_pid, lower=-0.02, upper=0.02, model=XY_TABLE), disturbance=sine_load(amplitude=1e-2)
    )
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
