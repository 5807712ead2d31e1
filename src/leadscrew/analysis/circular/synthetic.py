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

A double ball bar: what it would read of a true path.

The bar measures the distance between the centres of two balls, one at the set-up centre, one at the tool:

    reading = round((L + centre ball + tool ball + length error) / resolution) resolution

- ``L``: distance of the path from the centre ball, which lies ``centring`` beside the set-up centre;
- each ball is out of round by ``sphericity``, peak to valley, as it turns in its cup once a turn: lobes 2 to 7 with
  phases drawn from ``seed``, scaled to that size;
- a reading every ``step_deg`` degrees; the angle is that of the feed, as the software of a bar takes it.

Defaults (resolution 0.1 um, sphericity 0.05 um, 0.2 degree, the lobes) are chosen: usual values of a commercial bar.
Temperature, gravity and the bar's dynamics are not modelled.
"""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import CCW, CW, TURN, CircularTest, Floats, Turn
from leadscrew.analysis.circular.signatures import moving, peak_shape, saw_shape, since_reversal
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit, entries
from leadscrew.util.errors import ValueRefused


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


LOBES = range(2, 8)


class BallBar(NamedTuple):
    """The instrument and how it was set up."""

    resolution_um: Annotated[float, Unit("um"), Ge(0), Doc("step of the reading; 0: none")] = 0.1
    sphericity_um: Annotated[float, Unit("um"), Ge(0), Doc("out of round of each ball, peak to valley")] = 0.05
    centring_x_um: Annotated[float, Unit("um"), Doc("centre ball, from the set-up centre, along X")] = 0.0
    centring_y_um: Annotated[float, Unit("um"), Doc("the same along Y")] = 0.0
    length_error_um: Annotated[float, Unit("um"), Doc("calibrated length less true length")] = 0.0
    step_deg: Annotated[float, Unit("deg"), Gt(0), Doc("angle between readings")] = 0.2
    seed: Annotated[int, Ge(0), Doc("of the shape of the balls")] = 0


def read_by(bar: BallBar, test: CircularTest) -> CircularTest:
    """The test as the bar would read it.

    Raises:
        ValueRefused: a value of the bar out of its range, or more than 10 degrees between readings.
    """
    for entry in entries(bar, "bar."):
        entry.check(entry.default, "ball bar")
    points = round(360.0 / bar.step_deg)
    if points < 36:
        raise ValueRefused(f"bar.step_deg = {bar.step_deg:g} deg: expected at most 10")
    forms = [_ball(bar, which) for which in (0, 1)]
    ccw, cw = (None if t is None else _read(bar, t, points, forms, test.radius_mm) for t in (test.ccw, test.cw))
    said = (
        f"{points} readings a turn; resolution {bar.resolution_um:g} um, sphericity {bar.sphericity_um:g} um, centring "
        f"({bar.centring_x_um:g}, {bar.centring_y_um:g}) um"
    )
    return replace(test, ccw=ccw, cw=cw, source="bar", sampling=said)


def _read(bar: BallBar, turn: Turn, points: int, forms: list[Floats], radius: float) -> Turn:
    # Deviations are smooth between points where coordinates are not.
    u, v = turn.x_mm - 1e-3 * bar.centring_x_um, turn.y_mm - 1e-3 * bar.centring_y_um
    deviation = np.hypot(u, v) - radius
    start = float(turn.angle[0])
    angle = start + turn.sign * TURN * np.arange(points) / points
    here = np.mod(turn.angle, TURN)
    order = np.argsort(here, kind="stable")
    read = 1000.0 * np.interp(np.mod(angle, TURN), here[order], deviation[order], period=TURN)
    for form in forms:
        read = read + np.interp(np.mod(angle, TURN), TURN * np.arange(form.size) / form.size, form, period=TURN)
    read = read + bar.length_error_um
    if bar.resolution_um > 0.0:
        read = np.round(read / bar.resolution_um) * bar.resolution_um
    length = radius + 1e-3 * read
    return Turn(turn.direction, length * np.cos(angle), length * np.sin(angle))


def _ball(bar: BallBar, which: int) -> Floats:
    """Form of a ball around its equator, um."""
    random = np.random.default_rng((bar.seed, which))
    angle = TURN * np.arange(3600) / 3600
    form = np.zeros_like(angle)
    for lobe in LOBES:
        form += random.uniform(0.5, 1.0) / lobe * np.cos(lobe * angle + random.uniform(0.0, 2.0 * math.pi))
    form -= form.mean()
    return np.asarray(bar.sphericity_um / float(np.ptp(form)) * form)


RADIUS_MM, FEED_MM_MIN = 100.0, 1000.0
FAULTS = MachineErrors(
    x=AxisErrors(lag_um=42.0, scale_ppm=-18.0, backlash_plus_um=3.0, backlash_minus_um=3.0,
                 cyclic_um=0.6, lead_mm=10.0),
    y=AxisErrors(lag_um=40.0, scale_ppm=-12.0, stick_um=2.4, stick_rise_deg=1.0, stick_decay_deg=2.0),
    squareness_urad=-25.0,
)  # fmt: skip
BAR = BallBar(centring_x_um=4.0, centring_y_um=-6.0)
SCATTER_UM = 0.05


def example() -> str:
    """The file."""
    head = (
        "# A synthetic example, not a measurement: radius 100 mm, feed 1,000 mm/min, both directions.\n"
        "# Faults: squareness -25 urad; scale X -18 ppm, Y -12 ppm; X lags 42 um, Y 40 um; play of 3 um in X;\n"
        "#   cyclic error of 0.6 um in X with a lead of 10 mm; stick motion of 2.4 um in Y (rise 1, decay 2 degrees).\n"
        "# Read by a ball bar model: centring (4, -6) um, balls out of round by 0.05 um, scatter 0.05, step 0.1 um.\n"
        "angle_deg,deviation_um,direction\n"
    )
    test = read_by(BAR._replace(resolution_um=0.0), circle_with(FAULTS, RADIUS_MM, feed_mm_min=FEED_MM_MIN))
    lines, count = [], 0
    for turn in test.turns:
        degrees = np.degrees(turn.angle)
        for at, deviation in zip(degrees, turn.deviation_um(RADIUS_MM), strict=True):
            count += 1
            scatter = NormalDist(0.0, SCATTER_UM).inv_cdf((0.5 + 0.6180339887498949 * count) % 1.0)
            lines.append(f"{round(at, 1) + 0.0:g},{round(deviation + scatter, 1) + 0.0:g},{turn.direction}\n")
    return head + "".join(lines)
