"""The grating ruler counts: the chain of comparators, its block, and the fast ruler give the same counts."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from leadscrew.actuators._saturation import saturation
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.noise import Noise
from leadscrew.plants._lathe_servo import LathePosition, lathe_servo
from leadscrew.sensors._counts import grating_count
from leadscrew.sensors.grating import _counting as counting
from leadscrew.sensors.grating._counter import grating_counter, sector_of
from leadscrew.sensors.grating._quadrature import (
    PERFECT,
    SignalErrors,
    interpolation_error,
    plan_signals,
    quadrature,
    signals,
)
from leadscrew.sensors.grating._ruler import grating_ruler
from leadscrew.util.errors import ValueRefused
from tests.kernel.loops import COMMANDS, CONTROLLERS

QUIET = Noise(seed=0, run=0, block=0, period=0)
ALL_ERRORS = SignalErrors(offset_u=0.05, offset_v=-0.03, gain=0.1, phase=math.radians(5.0), harmonic=0.02)
ROUGH = SignalErrors(offset_u=-0.2, offset_v=0.15, gain=-0.2, phase=-0.3, harmonic=-0.05)
THERE_AND_BACK = np.concatenate([np.linspace(0.0, 1.25, 5000), np.linspace(1.25, -0.35, 5000)])
"""10,000 points, 0.4 and 0.5 counts apart, a reversal in the middle."""


def reading(block, x, noise=QUIET):
    return block.step(block.prepare(block.params, 1e-3), LathePosition(math.nan, float(x)), noise)


@pytest.mark.parametrize("errors", [PERFECT, ALL_ERRORS, ROUGH])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_the_counter_counts_what_unwrapped_angles_say_there_and_back(errors, noise):
    u, v = quadrature(THERE_AND_BACK, errors=errors, noise=noise, seed=4)
    unwrapped = np.unwrap(np.arctan2(u, v)) / (2.0 * np.pi)
    counted = counting.counted(u, v)
    np.testing.assert_array_equal(counted, np.floor(16.0 * unwrapped + 0.5).astype(int))
    error = interpolation_error(THERE_AND_BACK, u, v)
    np.testing.assert_array_equal(counted, counting.analytic_counts(THERE_AND_BACK, error))
    assert counted.max() > 1990 and counted.min() < -550


@pytest.mark.slow
@pytest.mark.parametrize("errors", [PERFECT, ALL_ERRORS, ROUGH])
def test_the_fast_ruler_and_the_counter_block_agree_count_for_count(errors):
    ruler, counter = grating_ruler(**errors._asdict()), grating_counter(**errors._asdict())
    fast, slow, s = ruler.prepare(ruler.params, 1e-3), counter.prepare(counter.params, 1e-5), counter.state
    reference = counting.counted(*quadrature(THERE_AND_BACK, errors=errors))
    for x, count in zip(THERE_AND_BACK.tolist(), reference.tolist(), strict=True):
        actual = LathePosition(math.nan, x)
        s, counted = counter.step(slow, s, actual, QUIET)
        assert counted == ruler.step(fast, actual, QUIET) == 0.000625 * count


@given(st.floats(-500.0, 500.0))
def test_without_errors_the_ruler_is_the_ideal_count_bit_for_bit(x):
    assert reading(grating_ruler, x) == grating_count.step(grating_count.params, LathePosition(0.0, x))


def test_each_sixteenth_of_a_pitch_has_its_own_code_and_neighbours_differ_in_one_bit():
    middles = (np.arange(16)) * 0.000625
    code = counting.comparators(*quadrature(middles))
    assert len({tuple(bits) for bits in code}) == 16
    assert (np.sum(code ^ np.roll(code, 1, axis=0), axis=1) == 1).all()
    assert counting.sectors(code).tolist() == list(range(16))
    assert [sector_of(float(u), float(v)) for u, v in zip(*quadrature(middles), strict=True)] == list(range(16))


def test_the_direction_decides_the_sign_of_the_count():
    forward = [0, 1, 2, 5, 12, 15, 0, 3]
    assert counting.counts(forward).tolist() == [0, 1, 2, 5, 12, 15, 16, 19]
    assert counting.counts(forward[::-1], count=19, before=3).tolist() == [19, 16, 15, 12, 5, 2, 1, 0]
    assert counting.counts([7, 15, 6]).tolist() == [7, -1, 6]  # 8 sixteenths at once are taken as backward
    p, s = grating_counter.prepare(grating_counter.params, 1e-5), grating_counter.state
    s, _ = grating_counter.step(p, s, LathePosition(math.nan, 0.005), QUIET)
    assert s.counts == -8 and s.sector == 8


def test_an_ideal_count_is_never_more_than_half_a_count_off():
    x = np.linspace(-0.05, 0.05, 200_001)
    error = 0.000625 * counting.counted(*quadrature(x[100_000:])) - x[100_000:]
    assert np.abs(error).max() == pytest.approx(0.0003125, rel=1e-3)
    assert np.abs(error).max() <= 0.0003125 * (1.0 + 1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_sampling_at_the_fastest_speed_loses_nothing_and_a_little_beyond_it_does(way):
    speed, period = counting.fastest(0.000625, 1e-3), 1e-3
    assert speed == pytest.approx(4.375)
    assert counting.longest_period(0.000625, 258.7) == pytest.approx(7 * 0.000625 / 258.7)
    for share, right in ((1.0, True), (1.2, False)):
        x = way * share * speed * period * np.arange(2000) + 1e-5
        equal = counting.counted(*quadrature(x)) == counting.analytic_counts(x)
        assert equal.all() == right


def loop_with(sensor, period):
    return Loop(
        reference=COMMANDS[0], controller=CONTROLLERS[0], plant=lathe_servo, sensor=sensor, actuator=saturation,
        period=period, metrics={}, seed=5,
    )  # fmt: skip


@pytest.mark.slow
def test_a_loop_at_one_millisecond_outruns_the_counter_but_not_the_ruler():
    fast, lost = (loop_with(sensor, 1e-3).run(0.2) for sensor in (grating_ruler, grating_counter))
    away = abs(lost["feedback"][-1] - lost["actual.reading"][-1])
    assert abs(fast["feedback"][-1] - fast["actual.reading"][-1]) <= 0.0003126
    assert away > 0.005 and abs(away / 0.01 - round(away / 0.01)) < 0.05  # whole pitches, but for rounding


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_in_a_compiled_loop_sampled_finely_the_counter_counts_right(noise):
    errors = ALL_ERRORS._asdict()
    counted = loop_with(grating_counter(noise=noise, **errors), 1e-5).run(0.05)
    ruled = loop_with(grating_ruler(**errors), 1e-5).run(0.05)
    for run in (counted, ruled):
        x = run["actual.reading"]
        exact = counting.analytic_counts(x, interpolation_error(x, *quadrature(x, errors=ALL_ERRORS)))
        off = np.abs(np.rint(run["feedback"] / 0.000625) - exact)
        noisy = noise > 0.0 and run is counted
        assert abs(x).max() > 0.5
        assert off.max() == (1 if noisy else 0)  # noise flickers by a count, it never loses one


def test_subdivision_scale_and_leftover_errors_do_what_their_sheet_says():
    x = np.linspace(-0.02, 0.03, 97)
    fine = np.array([reading(grating_ruler(subdivision=256), a) for a in x])
    np.testing.assert_allclose(fine, 0.01 / 256 * np.floor(x / (0.01 / 256) + 0.5), atol=1e-12)
    assert reading(grating_ruler(scale_error=1e-5), 170.0) == pytest.approx(170.0017, abs=0.0003126)
    phi = 2.0 * np.pi * x / 0.01
    block = grating_ruler(subdivision=65536, interpolation_1_mm=2e-4, interpolation_2_mm=1e-4, interpolation_phase=0.7)
    expected = 2e-4 * np.sin(phi + 0.7) + 1e-4 * np.sin(2.0 * phi + 0.7)
    np.testing.assert_allclose([reading(block, a) - a for a in x], expected, atol=0.01 / 65536)


def test_noise_of_the_ruler_has_the_deviation_asked_for():
    block = grating_ruler(subdivision=65536, noise_mm=5e-5)
    read = np.array([reading(block, 0.1234, Noise(seed=2, run=0, block=1, period=k)) for k in range(3000)])
    assert read.mean() == pytest.approx(0.1234, abs=4 * 5e-5 / math.sqrt(3000))
    assert read.std() == pytest.approx(5e-5, rel=0.05)


def test_signals_that_miss_zero_are_refused_and_those_at_the_limit_are_counted():
    with pytest.raises(ValueRefused, match=r"grating_ruler.*round zero"):
        reading(grating_ruler(offset_u=0.5, offset_v=0.4, gain=-0.4), 0.0)
    with pytest.raises(ValueRefused, match=r"grating_counter.*round zero"):
        block = grating_counter(correct_offset_u=0.5, offset_u=-0.5, correct_offset_v=0.4)
        block.prepare(block.params, 1e-5)
    with pytest.raises(ValueRefused, match="offset_u"):
        grating_ruler(offset_u=0.6)
    tried = accepted = 0
    x = np.linspace(0.0, 0.02, 4001)
    for a, b, g, d, h in itertools.product((-0.45, 0.2), (0.0, 0.4), (-0.4, 0.4), (-0.8, 0.5), (-0.1, 0.2)):
        errors = SignalErrors(a, b, g, d, h)
        block = grating_ruler(**errors._asdict())
        tried += 1
        try:
            block.prepare(block.params, 1e-3)
        except ValueRefused:
            continue
        accepted += 1
        u, v = quadrature(x, errors=errors)
        np.testing.assert_array_equal(
            counting.counted(u, v)[-1] - counting.counted(u, v)[0], 32
        )  # two pitches, no count lost
    assert 3 < accepted < tried


def test_whatever_errors_and_correction_are_accepted_the_signals_go_round_zero_once_a_pitch():
    rng, phi, accepted = np.random.default_rng(0), np.linspace(0.0, 2.0 * np.pi, 361), 0
    for _ in range(500):
        errors = SignalErrors(*(rng.uniform(-1.0, 1.0, 5) * (0.5, 0.5, 0.5, 1.0, 0.2)))
        correction = SignalErrors(*(rng.uniform(-1.0, 1.0, 4) * (0.5, 0.5, 0.5, 1.0)))
        try:
            plan = plan_signals(errors, correction, "test")
        except ValueRefused:
            continue
        accepted += 1
        pair = signals(plan, np.sin(phi), np.cos(phi), 0.0, 0.0)
        ahead = np.angle((pair.v + 1j * pair.u) * np.exp(-1j * phi))
        assert np.abs(np.diff(ahead)).max() < 3.0  # never through half a turn, where the count in one go would jump
    assert 100 < accepted < 400


def test_speeds_and_periods_that_mean_nothing_are_refused():
    with pytest.raises(ValueRefused, match=r"period_s = 0\.0"):
        counting.fastest(0.000625, 0.0)
    with pytest.raises(ValueRefused, match=r"speed_mm_s = -1\.0"):
        counting.longest_period(0.000625, -1.0)
