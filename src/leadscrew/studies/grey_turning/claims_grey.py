"""Grey models: the digest's vectors, GM(1,1) near a set-point, where it fails, and the errata of its printing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.grey.filters import lead, linearised, noise_gain, response
from leadscrew.grey.predictors import GM, predicted
from leadscrew.grey.vectorised import (
    fit,
    gm11,
    gm11_derivative,
    gm11_exponential,
    gm11_off_by_one,
    gm11_printed,
    gm11_shifted,
)
from leadscrew.grey.vectorised_others import dgm11, limit, line
from leadscrew.grey.window import filled
from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.claims_one_step import cell_claims, one_step_claims, reading_claims
from leadscrew.studies.grey_turning.one_step import SET_POINT, vectors
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said, word

WEIGHTS = np.array([0.0, -0.5, 0.0, 0.5, 1.0])
BIASES = ((-0.3, -1.74, 0.005), (-0.1, -0.12, 0.005), (0.1, -0.046, 0.0005), (0.5, 2.5, 0.05), (1.0, 29.0, 0.5))
"""Rate of an exponential, the digest's bias in percent, and half its last digit."""

arithmetic = partial(said, basis="arithmetic")
printed = partial(said, basis="arithmetic", group="as printed")
corrected = partial(said, basis="arithmetic", group="as corrected")


def grey_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    return [
        *_vectors(), *_symmetry(), *_bias(), *_limit(), *_degenerate(), *_errata(), *cell_claims(),
        *one_step_claims(loops), *reading_claims(loops),
    ]  # fmt: skip


def exponential(rate: float, count: int = 5) -> np.ndarray:
    """100 exp(-rate j)."""
    return 100.0 * np.exp(-rate * np.arange(count))


def _vectors() -> Iterator[Claim]:
    rows = vectors()
    known = [v for v in rows if not math.isnan(v.c)]
    worst = 0.0
    for v in known:
        found, scale = fit(v.samples), 1e-3 * float(np.abs(v.samples).max())
        pairs = (
            (found.c, v.c, 1e-3), (found.u, v.u, scale), (gm11(v.samples), v.prediction, scale),
            (gm11_shifted(v.samples, shift=150.0), v.shifted, 0.15), (line(v.samples), v.line, scale),
        )  # fmt: skip
        worst = max(worst, *(abs(float(ours) - theirs) / max(abs(theirs), least) for ours, theirs, least in pairs))
    yield arithmetic(
        "grey_vectors", "(3) to (12), A1", "largest relative deviation of c, u, prediction, shifted one and line",
        worst, "1", 1e-9, f"{len(known)} windows of the digest's table, of 13 digits, agree to {worst:.1e}; relative "
        "to at least 0.001 in c, a thousandth of the largest sample in u, prediction and line, 0.15 N in the shifted "
        "prediction: below that a relative deviation says nothing", sense="<=",
    )  # fmt: skip
    flagged = [bool(fit(v.samples).singular) for v in rows]
    right = [flag == math.isnan(v.c) for flag, v in zip(flagged, rows, strict=True)]
    last = all(float(gm11(v.samples)) == v.samples[-1] for v in rows if math.isnan(v.c))
    yield arithmetic(
        "grey_singular", "(8), A1", "singular windows are told apart and give their last sample",
        word(all(right) and last), "", "yes",
        f"zeros and alternating samples, {sum(flagged)} of {len(rows)} windows, have D = 0: equation (8) divides by it",
        sense="yes/no",
    )  # fmt: skip


def _symmetry() -> Iterator[Claim]:
    levels = np.concatenate([np.linspace(-1000.0, 1000.0, 2001), 10.0 ** np.arange(-9.0, 10.0)]).tolist()
    worst = max(abs(predicted(GM, filled(v), 1.0, 0.0, 0.0) - v) for v in levels)
    yield arithmetic(
        "grey_constant", "(9), A1", "largest error of the prediction of a constant", worst, "N", 0.0,
        f"{len(levels)} constants; the printed (9) divides by c = 0 there, the form with (exp(c) - 1) / c does not",
    )  # fmt: skip
    draws = np.random.default_rng(1).uniform(50.0, 250.0, (1000, 5))
    odd = float(np.abs(gm11(-draws) + gm11(draws)).max())
    yield arithmetic(
        "grey_odd", "(9), A1", "largest difference of the prediction of -y and minus that of y", odd, "N", 0.0,
        "1,000 random windows: the model is odd, so that a negative force needs no second model",
    )  # fmt: skip
    scaled = float(np.abs(gm11(1000.0 * draws) / (1000.0 * gm11(draws)) - 1.0).max())
    yield arithmetic(
        "grey_homogeneous", "(9)", "largest relative difference of the prediction of 1000 y and 1000 times that of y",
        scaled, "1", 1e-9, f"{scaled:.1e}: the unit of the force does not matter", sense="<=",
    )  # fmt: skip
    moved = float(gm11_shifted([100.0, 110.0, 120.0, 130.0, 140.0], shift=1000.0))
    yield arithmetic(
        "grey_offset", "(9)", "prediction after 100, 110 .. 140 raised by 1000 and lowered again", moved, "N", 150.0,
        f"{moved:.3f} against {float(gm11([100.0, 110.0, 120.0, 130.0, 140.0])):.3f} N without: an offset matters, and "
        "a large one makes a straight line of the model", kind="report",
    )  # fmt: skip


def _bias() -> Iterator[Claim]:
    fixed, dgm = 0.0, 0.0
    for rate, percent, half in BIASES:
        y = exponential(rate, 6)
        bias = 100.0 * (float(gm11(y[:5])) / y[5] - 1.0)
        fixed = max(fixed, abs(float(gm11_exponential(y[:5])) / y[5] - 1.0))
        dgm = max(dgm, abs(float(dgm11(y[:5])) / y[5] - 1.0))
        sign = "minus_" if rate < 0.0 else ""
        yield arithmetic(
            f"grey_bias_{sign}{abs(rate):g}".replace(".", ""), "(9)",
            f"bias of GM(1,1) on exp({-rate:g} j)", bias, "%", percent,
            f"c = 2 tanh(a/2) = {2.0 * math.tanh(rate / 2.0):.4f} is not the rate a = {rate:g}", tolerance=half,
        )  # fmt: skip
    yield arithmetic(
        "grey_exponential_exact", "(9), A1", "largest relative error on exponentials with a = ln((2+c)/(2-c))", fixed,
        "1", 1e-12, f"exact to {fixed:.1e}; DGM(1,1) to {dgm:.1e}", sense="<=",
    )  # fmt: skip
    ramp = [100.0, 110.0, 120.0, 130.0, 140.0]
    apart = float(gm11_exponential(ramp) - dgm11(ramp))
    yield arithmetic(
        "grey_dgm_apart", "(9)", "corrected GM(1,1) less DGM(1,1) after 100, 110 .. 140", apart, "N", None,
        f"{apart:.5f} N: the two are one on exact exponentials only, elsewhere their least squares weigh errors "
        "differently", kind="report",
    )  # fmt: skip


def _limit() -> Iterator[Claim]:
    found = linearised(SET_POINT)
    worst = float(np.abs(found - WEIGHTS).max())
    yield arithmetic(
        "grey_weights", "A2", "largest deviation of the weights at 150 N from 0, -1/2, 0, 1/2, 1", worst, "1", 1e-5,
        f"by differences {', '.join(f'{w:.6f}' for w in found)}: near a set-point GM(1,1) is a fixed filter",
        sense="<=",
    )  # fmt: skip
    short = linearised(SET_POINT, 4)[1:][::-1]
    yield arithmetic(
        "grey_weights_4", "A2", "largest deviation of the weights of four samples from 4/3, 1/3, -2/3",
        float(np.abs(short - np.array([4.0, 1.0, -2.0]) / 3.0).max()), "1", 1e-5,
        f"newest first {', '.join(f'{w:.6f}' for w in short)}", sense="<=",
    )  # fmt: skip
    far = linearised(SET_POINT, 7, 3.0)
    yield arithmetic(
        "grey_weights_line", "A2", "the same for seven samples and a horizon of three, from the least squares line",
        float(np.abs(far - limit(7, 3.0)).max()), "1", 1e-5, "the line leaves out the oldest sample", sense="<=",
    )  # fmt: skip
    yield arithmetic(
        "grey_noise_gain", "A2", "noise gain of the weights at 150 N", noise_gain(found), "1", 1.2247,
        f"the root of 1.5 is {math.sqrt(1.5):.5f}: prediction adds noise", tolerance=5e-5,
    )  # fmt: skip
    noise = 0.5 * np.random.default_rng(2).normal(size=(100_000, 5))
    seen = float((gm11(SET_POINT + noise) - SET_POINT).std() / 0.5)
    yield arithmetic(
        "grey_noise_gain_seen", "A2", "noise gain of GM(1,1) on windows of 150 N and white noise of 0.5 N", seen, "1",
        1.2247, f"{seen:.4f} on 100,000 windows (standard error 0.3 %); the digest measured 1.217", tolerance=0.012,
    )  # fmt: skip
    for count, weights, gain in ((4, limit(4), 1.53), (2, np.array([-1.0, 2.0]), 2.24)):
        yield arithmetic(
            f"grey_noise_gain_{count}", "A2", f"noise gain of {'four samples' if count == 4 else 'the two-point line'}",
            noise_gain(weights), "1", gain, "fewer samples, more noise", tolerance=0.005,
        )  # fmt: skip
    frequency = np.linspace(1e-4, math.pi, 20_001)
    h = response(WEIGHTS, frequency)
    lag = np.degrees(np.angle(h))
    low = frequency < 1.0
    crossing = float(frequency[low][np.argmax(lag[low] <= 0.0)])
    yield arithmetic(
        "grey_gain_peak", "A2", "largest gain of the filter at any frequency", float(np.abs(h).max()), "1", 1.80,
        "at 90 degrees a sample", tolerance=0.005,
    )  # fmt: skip
    yield arithmetic(
        "grey_phase_lead", "A2", "largest phase lead below the first zero-crossing of the phase", float(lag[low].max()),
        "deg", 12.1, f"the lead ends at {crossing:.3f} rad/sample, {crossing / (2e-2 * 2 * math.pi):.1f} Hz at 20 ms",
        tolerance=0.05,
    )  # fmt: skip
    yield arithmetic(
        "grey_lead_ends", "A2", "frequency at which the lead ends", crossing, "rad/sample", math.pi / 4.0,
        "sin 3w = sin w at a quarter of pi (the digest cuts it to 0.78)", tolerance=5e-4,
    )  # fmt: skip
    yield arithmetic(
        "grey_phase_lead_high", "A2", "largest phase lead at all frequencies", float(lag.max()), "deg", None,
        f"a second lead lies above three quarters of pi, largest at {float(frequency[lag.argmax()]):.2f} rad/sample: "
        "there is only noise", kind="report",
    )  # fmt: skip
    yield arithmetic(
        "grey_lead", "A2", "lead on slow signals", lead(WEIGHTS), "samples", 1.0, "exactly the horizon", tolerance=1e-12
    )
    high = gm11_shifted([12.5, 38.2, 69.7, 98.4, 120.9], shift=1e7)
    yield arithmetic(
        "grey_shift_line", "(9)", "rise 12.5 .. 120.9 N: prediction with a shift of 1e7 N less the line",
        float(high) - 151.0, "N", 0.0, "far from zero the model is the straight line", tolerance=1e-3,
    )  # fmt: skip


def _degenerate() -> Iterator[Claim]:
    cases = (
        ("grey_ramp", (100, 110, 120, 130, 140), 151.94, 0.005, "a straight rise is over-predicted: the line says 150"),
        (
            "grey_concave",
            (0, 60, 105, 130, 143),
            190.0,
            0.5,
            "a rise that levels off near 150 is over-predicted by 40 N",
        ),
        ("grey_leading_zeros", (0, 0, 0, 0, 1), 0.0, 0.0, "c = -2 and u = 0: the first sample of a cut is denied"),
        ("grey_three_zeros", (0, 0, 0, 1, 5), 55.0, 0.5, "the line says 5.5"),
        ("grey_sign_change", (-2, -1, 0, 1, 2), 121.0, 0.5, "the line says 3"),
    )
    for name, y, target, tolerance, why in cases:
        value = float(gm11(y))
        yield arithmetic(
            name, "(9)", f"GM(1,1) after {', '.join(map(str, y))}", value, "N", target,
            f"{value:.2f}; {why}", tolerance=tolerance,
        )  # fmt: skip
    noise = 5.0 * np.random.default_rng(3).normal(size=(1000, 60))
    kept, filtered = np.zeros(1000), np.empty((1000, 60))
    for k in range(60):
        kept = 0.8 * kept + 0.2 * noise[:, k]
        filtered[:, k] = kept
    windows = np.lib.stride_tricks.sliding_window_view(filtered, 5, axis=1)[:, :-1]
    wrong = np.abs(gm11(windows) - filtered[:, 5:])
    over = float(np.mean(wrong.max(axis=1) > 400.0))
    yield arithmetic(
        "grey_air_noise", "(9)", "share of 1.2 s of air cutting with a prediction more than 400 N wrong",
        100.0 * over, "%", None, f"filtered noise of 5 N about zero, 1,000 seeds: the median of the largest error is "
        f"{float(np.median(wrong.max(axis=1))):.0f} N; the digest saw 400 N", kind="report",
    )  # fmt: skip


def _errata() -> Iterator[Claim]:
    y = exponential(-0.1)
    right, wrong = float(gm11(y)), float(gm11_printed(y))
    nearest = 100.0 * math.exp(0.5)
    said_next = f"the next sample, here {nearest:.3f}"
    yield printed(
        "grey_sign_printed", "(11)", "equation (11) as printed after 100 exp(0.1 j), j = 0 .. 4", wrong, "N", -164.673,
        f"minus the value of (9) and (12), which is {right:.3f}: (1 - exp(-c)) should be (exp(-c) - 1)", tolerance=5e-4,
        paper=said_next, verdict="reproduced" if abs(wrong / nearest - 1.0) < 0.01 else "not reproduced",
    )  # fmt: skip
    yield corrected(
        "grey_sign_corrected", "(9), (12)", "GM(1,1) after 100 exp(0.1 j), j = 0 .. 4", right, "N", 164.673,
        f"the next sample is {nearest:.3f}, {100.0 * (right / nearest - 1.0):.2f} % away", tolerance=5e-4,
        paper=said_next, verdict="reproduced with change" if abs(right / nearest - 1.0) < 0.01 else "not reproduced",
    )  # fmt: skip
    late = float(gm11_off_by_one(y))
    yield printed(
        "grey_one_index_late", "(9), (10)", "(10) with k = 4, its sign put right, after 100 exp(0.1 j)", late, "N",
        None, f"{late:.3f} is the fit of the newest sample, {y[-1]:.3f}, not the next one, {nearest:.3f}: with five "
        "samples the exponent must be 5. (9) counts from zero, (10) from one", kind="report", paper=said_next,
        verdict="not reproduced" if abs(late - y[-1]) < abs(late - nearest) else "reproduced",
    )  # fmt: skip
    slope, middle = float(gm11_derivative(y)), float(gm11_derivative(y, 0.5))
    yield printed(
        "grey_derivative", "(11)", "derivative of (9) at the next sample, against the difference (12)",
        100.0 * (slope / right - 1.0), "%", 5.0,
        f"the text calls (11) a derivative; in mid-interval it is {100.0 * (middle / right - 1.0):.2f} % off",
        tolerance=0.5,
    )  # fmt: skip
    c = float(fit(y).c)
    yield printed(
        "grey_global_index", "(9) to (12)", "factor by which (12) is wrong with the global k = 50 for the place in it",
        math.exp(-c * (50 - 5)), "1", None,
        "after 1 s at 20 ms; k means the sample number in the text and the place in the window in (9) to (12)",
        kind="report",
    )  # fmt: skip
