"""Streaming metrics against NumPy on whole arrays and against formulas of second-order systems."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from leadscrew.kernel import metrics
from tests.kernel.recorded_steps import step_metrics

DT = 1e-3


def measure(block, command, actual, output=None, dt=DT):
    """The value of a metric after it has seen the arrays, as the loop feeds them."""
    output = np.zeros(len(command)) if output is None else output
    state = block.state
    for k in range(len(command)):
        seen = {
            "command": float(command[k]),
            "actual": float(actual[k]),
            "feedback": float(actual[k]),
            "error": float(command[k] - actual[k]),
            "output": float(output[k]),
            "t": k * dt,
            "dt": dt,
        }
        state = block.step(block.params, state, *(seen[name] for name in block.signals))
        assert all(math.isfinite(x) for x in state)
    return block.output(block.params, state)


@pytest.fixture(scope="module")
def signals():
    rng = np.random.default_rng(7)
    n = 1500
    return rng.normal(size=n), rng.normal(size=n), np.round(rng.normal(size=n), 1)


def window(from_time, n):
    return np.arange(n) >= round(from_time / DT)


@pytest.mark.parametrize("from_time", [0.0, 0.3, 0.777])
def test_sums_and_peaks_agree_with_numpy(signals, from_time):
    command, actual, output = signals
    inside = window(from_time, len(command))
    e, u, t = (command - actual)[inside], output[inside], (np.arange(len(command)) * DT)[inside]
    expected = {
        "rms_error": np.sqrt(np.mean(e**2)),
        "max_error": np.abs(e).max(),
        "iae": np.abs(e).sum() * DT,
        "ise": (e**2).sum() * DT,
        "itae": ((t - t[0]) * np.abs(e)).sum() * DT,
        "steady_state_error": np.abs(e).max(),
        "mean_steady_state_error": np.abs(e).mean(),
        "effort": np.sqrt(np.mean(u**2)),
        "mean_effort": np.abs(u).mean(),
        "total_effort": np.abs(u).sum() * DT,
        "max_output": np.abs(u).max(),
        "chatter": np.sqrt(np.mean(np.diff(u) ** 2)),
        "zero_crossing_rate": np.count_nonzero(np.diff(np.sign(u[u != 0]))) / (len(u) * DT),
    }
    for name, value in expected.items():
        block = getattr(metrics, name)(from_time=from_time)
        assert measure(block, command, actual, output) == pytest.approx(value, rel=1e-10), name


def test_a_window_without_samples_gives_nan():
    zeros = np.zeros(5)
    for name in (
        "rms_error", "max_error", "iae", "ise", "itae", "effort", "mean_effort", "total_effort", "max_output",
        "chatter", "zero_crossing_rate", "steady_state_error", "mean_steady_state_error", "overshoot",
    ):  # fmt: skip
        assert math.isnan(measure(getattr(metrics, name)(from_time=1.0), zeros, zeros, zeros)), name


def test_the_window_starts_at_the_nearest_sample_whatever_the_rounding_of_time():
    actual = np.ones(10)
    actual[:3] = 9.0
    value = measure(metrics.max_error(from_time=0.3), np.zeros(10), actual, dt=0.1)  # 3 * 0.1 > 0.3
    assert value == 1.0
    assert measure(metrics.max_error(from_time=0.7), np.zeros(10), np.arange(10.0)[::-1], dt=0.1) == 2.0


def test_a_zero_between_two_signs_is_one_crossing_and_between_equal_signs_none():
    u = np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 2.0])
    assert measure(metrics.zero_crossing_rate, u, u, u) == pytest.approx(2 / (8 * DT))


def second_order(zeta, wn, t):
    """Unit step response of ``wn^2 / (s^2 + 2 zeta wn s + wn^2)``."""
    wd = wn * math.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * wn * t)
    return np.where(t < 0, 0.0, 1 - decay * (np.cos(wd * t) + zeta * wn / wd * np.sin(wd * t)))


@pytest.mark.parametrize("zeta", [0.2, 0.5, 0.7])
@pytest.mark.parametrize("size", [1.0, -0.05])
@pytest.mark.parametrize("start", [0.0, 0.25])
def test_second_order_step_gives_the_textbook_overshoot_rise_and_settling(zeta, size, start):
    wn, origin = 30.0, 3.0
    k = np.arange(1500)
    t = (k - round(start / DT)) * DT
    command = origin + np.where(t >= 0, size, 0.0)
    actual = origin + size * second_order(zeta, wn, np.maximum(t, 0.0))
    overshoot = abs(size) * math.exp(-zeta * math.pi / math.sqrt(1 - zeta**2))
    assert measure(metrics.overshoot, command, actual) == pytest.approx(overshoot, rel=2e-3)
    fine = np.linspace(0, 0.5, 500_001)
    y = second_order(zeta, wn, fine)
    rise = fine[np.argmax(y >= 0.9)] - fine[np.argmax(y >= 0.1)]
    assert measure(metrics.rise_time, command, actual) == pytest.approx(rise, abs=2e-5)
    fine = np.linspace(0, 1.2, 600_001)
    outside = np.abs(second_order(zeta, wn, fine) - 1) > 0.02
    settled = fine[np.flatnonzero(outside)[-1]]
    value = measure(metrics.settling_time, command, actual)
    assert settled - 1e-6 <= value <= settled + DT + 1e-6
    in_units = measure(metrics.settling_time(percent=0.0, band=0.02 * abs(size)), command, actual)
    assert in_units == pytest.approx(value, abs=1.5 * DT)


def test_rise_time_of_a_first_order_lag_is_ln_9_time_constants():
    t = np.arange(1000) * DT
    value = measure(metrics.rise_time, np.ones(1000), 1 - np.exp(-t / 0.05))
    assert value == pytest.approx(0.05 * math.log(9), abs=2e-5)


def test_a_rise_from_0_percent_begins_with_the_step():
    rising = np.concatenate([np.linspace(0.0, 1.0, 11), np.ones(5)])
    for low, high, samples in ((0.0, 90.0, 9), (0.0, 100.0, 10), (20.0, 60.0, 4)):
        block = metrics.rise_time(low_percent=low, high_percent=high)
        assert measure(block, np.ones(16), rising) == pytest.approx(samples * DT, rel=1e-9)


def test_only_the_last_move_counts():
    command = np.concatenate([np.full(100, 1.0), np.full(100, 0.5)])
    actual = np.concatenate([[0.0], np.full(99, 1.4), np.full(99, 0.4), [0.5]])
    actual[100] = 1.4
    assert measure(metrics.overshoot, command[:100], actual[:100]) == pytest.approx(0.4)
    assert measure(metrics.overshoot, command, actual) == pytest.approx(0.1)
    assert measure(metrics.settling_time, command, actual) == pytest.approx(99 * DT)


def test_settling_is_nan_outside_the_band_at_the_end_and_rise_is_nan_short_of_the_level():
    command, actual = np.ones(50), np.linspace(0, 0.5, 50)
    assert math.isnan(measure(metrics.settling_time, command, actual))
    assert math.isnan(measure(metrics.rise_time, command, actual))
    assert measure(metrics.settling_time(band=0.6), command, actual) == pytest.approx(40 * DT)


def test_settling_after_a_long_move_counts_from_its_end_with_the_band_of_the_whole_move():
    command = np.concatenate([np.zeros(10), np.linspace(0, 10, 101)[1:], np.full(100, 10.0)])
    actual = np.concatenate([np.zeros(15), command[:-15]])
    # The command's last change is at sample 109; 15 periods later 0.1 per sample is left, inside 2 % of 10 two earlier.
    assert measure(metrics.settling_time, command, actual) == pytest.approx(13 * DT)
    assert measure(metrics.overshoot, command, actual) == 0.0
    assert math.isnan(measure(metrics.rise_time, command, actual))


@pytest.mark.parametrize("level", [0.0, 5.0, -5.0])
def test_a_loop_that_rests_has_no_overshoot_and_no_rise_time_wherever_it_rests(level):
    at_rest = np.full(20, level)
    assert math.isnan(measure(metrics.overshoot, at_rest, at_rest))
    assert math.isnan(measure(metrics.rise_time, at_rest, at_rest))
    assert measure(metrics.settling_time, at_rest, at_rest) == 0.0


def test_a_command_that_never_stops_has_no_overshoot_and_no_settling_time():
    t = np.arange(200) * DT
    command, actual = np.sin(20.0 * t), 1.01 * np.sin(20.0 * t - 0.001)
    for name in ("overshoot", "rise_time", "settling_time"):
        assert math.isnan(measure(getattr(metrics, name), command, actual)), name
    rest = np.concatenate([command, np.full(5, command[-1])])
    there = np.concatenate([actual, np.full(5, command[-1])])
    assert measure(metrics.settling_time(percent=0.0, band=1e-3), rest, there) == pytest.approx(DT)


@settings(max_examples=60, deadline=None)
@given(
    # Steps of a thousandth, a little beside the marks: a sample on the very edge of a band may fall to either side.
    st.lists(
        st.tuples(st.sampled_from([0.0, 1.0, -2.0]), st.integers(-3000, 3000).map(lambda k: k / 1000 + 1.4142e-5)),
        min_size=2,
        max_size=40,
    ),
)
def test_streaming_and_recorded_step_metrics_agree_on_any_signal(samples):
    command, actual = (np.array(x) for x in zip(*samples, strict=True))
    t = np.arange(len(command)) * DT
    recorded = step_metrics(t, command, actual)
    assert measure(metrics.overshoot, command, actual) == pytest.approx(recorded.overshoot, abs=1e-12, nan_ok=True)
    for name in ("rise_time", "settling_time"):
        value = measure(getattr(metrics, name), command, actual)
        assert value == pytest.approx(getattr(recorded, name), rel=1e-9, abs=1e-12, nan_ok=True), name


def test_the_standard_set_is_complete_and_made_of_metrics():
    assert list(metrics.STANDARD) == [
        "rms_error",
        "max_error",
        "iae",
        "ise",
        "itae",
        "overshoot",
        "rise_time",
        "settling_time",
        "steady_state_error",
        "effort",
        "chatter",
        "zero_crossing_rate",
    ]
    for name, block in metrics.STANDARD.items():
        assert block.kind == "metric" and block.name == name and block.doc and callable(block.output)
