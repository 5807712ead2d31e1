"""What a tangential knife is told: heading and curvature of the programmed line, sample by sample, and a little ahead.

    heading_k = table[min(k, n - 1)],                or, again and again, table[k mod n] + turn floor(k / n)
    travel_k = k feed dt

The tables hold ``n`` values (``samples``), one a control period at the programmed feed;
:func:`leadscrew.paths.path.sampled` makes them. The heading is unwrapped: an angle folded to the half circle would jump
by 180 degrees on every closed line. What is asked for is a deviation of zero between the tangent of the cut and that of
the programme.

Source: signals of the paper of the study ``sofnn_tangent``, where the offset angle turns the blade against the error of
the tangent. Feed and sampling are reconstructed.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused

ROOM = 2048
"""Places of the tables: all lines of a study share one compiled program."""


class TangentCommand(NamedTuple):
    """The programmed line where the blade is, and a little ahead."""

    deviation: Annotated[float, Unit("deg"), Doc("angle between the cut and the programme: zero")] = 0.0
    heading: Annotated[float, Unit("deg"), Doc("tangent of the programmed line, unwrapped")] = 0.0
    curvature: Annotated[float, Unit("1/mm"), Doc("its curvature, positive to the left")] = 0.0
    heading_ahead: Annotated[float, Unit("deg"), Doc("tangent a few samples ahead")] = 0.0
    curvature_ahead: Annotated[float, Unit("1/mm"), Doc("curvature a few samples ahead")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("distance along the line")] = 0.0


Heading = Annotated[NDArray[np.float64], Unit("deg"), Doc("tangent at each sample, unwrapped")]
Curvature = Annotated[NDArray[np.float64], Unit("1/mm"), Doc("curvature at each sample")]
Samples = Annotated[int, Ge(1), Le(ROOM), Doc("samples of the line")]
Again = Annotated[bool, Doc("whether the line starts again behind its last sample; else the last is held")]
Turn = Annotated[float, Unit("deg"), Doc("what a lap adds to the heading")]
Feed = Annotated[float, Unit("mm/s"), Gt(0), Le(5000), Doc("speed of the blade along the line")]


class CutLineParams(NamedTuple):
    """A sampled line."""

    heading: Heading = np.zeros(ROOM)
    curvature: Curvature = np.zeros(ROOM)
    samples: Samples = 1
    again: Again = False
    turn: Turn = 0.0
    preview: Annotated[int, Ge(0), Le(200), Doc("samples between what is commanded and what is shown ahead")] = 1
    feed: Feed = 50.0


class Place(NamedTuple):
    """Where in a table, and the heading of the laps before."""

    at: int
    laps: float


def place_of(count, again, turn, k):
    """The place of sample ``k``."""
    lap = math.floor(k / count) if again else 0.0
    at = k - lap * count
    return Place(int(min(at, count - 1.0)), lap * turn)


def sample_of(t, dt):
    """Number of the period that starts at ``t``, as a float."""
    return math.floor(t / dt + 0.5)


@reference(CutLineParams)
def cut_line(p, t, dt):
    """The programmed line, here and ``preview`` samples ahead."""
    k = sample_of(t, dt)
    here = place_of(p.samples, p.again, p.turn, k)
    there = place_of(p.samples, p.again, p.turn, k + p.preview)
    return TangentCommand(
        0.0,
        p.heading[here.at] + here.laps,
        p.curvature[here.at],
        p.heading[there.at] + there.laps,
        p.curvature[there.at],
        k * p.feed * dt,
    )


def tables(heading: NDArray[np.float64], curvature: NDArray[np.float64]) -> dict[str, NDArray[np.float64] | int]:
    """``heading``, ``curvature`` and ``samples`` as parameters, in tables of :data:`ROOM` places.

    Raises:
        ValueRefused: no or too many samples, of unequal number, or not finite.
    """
    h, c = np.asarray(heading, dtype=float), np.asarray(curvature, dtype=float)
    if h.ndim != 1 or h.shape != c.shape or not 1 <= h.size <= ROOM:
        raise ValueRefused(
            f"heading of shape {h.shape}, curvature of shape {c.shape} (cut_line): expected rows of one length, "
            f"1 to {ROOM} samples; a longer line needs a higher feed or a longer period"
        )
    if not (np.isfinite(h).all() and np.isfinite(c).all()):
        raise ValueRefused("heading or curvature (cut_line): has values that are not finite")
    room = np.zeros((2, ROOM))
    room[:, : h.size] = h, c
    room[:, h.size :] = [[h[-1]], [c[-1]]]
    return {"heading": room[0], "curvature": room[1], "samples": int(h.size)}


def along(block: Block, heading: NDArray[np.float64], curvature: NDArray[np.float64], **values: float) -> Block:
    """A block of this line's tables (``cut_line``, ``cut_load``) on another line; ``values``: further parameters."""
    return block(**tables(heading, curvature), **values)
