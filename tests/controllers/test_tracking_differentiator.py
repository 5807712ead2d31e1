"""The tracking differentiator against Han's own form, its linear limit, the time-optimal move, and in the loop."""

import math

import numpy as np
import pytest
from scipy import signal

from leadscrew.controllers._npid import npid
from leadscrew.controllers._npid_after import npid_after
from leadscrew.controllers._npid_slope import npid_slope
from leadscrew.controllers._torque_pid import torque_pid
from leadscrew.controllers._tracking_differentiator import fhan, follow, tracking_differentiator
from leadscrew.references._eased_sine import eased_sine
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.sensors._counts import noisy_ruler
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.xy_loop import PERIOD, outputs, xy_loop

SCALE = noisy_ruler(resolution_mm=5e-4, noise_mm=1e-4)
MM_1 = eased_sine(amplitude=1.0, frequency=0.7)


def sign(x):
    return math.copysign(1.0, x) if x else 0.0


def han(x1, x2, r, h):
    """The published form, with its switches written as signs."""
    d = r * h * h
    a0 = h * x2
    y = x1 + a0
    a2 = a0 + sign(y) * (math.sqrt(d * (d + 8.0 * abs(y))) - d) / 2.0
    sy = (sign(y + d) - sign(y - d)) / 2.0
    a = (a0 + y - a2) * sy + a2
    sa = (sign(a + d) - sign(a - d)) / 2.0
    return -r * (a / d - sign(a)) * sa - r * sign(a)


def test_fhan_is_the_published_function():
    random = np.random.default_rng(1)
    for scale in (1e-6, 1e-4, 1e-2, 1.0):
        for x1, x2 in scale * random.normal(size=(200, 2)):
            assert fhan(x1, 30.0 * x2, 1000.0, 1e-3) == pytest.approx(han(x1, 30.0 * x2, 1000.0, 1e-3), abs=1e-9)


def followed(signal_mm, r=1000.0, h=1e-3, rate=0.0):
    x1, x2, rates = float(signal_mm[0]), rate, []
    for v in signal_mm.tolist():
        x1, x2 = follow(x1, x2, v, r, h, PERIOD)
        rates.append(x2)
    return np.array(rates)


def test_a_small_signal_meets_two_lags_of_h():
    """x1+ = x1 + T x2, x2+ = x2 - T/h^2 (x1 - v) - 2 T/h x2: run by SciPy on noise that never asks for r."""
    v = 1e-4 * np.random.default_rng(6).normal(size=400)
    v[0] = 0.0
    h, n = 2e-3, PERIOD / 2e-3**2
    a = [[1.0, PERIOD], [-n, 1.0 - 2.0 * PERIOD / h]]
    response = signal.dlsim((a, [[0.0], [n]], [a[1]], [[n]], PERIOD), v)[1][:, 0]
    assert followed(v, r=1e6, h=h) == pytest.approx(response, rel=1e-9, abs=1e-12)


def test_with_h_of_one_period_a_small_signal_meets_the_backward_difference():
    v = 1e-6 * np.random.default_rng(7).normal(size=200)
    assert followed(v, h=PERIOD)[1:] == pytest.approx(np.diff(v) / PERIOD, abs=1e-12)


def test_the_lag_costs_the_gain_margin_that_its_sheet_says():
    """A PID's loop with the linear follower grows at its gain margin, 1.60 with h = 1 ms, not at 2.51."""
    for factor, grows in ((1.58, False), (1.62, True)):
        inner = table_pid(kp=factor * 1.32, ki=0.0, kd=factor * 0.006805)
        run = xy_loop(tracking_differentiator(inner, r_mm_s2=1e9), step(target=1e-3)).run(2.0, record="actual")
        early, late = (np.ptp(run["actual"][a:b]) for a, b in ((1000, 1400), (3600, 4000)))
        assert (late > early) == grows


def test_a_step_is_followed_in_the_shortest_time_that_r_allows():
    """1 mm at 1000 mm/s^2: 31.6 ms of acceleration, 31.6 ms of braking, 31.6 mm/s in between."""
    rates = followed(np.concatenate([[0.0], np.ones(400)]))
    assert np.abs(np.diff(rates)).max() <= 1000.0 * PERIOD * (1.0 + 1e-12)
    assert rates.max() == pytest.approx(math.sqrt(1000.0), rel=0.02)
    reached = PERIOD * np.argmax(np.cumsum(rates) * PERIOD > 0.999)
    assert reached == pytest.approx(2.0 / math.sqrt(1000.0), abs=5e-3)


def derivative_errors(h):
    """RMS error of the error's rate, by difference and followed: a 1 mm sine read by a 0.5 um scale."""
    t, w = PERIOD * np.arange(20_000), 2.0 * math.pi * 0.7
    error, rate = 7.12e-3 * np.sin(w * t), 7.12e-3 * w * np.cos(w * t)
    read = np.sin(w * t) - error + 1e-4 * np.random.default_rng(0).normal(size=t.size)
    seen = np.sin(w * t) - 5e-4 * np.floor(read / 5e-4 + 0.5)
    plain = np.diff(seen) / PERIOD - rate[1:]
    return plain.std(), (followed(seen, h=h, rate=rate[0]) - rate)[1000:].std()


@pytest.mark.parametrize("h", [1e-3, 2e-3])
def test_it_takes_the_quantisation_noise_out_of_the_rate(h):
    """What is left is white noise of the scale's size through the two lags."""
    plain, better = derivative_errors(h)
    noise = math.hypot(5e-4 / math.sqrt(12.0), 1e-4)
    n = PERIOD / h**2
    a = [[1.0, PERIOD], [-n, 1.0 - 2.0 * PERIOD / h]]
    pulse = signal.dlsim((a, [[0.0], [n]], [a[1]], [[n]], PERIOD), np.eye(1, 400)[0])[1]
    assert plain == pytest.approx(noise * math.sqrt(2.0) / PERIOD, rel=0.01)
    assert better == pytest.approx(noise * np.linalg.norm(pulse), rel=0.03)
    assert better < 0.2 * plain


@pytest.mark.slow
def test_in_the_loop_the_output_is_five_times_calmer_and_the_error_is_the_same():
    found = {}
    for name, block in (("difference", table_pid), ("followed", tracking_differentiator(table_pid))):
        run = xy_loop(block, MM_1, sensor=SCALE).run(12.0, record=("true_error", "output"))
        found[name] = 1e3 * run["true_error"][4000:].std(), 1e3 * np.diff(run["output"][4000:]).std()
    assert found["difference"] == pytest.approx((5.04, 6.1), rel=0.02)
    assert found["followed"] == pytest.approx((5.04, 1.2), rel=0.01)


@pytest.mark.filterwarnings("ignore::leadscrew.kernel.loop.DivergenceWarning")
@pytest.mark.parametrize(
    "law", [npid, pytest.param(npid_after, marks=pytest.mark.slow), pytest.param(npid_slope, marks=pytest.mark.slow)]
)
def test_gains_that_need_the_phase_of_a_plain_difference_are_lost(law):
    many = xy_loop(tracking_differentiator(law), MM_1, sensor=SCALE, bound=10.0).batch(
        4.0, {"controller.h_s": np.array([5e-4, 1e-3, 2e-3])}
    )
    assert np.isfinite(many.diverged_at).all()


@pytest.mark.slow
def test_noise_alone_throws_a_follower_of_200_mm_s2_into_a_cycle():
    block = tracking_differentiator(table_pid, r_mm_s2=200.0)
    clean, noisy = (
        1e3 * xy_loop(block, MM_1, sensor=scale).run(12.0, record="true_error")["true_error"][4000:].std()
        for scale in (None, SCALE)
    )
    assert clean == pytest.approx(5.04, abs=0.01) and noisy == pytest.approx(19.4, rel=0.03)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::leadscrew.kernel.loop.DivergenceWarning")
def test_a_blow_throws_a_slow_follower_into_a_large_cycle_and_a_fast_one_not():
    """A sine that starts at full speed, 4.4 mm/s: r = 1000 does not come back, r = 5000 does."""
    many = xy_loop(tracking_differentiator(table_pid), sine(amplitude=1.0, frequency=0.7)).batch(
        8.0, {"controller.r_mm_s2": np.array([1000.0, 5000.0])}, record="true_error"
    )
    slow, fast = 1e3 * np.abs(many["true_error"][:, 8000:]).max(axis=1)
    assert slow > 100.0 and fast == pytest.approx(7.12, abs=0.01)
    tuned = xy_loop(TUNINGS["ours.pid_td"], sine(amplitude=1.0, frequency=0.7), sensor=SCALE).run(4.0)
    assert 1e3 * np.abs(tuned["true_error"][4000:]).max() < 0.8


def test_the_other_terms_are_those_of_the_inner_controller():
    for inner in (
        table_pid(kd=0.0, ki=20.0),
        npid(kd=0.0, lower=-4e-3, upper=4e-3),
        npid_after(kd=0.0, ki=20.0, lower=-4e-3, upper=4e-3),
    ):
        errors = 3e-3 * np.random.default_rng(8).normal(size=300)
        assert outputs(tracking_differentiator(inner), errors, np.zeros(300)) == outputs(inner, errors, np.zeros(300))


@pytest.mark.parametrize("inner", [TUNINGS["ours.pid_ms_159"], npid(ki=5.0), npid_after(ki=5.0)])
def test_the_first_output_after_an_align_is_the_last_one_before(inner):
    block = tracking_differentiator(inner)
    _, u = block.step(block.params, block.align(block.params, 1.0, 1.002, 0.7), 1.0, 1.002, PERIOD)
    assert u == pytest.approx(0.7, abs=1e-12)


@pytest.mark.sweep
@pytest.mark.parametrize(
    "inner", [table_pid(filter_s=1e-3, lower=-0.03, upper=0.03), npid_after(lower=-0.03, upper=0.03)]
)
def test_all_engines_give_the_same_bits(inner):
    loop = xy_loop(tracking_differentiator(inner), sine(amplitude=4.0, frequency=3.0))
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.1, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_the_follower_decays_to_zero_and_not_to_denormal_numbers():
    x1, x2 = 1e-3, 0.0
    for _ in range(20_000):
        x1, x2 = follow(x1, x2, 0.0, 1000.0, 5e-3, PERIOD)
    assert x1 == 0.0 and x2 == 0.0


def test_what_it_cannot_do_is_refused():
    with pytest.raises(BlockError, match=r"tracking_differentiator\(torque_pid\).*pid, npid, npid_slope or npid_after"):
        tracking_differentiator(torque_pid)
    with pytest.raises(ValueRefused, match=r"h_s = 0.0002 s .*shorter than the control period"):
        xy_loop(tracking_differentiator(table_pid, h_s=2e-4), sine()).run(0.01)
