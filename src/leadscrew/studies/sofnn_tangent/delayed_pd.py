"""Equation (3) with three gains in place of its rules: the offset of some samples ago, and a PD of the deviation.

    d(k) = clip(share d(k - delay) + kp e(k) + kd (e(k) - e(k - 1)), -most, most)              e = command - feedback

With ``share = 1`` it is the linear part of the paper's network: a small deviation stays in one column of the rules, and
there a correction is proportional to ``e`` and its change. As an observer with ``kp = share / g``: it takes the offset
of ``delay`` samples ago for where the axis was when the cut was seen (``g`` the gain from offset to deviation).

Bumpless start: the offsets of before were the last one, less what ``kp`` adds.

Source: ours, the linear baseline of the study ``sofnn_tangent``.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.controllers._tangent.believed import MOST_DEG, RING, MaxOffset, back, next_place, quiet, within
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit


class DelayedPdParams(NamedTuple):
    """Three gains, and how old the offset is."""

    share: Annotated[float, Ge(0), Le(1.5), Doc("share of the old offset")] = 1.0
    kp: Annotated[float, Ge(0), Le(100), Doc("offset for a deviation")] = 0.3
    kd: Annotated[float, Ge(0), Le(100), Doc("offset for its change a sample")] = 0.0
    delay: Annotated[int, Ge(1), Le(RING - 1), Doc("samples from an offset to its reading")] = 5
    max_offset: MaxOffset = MOST_DEG


class DelayedPdState(NamedTuple):
    """Offsets and the last deviation."""

    sent: Annotated[np.ndarray, Unit("deg"), Doc("offsets less the first one's")] = np.zeros(RING)
    at: Annotated[int, Doc("place of the last one")] = 0
    last: Annotated[float, Unit("deg"), Doc("last deviation")] = 0.0
    before: Annotated[float, Unit("deg"), Doc("offset of before the start")] = 0.0


def align(params, command, feedback, output):
    """The state from which the next output is ``output``; without a share it cannot be."""
    e = command - feedback
    return DelayedPdState(np.zeros(RING), 0, e, (output - params.kp * e) / max(params.share, 1e-9))


@controller(DelayedPdParams(), DelayedPdState(), align=align, unit="deg", drive="position")
def delayed_pd(p, s, command, feedback, dt):
    """The offset of some samples ago and a PD of the deviation; an offset in deg."""
    e = command - feedback
    at = next_place(s.at)
    old = s.before + back(s.sent, at, p.delay)
    d = within(p.share * old + p.kp * e + p.kd * (e - s.last), p.max_offset)
    s.sent[at] = quiet(d - s.before)
    return DelayedPdState(s.sent, at, e, s.before), d
