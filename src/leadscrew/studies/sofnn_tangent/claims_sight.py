"""Claims on the offset of the networks while the camera loses the cut and finds it again: it fades, and does not jump.

The feed-forward and the rules of the curvature: :mod:`leadscrew.studies.sofnn_tangent.claims_feed_forward`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.block import Block
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.lines import PERIOD_S
from leadscrew.studies.sofnn_tangent.online import PNN, TUNED
from leadscrew.studies.sofnn_tangent.resight import LOST_FOR_S, LOST_FROM_S, changes
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said

WATCHED = {"pnn": PNN, "tuned": TUNED, "sofc": "ours.sofc_tuned", "fnn": "corrected.fnn"}
TIMES = 1.5
"""How much larger than without a loss the largest step may be: the rules learn from a deviation of several degrees."""
AFTER_S = 1.0
"""Watched from when the cut is seen again."""


class Steps(NamedTuple):
    """Largest change of the offset in one sample, deg."""

    lost: float
    """From the loss until the cut is seen again."""
    seen: float
    """In the second after that."""
    plain: float
    """In the same runs without a loss, anywhere."""

    @property
    def times(self) -> float:
        """The larger of the first two, in steps without a loss."""
        return max(self.lost, self.seen) / self.plain


def steps_of(loops: Loops, block: Block) -> Steps:
    """Losses of a second at eleven places of the flower in foam."""
    lost = np.array(LOST_FROM_S)
    never = np.full(lost.size, 1e9)
    rows = changes(loops, block, np.concatenate([lost, never]))
    apart, plain = rows[: lost.size], rows[lost.size :]
    gap, after = round(LOST_FOR_S / PERIOD_S), round(AFTER_S / PERIOD_S)
    first = np.round(lost / PERIOD_S).astype(int) - 1
    gone = max(float(row[k : k + gap].max()) for row, k in zip(apart, first, strict=True))
    back = max(float(row[k + gap : k + gap + after].max()) for row, k in zip(apart, first, strict=True))
    return Steps(gone, back, float(plain.max()))


def sight_claims(loops: Loops) -> list[Claim]:
    """One for each kind of controller of :mod:`leadscrew.controllers.sofnn`."""
    return list(_steps(loops))


def _steps(loops: Loops) -> Iterator[Claim]:
    for short, name in WATCHED.items():
        block = loops.controllers[name]
        found, at_once = steps_of(loops, block), steps_of(loops, block(fade_s=0.02 * PERIOD_S))
        yield said(
            f"sight_{short}", "not in the paper; digest section 5, safeguards", f"largest change of the offset from "
            f"one sample to the next while the cut is lost and in the second after, over the largest without a loss, "
            f"{name}, {len(LOST_FROM_S)} losses of a second, flower in foam", found.times, "1", TIMES,
            f"{found.lost:.2f} deg in the loss and {found.seen:.2f} after it, {found.plain:.2f} where nothing is lost; "
            f"with no time to fade out and in {at_once.lost:.1f} and {at_once.seen:.1f} deg", sense="<=",
        )  # fmt: skip
