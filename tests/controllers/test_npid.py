"""The nonlinear PID against worked numbers, the two readings of its clip and unit, and its known limit cycle."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.controllers._npid import NPIDParams, npid, scaled_error
from leadscrew.kernel.block import disturbance
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.tunings import TUNINGS, table_pid
from tests.controllers.xy_loop import PERIOD, outputs, xy_loop

UM = 1e-3


def gain(error_um, **changes):
    return scaled_error(NPIDParams()._replace(**changes), error_um * UM) / (error_um * UM)


def test_the_gain_of_table_1_is_the_printed_2_35():
    assert gain(3.0) == pytest.approx(2.35241, abs=1e-5) and gain(-300.0) == pytest.approx(2.35241, abs=1e-5)
    assert gain(1.0) == pytest.approx(math.cosh(0.5), rel=1e-14)
    assert gain(math.acosh(2.5) / 0.5, e_max=9.0) == pytest.approx(2.5, rel=1e-14)


def test_the_steepest_slope_is_5_55_and_beyond_e_max_it_is_the_gain():
    def slope(e, h=1e-5):
        p = NPIDParams()
        return (scaled_error(p, (e + h) * UM) - scaled_error(p, (e - h) * UM)) / (2.0 * h * UM)

    x = 1.5
    assert slope(3.0 - 2e-5) == pytest.approx(math.cosh(x) + x * math.sinh(x), rel=1e-4)
    assert slope(3.0 - 2e-5) == pytest.approx(5.5463, abs=5e-4) and slope(4.0) == pytest.approx(2.35241, abs=1e-5)


def test_in_mm_a_micrometre_meets_a_plain_pid():
    assert gain(1.0, error_unit_per_mm=1.0) - 1.0 == pytest.approx(1.25e-7, rel=1e-3)
    assert gain(100.0, error_unit_per_mm=1.0) == pytest.approx(1.00125, abs=1e-6)


def test_a_clipped_error_is_the_gain_times_e_max():
    assert scaled_error(NPIDParams(clip_error=True), -1.0) == pytest.approx(-3.0 * UM * math.cosh(1.5), rel=1e-14)
    assert scaled_error(NPIDParams(clip_error=True), 2.0 * UM) == scaled_error(NPIDParams(), 2.0 * UM)


def test_it_is_the_pid_of_the_scaled_error():
    errors = np.random.default_rng(2).normal(scale=5.0 * UM, size=200)
    scaled = [math.cosh(0.5 * min(abs(e) / UM, 3.0)) * e for e in errors]
    zeros = np.zeros(200)
    assert outputs(npid, errors, zeros) == pytest.approx(outputs(table_pid, scaled, zeros), rel=1e-9)


def worst_um(name, amplitude):
    run = xy_loop(TUNINGS[name], sine(amplitude=amplitude, frequency=0.7)).run(12.0, record="true_error")
    return np.abs(run["true_error"][4000:]).max() / UM


@pytest.mark.parametrize(("amplitude", "inside", "clipped"), [(2.0, 6.06, 1138.0), (15.0, 45.5, 14690.0)])
def test_a_clip_of_the_error_itself_loses_the_sine(amplitude, inside, clipped):
    assert worst_um("corrected.npid_um", amplitude) == pytest.approx(inside, rel=1e-3)
    assert worst_um("corrected.npid_um_clipped", amplitude) == pytest.approx(clipped, rel=1e-3)


@pytest.mark.parametrize(("amplitude", "difference"), [(0.05, 1.6e-8), (1.0, 6.3e-6), (15.0, 1.42e-3)])
def test_as_printed_it_tracks_like_the_pid(amplitude, difference):
    errors = [
        xy_loop(block, sine(amplitude=amplitude, frequency=0.7)).run(12.0)["true_error"][4000:]
        for block in (table_pid, TUNINGS["paper.npid_mm"])
    ]
    apart = np.abs(errors[1] - errors[0]).max() / np.abs(errors[0]).max()
    assert apart == pytest.approx(difference, rel=0.02)


class PushParams(NamedTuple):
    """A constant load that asks for ``f = size_um``, with a kick at the start."""

    size_um: float = 1.0


@disturbance(PushParams())
def push(p, t):
    """The load in volt."""
    return p.size_um * 1.32e-3 + (5e-3 * math.sin(2.0 * math.pi * 190.0 * t) if t < 2.0 else 0.0)


@pytest.mark.parametrize(
    ("size_um", "peak_to_peak"),
    [(2.5, 0.0), (3.0, 2.26), (5.0, 4.89), (7.0, 6.20), (10.0, 7.99), (12.0, 8.98), (15.0, 0.0)],
)
def test_a_constant_load_chatters_where_the_slope_exceeds_the_gain_margin(size_um, peak_to_peak):
    loop = xy_loop(npid, step(target=0.0), disturbance=push(size_um=size_um))
    tail = loop.run(6.0, record="true_error")["true_error"][-1000:] / UM
    assert np.ptp(tail) == pytest.approx(peak_to_peak, rel=0.02, abs=5e-3)
    if peak_to_peak:
        lines = np.abs(np.fft.rfft(tail - tail.mean()))
        assert 187.0 <= np.argmax(lines) / (1000 * PERIOD) <= 193.0


def test_the_first_output_after_an_align_is_the_last_one_before():
    block = npid(ki=5.0)
    s = block.align(block.params, 1.0, 1.0 + 2.5 * UM, 0.7)
    _, u = block.step(block.params, s, 1.0, 1.0 + 2.5 * UM, PERIOD)
    assert u == pytest.approx(0.7, abs=1e-13)


def test_a_positive_error_gives_a_positive_voltage():
    assert npid.sense == 1 and outputs(npid, [1.0], [0.0])[0] > 0.0


@pytest.mark.sweep
@pytest.mark.parametrize("changes", [{}, {"clip_error": True, "error_unit_per_mm": 1.0, "e_max": 0.5}])
def test_all_engines_give_the_same_bits(changes):
    loop = xy_loop(npid(**changes), sine(amplitude=4.0, frequency=3.0))
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.2, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[name], plain[name]) for name in plain.signals)
