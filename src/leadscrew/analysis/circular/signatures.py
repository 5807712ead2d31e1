"""What each fault of a machine draws: the radial deviation at the commanded angle, to first order, for 1 um of it.

With ``phi`` the angle, ``d = 1`` counter-clockwise and -1 clockwise, ``c = cos phi``, ``s = sin phi``, ``v_x = -d s``
and ``v_y = d c`` the directions in which the axes move, the radial deviation is ``c e_x + s e_y``:

=====================  ==============================================================================================
centring X, Y          ``c``;  ``s``
scale X, Y             ``c^2``;  ``s^2``                     1 um: as much at the radius
squareness             ``s c``                               1 um: ``beta R``, ``x + beta y``; positive opens the angle
                                                             between +x and +y to less than 90 degrees
servo mismatch         ``d s c``                             1 um: X follows 1 um farther behind than Y
backlash X+, X-        ``-c sgn(v_x) (1 + c) / 4``, ``-c sgn(v_x) (1 - c) / 4``     1 um of play at that end
backlash Y+, Y-        ``-s sgn(v_y) (1 + s) / 4``, ``-s sgn(v_y) (1 - s) / 4``
straightness X, Y      ``s c^2``;  ``c s^2``                 1 um: bow of the axis's path at the ends
cyclic X, Y            ``c sin(2 pi R c / lead)``, ``c cos(2 pi R c / lead)``; the same with ``s``
stick motion X, Y      ``abs(c) p(psi)``, ``p = (psi / rise)^2`` up to ``rise``, then ``exp(-(psi - rise) / decay)``
stick-slip X, Y        ``c sgn(v_x) (1/2 - frac(n / period))`` within ``zone`` of a reversal, ``n`` the angle to it
=====================  ==============================================================================================

``psi`` is the angle since the last reversal of the axis. Negative backlash is over-compensation. The first order leaves
out ``e^2 / (2 R)``: 0.5 nm for 10 um on a radius of 100 mm, but 50 nm on 1 mm.

The shapes of Annex B of ISO 230-4 are these in words; stick motion and stick-slip are ours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import Floats

AXES = ("X", "Y")
AT_REST = 1e-9
"""Part of the feed below which an axis counts as at rest: it is at its reversal."""


def along(phi: Floats, which: int) -> Floats:
    """Place of an axis, in radii: ``cos phi`` for X (0), ``sin phi`` for Y (1)."""
    return np.cos(phi) if which == 0 else np.sin(phi)


def moving(phi: Floats, sign: Floats | int, which: int) -> Floats:
    """In which direction an axis moves: 1, -1, or 0 at its reversal."""
    speed = -sign * np.sin(phi) if which == 0 else sign * np.cos(phi)
    return np.where(np.abs(speed) < AT_REST, 0.0, np.sign(speed))


def since_reversal(phi: Floats, sign: Floats | int, which: int) -> Floats:
    """Angle since the last reversal of an axis, in [0, pi) rad."""
    first = 0.0 if which == 0 else 0.5 * math.pi
    return np.maximum(np.mod(sign * (phi - first) + AT_REST, math.pi) - AT_REST, 0.0)


def peak_shape(after: Floats, rise_deg: float, decay_deg: float) -> Floats:
    """Stick motion after a reversal: 1 at ``rise_deg`` after it."""
    rise, decay = math.radians(rise_deg), math.radians(decay_deg)
    return np.where(after < rise, (after / rise) ** 2, np.exp(-np.maximum(after - rise, 0.0) / decay))


def saw_shape(after: Floats, way: Floats, period_deg: float, zone_deg: float) -> Floats:
    """Stick-slip near a reversal: a saw tooth of 1 peak to peak, zero outside the zone."""
    near = np.minimum(after, math.pi - after)
    tooth = 0.5 - np.mod(near / math.radians(period_deg) + AT_REST, 1.0)
    return np.where(near < math.radians(zone_deg), way * tooth, 0.0)


BASE = (
    "centring X", "centring Y", "scale X", "scale Y", "squareness", "servo mismatch",
    "straightness X", "straightness Y", "backlash X+", "backlash X-", "backlash Y+", "backlash Y-",
)  # fmt: skip
"""Signatures without a shape of their own to find."""


class Motions(NamedTuple):
    """How one axis moves, at each point."""

    place: Floats
    """In radii."""
    way: Floats
    """1, -1, or 0 at a reversal."""
    after: Floats
    """Angle since the last reversal, rad."""


def motions(phi: Floats, sign: Floats, which: int) -> Motions:
    """How an axis moves at the angles of a test."""
    return Motions(along(phi, which), moving(phi, sign, which), since_reversal(phi, sign, which))


def base(sign: Floats, x: Motions, y: Motions) -> Floats:
    """The columns of :data:`BASE`, one row a point."""
    c, s = x.place, y.place
    columns = [c, s, c * c, s * s, s * c, sign * s * c, s * c * c, c * s * s]
    for axis in (x, y):
        half = -0.25 * axis.place * axis.way
        columns += [half * (1.0 + axis.place), half * (1.0 - axis.place)]
    return np.column_stack(columns)


def cyclic(axis: Motions, per_radius: float) -> Floats:
    """Two columns, sine and cosine; ``per_radius`` is the radius in leads."""
    turns = 2.0 * math.pi * per_radius * axis.place
    return np.column_stack((axis.place * np.sin(turns), axis.place * np.cos(turns)))


def stick(axis: Motions, rise_deg: float, decay_deg: float) -> Floats:
    """One column: stick motion, outwards behind each reversal."""
    return np.column_stack((-axis.place * axis.way * peak_shape(axis.after, rise_deg, decay_deg),))


def slip(axis: Motions, period_deg: float, zone_deg: float) -> Floats:
    """One column: stick-slip."""
    return np.column_stack((axis.place * saw_shape(axis.after, axis.way, period_deg, zone_deg),))
