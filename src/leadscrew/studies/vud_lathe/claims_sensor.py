"""Claims about the grating ruler: the fringe of (1), the count, and the errors of the two signals and their correction.

Arithmetic only, no loop. Where noise is drawn the seed is :data:`SEED` and the tolerance is three standard deviations
of the same number over seeds 0 to 29 (:data:`SPREAD`), plus half a unit of the expected number's last digit.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from leadscrew.report.claim import Claim, Group, Kind, Sense, Verdict
from leadscrew.sensors.grating.counting import analytic_counts, counted, fastest, longest_period
from leadscrew.sensors.grating.heydemann import fit_ellipse
from leadscrew.sensors.grating.moire import GRATING, fringe_width, magnification, small_angle_error
from leadscrew.sensors.grating.quadrature import (
    PERFECT,
    Floats,
    SignalErrors,
    first_order_error,
    interpolation_error,
    quadrature,
)

SEED = 0
ANGLE_RAD = math.radians(0.1)
"""A small crossing angle of the gratings: our example, the paper prints none."""
TOP_SPEED_MM_S = 258.7
"""Largest speed of the axis, 25.87 mm in 0.1 s (step 1)."""
PERIOD_S = 0.001

TRIAL = SignalErrors(offset_u=0.05, offset_v=-0.03, gain=0.1, phase=math.radians(5.0))
"""Signals of a reader as it comes out of its box: our assumption, no number of it is the paper's."""
ALONE = {
    "offset": (SignalErrors(offset_u=0.05), "an offset of 5 %", 0.0796, 0.0796),
    "gain": (SignalErrors(gain=0.1), "amplitudes 10 % apart", 0.0758, 0.0796),
    "harmonic": (SignalErrors(harmonic=0.02), "a third harmonic of 2 %", 0.0318, 0.0318),
    "phase": (SignalErrors(phase=math.radians(5.0)), "a phase error of 5 degrees", 0.139, 0.1389),
    "together": (TRIAL, "offsets of 5 % and -3 %, 10 % and 5 degrees together", 0.193, 0.195),
}
"""Errors of the signals, and the largest error of position that each makes: exact, and by the first-order formula."""
NOISES = (0.0, 0.005, 0.02)
POINTS = 40_000
"""Logged samples of one pitch for the ellipse; a peak over fewer would be smaller."""
SPREAD: dict[str | float, float] = {
    "count": 0.0129,
    0.005: 1.9e-5,
    0.02: 7.5e-5,
    "peak before": 0.0085,
    "peak after": 0.0073,
}
"""Standard deviations over seeds 0 to 29 of the numbers with noise, um; a test measures them again."""
NOT_SAID = "the paper gives no errors of its reader"


def there_and_back() -> Floats:
    """10,000 positions in mm, about half a count apart, with a reversal."""
    return np.concatenate([np.linspace(0.0, 1.25, 5000), np.linspace(1.25, -0.35, 5000)])


def disagreements(errors: SignalErrors, noise: float) -> int:
    """At how many of the 10,000 positions the counter differs from the count worked out in one go."""
    x = there_and_back()
    u, v = quadrature(x, errors=errors, noise=noise, seed=SEED)
    in_one_go = analytic_counts(x, interpolation_error(x, u, v))
    return int(np.count_nonzero(counted(u, v) != in_one_go))


def noisy_count_um(seed: int) -> float:
    """The largest error of 10,000 counts along 1 mm with noise of 2 % on each signal."""
    x = np.linspace(0.0, 1.0, 10_000)
    u, v = quadrature(x, noise=0.02, seed=seed)
    return float(1000.0 * np.abs(GRATING.resolution_mm * counted(u, v) - x).max())


def corrected_um(noise: float, seed: int) -> tuple[float, float, float, float]:
    """Standard deviation before and after Heydemann's correction, largest error before and after; over one pitch."""
    x = GRATING.pitch_mm * np.arange(POINTS) / POINTS
    u, v = quadrature(x, errors=TRIAL, noise=noise, seed=seed)
    raw = 1000.0 * interpolation_error(x, u, v)
    left = 1000.0 * interpolation_error(x, *fit_ellipse(u, v).corrected(u, v))
    return float(raw.std()), float(left.std()), float(np.abs(raw).max()), float(np.abs(left).max())


@lru_cache(maxsize=1)
def sensor_claims() -> list[Claim]:
    """All of them."""
    return [*_fringe(), *_count(), *_signals(), *_correction()]


def _claim(
    name: str,
    source: str,
    statement: str,
    paper: float | str | None,
    measured: float | str,
    target: float | str | None,
    tolerance: float,
    reason: str,
    unit: str = "um",
    verdict: Verdict = "cannot be checked",
    sense: Sense = "=",
    kind: Kind = "required",
    group: Group = "ours",
) -> Claim:
    return Claim(
        f"vud_lathe.{name}", source, group, "arithmetic", statement, paper, measured, unit, sense, target, tolerance,
        kind, verdict, reason,
    )  # fmt: skip


def crossed_period_mm(lines_per_mm: float, angle_rad: float) -> float:
    """Width of the fringe from the two gratings' wave vectors: 1 over the length of their difference. Without (1)."""
    first, second = (
        lines_per_mm * np.array([math.cos(a), math.sin(a)]) for a in (-0.5 * angle_rad, 0.5 * angle_rad)
    )  # fmt: skip
    return 1.0 / float(np.linalg.norm(first - second))


def _fringe() -> list[Claim]:
    width = fringe_width(GRATING.pitch_mm, ANGLE_RAD)
    vectors = crossed_period_mm(GRATING.lines_per_mm, ANGLE_RAD)
    as_number = fringe_width(GRATING.lines_per_mm, ANGLE_RAD)
    fits = math.isclose(as_number, vectors, rel_tol=1e-6)
    short = (0.1, 5.0)
    losses = [small_angle_error(math.radians(a)) for a in short]
    no_angle = "the paper prints neither an angle nor a width"
    return [
        _claim("eq1_fringe_width", "(1)", "width of the fringe of a pitch of 0.01 mm at 0.1 degrees", None, width,
               5.730, 5e-4, no_angle, "mm", group="as printed"),
        _claim("eq1_magnification", "(1)", "k_w at 0.1 degrees", None, magnification(ANGLE_RAD), 573.0, 0.5, no_angle,
               "1", group="as printed"),
        _claim("eq1_short_form_01", "(1)", "what the short form w/theta loses at 0.1 degrees", None, losses[0], 1.3e-7,
               5e-9, "about theta^2/24: the short form is as good as exact", "1", group="as printed"),
        _claim("eq1_short_form_5", "(1)", "what the short form w/theta loses at 5 degrees", None, losses[1], 3.2e-4,
               5e-6, "about theta^2/24: negligible beside 1 % even here", "1", group="as printed"),
        _claim("eq1_unit", "(1), text", "w in (1) is a number of grooves per mm", "yes", "yes" if fits else "no", "no",
               0.0, f"put in as 100 per mm it makes a fringe of {as_number / 1000.0:.1f} m; the wave vectors of the "
               f"two gratings make {vectors:.3f} mm, which (1) gives with the pitch of {GRATING.pitch_mm:g} mm", "",
               _agreed(fits, otherwise="not reproduced"), "yes/no", group="as printed"),
    ]  # fmt: skip


def _agreed(yes: bool, otherwise: Verdict) -> Verdict:
    return "reproduced" if yes else otherwise


def _count() -> list[Claim]:
    length = 1000.0 * GRATING.resolution_mm
    x = np.linspace(0.0, 0.05, 100_001)
    ideal = float(1000.0 * np.abs(GRATING.resolution_mm * counted(*quadrature(x)) - x).max())
    slow, period = fastest(GRATING.resolution_mm, PERIOD_S), longest_period(GRATING.resolution_mm, TOP_SPEED_MM_S)
    rows = [
        _claim("count_length", "section III, end", "length of one count: 16 a pitch of 0.01 mm", 0.625, length, 0.625,
               1e-9, "0.01 mm / 16", verdict=_agreed(math.isclose(length, 0.625), "not reproduced"),
               group="as printed"),
        _claim("count_error", "section III, end", "largest error of the count with ideal signals", "micrometre grade",
               ideal, 0.3125, 1e-6, "half a count; the errors of the signals and of the scale itself come on top",
               verdict=_agreed(ideal < 1.0, "not reproduced"), sense="<=", group="as printed"),
    ]  # fmt: skip
    for name, errors, noise, text in (
        ("counter_ideal", PERFECT, 0.0, "ideal signals"),
        ("counter_errors", TRIAL, 0.02, "errors and noise of 2 % on the signals"),
    ):
        rows.append(
            _claim(name, "section III", f"positions of 10,000, both ways, where the comparator chain and the count in "
                   f"one go differ; {text}", None, disagreements(errors, noise), 0, 0.0,
                   "loops of 1 ms may work the count out in one go", "positions")
        )  # fmt: skip
    return [
        *rows,
        _claim("fringe_rate", "section III, step 1", "periods of the signals per second at 258.7 mm/s", None,
               GRATING.fringe_rate_hz(TOP_SPEED_MM_S) / 1000.0, 25.9, 0.05, "speed over pitch", "kHz"),
        _claim("count_rate", "section III, step 1", "counts per second at 258.7 mm/s", None,
               GRATING.count_rate_hz(TOP_SPEED_MM_S) / 1000.0, 414.0, 0.5, "sixteen times as many", "kHz"),
        _claim("counter_speed", "section III", "speed up to which a counter sampled every 1 ms loses nothing", None,
               slow, None, 0.0, f"at {TOP_SPEED_MM_S} mm/s it takes a sample every {1e6 * period:.1f} us: the paper's "
               "counter must be a circuit, not a program of the 1 ms loop", "mm/s", kind="report"),
        _claim("count_noise", "section III", "largest error of 10,000 counts with noise of 2 % on each signal", None,
               noisy_count_um(SEED), 0.415, 3.0 * SPREAD["count"] + 5e-4,
               f"{NOT_SAID}; seed {SEED}, other seeds differ by {SPREAD['count']:.3f} um (standard deviation)"),
    ]  # fmt: skip


def _signals() -> list[Claim]:
    x = GRATING.pitch_mm * np.arange(100_000) / 100_000
    rows = []
    for name, (errors, text, largest, largest_formula) in ALONE.items():
        exact = 1000.0 * interpolation_error(x, *quadrature(x, errors=errors))
        formula = 1000.0 * first_order_error(x, errors=errors)
        digits = 5e-4 if largest > 0.1 else 5e-5
        rows += [
            _claim(f"signal_{name}", "section III", f"largest error of position from {text}", None,
                   float(np.abs(exact).max()), largest, digits, f"{NOT_SAID}; before rounding to counts"),
            _claim(f"signal_{name}_formula", "section III", f"the same by the first-order formula; {text}", None,
                   float(np.abs(formula).max()), largest_formula, 5e-4 if name == "together" else 5e-5,
                   f"the formula is {100.0 * abs(np.abs(formula).max() / np.abs(exact).max() - 1.0):.1f} % off"),
        ]  # fmt: skip
        if name == "phase":
            rows.append(
                _claim("signal_phase_swing", "section III", f"half of peak to peak of the error from {text}", None,
                       0.5 * float(np.ptp(exact)), 0.0695, 5e-5, "the rest of the error is a constant shift")
            )  # fmt: skip
    return rows


def _harmonic_ratio() -> float:
    x = GRATING.pitch_mm * np.arange(1000) / 1000
    u, v = quadrature(x, errors=ALONE["harmonic"][0])
    before, after = (
        np.abs(interpolation_error(x, *pair)).max() for pair in ((u, v), fit_ellipse(u, v).corrected(u, v))
    )
    return float(after / before)


def _correction() -> list[Claim]:
    found = {noise: corrected_um(noise, SEED) for noise in NOISES}
    left = {
        0.0: ("0pct", 0.0, 1e-6, "without noise nothing is left"),
        0.005: ("05pct", 0.0076, 3.0 * SPREAD[0.005] + 5e-5, "what is left is the noise itself"),
        0.02: ("2pct", 0.0305, 3.0 * SPREAD[0.02] + 5e-5, "what is left is the noise itself"),
    }
    gain = {noise: raw / max(after, 1e-9) for noise, (raw, after, _, _) in found.items()}
    harmonic = _harmonic_ratio()
    drawn = f"seed {SEED}, {POINTS:,} samples of one pitch"
    rows = [
        _claim("heydemann_before", "section III", "standard deviation of the error of the trial signals, without noise",
               None, found[0.0][0], 0.0957, 5e-5, f"{NOT_SAID}; about its mean, since a constant shift does no harm")
    ]  # fmt: skip
    rows += [
        _claim(f"heydemann_after_{key}", "section III",
               f"standard deviation after the ellipse's correction, noise of {100 * noise:g} % on each signal", None,
               found[noise][1], target, tolerance, f"{drawn}; {text}")
        for noise, (key, target, tolerance, text) in left.items()
    ]  # fmt: skip
    return [
        *rows,
        _claim("heydemann_reduction", "section III", "least reduction of the standard deviation at noise up to 0.5 %",
               None, min(gain[0.0], gain[0.005]), 10.0, 0.0, f"{drawn}; at 2 % the reduction is {gain[0.02]:.1f}", "1",
               sense=">="),
        _claim("heydemann_harmonic", "section III", "error after the correction over that before it, with a third "
               "harmonic alone", None, harmonic, None, 0.0, "a third harmonic looks like unequal amplitudes to the "
               f"ellipse: the correction makes its error {harmonic:.1f} times as large", "1", kind="report"),
        _claim("heydemann_peak_before", "section III", "largest error before the correction, noise of 2 %", None,
               found[0.02][2], 0.30, 3.0 * SPREAD["peak before"] + 5e-3,
               f"{drawn}; more samples give a larger peak"),
        _claim("heydemann_peak_after", "section III", "largest error after the correction, noise of 2 %", None,
               found[0.02][3], 0.136, 3.0 * SPREAD["peak after"] + 5e-4,
               f"{drawn}; more samples give a larger peak"),
    ]  # fmt: skip
