"""The bar on the lathe: where it begins and ends along the feed, how thick its stock is, how hard it is.

    b(x) = depth + extra_i         where  from_i <= x < from_(i+1),   starts <= x < ends;  0 elsewhere
    K(x) = K (1 + harder_i)

``x``: travel of the carriage, mm; ``depth``: of the tool below the nominal surface. Up to :data:`STRETCHES` stretches:
shoulders of the raw part as ``extra``, hard places as ``harder``. Before the first ``from`` both are 0. A profile
over the way, not over time: a machine that feeds faster comes to the next shoulder sooner.

Where a shoulder lies at one place of the axis, the edge meets it within a revolution: here at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.util.errors import ValueRefused

STRETCHES = 8
"""Most stretches of a bar."""

FAR_MM = 1e9
"""A place that is not reached, mm."""

Eight = NDArray[np.float64]


class Workpiece(NamedTuple):
    """A bar; endless and of one kind by default."""

    diameter: Annotated[float, Unit("mm"), Gt(0), Doc("mean diameter of the cut")] = 50.0
    starts: Annotated[float, Unit("mm"), Doc("travel of the carriage at which the bar begins")] = 0.0
    ends: Annotated[float, Unit("mm"), Doc("and at which it ends")] = FAR_MM
    places: Annotated[Eight, Unit("mm"), Doc("where each of 8 stretches begins, rising; 1e9: not there")] = np.full(
        STRETCHES, FAR_MM
    )
    extra: Annotated[Eight, Unit("mm"), Doc("stock above the nominal surface there")] = np.zeros(STRETCHES)
    harder: Annotated[Eight, Doc("relative change of the specific force there")] = np.zeros(STRETCHES)


class Stock(NamedTuple):
    """The bar at one place."""

    extra: float
    """Stock above the nominal surface, mm."""
    harder: float
    """Relative change of the specific force."""
    there: float
    """1 on the bar, 0 before and behind it."""


def stretches(places: Sequence[float], extra: Sequence[float], harder: Sequence[float] = ()) -> dict[str, Eight]:
    """The three lists of a bar with up to eight stretches, filled up: keywords of :class:`Workpiece`.

    Raises:
        ValueRefused: lists of different length, or more than eight stretches.
    """
    hard = harder or [0.0] * len(places)
    if not len(places) == len(extra) == len(hard) <= STRETCHES:
        raise ValueRefused(
            f"stretches: {len(places)} places, {len(extra)} extra, {len(hard)} harder; the three have one length of at "
            f"most {STRETCHES}"
        )

    def filled(values: Sequence[float], rest: float) -> Eight:
        return np.array([*values, *[rest] * (STRETCHES - len(values))], dtype=float)

    return {"places": filled(places, FAR_MM), "extra": filled(extra, 0.0), "harder": filled(hard, 0.0)}


def checked(work: Workpiece) -> Workpiece:
    """The workpiece as it is.

    Raises:
        ValueRefused: places that do not rise, an end before the start, or a hardness below nothing.
    """
    if np.any((np.diff(work.places) <= 0.0) & (work.places[1:] < FAR_MM)):
        raise ValueRefused(f"work.places = {work.places.tolist()} (turning_lathe): must rise")
    if work.ends <= work.starts:
        raise ValueRefused(f"work.ends = {work.ends!r} (turning_lathe): must lie behind work.starts = {work.starts!r}")
    if np.any(work.harder <= -1.0):
        raise ValueRefused(f"work.harder = {work.harder.tolist()} (turning_lathe): each above -1")
    return work


def stock_at(bar, travel):
    """Extra stock and hardness where the carriage stands."""
    extra, harder = 0.0, 0.0
    for i in range(STRETCHES):
        here = travel >= bar.places[i]
        extra = bar.extra[i] if here else extra
        harder = bar.harder[i] if here else harder
    inside = travel >= bar.starts and travel < bar.ends
    return Stock(extra, harder, 1.0 if inside else 0.0)
