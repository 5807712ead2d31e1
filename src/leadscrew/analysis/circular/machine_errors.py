"""Circles with known faults: exact paths of a machine of which one knows what is wrong, to try an evaluation on.

With the command ``x = R cos phi``, ``y = R sin phi``:

    servo lag        each axis at phase ``phi -+ lag``: ``lag_um / R`` behind in its own direction of travel
    scale            ``x (1 + k_x)``, ``y (1 + k_y)``
    backlash         ``x - (b(x) / 2) sgn(x')``, ``b`` linear in x between its values at the ends
    stick motion     ``x + h p(psi) sgn(x)``: outwards after each reversal of x, ``psi`` the angle since then
    its shape        ``p = (psi / rise)^2`` up to ``rise``, then ``exp(-(psi - rise) / decay)``
    stick-slip       ``x + a sgn(x') (1/2 - frac(|psi| / period))`` within ``zone`` of a reversal of x
    cyclic           ``x + c sin(2 pi x / lead + phase)``
    straightness     ``y + s (x / R)^2`` and ``x + s (y / R)^2``
    squareness       ``x + beta y``
    centring         the whole path moved

Every term is computed from where the axis would be with its lag alone: faults add and do not multiply (parts per
million of each other). The shapes of stick motion and stick-slip are chosen: a
half wave that rises and decays.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import CCW, CW, CircularTest, Floats, Turn
from leadscrew.analysis.circular.signatures import moving, peak_shape, saw_shape, since_reversal


class AxisErrors(NamedTuple):
    """The faults of one axis; lengths in um, angles in degrees."""

    lag_um: float = 0.0
    """Following distance at the feed of the test."""
    scale_ppm: float = 0.0
    backlash_plus_um: float = 0.0
    """Play at the end of the axis in positive direction."""
    backlash_minus_um: float = 0.0
    stick_um: float = 0.0
    stick_rise_deg: float = 1.0
    stick_decay_deg: float = 2.0
    slip_um: float = 0.0
    """Peak to peak of the stick-slip."""
    slip_period_deg: float = 1.6
    slip_zone_deg: float = 8.0
    cyclic_um: float = 0.0
    lead_mm: float = 10.0
    cyclic_phase_rad: float = 0.0
    straightness_um: float = 0.0
    """Bow of this axis's path sideways, in the direction of the other axis, at the ends of the circle."""


class MachineErrors(NamedTuple):
    """The faults of a machine with two axes."""

    x: AxisErrors = AxisErrors()
    y: AxisErrors = AxisErrors()
    squareness_urad: float = 0.0
    centre_x_um: float = 0.0
    centre_y_um: float = 0.0


def circle_with(
    errors: MachineErrors,
    radius_mm: float,
    points: int = 1800,
    angles: Any = None,
    directions: str = "both",
    **test: Any,
) -> CircularTest:
    """The circular test of a machine with these faults; ``angles`` in rad in place of ``points``."""
    if angles is None:
        angles = 2.0 * math.pi * np.arange(points) / points
    phi = np.asarray(angles, dtype=np.float64)
    made = {}
    for direction in (CCW, CW):
        if directions in ("both", direction):
            order = phi if direction == CCW else -phi
            made[direction] = Turn(direction, *_path(errors, radius_mm, order, 1 if direction == CCW else -1))
    return CircularTest(radius_mm, made.get(CCW), made.get(CW), sampling=f"{phi.size} points a turn", **test)


def _path(errors: MachineErrors, radius: float, phi: Floats, sign: int) -> tuple[Floats, Floats]:
    # Each axis is where its own lag puts it; its faults are those of that place.
    at_x, at_y = (phi - sign * axis.lag_um / (1000.0 * radius) for axis in (errors.x, errors.y))
    x, y = radius * np.cos(at_x), radius * np.sin(at_y)
    along_x = _along(errors.x, radius, at_x, sign, 0) + errors.y.straightness_um * np.sin(at_y) ** 2
    along_y = _along(errors.y, radius, at_y, sign, 1) + errors.x.straightness_um * np.cos(at_x) ** 2
    along_x = along_x + 1e-3 * errors.squareness_urad * y + errors.centre_x_um
    return x + 1e-3 * along_x, y + 1e-3 * (along_y + errors.centre_y_um)


def _along(axis: AxisErrors, radius: float, phi: Floats, sign: int, which: int) -> Floats:
    """Error of one axis along itself, um."""
    place = np.cos(phi) if which == 0 else np.sin(phi)
    way = moving(phi, sign, which)
    after = since_reversal(phi, sign, which)
    play = 0.5 * (axis.backlash_plus_um * (1.0 + place) + axis.backlash_minus_um * (1.0 - place))
    found = 1e-3 * axis.scale_ppm * radius * place - 0.5 * play * way
    found = found + axis.stick_um * np.sign(-way) * peak_shape(after, axis.stick_rise_deg, axis.stick_decay_deg)
    found = found + axis.slip_um * saw_shape(after, way, axis.slip_period_deg, axis.slip_zone_deg)
    return found + axis.cyclic_um * np.sin(2.0 * math.pi * radius * place / axis.lead_mm + axis.cyclic_phase_rad)
