"""Amplitudes of lines: right without noise, with intervals that hold under it, refused where they cannot be told."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.signal.windows import flattop

from leadscrew.analysis.harmonics import (
    LineFit,
    Sampling,
    fitted_fundamental,
    folded,
    least_squares,
    sampling,
    spectrum,
)
from leadscrew.analysis.harmonics.measured import measure
from leadscrew.util.errors import DataError, ValueRefused
from tests.budget import in_every_run

RATE = 2000.0
HZ = (0.7, 2.1, 3.5, 4.9, 6.3, 7.7)
SIZES = np.array([7.12, 0.7865, 0.4205, 0.7650, 0.7670, 0.5239])


def times(samples, start=0.0, rate=RATE):
    return start + np.arange(samples) / rate


def lines(t, frequencies, sizes, phases):
    return sum(a * np.sin(2 * np.pi * f * t + p) for f, a, p in zip(frequencies, sizes, phases, strict=True))


def draws(count, shape=(), seed=0):
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (*shape, count))


def coloured(rng, shape):
    """Noise whose spectrum falls by 40 dB within the band: an autoregression of 0.98 at 2 kHz, corner 6.4 Hz."""
    return 0.1 * lfilter([1.0], [1.0, -0.98], rng.normal(size=shape), axis=-1)


def covered(low, high, truth):
    return float(np.mean((low <= truth) & (truth <= high)))


@pytest.mark.parametrize("samples", [5000, 8192, 20000])
def test_without_noise_amplitudes_and_phases_are_exact_whatever_the_length(samples):
    phases = draws(6)
    t = times(samples, start=3.0)
    found = least_squares(t, lines(t, HZ, SIZES, phases) + 0.4 - 0.02 * t, HZ)
    assert np.max(np.abs(found.amplitudes / SIZES - 1.0)) < 1e-8
    assert np.max(np.abs(found.phases - phases)) < 1e-7
    assert found.trend == pytest.approx(-0.02, abs=1e-9) and found.offset == pytest.approx(0.4 - 0.02 * t.mean())
    assert found.notes == () and np.max(np.abs(found.at(t) - (lines(t, HZ, SIZES, phases) + 0.4 - 0.02 * t))) < 1e-9


def test_it_is_the_least_squares_solution_that_numpy_finds():
    rng = np.random.default_rng(1)
    t = times(3000)
    y = rng.normal(size=3000)
    columns = [f(2 * np.pi * hz * t) for f in (np.sin, np.cos) for hz in HZ]
    x, left, _, _ = np.linalg.lstsq(np.stack([*columns, np.ones(3000), t - t.mean()], axis=1), y, rcond=None)
    found = least_squares(t, y, HZ, noise="white")
    assert found.amplitudes == pytest.approx(np.hypot(x[:6], x[6:12]), rel=1e-9)
    assert found.phases == pytest.approx(np.arctan2(x[6:12], x[:6]), rel=1e-9)
    assert found.residual_rms == pytest.approx(np.sqrt(left[0] / 3000)) and found.dof[0] == 3000 - 14
    expected = np.sqrt(left[0] / (3000 - 14) * 2 / 3000)
    assert found.sd == pytest.approx(np.full(6, expected), rel=0.1)


def test_many_records_at_once_give_what_each_gives_alone():
    rng = np.random.default_rng(2)
    t, y = times(2000), rng.normal(size=(2, 3, 2000))
    fit = LineFit(t, HZ[1:])
    many = fit.fit(y)
    alone = fit.fit(y[1, 2])
    assert many.amplitudes.shape == (2, 3, 5) and many.residual_rms.shape == (2, 3)
    for name in ("amplitudes", "phases", "sd", "level"):
        assert getattr(many, name)[1, 2] == pytest.approx(getattr(alone, name), rel=1e-9)


@pytest.mark.parametrize("size", in_every_run([0.03, 0.5], [0.5]))
@pytest.mark.parametrize("made", ["white", "coloured"])
def test_confidence_intervals_hold_as_often_as_they_say(made, size):
    rng = np.random.default_rng(3)
    runs, t, hz = 300, times(8192), (6.3, 12.0, 30.0)
    noise = rng.normal(size=(runs, 8192)) if made == "white" else coloured(rng, (runs, 8192))
    phases = draws(3, (runs,))
    y = noise + sum(size * np.sin(2 * np.pi * f * t + phases[:, [k]]) for k, f in enumerate(hz))
    found = least_squares(t, y, hz)
    assert 0.93 < covered(*found.confidence(0.95), size) < 0.98
    assert covered(*found.confidence(0.70), size) > 0.65
    if size == 0.5:
        # Below the noise they are wider than they say: the upper end is never less than one standard deviation.
        assert covered(*found.confidence(0.70), size) < 0.76
        off = np.abs(np.angle(np.exp(1j * (found.phases - phases))))
        assert 0.925 < np.mean(off <= found.phase_confidence(0.95)) < 0.975


def test_taking_coloured_noise_for_white_gives_intervals_that_do_not_hold():
    t, hz = times(4096), (2.1, 6.3)
    y = coloured(np.random.default_rng(4), (300, 4096)) + lines(t, hz, (0.5, 0.5), (0.0, 1.0))
    assert covered(*least_squares(t, y, hz, noise="white").confidence(), 0.5) < 0.5
    assert covered(*least_squares(t, y, hz).confidence(), 0.5) > 0.9


def test_where_there_is_no_line_the_interval_begins_at_zero():
    y = np.random.default_rng(5).normal(size=(400, 4096))
    low, high = least_squares(times(4096), y, (5.0, 50.0)).confidence(0.95)
    assert 0.94 < np.mean(low == 0.0) <= 1.0 and np.all(high > 0.0)


def test_a_strong_line_that_is_not_in_the_model_widens_the_intervals_of_the_others():
    t = times(20000)
    y = lines(t, (*HZ, 50.0 / 3), (*SIZES, 1.0), (*draws(6), 0.3))
    low, high = least_squares(t, y, HZ).confidence()
    assert np.all((low < SIZES) & (high > SIZES)) and np.all(high - low < 0.02)


# ---- what a record cannot tell
def test_a_line_above_nyquist_is_refused_with_the_frequency_it_folds_to():
    with pytest.raises(ValueRefused, match=r"1800 Hz is not below half .*\(1000 Hz\).* folds to 200 Hz"):
        least_squares(times(4000), np.zeros(4000), (2.1, 1800.0))
    t = times(4000)
    assert least_squares(t, np.sin(2 * np.pi * 1800 * t), (folded(1800.0, RATE),)).amplitudes[0] == pytest.approx(1.0)
    assert [folded(f, 1000.0) for f in (300.0, 700.0, 1300.0, 1700.0)] == [300.0, 300.0, 300.0, 300.0]


def test_two_lines_closer_than_one_over_the_record_are_noted_with_the_length_they_take():
    found = least_squares(times(1000), np.zeros(1000), (5.0, 6.25))
    assert "0.5 s is too short to separate 5 and 6.25 Hz (Rayleigh): that takes 0.8 s" in found.notes[0]
    assert "less than one period of 0.7 Hz" in least_squares(times(1000), np.zeros(1000), (0.7,)).notes[0]
    rng = np.random.default_rng(6)
    near, far = (least_squares(times(1000), rng.normal(size=1000), (50.0, 50.0 + d), noise="white") for d in (0.2, 5))
    assert near.sd[0] > 3 * far.sd[0]
    with pytest.raises(ValueRefused, match="cannot separate"):
        least_squares(times(1000), np.zeros(1000), (5.0, 5.0 + 1e-7))


@pytest.mark.parametrize(
    ("spoilt", "error", "says"),
    [
        (lambda t, y: (np.where(t == t[7], t + 2e-4, t), y), DataError, "sample 7 at 0.0037 s"),
        (lambda t, y: (t[::-1], y), DataError, "expected times that rise"),
        (lambda t, y: (t, np.where(t == t[9], np.nan, y)), DataError, "y: sample 9 is not a finite number"),
        (lambda t, y: (t, y[:-1]), ValueRefused, "expected 64 samples"),
        (lambda t, y: (t[:2], y[:2]), ValueRefused, "at least 4 times"),
    ],
)
def test_a_bad_record_is_refused_by_name(spoilt, error, says):
    with pytest.raises(error, match=says):
        least_squares(*spoilt(times(64), np.zeros(64)), (100.0,))


@pytest.mark.parametrize(
    ("wanted", "says"),
    [((), "one or more"), ((0.0,), "positive"), ((5.0, 5.0), "given twice"), ((np.nan,), "positive")],
)
def test_bad_frequencies_are_refused(wanted, says):
    with pytest.raises(ValueRefused, match=says):
        least_squares(times(64), np.zeros(64), wanted)


def test_more_unknowns_than_samples_are_refused():
    with pytest.raises(ValueRefused, match="10 samples do not tell 14 unknowns"):
        least_squares(times(10, rate=100.0), np.zeros(10), np.arange(1.0, 7.0) * 7.0)
    with pytest.raises(ValueRefused, match=r"level = 1\.2"):
        least_squares(times(64), np.zeros(64), (100.0,)).confidence(1.2)
    with pytest.raises(ValueRefused, match="noise = 'pink'"):
        least_squares(times(64), np.zeros(64), (100.0,), noise="pink")


# ---- FFT
def test_a_coherent_record_needs_no_window():
    t = times(20000)
    found = spectrum(t, lines(t, HZ, SIZES, draws(6)))
    assert found.amplitude(HZ) == pytest.approx(SIZES, rel=1e-9) and found.notes(HZ) == []
    assert found.amplitude((2.0, 5.0)) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_beside_a_bin_a_lone_line_reads_low_by_the_window_s_own_shape():
    t = times(8192)
    for f in (102.3, 250.07, 333.1):
        y, off = np.sin(2 * np.pi * f * t + 0.7), f * 4.096 - round(f * 4.096)
        assert spectrum(t, y).amplitude((f,))[0] == pytest.approx(np.sinc(off), abs=3e-3)
        hann = spectrum(t, y, "hann")
        assert hann.amplitude((f,))[0] == pytest.approx(np.sinc(off) / (1 - off**2), abs=1e-4)
        assert hann.amplitude((f,), "interpolated")[0] == pytest.approx(1.0, abs=1e-4)
        assert spectrum(t, y).amplitude((f,), "interpolated")[0] == pytest.approx(1.0, abs=6e-3)
        assert spectrum(t, y, "flattop").amplitude((f,))[0] == pytest.approx(1.0, abs=1e-3)
        assert hann.amplitude((f,), "exact")[0] == pytest.approx(1.0, abs=1e-4)


def test_the_window_is_scipy_s_periodic_one():
    y = np.random.default_rng(7).normal(size=512)
    w = flattop(512, sym=False)
    expected = 2.0 * np.abs(np.fft.rfft(w * (y - y.mean()))) / w.sum()
    assert spectrum(times(512), y, "flattop").amplitudes == pytest.approx(expected)


def test_notes_say_why_a_spectrum_misreads_its_lines():
    t = times(8192)
    found = spectrum(t, np.sin(t)).notes((2.1, 3.5))
    assert len(found) == 1 and "2.1 (8.60 periods), 3.5 (14.34 periods)" in found[0] and "leak" in found[0]
    near = spectrum(t, np.sin(t), "flattop").notes((2.1, 3.5))
    assert "5.7 bins apart: with the window flattop a record of 7.14 s separates them" in near[-1]


def test_bad_readings_are_refused():
    found = spectrum(times(512), np.ones(512), "flattop")
    with pytest.raises(ValueRefused, match="interpolated"):
        found.amplitude((100.0,), "interpolated")
    with pytest.raises(ValueRefused, match="reading = 'best'"):
        found.amplitude((100.0,), "best")
    with pytest.raises(ValueRefused, match="window = 'kaiser'"):
        spectrum(times(512), np.ones(512), "kaiser")
    with pytest.raises(ValueRefused, match="folds to 500 Hz"):
        found.amplitude((1500.0,))


# ---- fundamental
@pytest.mark.slow
def test_the_fitted_fundamental_is_inside_its_interval_as_often_as_it_says():
    rng, t, orders = np.random.default_rng(8), times(2000, rate=200.0), (1, 3, 5)
    inside = []
    for run in range(100):
        f0 = 0.7 * (1.0 + rng.uniform(-0.03, 0.03))
        noise = rng.normal(size=2000) if run % 2 else 0.5 * coloured(rng, 2000)
        y = noise + lines(t, [n * f0 for n in orders], (2.0, 0.8, 0.5), rng.uniform(-3, 3, 3))
        low, high = fitted_fundamental(t, y, 0.7, orders).confidence()
        inside.append(low <= f0 <= high)
    assert 0.90 <= np.mean(inside) <= 0.99


def test_the_fitted_fundamental_is_exact_without_noise_and_knows_its_lines():
    t = times(8192)
    f0, phases = 0.7123, draws(6)
    found = fitted_fundamental(t, lines(t, [n * f0 for n in (1, 3, 5, 7, 9, 11)], SIZES, phases), 0.7,
                               (1, 3, 5, 7, 9, 11))  # fmt: skip
    assert found.frequency == pytest.approx(f0, rel=1e-9)
    assert found.harmonics.amplitudes == pytest.approx(SIZES, rel=1e-7)
    assert found.as_dict()["base_hz"] == found.frequency


def test_the_fundamental_agrees_with_a_search_by_scipy():
    from scipy.optimize import minimize_scalar

    rng, t = np.random.default_rng(9), times(3000, rate=300.0)
    y = rng.normal(size=3000) + lines(t, (1.03, 3.09), (3.0, 1.0), (0.1, 1.0))
    left = minimize_scalar(
        lambda f: float(least_squares(t, y, (f, 3 * f), noise="none").residual_rms), bounds=(1.01, 1.05),
        method="bounded", options={"xatol": 1e-10},
    )  # fmt: skip
    assert fitted_fundamental(t, y, 1.0, (1, 3)).frequency == pytest.approx(left.x, abs=2e-7)


def test_other_lines_do_not_bias_the_fundamental_when_they_are_named():
    t = times(20000)
    y = lines(t, (*HZ, 50.0 / 3), (*SIZES, 1.0), (*draws(6), 0.3))
    orders = (1, 3, 5, 7, 9, 11)
    named = fitted_fundamental(t, y, 0.7, orders, others=(50.0 / 3,))
    unnamed = fitted_fundamental(t, y, 0.7, orders)
    assert abs(named.frequency - 0.7) < 1e-10
    assert abs(unnamed.frequency - 0.7) > 1e-6
    assert len(named.harmonics.frequencies) == 6


def test_a_fundamental_outside_its_range_is_refused():
    t = times(8000)
    with pytest.raises(DataError, match=r"no fundamental within 5 % of 5 Hz"):
        fitted_fundamental(t, np.sin(2 * np.pi * 5.6 * t), 5.0)
    with pytest.raises(ValueRefused, match=r"order 3 of 400 Hz .*folds to"):
        fitted_fundamental(t, np.sin(t), 400.0, (1, 3))
    for wrong, says in (({"base": -1.0}, "base"), ({"within": 0.9}, "within"), ({"orders": (1, 1)}, "orders")):
        with pytest.raises(ValueRefused, match=says):
            fitted_fundamental(t, np.sin(t), **({"base": 1.0} | wrong))


# ---- lines by name
def test_motion_and_an_unknown_spindle_are_found_together():
    t = times(20000)
    turn = 1000.0 / 60.0 * 1.013
    y = lines(t, (*(HZ[k] * 1.01 for k in range(6)), turn, 2 * turn), (*SIZES, 0.68, 1.08), draws(8))
    found = measure(t, y, base=0.7, orders=(3, 5, 7, 9, 11), fit_base=True, spindle_rpm=1000.0, teeth=2,
                    fit_spindle=True)  # fmt: skip
    assert found.names == ("order 1", "order 3", "order 5", "order 7", "order 9", "order 11", "spindle", "teeth (2)")
    assert found.harmonics.amplitudes == pytest.approx([*SIZES, 0.68, 1.08], abs=2e-6)
    assert 60.0 * found.spindle.frequency == pytest.approx(1013.0, abs=1e-5)
    assert found.base.frequency == pytest.approx(0.707, abs=1e-8) and found.notes == ()


def test_tooth_passing_above_nyquist_is_measured_at_its_alias_and_said():
    t = times(20000)
    y = lines(t, (410.0, 1640.0), (0.5, 0.2), (0.0, 1.0))
    found = measure(t, y, spindle_rpm=24600.0, teeth=4)
    assert found.harmonics.frequencies == pytest.approx([410.0, 360.0])
    assert found.harmonics.amplitudes == pytest.approx([0.5, 0.2])
    said = "teeth (4) at 1640 Hz is above half the sampling rate: measured at its alias, 360 Hz"
    assert found.notes == (said,)


def test_an_alias_that_falls_on_another_line_is_refused():
    with pytest.raises(ValueRefused, match=r"400 Hz, .*spindle and teeth"):
        measure(times(20000), np.sin(times(20000)), spindle_rpm=24000.0, teeth=4)


def test_a_strong_line_that_nobody_named_is_pointed_out():
    t = times(20000)
    y = lines(t, (0.7, 2.1, 33.3), (7.0, 0.8, 0.5), (0.0, 1.0, 2.0))
    y = y + 0.01 * np.random.default_rng(10).normal(size=20000)
    assert "at 33.3 Hz" in measure(t, y, base=0.7, orders=(3,)).notes[0]
    assert measure(t, y, base=0.7, orders=(3,), lines=(33.3,)).notes == ()


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({}, "no line to measure"),
        ({"orders": (3,)}, "expected its frequency as base"),
        ({"base": 0.7, "teeth": 3}, "need the spindle's speed"),
        ({"base": 0.7, "orders": (2.5,)}, "whole orders"),
        ({"spindle_rpm": -5.0}, "positive speed"),
        ({"spindle_rpm": 1000.0, "teeth": 0}, "whole number from 1"),
    ],
)
def test_a_question_without_sense_is_refused(asked, says):
    with pytest.raises(ValueRefused, match=says):
        measure(times(8000), np.sin(times(8000)), **asked)


def test_sampling_says_its_length_and_nyquist():
    taken = sampling(times(20000, start=5.0))
    assert (taken.samples, taken.duration, taken.nyquist, taken.start) == (20000, pytest.approx(10.0), 1000.0, 5.0)
    assert taken.time == pytest.approx(times(20000, start=5.0)) and isinstance(taken, Sampling)


@pytest.mark.slow
def test_noise_alone_is_no_spindle():
    """By the interval of one line most of these records have one: the best of many places is that large by chance."""
    t, seen, taken = times(3200, rate=200.0), 0, 0
    for seed in range(20):
        y = np.random.default_rng(seed).normal(size=len(t))
        try:
            fitted_fundamental(t, y, 1100.0 / 60.0, (1, 2), 0.02)
        except DataError:
            continue
        seen += 1
        with pytest.raises(DataError, match=r"no fundamental within 2 % of 1100 1/min: .* no better than noise"):
            measure(t, y, spindle_rpm=1100.0, teeth=2, fit_spindle=True)
        y = y + 0.3 * np.sin(2 * np.pi * 1090.0 / 60.0 * t)
        found = measure(t, y, spindle_rpm=1100.0, teeth=2, fit_spindle=True).spindle
        taken += abs(60.0 * found.frequency - 1090.0) < 5.0 * 60.0 * found.sd
    assert seen > 8 and taken == seen


def test_a_line_of_which_there_is_a_part_of_a_period_is_not_to_be_believed():
    t = times(200)
    notes = measure(t, np.sin(2 * np.pi * 30.0 * t), base=0.7, lines=(30.0,)).notes
    assert any(
        "order 1: 0.07 of a period" in n and "do not believe its amplitude" in n and "1.43 s" in n for n in notes
    )
    assert not any(n.startswith("30 Hz") for n in notes)
