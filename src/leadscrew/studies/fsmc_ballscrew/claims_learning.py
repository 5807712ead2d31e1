"""Claims about learning from pass to pass: the observer's torque of one pass as feed-forward of the next.

What we ask of ourselves is what the project's digest says of an earlier simulation. Its digits depend on how a pass
starts and where the scale's steps fall, which it does not say: rows with its numbers report, required is the direction.
"""

from __future__ import annotations

from itertools import pairwise
from statistics import fmean

from leadscrew.report.claim import Claim, Kind, Sense
from leadscrew.studies.fsmc_ballscrew.learning import FIXED, HIGH_GAIN, NO_DAMPING, SCHEDULED, passes
from leadscrew.studies.fsmc_ballscrew.naming import FIGURE, WAY
from leadscrew.studies.fsmc_ballscrew.runs import ENCODER_NM, Loops

PASSES = 15
SLOW_PASSES = 2
"""On the slow sine, where a pass takes long: the stage sticks and slips."""
LAST = 4
"""Passes at the end whose mean counts, where the error goes up and down."""

UNSAID = "the paper learns nothing"


def _claim(
    name: str, scenario: str, statement: str, measured: float, unit: str, sense: Sense, target: float | None,
    kind: Kind = "required", reason: str = UNSAID,
) -> Claim:  # fmt: skip
    said = f"{WAY[scenario]} at 4 kHz, learning from pass to pass: {statement}"
    return Claim(
        f"fsmc_ballscrew.learning_{name}", FIGURE[scenario], "ours", "printed plant", said, None, float(measured), unit,
        sense, target, 0.0, kind, "cannot be checked", reason,
    )  # fmt: skip


def learning_claims(loops: Loops) -> list[Claim]:
    """Fixed gains on the three sines, a high gain, scheduled gains."""
    return [*_fixed(loops), *_high_gain(loops), *_scheduled(loops)]


def _fixed(loops: Loops) -> list[Claim]:
    fast = passes(loops, FIXED, "sine_fast", PASSES)
    wide = passes(loops, FIXED, "sine_wide", PASSES, NO_DAMPING)
    slow = passes(loops, FIXED, "sine_slow", SLOW_PASSES)
    rise = max(after - before for before, after in pairwise(fast))
    late = fmean(wide[-LAST:])
    return [
        _claim("fast_first", "sine_fast", "largest error before the first pass", fast[0], "um", "=", None, "report",
               "the digest has 0.224 um"),
        _claim("fast_last", "sine_fast", f"largest error after {PASSES} passes", fast[-1], "um", "=", None, "report",
               "the digest has 0.082 um"),
        _claim("fast_share", "sine_fast", f"what {PASSES} passes leave of the largest error", fast[-1] / fast[0], "",
               "<=", 0.5, "required", f"{fast[0]:.3f} to {fast[-1]:.3f} um; the digest leaves 0.37"),
        _claim("fast_rise", "sine_fast", "largest rise from one pass to the next", rise, "um", "<=", 1e-3 * ENCODER_NM,
               "required", "it falls, but for less than one step of the scale"),
        _claim("wide_first", "sine_wide", "largest error before the first pass, no sigma_1 believed", wide[0], "um",
               "=", None, "report", "the digest has 0.53 um"),
        _claim("wide_last", "sine_wide", f"largest error, mean of the last {LAST} of {PASSES} passes", late, "um",
               "=", None, "report", f"the digest has 0.1 um; ours goes up and down on the way, {min(wide):.2f} to "
               f"{max(wide[1:]):.2f} um: steps of the scale, with 1 nm it settles below 0.1 um"),
        _claim("wide_share", "sine_wide", "what they leave of the largest error", late / wide[0], "", "<=", 0.5,
               "required", f"{wide[0]:.3f} to {late:.3f} um"),
        _claim("slow_again", "sine_slow", f"largest error among passes 1 to {SLOW_PASSES}", max(slow[1:]), "um", ">=",
               0.3, "required", "does not converge, as the digest says: with fixed gains the stage sticks and slips "
               f"({slow[0]:.2f} um before the first)"),
    ]  # fmt: skip


def _high_gain(loops: Loops) -> list[Claim]:
    wide = passes(loops, FIXED, "sine_wide", 1, HIGH_GAIN)
    fast = passes(loops, FIXED, "sine_fast", PASSES, HIGH_GAIN)
    return [
        _claim("high_gain_wide", "sine_wide", "largest error with kp = 1000 N m/rad before anything is learned",
               wide[0], "um", ">=", 1.0, "required", "the digest says that learning diverges with kp = 1000; on this "
               "sine the loop oscillates without it"),
        _claim("high_gain_wide_next", "sine_wide", "largest error with kp = 1000 N m/rad after one pass", wide[1],
               "um", ">=", wide[0], "required", f"the oscillation of {wide[0]:.1f} um is learned and grows"),
        _claim("high_gain_fast", "sine_fast", f"what {PASSES} passes leave of the largest error with kp = 1000 N m/rad",
               fast[-1] / fast[0], "", "<=", None, "report", f"{fast[0]:.3f} to {fast[-1]:.3f} um: not divergent, "
               "other than the digest's sentence on kp = 1000, which names no sine"),
    ]  # fmt: skip


def _scheduled(loops: Loops) -> list[Claim]:
    fast = passes(loops, SCHEDULED, "sine_fast", PASSES)
    slow = passes(loops, SCHEDULED, "sine_slow", SLOW_PASSES)
    late = fmean(fast[-LAST:])
    return [
        _claim("scheduled_fast", "sine_fast", f"largest error of ours.pd_dob, mean of the last {LAST} of {PASSES} "
               "passes", late, "um", "<=", 0.1, "required", f"{fast[0]:.3f} um before the first"),
        _claim("scheduled_slow", "sine_slow", f"what {SLOW_PASSES} passes leave of the largest error of "
               "ours.pd_dob", slow[-1] / slow[0], "", "<=", 0.5, "required", f"{slow[0]:.3f} to {slow[-1]:.3f} um: "
               "with gains that keep the stage from stick-slip the slow sine is learned too"),
    ]  # fmt: skip
