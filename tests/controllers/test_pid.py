"""The PID against its own formula, SciPy, python-control, and the known numbers of the XY table's loop."""

import numpy as np
import pytest
from scipy import signal
from scipy.linalg import expm

from leadscrew.plants._xy_table import xy_table
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from leadscrew.util.errors import ValueRefused
from tests.controllers.xy_loop import PERIOD, outputs, xy_loop

RNG = np.random.default_rng(11)
COMMANDS, FEEDBACKS = RNG.normal(size=400), RNG.normal(size=400)


def test_the_plain_law_comes_out_bit_for_bit():
    p, total, last, expected = table_pid.params, 0.0, 0.0, []
    for command, feedback in zip(COMMANDS.tolist(), FEEDBACKS.tolist(), strict=True):
        error = command - feedback
        total = total + error * PERIOD
        expected.append(p.kp * error + p.ki * total + p.kd * (error - last) / PERIOD)
        last = error
    assert outputs(table_pid, COMMANDS, FEEDBACKS) == expected


@pytest.mark.parametrize("lag", [0.0, 2e-3])
def test_the_difference_equation_is_the_one_of_the_z_transform(lag):
    """Kp + ki T / (1 - z^-1) + kd (1 - z^-1) / (lag + T - lag z^-1), run by SciPy on command and feedback alone."""
    block = table_pid(kp=2.0, ki=30.0, kd=0.01, b=0.4, c=0.1, filter_s=lag)
    p = block.params

    def response(x, weight_p, weight_i, weight_d):
        integral = signal.lfilter([PERIOD], [1.0, -1.0], x)
        slope = signal.lfilter([1.0, -1.0], [lag + PERIOD, -lag], x)
        return weight_p * p.kp * x + weight_i * p.ki * integral + weight_d * p.kd * slope

    expected = response(COMMANDS, p.b, 1.0, p.c) - response(FEEDBACKS, 1.0, 1.0, 1.0)
    assert outputs(block, COMMANDS, FEEDBACKS) == pytest.approx(expected, rel=1e-11, abs=1e-11)


def test_a_derivative_of_the_measurement_is_not_kicked_by_a_step_of_the_command():
    kicked = outputs(table_pid(ki=0.0), [1.0, 1.0], [0.0, 0.0])
    smooth = outputs(table_pid(ki=0.0, c=0.0), [1.0, 1.0], [0.0, 0.0])
    assert kicked[0] == pytest.approx(1.32 + 0.006805 / PERIOD) and kicked[1] == 1.32
    assert smooth == [1.32, 1.32]


def wound_up(block, periods=400, error=1.0):
    s = block.state
    for _ in range(periods):
        s, u = block.step(block.params, s, error, 0.0, PERIOD)
    return s, u


def test_without_anti_windup_the_integral_grows_at_the_limit():
    s, u = wound_up(table_pid(ki=100.0, lower=-5.0, upper=5.0, anti_windup=0))
    assert u == 5.0 and s.integral == pytest.approx(400 * PERIOD)


def test_clamping_stops_the_integral_at_the_limit_and_lets_it_return_at_once():
    block = table_pid(ki=100.0, kd=0.0, lower=-5.0, upper=5.0, anti_windup=1)
    s, u = wound_up(block)
    assert u == 5.0 and 5.0 - 100.0 * PERIOD < 1.32 + 100.0 * s.integral <= 5.0
    after, _ = block.step(block.params, s, -0.1, 0.0, PERIOD)
    assert after.integral < s.integral
    s, u = wound_up(block, error=-1.0)
    assert u == -5.0 and -5.0 <= -1.32 + 100.0 * s.integral < -5.0 + 100.0 * PERIOD


@pytest.mark.parametrize("tracking", [0.004, 0.0])
def test_back_calculation_balances_the_error_against_the_excess(tracking):
    """Where the integral stands still, ki e T = share (raw - limit), with share = T / max(tracking, T)."""
    block = table_pid(ki=100.0, kd=0.0, lower=-5.0, upper=5.0, anti_windup=2, tracking_s=tracking)
    s, u = wound_up(block)
    excess = 1.32 + 100.0 * (s.integral + PERIOD) - 5.0
    assert u == 5.0 and excess == pytest.approx(100.0 * max(tracking, PERIOD))


@pytest.mark.parametrize("rule", [1, 2])
def test_anti_windup_takes_the_overshoot_of_a_saturated_step(rule):
    tuned = TUNINGS["ours.pid_ms_159"]
    moved = [
        xy_loop(tuned(lower=-0.5, upper=0.5, anti_windup=kind, tracking_s=0.01), step(target=20.0)).run(1.5)
        for kind in (0, rule)
    ]
    wound, held = (run["actual"].max() - 20.0 for run in moved)
    assert held < 0.5 * wound and abs(moved[1]["true_error"][-1]) < 0.01


def test_the_printed_gains_are_a_pd_in_practice():
    run = xy_loop(table_pid, step(target=0.01)).run(1.0)
    assert 100.0 * run["true_error"][-1] / 0.01 == pytest.approx(0.181, abs=5e-4)
    assert 100.0 * (run["actual"].max() / 0.01 - 1.0) == pytest.approx(20.8, abs=0.05)


def test_a_sine_of_1_mm_leaves_the_error_of_the_loops_frequency_response():
    run = xy_loop(table_pid, sine(frequency=0.7)).run(12.0)
    assert 1e3 * np.abs(run["true_error"][4000:]).max() == pytest.approx(7.12, abs=0.01)


def open_loop(block):
    """The sampled loop of python-control: PID, delay of one period and 0.275 ms, exact plant."""
    import control

    joined = np.zeros((3, 3))
    joined[:2] = [[0.0, 1.0, 0.0], [-166.3, -144.8, 69380.0]]

    def step_of(h):
        e = expm(h * joined)
        return e[:2, :2], e[:2, 2]

    late = 0.275e-3
    a, _ = step_of(PERIOD)
    after, new = step_of(PERIOD - late)
    old = after @ step_of(late)[1]
    a4 = np.zeros((4, 4))
    a4[:2, :2], a4[:2, 2], a4[:2, 3], a4[2, 3] = a, old, new, 1.0
    delayed = control.ss(a4, [[0], [0], [0], [1.0]], [[1.0, 0, 0, 0]], 0, PERIOD)
    p = block.params
    num = [p.kp * PERIOD + p.ki * PERIOD**2 + p.kd, -p.kp * PERIOD - 2.0 * p.kd, p.kd]
    return control.ss(control.tf(num, [PERIOD, -PERIOD, 0], PERIOD)) * delayed


@pytest.mark.parametrize(
    ("name", "gain_margin", "peak"),
    [("paper.pid", 2.510, 1.87), ("ours.pid_ms_159", 3.70, 1.59), ("ours.pid_ms_185", 2.89, 1.85)],
)
def test_the_loop_becomes_unstable_at_python_controls_gain_margin(name, gain_margin, peak):
    import control

    block = TUNINGS[name]
    margin, _, distance, *_ = control.stability_margins(open_loop(block))
    assert margin == pytest.approx(gain_margin, abs=0.005) and 1.0 / distance == pytest.approx(peak, abs=0.01)
    for factor, grows in ((0.99, False), (1.01, True)):
        k = factor * margin
        p = block.params
        run = xy_loop(block(kp=k * p.kp, ki=k * p.ki, kd=k * p.kd), step(target=1e-3)).run(2.0, record="actual")
        early, late = (np.ptp(run["actual"][a:b]) for a, b in ((1000, 1400), (3600, 4000)))
        assert (late > early) == grows


def test_another_pid_takes_over_without_a_bump():
    live = xy_loop(TUNINGS["ours.pid_ms_159"], sine(amplitude=5.0, frequency=0.7)).start()
    live.advance(1000)
    expected = live.advance_preview()["output"]
    after = live.switch(TUNINGS["ours.pid_ms_185"](filter_s=1e-3, b=0.5, c=0.0, lower=-9.0, upper=9.0))
    assert after.bumpless
    assert after.advance(1)["output"][0] == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("command", "feedback", "output"), [(1.0, 0.25, -3.0), (-2.0, 5.0, 7.5)])
def test_the_first_output_after_an_align_is_the_last_one_before(command, feedback, output):
    block = table_pid(ki=12.0, b=0.7, c=0.2, filter_s=1e-3)
    s = block.align(block.params, command, feedback, output)
    s, u = block.step(block.params, s, command, feedback, PERIOD)
    assert u == pytest.approx(output, abs=1e-12)
    _, v = block.step(block.params, s, command, feedback, PERIOD)
    assert v - u == pytest.approx(12.0 * (command - feedback) * PERIOD)


def test_without_integral_action_an_align_starts_from_the_proportional_term():
    block = table_pid(ki=0.0)
    _, u = block.step(block.params, block.align(block.params, 2.0, 1.0, 9.0), 2.0, 1.0, PERIOD)
    assert u == 1.32


@pytest.mark.sweep
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"anti_windup": 2, "filter_s": 1e-3, "lower": -0.3, "upper": 0.3, "ki": 50.0, "b": 0.3, "c": 0.0},
        {"ki": 0.0},
    ],
)
def test_all_engines_give_the_same_bits(changes):
    loop = xy_loop(table_pid(**changes), sine(amplitude=4.0, frequency=3.0))
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_a_filtered_derivative_decays_to_zero_and_not_to_denormal_numbers():
    s = outputs_state(table_pid(filter_s=5e-3), [1.0] + [0.0] * 5000)
    assert s.slope == 0.0


def outputs_state(block, errors):
    s = block.state
    for error in errors:
        s, _ = block.step(block.params, s, error, 0.0, PERIOD)
    return s


def test_unknown_rules_and_negative_gains_are_refused():
    with pytest.raises(ValueRefused, match=r"anti_windup = 3 .*none, clamping, back-calculation"):
        table_pid(anti_windup=3)
    with pytest.raises(ValueRefused, match=r"kp = -1.0"):
        table_pid(kp=-1.0)


def test_the_table_is_the_printed_transfer_function():
    inputs = RNG.normal(size=300)
    p, s, seen = xy_table.prepare(xy_table.params, PERIOD), xy_table.state, []
    for u in inputs:
        seen.append(s.position)
        s = xy_table.step(p, s, float(u), PERIOD)
    t = PERIOD * np.arange(300)
    expected = signal.lsim(([69380.0], [1.0, 144.8, 166.3]), inputs, t, interp=False)[1]
    assert seen == pytest.approx(expected, abs=1e-10)
