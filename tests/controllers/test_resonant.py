"""Resonators: the difference equation, the loop that places them, and the lines that they remove."""

import math

import control
import numpy as np
import pytest
from scipy import signal

from leadscrew.analysis.stability.loop import sampled_loop
from leadscrew.controllers._inverse_feed_forward import inverse_feed_forward
from leadscrew.controllers._npid import npid
from leadscrew.controllers._resonant import resonant
from leadscrew.controllers._response import law_response, plant_response
from leadscrew.controllers._wrapping import wrapped
from leadscrew.disturbances._five_sines import five_sines
from leadscrew.disturbances._sine_load import sine_load
from leadscrew.plants._xy_table import xy_table
from leadscrew.sensors._counts import noisy_ruler
from leadscrew.studies.npid_xytable.tunings import INVERSE, TUNINGS, XY_TABLE, table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.table_axis import PERIOD, lines_um, rms_um, table_axis, tried

RNG = np.random.default_rng(5)
W = 2.0 * np.pi * np.array([0.7, 7.7, 33.3, 100.0, 700.0])
SILENT = table_pid(kp=0.0, ki=0.0, kd=0.0)


def test_a_resonator_is_the_difference_equation_of_the_digest():
    block, w = resonant(SILENT, [4.9], strength=2.0, model=XY_TABLE), 2.0 * np.pi * 4.9
    h = plant_response(block.params.model, PERIOD, w)
    g, p = 2.0 / abs(h), -np.angle(h)
    errors = RNG.normal(size=500)
    expected = signal.lfilter(
        [g * PERIOD * math.cos(p), -g * PERIOD * math.cos(w * PERIOD - p)],
        [1.0, -2.0 * math.cos(w * PERIOD), 1.0],
        errors,
    )
    assert tried(block, errors.tolist(), np.zeros(500)) == pytest.approx(expected, rel=1e-9, abs=1e-9 * g * PERIOD)


@pytest.mark.parametrize("late", [0.0, 0.3e-3, 0.775e-3, 1.9e-3])
def test_the_believed_table_is_python_controls_with_the_delay_of_the_step(late):
    """Late by theta of a period: the modified z-transform, worked out by python-control from two exact steps."""
    dt, whole = PERIOD, int(late / PERIOD + 1e-9)
    theta = late - whole * dt
    plant = control.ss(control.tf([69380.0], [1.0, 144.8, 166.3]))

    def held(h):
        found = control.c2d(plant, h)
        return np.asarray(found.A), np.asarray(found.B)

    a, _ = held(dt)
    after, new = held(dt - theta)
    old = after @ held(theta)[1] if theta > 1e-9 else 0.0 * new
    z = np.exp(1j * W * dt)
    expected = [(np.asarray(plant.C) @ np.linalg.solve(x * np.eye(2) - a, new + old / x)).item() * x**-whole for x in z]
    assert plant_response(XY_TABLE._replace(dead_time_s=late), dt, W) == pytest.approx(np.array(expected), rel=1e-8)


def test_the_response_of_a_controller_is_that_of_its_z_transform():
    block = TUNINGS["ours.pid_ms_159"](filter_s=1e-3)
    p = block.params
    transfer = control.tf([p.kp], [1.0], PERIOD) + control.tf([p.ki * PERIOD, 0.0], [1.0, -1.0], PERIOD)
    transfer += control.tf([p.kd, -p.kd], [p.filter_s + PERIOD, -p.filter_s], PERIOD)
    part = wrapped(block, "here")
    found = law_response(part.law, p, block.state, part.motion, PERIOD, W)
    assert found == pytest.approx(transfer(np.exp(1j * W * PERIOD)), rel=1e-9)


def test_a_nonlinear_law_counts_by_its_slope_at_rest():
    linear, bent = (wrapped(b, "here") for b in (table_pid, npid))
    responses = [law_response(x.law, x.block.params, x.block.state, x.motion, PERIOD, W) for x in (linear, bent)]
    assert responses[1] == pytest.approx(responses[0], rel=1e-5)


@pytest.mark.parametrize("strength", [pytest.param(0.5, marks=pytest.mark.slow), 2.0])
def test_a_line_decays_at_half_the_strength(strength):
    """Whatever the loop does to that frequency, by which the gain is measured."""
    block = resonant(TUNINGS["ours.pid_ms_159"], [7.7], strength=strength, model=XY_TABLE)
    load = sine_load(amplitude=1e-3, frequency=7.7, phase=0.3)
    run = table_axis(block, amplitude=0.0, disturbance=load).run(8.0)
    parts = [lines_um({"true_error": run["true_error"][: round(t / PERIOD)]}, [7.7], 0.6494)[0] for t in (2.0, 4.0)]
    assert math.log(parts[0] / parts[1]) / 2.0 == pytest.approx(0.5 * strength, rel=0.02)


def test_the_loop_stays_as_stable_as_without_them():
    plain, with_lines = (
        sampled_loop(table_axis(block)) for block in (TUNINGS["ours.pid_ms_159"], TUNINGS["ours.resonant_box"])
    )
    w = np.geomspace(10.0, 6000.0, 20000)
    peaks = [(1.0 / np.abs(1.0 + loop.response(w))).max() for loop in (plain, with_lines)]
    assert peaks[1] == pytest.approx(peaks[0], rel=0.02)
    assert max(abs(with_lines.closed_poles(k)).max() for k in np.linspace(0.25, 3.5, 30)) < 1.0


LINES = (0.7, 2.1, 3.5, 4.9, 6.3, 7.7)


@pytest.mark.slow
def test_every_line_of_table_ii_goes_below_one_hundredth():
    load = five_sines(**{f"{place}.amplitude": 1e-3 for place in five_sines.params._fields})
    blocks = (table_pid, TUNINGS["ours.resonant"])
    before, after = (lines_um(table_axis(block, disturbance=load).run(20.0), LINES) for block in blocks)
    assert (before > 0.7).all() and (after < 0.01 * before).all()


@pytest.mark.slow
def test_a_line_in_the_wrong_place_keeps_what_the_data_sheet_says():
    d, strength = 2.0 * math.pi * 0.1, 1.0
    plain, off = (
        lines_um(table_axis(b, amplitude=0.0, spindle_hz=50.1, spindle_v=1e-3).run(20.0), [50.1])[0]
        for b in (table_pid, resonant(table_pid, [50.0], strength, model=XY_TABLE))
    )
    assert off / plain == pytest.approx(d / math.hypot(d, 0.5 * strength), rel=0.02)


@pytest.mark.parametrize("rpm", [1000, *(pytest.param(r, marks=pytest.mark.slow) for r in (2000, 3000))])
def test_with_known_spindle_lines_the_total_error_is_below_100_nm(rpm):
    """Encoder of 0.5 um, noise of 0.1 um, 1 mm at 0.7 Hz, 1 mV at the spindle's speed, 2 mV at its two teeth."""
    block = TUNINGS["ours.resonant_full"](**{"inner.spindle_hz": rpm / 60.0})
    loop = table_axis(
        block, spindle_hz=rpm / 60.0, spindle_v=1e-3, tooth_v=2e-3,
        disturbance=sine_load(amplitude=1e-3, frequency=2.1),
        sensor=noisy_ruler(resolution_mm=5e-4, noise_mm=1e-4),
    )  # fmt: skip
    assert rms_um(loop.run(20.0)) < 0.1


def test_at_the_limit_of_the_output_resonators_do_not_grow():
    block = resonant(SILENT, [2.1], lower=-1e-3, upper=1e-3, model=XY_TABLE)
    t = PERIOD * np.arange(8000)
    outputs = np.array(tried(block, np.sin(2.0 * np.pi * 2.1 * t).tolist(), np.zeros(8000)))
    free = np.array(
        tried(block(lower=-math.inf, upper=math.inf), np.sin(2.0 * np.pi * 2.1 * t).tolist(), np.zeros(8000))
    )
    assert np.abs(outputs).max() == 1e-3 and np.abs(free).max() > 1.5e-3
    assert np.abs(outputs[-500:]).max() < 1.01e-3 and np.ptp(outputs[-1000:]) > 1e-3


def test_a_cutter_of_one_tooth_has_one_line_at_the_spindles_speed():
    errors = RNG.normal(size=400)
    one, same = (
        tried(resonant(table_pid, lines, model=XY_TABLE, **more), errors.tolist(), np.zeros(400))
        for lines, more in (([0.7], {"spindle_hz": 20.0, "teeth": 1}), ([0.7, 20.0], {}))
    )
    assert one == pytest.approx(same, rel=1e-12, abs=1e-15)


def test_the_parameters_are_those_of_the_inner_controller_and_its_gain_moves_the_phase():
    loop = table_axis(TUNINGS["ours.resonant_full"])
    assert loop.parameters["controller.inner.inner.kp"] == 1.17
    block = resonant(table_pid, model=XY_TABLE)
    before, after = (b.prepare(b.params, PERIOD).lines for b in (block, block(**{"inner.ki": 175.0})))
    assert not np.allclose(before.in_im, after.in_im) and np.array_equal(before.turn_re, after.turn_re)


@pytest.mark.slow
@pytest.mark.parametrize(
    "block",
    [
        TUNINGS["ours.resonant_box"],
        resonant(inverse_feed_forward(TUNINGS["ours.pid_ms_159"], **INVERSE), model=XY_TABLE),
    ],
)
def test_a_resonant_controller_takes_over_without_a_bump(block):
    live = table_axis(
        inverse_feed_forward(TUNINGS["ours.pid_ms_185"], **INVERSE) if "ff" in block.name else table_pid
    ).start()
    live.advance(3000)
    expected = live.advance_preview()["output"]
    after = live.switch(block)
    assert after.bumpless and after.advance(1)["output"][0] == pytest.approx(expected, abs=1e-13)


@pytest.mark.sweep
def test_all_engines_give_the_same_bits():
    loop = table_axis(
        resonant(TUNINGS["ours.pid_ms_159"], lower=-0.02, upper=0.02, model=XY_TABLE),
        disturbance=sine_load(amplitude=1e-3),
    )
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)


def test_wrong_lines_are_refused_in_a_sentence():
    for lines in ([], [[1.0]], [0.7, -2.0], [math.inf]):
        with pytest.raises(ValueRefused, match="expected positive numbers in one row"):
            resonant(table_pid, lines, model=XY_TABLE)
    with pytest.raises(ValueRefused, match=r"\[0.7, 2.1, 0.7\] \(resonant\): expected each frequency once"):
        resonant(table_pid, [0.7, 2.1, 0.7], model=XY_TABLE)
    with pytest.raises(ValueRefused, match=r"1200 Hz \(resonant\).* below half the sampling frequency, here 1000 Hz"):
        table_axis(resonant(table_pid, [1200.0], model=XY_TABLE)).run(0.1)
    with pytest.raises(BlockError, match=r"resonant\(xy_table\)"):
        resonant(xy_table, model=XY_TABLE)
