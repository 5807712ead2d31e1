"""Claims of runs in which something changes: the material on the way, the shear in a step, the feed."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.chance import HALF_DIGIT, by_chance
from leadscrew.studies.sofnn_tangent.changing import (
    FEED_ROWS,
    FEEDS,
    REPEATS,
    ROWS,
    RUNS,
    STEP_VALUES,
    Changes,
    changes_of,
    feed_values,
    steps,
    with_values,
)
from leadscrew.studies.sofnn_tangent.comparison import (
    BILINEAR,
    DIGEST,
    FIXED,
    NONE,
    PAPER,
    PID,
    TUNED,
)
from leadscrew.studies.sofnn_tangent.lines import LAPS
from leadscrew.studies.sofnn_tangent.runs import CELLS, Loops
from leadscrew.studies.sofnn_tangent.saying import said, verdict_of

SOURCE = "digest, section 7"
ADAPTIVE = "good adaptive control when the environment changes"

HALVES: dict[str, dict[str, tuple[float, float, float]]] = {
    NONE: {"wave": (1.39, 1.65, 3.0), "flower": (2.59, 4.28, 7.3), "rrect": (1.69, 3.54, 8.0)},
    FIXED: {"wave": (1.20, 1.46, 2.7), "flower": (2.26, 3.81, 6.6), "rrect": (1.48, 3.17, 7.1)},
    PAPER: {"wave": (0.75, 1.00, 2.0), "flower": (1.97, 3.04, 6.7), "rrect": (1.20, 2.22, 4.8)},
    TUNED: {"wave": (0.29, 0.24, 0.6), "flower": (1.07, 1.36, 3.5), "rrect": (0.86, 1.29, 3.4)},
    PID: {"wave": (0.29, 0.29, 0.7), "flower": (1.08, 1.67, 4.2), "rrect": (0.81, 1.43, 3.5)},
}
"""RMS before and after half the way, largest deviation after, deg; fabric, then foam."""
STEPS: dict[str, tuple[float, float]] = {
    "fixed": (22.7, math.inf), "table": (1.79, 1.14), "net": (2.93, 1.91), "tuned": (0.43, 0.33), "pid": (0.37, 0.23),
}  # fmt: skip
"""IAE in deg s and settling time in s after a step of -5 deg."""
FOURTH: dict[str, tuple[float, float]] = {"table": (1.14, 0.98), "net": (1.37, 1.41), "tuned": (0.60, 0.70)}
"""The same of the fourth step."""
STEP_WORDS = {
    "fixed": "fixed rules", "table": "SOFNN with the table", "net": "SOFNN of the paper", "tuned": "SOFNN tuned",
    "pid": "PID 0.7, 14, 0.005",
}  # fmt: skip
"""With :func:`leadscrew.studies.sofnn_tangent.changing.with_values`, which says what a row has of its own."""
FED: dict[str, tuple[float, float, float]] = {
    NONE: (2.16, 2.69, 3.00), BILINEAR: (1.10, 1.84, 2.38), TUNED: (0.44, 1.00, 1.95), PID: (0.47, 1.07, 1.94),
}  # fmt: skip
"""RMS deviation at 20, 50 and 100 mm/s."""


def change_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    made = changes_of(loops)
    return [*_material(made), *_adaptive(made), *_steps(made), *_diverges(loops), *_feed(made)]


def _material(made: Changes) -> Iterator[Claim]:
    for name in ROWS:
        short, same, seen = name.split(".")[-1], 0, []
        for line in LAPS:
            halves, digest = made.material[name, line], HALVES[name][line]
            found, spread = halves.judged(), halves.spread()
            same += sum(
                abs(a - b) <= by_chance(s, half)
                for a, b, s, half in zip(found, digest, spread, (HALF_DIGIT, HALF_DIGIT, 0.05), strict=True)
            )
            text = "before {:.2f}, after {:.2f}, largest after {:.1f} deg"
            seen.append(f"{line} {text.format(*found)} (digest {digest[0]:g}, {digest[1]:g}, {digest[2]:g})")
            yield said(
                f"change_{short}_{line}", SOURCE, f"RMS deviation behind a change from fabric to foam on the {line}: "
                f"{DIGEST[name].words}", found[1], "deg", digest[1], text.format(*found)
                + f"; the digest has {digest[0]:g}, {digest[1]:g}, {digest[2]:g}", tolerance=by_chance(spread[1]),
            )  # fmt: skip
        yield said(
            f"change_{short}_agrees", SOURCE,
            f"numbers of the change table that agree but for chance: {DIGEST[name].words}", same, "of 9", 9.0,
            "; ".join(seen),
        )  # fmt: skip


def _adaptive(made: Changes) -> Iterator[Claim]:
    def less(name: str, than: str) -> np.ndarray:
        pairs = [(made.material[name, line].judged()[1], made.material[than, line].judged()[1]) for line in LAPS]
        return 100.0 * (1.0 - np.array([a / b for a, b in pairs]))

    for short, name, target, digest in (("literal", PAPER, 18.0, "20 to 32"), ("tuned", TUNED, 55.0, "59 to 84")):
        gains = less(name, FIXED)
        yield said(
            f"change_{short}_gain", "simulation tests; digest A8", "least reduction of the RMS behind a change of "
            f"material against fixed rules, of three lines: {DIGEST[name].words}", float(gains.min()), "%", target,
            f"{', '.join(f'{line} {x:.0f} %' for line, x in zip(LAPS, gains, strict=True))}; the digest {digest} %",
            sense=">=", paper=ADAPTIVE if name == PAPER else None,
            verdict=verdict_of(bool(gains.min() > 0.0), change=True) if name == PAPER else "cannot be checked",
        )  # fmt: skip
    gains = less(PAPER, PID)
    yield said(
        "change_literal_over_pid", "simulation tests", "RMS behind a change of material, paper's SOFNN less than the "
        "PID, best of three lines", float(gains.max()), "%", 0.0,
        f"{', '.join(f'{line} {x:+.0f} %' for line, x in zip(LAPS, gains, strict=True))}: the network of the paper "
        "adapts better than fixed rules, and worse than an integrator", sense="<=",
    )  # fmt: skip
    gains = less(TUNED, PID)
    yield said(
        "change_tuned_over_pid", "digest, section 7", "RMS behind a change of material, tuned SOFNN less than the PID, "
        "mean of three lines", float(gains.mean()), "%", None,
        f"{', '.join(f'{line} {x:+.0f} %' for line, x in zip(LAPS, gains, strict=True))} against PID 0.7, 14, 0.005",
        kind="report",
    )  # fmt: skip


def _step_words(short: str) -> str:
    return with_values(STEP_WORDS[short], STEP_VALUES.get(short, {}))


def _steps(made: Changes) -> Iterator[Claim]:
    source = "Figure 4; digest, section 7"
    for short, (iae, settling) in STEPS.items():
        first, words = made.step[short][0], _step_words(short)
        half = 0.05 if iae > 10.0 else HALF_DIGIT
        yield said(
            f"step_{short}_iae", source, f"integral of abs e after a step of the shear by -5 deg: {words}", first.iae,
            "deg s", iae, f"{first.iae:.3f} deg s, {first.last:.2f} deg left after 5.5 s; digest {iae:g}",
            tolerance=0.02 * iae + half,
        )  # fmt: skip
        if math.isinf(settling):
            yield said(
                f"step_{short}_left", source, f"deviation left by {words}", first.last, "deg", -4.13,
                f"{first.last:.3f} deg: rules without memory leave what the loop gain cannot hold, and never settle",
                tolerance=HALF_DIGIT,
            )  # fmt: skip
            continue
        yield said(
            f"step_{short}_settling", source, f"time until the deviation stays within 0.25 deg: {words}",
            first.settling_s, "s", settling, f"{first.settling_s:.2f} s; digest {settling:g}", tolerance=0.015,
        )  # fmt: skip
    for short, (iae, settling) in FOURTH.items():
        first, fourth = made.step[short][0], made.step[short][REPEATS - 1]
        yield said(
            f"step_{short}_fourth", source, f"integral of abs e after the fourth step: {_step_words(short)}",
            fourth.iae, "deg s", iae, f"{fourth.iae:.2f} deg s, settled after {fourth.settling_s:.2f} s, overshoot "
            f"{max(fourth.overshoot, 0.0):.2f} deg; digest {iae:g} and {settling:g} s. The rules and their covariance "
            f"are kept, everything else starts anew; the first time {first.iae:.2f}",
            tolerance=0.03 * iae,
        )  # fmt: skip
    tuned = [each.iae for each in made.step["tuned"]]
    yield said(
        "step_tuned_gets_worse", source, "integral of abs e of the fourth step over that of the first: "
        + _step_words("tuned"),
        tuned[-1] / tuned[0], "", 1.0, f"{', '.join(f'{x:.2f}' for x in tuned)} deg s: what the rules keep from the "
        "step before is an offset, and it is wrong when the next run begins without the shear", sense=">=",
    )  # fmt: skip


def _diverges(loops: Loops) -> Iterator[Claim]:
    found = steps(loops, loops.controllers["paper.sofnn_bad_slope"], 1)[0]
    yield said(
        "step_bad_slope_left", "Figure 4; digest, section 7", "size of the deviation left by the SOFNN whose "
        "performance network has the wrong slope at the origin", abs(found.last), "deg", 5.0,
        f"{found.last:.1f} deg after 5.5 s, integral {found.iae:.0f} deg s: it drives the axis to its limit",
        sense=">=",
    )  # fmt: skip


def _feed(made: Changes) -> Iterator[Claim]:
    for name in FEED_ROWS:
        for feed, digest in zip(FEEDS, FED[name], strict=True):
            values = made.feed[name, feed]
            mean, deviation = float(values[:CELLS].mean()), float(values.std(ddof=1))
            tolerance = by_chance(deviation)
            unlike = name == TUNED and feed == FEEDS[0]
            yield said(
                f"feed_{name.split('.')[-1]}_{feed:.0f}", SOURCE,
                f"RMS deviation on the flower in fabric at {feed:g} mm/s: "
                + with_values(DIGEST[name].words, feed_values(name)), mean, "deg", digest,
                f"{mean:.3f} deg, {deviation:.3f} from run to run; the digest has {digest:g}"
                + (", as a texture by the sample would give" if unlike else ""),
                tolerance=tolerance, kind="report" if unlike else "required",
            )  # fmt: skip
    values = made.slow_by_sample
    mean, deviation = float(values[:CELLS].mean()), float(values.std(ddof=1))
    yield said(
        "feed_sofnn_tuned_20_by_sample", SOURCE, "RMS deviation of the tuned SOFNN at 20 mm/s in a texture changing "
        "from sample to sample as at 50 mm/s", mean, "deg", FED[TUNED][0], f"{mean:.3f} deg: the digest seems to have "
        "kept its texture in samples when it changed the feed, and not along the way as its section 6 says",
        tolerance=by_chance(deviation),
    )  # fmt: skip
    for short, name in (("tuned", TUNED), ("pid", PID)):
        slow, fast = (float(made.feed[name, feed][:RUNS].mean()) for feed in (FEEDS[0], FEEDS[-1]))
        yield said(
            f"feed_fades_{short}", SOURCE, f"RMS deviation at 100 mm/s over that at 20 mm/s: {DIGEST[name].words}",
            fast / slow, "", 2.0, f"{slow:.2f} and {fast:.2f} deg: camera and axis are as late in time as before, so "
            "later on the way; all feedback fades with the feed", sense=">=",
        )  # fmt: skip
