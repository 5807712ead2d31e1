"""The filter of the force alone (A12), and how well each predictor says the next filtered force in closed loops."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from itertools import pairwise

import numpy as np

from leadscrew.grey.predictors import DERIVATIVE, GM_CLAMPED
from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.machines import PERIOD_S
from leadscrew.studies.grey_turning.one_step import RUNS, closed_loops, errors, judged, on_the_load_cell
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said, word

KEEP = 0.8
LOOP, MACHINE = "corrected.tfc_sbn", "plant_n"
"""The loop whose errors lie nearest to the digest's, which does not name its own."""
DIGEST = {
    "last": (6.34, 0.47), "gm11": (9.78, 0.55), "gm11_guarded": (3.70, 0.55), "gm11_shifted": (2.26, 0.55),
    "line": (2.17, 0.55), "dgm11": (9.5, 0.55), "two_point": (1.14, 0.73),
}  # fmt: skip
"""Its one-step errors, N: until 0.8 s, and steady."""
SHOWN = (*DIGEST, "gm11_exponential", "gm11_residual", "verhulst")
arithmetic = partial(said, basis="arithmetic")
nearest = partial(said, basis="fitted to this number")


def cell_claims() -> Iterator[Claim]:
    """A12: by the frequency response, and by the compiled sensor in a loop."""
    w = 2.0 * math.pi * 20.0 * PERIOD_S
    gain = abs((1.0 - KEEP) / (1.0 - KEEP * np.exp(-1j * w)))
    noise = on_the_load_cell(40_000, noise_n=1.0)[100:]
    spread = float(noise.std())
    yield arithmetic(
        "filter_noise", "section 5, Fig. 5, A12", "white noise after the filter of 0.8, over that before it", spread,
        "1", 1.0 / 3.0, f"{spread:.4f} in {len(noise):,} samples of the compiled sensor; sqrt(0.2 / 1.8) = 1/3",
        tolerance=0.01,
    )  # fmt: skip
    level = float(on_the_load_cell(level=150.0)[-1]) / 150.0
    yield arithmetic(
        "filter_dc", "section 5, A12", "gain of the filter for a constant force", level, "1", 1.0,
        "150 N held for 80 s", tolerance=1e-12,
    )  # fmt: skip
    k = np.arange(4000)
    sine = on_the_load_cell(size=100.0, frequency=20.0)
    basis = np.column_stack([np.sin(w * k), np.cos(w * k)])[200:]
    size = float(np.hypot(*np.linalg.lstsq(basis, sine[200:], rcond=None)[0])) / 100.0
    yield arithmetic(
        "filter_20_hz", "section 5, A12", "gain of the filter at 20 Hz, the runout at 1,200 1/min", size, "1", 0.117,
        f"{size:.4f} of a sine on the sensor, {gain:.4f} by its transfer function", tolerance=5e-4,
    )  # fmt: skip
    ramp = on_the_load_cell(slope=1.0 / PERIOD_S)
    # The force of a period is measured at its end: one sample that is not the filter's.
    behind = float(k[-1] - 1 - ramp[-1])
    yield arithmetic(
        "filter_delay", "section 5, A12", "delay of the filter on slow changes", behind, "samples", 4.0,
        "a force that rises by 1 N a sample is shown 4 N too low: 0.8 / (1 - 0.8)", tolerance=1e-9,
    )  # fmt: skip


def one_step_claims(loops: Loops) -> Iterator[Claim]:
    """The digest's table of one-step errors, on its likeliest loop, with what it did not test."""
    found = errors(closed_loops(loops, LOOP, MACHINE))
    rise = {k: float(np.sqrt(np.mean(v.transient**2))) for k, v in found.items()}
    rest = {k: float(np.sqrt(np.mean(v.steady**2))) for k, v in found.items()}
    where = f"{LOOP} on {MACHINE}, the nearest of the loops tried, {RUNS} noise seeds"
    yield nearest(
        "one_step_steady_order", "section 2 of the digest", "steady: last value before GM, GM before two points",
        word(rest["last"] < rest["gm11"] < rest["two_point"]), "", "yes",
        f"{where}: {rest['last']:.2f}, {rest['gm11']:.2f} and {rest['two_point']:.2f} N. Grey prediction loses to "
        "the last value once the force has settled", sense="yes/no",
    )  # fmt: skip
    ordered = ("two_point", "line", "gm11_shifted", "gm11_guarded", "last")
    yield nearest(
        "one_step_rise_order", "section 2 of the digest", "rise, best first: two points, line, shifted, guarded, last",
        word(all(rise[a] < rise[b] for a, b in pairwise(ordered))), "", "yes",
        f"{where}: {', '.join(f'{k} {rise[k]:.2f}' for k in ordered)} N. No form of GM(1,1) beats a "
        "straight line", sense="yes/no",
    )  # fmt: skip
    raw = found["gm11"].transient
    yield said(
        "one_step_rise_gm_spread", "section 2 of the digest", "rise: largest over smallest error of raw GM(1,1)",
        float(raw.max() / raw.min()), "1", None,
        f"{where}: from {raw.min():.1f} to {raw.max():.0f} N, median {float(np.median(raw)):.1f}: the first samples "
        "are noise about zero, and one of them rules the figure. The digest's 9.78 N is one draw of it", kind="report",
    )  # fmt: skip
    for model in SHOWN:
        theirs = DIGEST.get(model)
        likely = said if theirs is None else nearest
        both = (
            "" if theirs is None else f"; the digest has {theirs[0]:.2f} and {theirs[1]:.2f} on a loop it does not name"
        )
        yield likely(
            f"one_step_rise_{model}", "section 2 of the digest", f"error of {model} one sample ahead, up to 0.8 s",
            rise[model], "N", None if theirs is None else theirs[0],
            f"{where}: {rise[model]:.2f} N, {rest[model]:.2f} N from 1 s on{both}", kind="report",
        )  # fmt: skip
        yield likely(
            f"one_step_steady_{model}", "section 2 of the digest", f"error of {model} one sample ahead, from 1 s on",
            rest[model], "N", None if theirs is None else theirs[1], f"{where}: {rest[model]:.3f} N{both}",
            kind="report",
        )  # fmt: skip


def reading_claims(loops: Loops) -> Iterator[Claim]:
    """Erratum 3 in a closed loop: (11) as a derivative; erratum 2 is in claims_errata."""
    name = "corrected.gpfc_b_sbn"
    readings = judged(loops, name, MACHINE, (GM_CLAMPED, DERIVATIVE))
    for key, reading, seconds in zip(("difference", "derivative"), readings, (0.30, 0.34), strict=True):
        rise = float(reading.rise_s.mean())
        yield said(
            f"closed_{key}_rise", "(11)", f"rise time with (11) as a {key}, GPFC (B) with SBN, plant N", rise, "s",
            seconds, f"mean of {RUNS} noise seeds: {rise:.3f} s; the digest names no factors here, of those tried on "
            "both plants these give its pair", tolerance=0.01, basis="fitted to this number",
        )  # fmt: skip
