"""Chip and force in turning: the thickness is what the tool moved since the same place of the last revolution.

With the carriage at ``x``, the spindle at ``theta`` revolutions and the surface ``x_c(theta)`` that the edge has left:

    w = x - x_c(theta - 1)                                  room between the edge and the surface, if nothing gives way
    h + (r K b / k) h^P = w,      F = K b h^P               chip thickness and main cutting force, h >= 0
    x_c(theta) = max(x - r F / k, x_c(theta - 1))           what the edge leaves; nothing, where it is out of the cut

``K`` N/mm^(1+P), ``P``: material; ``b``: depth of cut, mm; ``k``: stiffness of tool and work in the direction of the
feed, N/mm; ``r``: force in that direction over the main force. Without compliance ``h`` is the feed per revolution once
a full revolution has been cut at that feed, and ``F = K b f^P``: equation (1) of the paper of the study
``grey_turning``, which holds in the steady state only.

The surface is kept by angle, :data:`CELLS` places a revolution, so a spindle that droops or stops is dealt with as it
is on a machine.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import Doc, Gt, Le, Unit

CELLS = 256
"""Places of the surface a revolution; straight lines between them."""

RING = CELLS + 2
"""Places kept."""

THINNEST = 1e-12
"""Room below which there is no chip, mm."""

NEWTON_STEPS = 4


class CuttingLaw(NamedTuple):
    """Main cutting force ``F = kf b h^exponent``; S45C (medium carbon steel) by default."""

    kf: Annotated[float, Unit("N/mm^(1+P)"), Gt(0), Doc("specific force at a chip thickness of 1 mm")] = 2256.3
    exponent: Annotated[float, Gt(0), Le(1), Doc("P: how force grows with chip thickness")] = 0.77


S45C = CuttingLaw()
"""Medium carbon steel, section 2 of the paper."""

IRON = CuttingLaw(1450.0, 0.96)
"""Iron, section 2 of the paper."""


class Cut(NamedTuple):
    """One instant of the cut."""

    chip: float
    """Chip thickness, mm."""
    force: float
    """Main cutting force, N."""


def surface_before(ring, turns):
    """Where the surface stands that was cut one revolution before ``turns``, mm; 0 before the first one."""
    place = max(turns - 1.0, 0.0) * CELLS
    whole = math.floor(place)
    i = int(whole)
    share = place - whole
    found = (1.0 - share) * ring[i % RING] + share * ring[(i + 1) % RING]
    return found if turns >= 1.0 else 0.0


def leave_surface(ring, turns, surface, next_turns, next_surface):
    """Writes what the edge left between two angles into the ring; returns the last place written."""
    first = int(turns * CELLS) + 1
    last = int(next_turns * CELLS)
    slope = (next_surface - surface) / max(next_turns - turns, 1e-15)
    for i in range(first, last + 1):
        ring[i % RING] = surface + slope * (i / CELLS - turns)
    return last


def cut(law, depth, yielding, room):
    """Chip thickness and force where there is ``room`` in front of the edge.

    ``yielding``: ``r / k``, mm of chip lost for each N. Newton's method on ``q = h^P``: ``q^(1/P) + c q = w`` is
    convex, and from above it comes down to the root without passing it.
    """
    w = max(room, THINNEST)
    force_per_q = law.kf * depth
    c = yielding * force_per_q
    turned = 1.0 / law.exponent
    q = w**law.exponent
    q = min(q, w / max(c, 1e-30))
    for _ in range(NEWTON_STEPS):
        h = q**turned
        q = max(q - (h + c * q - w) / (turned * h / q + c), 1e-30)
    there = room > THINNEST
    return Cut(max(w - c * q, 0.0) if there else 0.0, force_per_q * q if there else 0.0)


def blank() -> np.ndarray:
    """A surface at 0 all around."""
    return np.zeros(RING)
