"""Frequency responses from logs against python-control's response of the loop that made them, noise and all."""

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import dlsim, lfilter

from leadscrew.analysis.frequency_response import (
    frequency_response,
    loop_gain,
    measured_margins,
    periodic_response,
)
from leadscrew.disturbances._white_noise import white_noise
from leadscrew.kernel.loop import Loop
from leadscrew.plants._xy_table import xy_table
from leadscrew.references._chirp import log_chirp
from leadscrew.sensors._counts import noisy_ruler
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import DataError, ValueRefused

PERIOD, DELAY = 0.5e-3, 0.775e-3


def swept(**more):
    return Loop(
        reference=log_chirp(amplitude=0.1, start_frequency=0.5, end_frequency=900.0, duration=20.0),
        controller=table_pid, plant=xy_table, period=PERIOD, substeps=20, computation_delay=DELAY, metrics={}, **more,
    )  # fmt: skip


@pytest.fixture(scope="module")
def log():
    """A run of the digital loop L* with a swept command."""
    return swept().run(20.0, record=("command", "feedback", "error", "output"))


@pytest.fixture(scope="module")
def l_star():
    """The loop gain of L*, put together by python-control from the printed plant; delay 0.775 ms = 1 + 0.55 periods."""
    a, b = np.array([[0.0, 1.0], [-166.3, -144.8]]), np.array([[0.0], [69380.0]])

    def held(time):
        step = expm(np.block([[a, b], [np.zeros((1, 3))]]) * time)
        return step[:2, :2], step[:2, 2:]

    whole, _ = held(PERIOD)
    after, now = held(2 * PERIOD - DELAY)
    _, late = held(DELAY - PERIOD)
    row, late_one = np.array([[1.0, 0.0]]), control.tf([1], [1, 0], PERIOD)
    parts = [control.ss(whole, part, row, 0.0, PERIOD) for part in (now, after @ late)]
    table = control.tf(parts[0]) * late_one + control.tf(parts[1]) * late_one * late_one
    g = table_pid.params
    law = (
        g.kp + g.ki * PERIOD * control.tf([1, 0], [1, -1], PERIOD)
        + g.kd / PERIOD * control.tf([1, -1], [1, 0], PERIOD)
    )  # fmt: skip
    return table, law


def at(systems, hertz):
    z = np.exp(2j * np.pi * np.asarray(hertz) * PERIOD)
    return np.prod([np.array([complex(s(x)) for x in z]) for s in systems], axis=0)


def test_command_to_feedback_is_the_closed_loop_of_python_control(log, l_star):
    found = frequency_response(log.time, log["command"], log["feedback"], segment=2.0).within(5.0, 700.0)
    loop = at(l_star, found.frequencies)
    assert np.max(np.abs(found.response / (loop / (1.0 + loop)) - 1.0)) < 0.01
    assert np.min(found.coherence) > 0.999 and found.notes == ()


def test_the_loop_gain_from_the_closed_loop_is_the_broken_loop_s(log, l_star):
    found = loop_gain(log.time, log["error"], log["feedback"], log["command"], segment=2.0).within(10.0, 700.0)
    assert np.max(np.abs(found.response / at(l_star, found.frequencies) - 1.0)) < 0.02
    assert np.min(found.coherence) > 0.99


@pytest.mark.slow
def test_the_measured_margins_are_those_of_python_control(log, l_star):
    found = loop_gain(log.time, log["error"], log["feedback"], log["command"], segment=2.0).within(5.0, 900.0)
    margins = measured_margins(found)
    # On its response, not on its polynomials: python-control 0.10.2 finds a false crossover at 20 rad/s in those.
    w = 2 * np.pi * np.linspace(5.0, 900.0, 4000)
    loop = at(l_star, w / (2 * np.pi))
    gain, phase, _, at_gain, at_phase, _ = control.stability_margins(
        (np.abs(loop), np.degrees(np.unwrap(np.angle(loop))), w)
    )
    assert margins.gain_margin == pytest.approx(gain, rel=0.01) == pytest.approx(2.510, abs=0.01)
    assert margins.phase_margin_deg == pytest.approx(phase, abs=0.5)
    assert margins.phase_crossover_hz == pytest.approx(at_gain / (2 * np.pi), rel=0.01)
    assert margins.gain_crossover_hz == pytest.approx(at_phase / (2 * np.pi), rel=0.01)
    assert margins.sensitivity == pytest.approx(1.87, abs=0.02)


@pytest.fixture(scope="module")
def noisy():
    """The same loop at rest, shaken by a white load at the plant's input, read by a noisy encoder."""
    loop = Loop(
        reference=log_chirp(amplitude=0.0), controller=table_pid, plant=xy_table,
        disturbance=white_noise(deviation=0.003), sensor=noisy_ruler(resolution_mm=1e-9, noise_mm=2e-3),
        period=PERIOD, substeps=20, computation_delay=DELAY,
        metrics={},
    )  # fmt: skip
    return loop.run(40.0, record=("output", "feedback", "disturbance"))


@pytest.mark.slow
def test_inside_a_noisy_loop_the_direct_estimate_is_wrong_and_the_one_with_the_excitation_right(noisy, l_star):
    log = noisy
    drive, seen = log["output"], log["feedback"]
    direct = frequency_response(log.time, drive, seen, segment=0.5).within(20.0, 100.0)
    joint = frequency_response(log.time, drive, seen, excitation=log["disturbance"], segment=0.5).within(20.0, 100.0)
    # From the controller's output back to the feedback under a load: the controller's inverse, whatever the plant.
    inverse = -1.0 / at(l_star[1:], joint.frequencies)
    assert np.median(np.abs(joint.response / inverse - 1.0)) < 0.05
    table = at(l_star[:1], direct.frequencies)
    assert np.median(np.abs(direct.response / table - 1.0)) > 0.5


def test_from_an_injected_load_to_the_feedback_it_is_the_disturbance_s_response(noisy, l_star):
    log = noisy
    found = frequency_response(log.time, log["disturbance"], log["feedback"], segment=1.0).within(5.0, 60.0)
    loop, law = at(l_star, found.frequencies), at(l_star[1:], found.frequencies)
    # The load acts at once, the drive after its dead time: the plant without the delay is L e^(s tau) / C.
    early = loop / law * np.exp(2j * np.pi * found.frequencies * DELAY)
    expected = early / (1.0 + loop)
    low, high = found.gain_confidence(0.99)
    inside = (low < np.abs(expected)) & (np.abs(expected) < high)
    assert inside.mean() > 0.9


# ---- intervals, on systems whose response is known
def made(rng, runs, samples=4096, noise=1.0):
    x = rng.normal(size=(runs, samples))
    y = lfilter([0.5, 0.5], [1.0, -0.5], x, axis=-1) + noise * rng.normal(size=(runs, samples))
    return x, y


def truth(hertz, rate=100.0):
    z = np.exp(-2j * np.pi * hertz / rate)
    return (0.5 + 0.5 * z) / (1.0 - 0.5 * z)


@pytest.mark.slow
def test_gain_and_phase_are_inside_their_intervals_as_often_as_they_say():
    t = np.arange(4096) / 100.0
    inside, turned = [], []
    for x, y in zip(*made(np.random.default_rng(1), 60), strict=True):
        found = frequency_response(t, x, y, segment=2.56).within(1.0, 40.0)
        low, high = found.gain_confidence(0.95)
        exact = truth(found.frequencies)
        inside.append((low <= np.abs(exact)) & (np.abs(exact) <= high))
        turned.append(np.abs(np.angle(found.response / exact)) <= found.phase_confidence(0.95))
    assert 0.93 < np.mean(inside) < 0.97 and 0.93 < np.mean(turned) < 0.97


@pytest.mark.slow
def test_h1_is_right_with_noise_on_the_output_and_h2_with_noise_on_the_input():
    t, rng = np.arange(200_000) / 100.0, np.random.default_rng(2)
    x, y = (s[0] for s in made(rng, 1, len(t), 0.0))
    loud = rng.normal(size=len(t))

    def off(a, b, method):
        found = frequency_response(t, a, b, method=method, segment=4.0).within(1.0, 20.0)
        return float(np.mean(found.gain / np.abs(truth(found.frequencies))))

    assert off(x, y + loud, "H1") == pytest.approx(1.0, abs=0.01) and off(x, y + loud, "H2") > 1.3
    assert off(x + loud, y, "H2") == pytest.approx(1.0, abs=0.01) and off(x + loud, y, "H1") < 0.6


def test_coherence_is_the_share_that_scipy_finds():
    from scipy.signal import coherence

    x, y = (s[0] for s in made(np.random.default_rng(3), 1))
    found = frequency_response(np.arange(4096) / 100.0, x, y, segment=2.56)
    f, expected = coherence(x, y, fs=100.0, nperseg=256)
    assert found.frequencies == pytest.approx(f[1:]) and found.coherence == pytest.approx(expected[1:], abs=1e-9)


def test_a_periodic_excitation_is_exact_at_its_lines_and_knows_its_own_scatter():
    rate, period, periods = 100.0, 5.0, 40
    rng = np.random.default_rng(4)
    t = np.arange(int(rate * period) * periods) / rate
    lines = np.array([1.0, 3.0, 10.0, 25.0])
    x = sum(np.cos(2 * np.pi * f * t + k) for k, f in enumerate(lines))
    y = dlsim(([0.5, 0.5], [1.0, -0.5], 1.0 / rate), x)[1][:, 0]
    clean = periodic_response(t, x, y, period)
    assert clean.frequencies == pytest.approx(lines)
    assert clean.response == pytest.approx(truth(lines), abs=1e-9) and np.all(clean.coherence > 1.0 - 1e-9)
    inside = []
    for _ in range(60):
        found = periodic_response(t, x, y + rng.normal(size=len(t)), period)
        low, high = found.gain_confidence(0.95)
        inside.append((low <= np.abs(truth(lines))) & (np.abs(truth(lines)) <= high))
    assert 0.90 < np.mean(inside) < 0.99


def test_python_control_takes_the_response(log):
    found = frequency_response(log.time, log["command"], log["feedback"], segment=2.0).within(10.0, 100.0)
    data = found.to_control()
    assert data.omega == pytest.approx(2 * np.pi * found.frequencies)
    assert np.asarray(data(1j * data.omega)).ravel() == pytest.approx(found.response)


# ---- refusals
def test_noise_alone_is_said_not_shown_as_a_response():
    rng = np.random.default_rng(5)
    found = frequency_response(np.arange(4096) / 100.0, rng.normal(size=4096), rng.normal(size=4096))
    assert "there the log does not tell the response" in found.notes[0]
    assert measured_margins(found).gain_margin is None


@pytest.mark.parametrize(
    ("asked", "error", "says"),
    [
        ({"x": np.ones(4096)}, DataError, "x does not move"),
        ({"excitation": np.ones(4096)}, DataError, "excitation does not move"),
        ({"segment": 30.0}, ValueRefused, "half of the record"),
        ({"segment": 0.01}, ValueRefused, "8 samples"),
        ({"method": "H3"}, ValueRefused, "H1"),
        ({"overlap": 0.95}, ValueRefused, "overlap"),
        ({"y": np.zeros((2, 4096))}, ValueRefused, "expected one record"),
    ],
)
def test_a_log_that_cannot_tell_is_refused(asked, error, says):
    rng = np.random.default_rng(6)
    given = {"t": np.arange(4096) / 100.0, "x": rng.normal(size=4096), "y": rng.normal(size=4096)} | asked
    with pytest.raises(error, match=says):
        frequency_response(given.pop("t"), given.pop("x"), given.pop("y"), **given)


def test_what_is_no_unity_feedback_loop_has_no_loop_gain(log):
    with pytest.raises(DataError, match="forward is not the excitation minus back"):
        loop_gain(log.time, log["output"], log["feedback"], log["command"])
    with pytest.raises(ValueRefused, match=r"the response has frequencies every 0\.5 Hz"):
        frequency_response(log.time, log["command"], log["feedback"], segment=2.0).within(0.1, 0.2)


@pytest.mark.parametrize(
    ("period", "settle", "says"),
    [(0.333, 1, "whole number of samples"), (30.0, 1, "hold 1 periods"), (5.0, 8, "settle")],
)
def test_a_period_that_does_not_fit_is_refused(period, settle, says):
    t = np.arange(4096) / 100.0
    with pytest.raises(ValueRefused, match=says):
        periodic_response(t, np.sin(t), np.sin(t), period, settle=settle)


def test_a_thousandth_of_the_signal_may_be_missing_from_a_loop_s_sum():
    rng = np.random.default_rng(4)
    t, r, b = np.arange(4000) * 1e-3, rng.standard_normal(4000), 0.1 * rng.standard_normal(4000)
    extra = rng.standard_normal(4000)
    extra *= np.std(r - b) / np.std(extra)
    assert loop_gain(t, r - b + 5e-4 * extra, b, r).frequencies[0] > 0.0
    with pytest.raises(DataError, match="no loop with unity negative feedback"):
        loop_gain(t, r - b + 2e-3 * extra, b, r)
