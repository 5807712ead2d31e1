"""What the fuzzy controllers of a tangential knife share: from the seen deviation to levels, and back to an offset.

    e  = seen deviation - commanded deviation                     deg, actual minus reference
    ec = a ec + (1 - a) (e(k) - e(k-1)),   a = exp(-T / filter_s)  deg a sample
    E  = k_e e,   EC = k_ec ec   or, per second,  EC = k_ec ec / T      levels; not rounded, held to -6..6 by the rules
    d  = clip(k_d D, -max_offset, max_offset)                     deg, counter-clockwise positive

The paper does not say in what time ``ec`` is meant. Per sample is the default; ``per_second`` is the other reading.

While the cut is not seen (``seen`` = 0) the reading is worth nothing: the offset fades from the last one sent towards
0 with ``fade_s``, and no difference is taken between readings on both sides of a gap. When the cut is seen again, the
offset goes from the last one sent to that of the rules with ``fade_s`` too, without a jump:

    d(k) = clip(clip(k_d D(k)) - short(k)),    short(k) = exp(-T / fade_s) short(k-1)

with ``clip(k_d D(k)) - d(k-1)`` in place of ``short(k-1)`` in the first sample that is seen. After another controller
the first offset is the one that it sent last, and what that is short of the rules' one fades likewise.

Source: the paper of the study ``sofnn_tangent`` (Deng, Liu, Wu, Zhang), section 2: ranges of +-90 and +-15 deg in 13
levels of -6..6. The filter, the fading and the reading per sample are the study's.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

MOST_LEVEL = 6.0
"""Outermost level."""
ROOM = 64
"""Samples that are kept."""
TINY = 1e-30
"""Below this a fading value is 0."""

KE = Annotated[float, Unit("1/deg"), Gt(0), Le(60), Doc("levels per degree of deviation, k_e")]
KEC = Annotated[float, Ge(0), Le(600), Doc("levels per deg a sample (or deg/s, see per_second) of its change, k_ec")]
PerSecond = Annotated[bool, Doc("k_ec is per deg/s; else per deg a sample")]
KD = Annotated[float, Unit("deg"), Gt(0), Le(15), Doc("degrees of offset per level, k_d")]
FilterS = Annotated[float, Unit("s"), Ge(0), Le(10), Doc("time constant of the filter of the change")]
MaxOffset = Annotated[float, Unit("deg"), Gt(0), Le(90), Doc("largest offset, either way")]
FadeS = Annotated[
    float,
    Unit("s"),
    Gt(0),
    Le(1e6),
    Doc("time constant with which the offset fades while nothing is seen, and comes back"),
]


class Scales(NamedTuple):
    """Scales as a step reads them."""

    k_e: float
    k_ec: float
    k_d: float
    keep: float
    max_offset: float
    fade: float


class Watch(NamedTuple):
    """What is known of the deviation."""

    error: Annotated[float, Unit("deg"), Doc("last deviation that was seen, e")] = 0.0
    rate: Annotated[float, Unit("deg"), Doc("its filtered change in one sample, ec")] = 0.0
    known: Annotated[int, Doc("samples in a row in which the cut was seen, up to 64")] = 0
    blind: Annotated[int, Doc("1 while the cut is not seen, else 0")] = 0


Aligned = Annotated[int, Doc("1 in the first sample after a bumpless start, else 0")]
Short = Annotated[float, Unit("deg"), Doc("what the offset sent is short of the rules' one after a gap or a takeover")]


def scales(params, dt: float) -> Scales:
    """The scales of a controller's parameters at this period."""
    keep = math.exp(-dt / params.filter_s) if params.filter_s > 0.0 else 0.0
    k_ec = params.k_ec / dt if params.per_second else params.k_ec
    return Scales(params.k_e, k_ec, params.k_d, keep, params.max_offset, math.exp(-dt / params.fade_s))


def faded(x):
    """``x``, or 0 where nothing is left of it."""
    return x if abs(x) > TINY else 0.0


def watched(p, s, command, feedback):
    """The deviation and its change after one more reading; ``known`` is 0 while the cut is not seen."""
    seen = feedback.seen > 0.5
    error = feedback.deviation - command.deviation if seen else s.error
    change = error - s.error if s.known > 0 else 0.0
    rate = faded(p.keep * s.rate + (1.0 - p.keep) * change)
    return Watch(error, rate, min(s.known + 1, ROOM) if seen else 0, 0 if seen else 1)


def taken_over(command, feedback):
    """What is known of the deviation when another controller is replaced: the reading, if the cut is seen."""
    seen = feedback.seen > 0.5
    return Watch(feedback.deviation - command.deviation if seen else 0.0, 0.0, 0, 0 if seen else 1)


def held(x, max_offset):
    """``x`` within ``-most`` and ``most``."""
    return min(max(x, -max_offset), max_offset)


def lacking(p, blind, aligned, short, level, before):
    """What the offset is short of the rules' one: all between it and the last after a gap or a takeover; it fades."""
    apart = held(p.k_d * level, p.max_offset) - before
    return apart if aligned == 1 else faded(p.fade * (apart if blind == 1 else short))


def sent(p, watch, level, short, before):
    """The offset for a level of the rules; fading from ``before`` while the cut is not seen."""
    return faded(p.fade * before) if watch.known == 0 else held(held(p.k_d * level, p.max_offset) - short, p.max_offset)
