"""A double ball bar: what it would read of a true path.

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
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.analysis.circular.paths import TURN, CircularTest, Floats, Turn
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.sheet import Doc, Ge, Gt, Unit, entries

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
