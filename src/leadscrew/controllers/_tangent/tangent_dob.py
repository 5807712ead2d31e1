"""Disturbance observer of a tangential axis: what the material does to the cut line, and its opposite.

    z(k) = z(k-1) + (1 - e^(-T / filter_s)) (c(k) - z(k-1))
    d(k) = clip(-gain z(k) / g, -max_offset, max_offset)

``c`` is what the offset does not explain of the reading (:mod:`leadscrew.controllers._tangent.believed`). With
``gain = 1`` and everything as believed the slow part of the deviation goes to zero; a smaller gain leaves ``1 - gain``
of it, and bounds what a wrong belief can do.

The reading is a number; the command's deviation, 0, is taken off it. A lost cut is not seen in it: a
reading that stands still winds ``z`` up, and the offset jumps when the cut is seen again (8 deg in one sample after a
second in the study, claim ``resight_observer``). Where the camera loses the cut, take a controller that reads ``seen``.

Bumpless start: the axis is believed at the output, and the observer settled at it.

Source: ours, for the study ``sofnn_tangent`` (g 0.9, gain 0.9, 0.02 s); structure as in
:obj:`leadscrew.controllers.input_dob`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.controllers._tangent.believed import (
    MOST_DEG,
    RING,
    AxisLag,
    FilterS,
    MaxOffset,
    ObserverGain,
    PlantGain,
    SensorDelay,
    back,
    next_place,
    quiet,
    samples,
    within,
)
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Unit


class TangentDobParams(NamedTuple):
    """What is believed of the axis, and the filter."""

    plant_gain: PlantGain = 0.9
    gain: ObserverGain = 0.9
    filter_s: FilterS = 0.02
    axis_lag_s: AxisLag = 0.02
    delay_s: SensorDelay = 0.04
    max_offset: MaxOffset = MOST_DEG


class TangentDobPlan(NamedTuple):
    """Shares per period and the delay in samples."""

    plant_gain: float
    gain: float
    filtered: float
    axis: float
    late: int
    max_offset: float
    empty: np.ndarray


class TangentDobState(NamedTuple):
    """The axis as believed, its past, and what was found."""

    places: Annotated[np.ndarray, Doc("angles of the axis, as believed, from where it started, deg")]
    at: Annotated[int, Doc("where the next one goes")] = 0
    axis: Annotated[float, Unit("deg"), Doc("angle of the axis, as believed, from where it started")] = 0.0
    found: Annotated[float, Unit("deg"), Doc("deviation that the material makes, z")] = 0.0
    start: Annotated[float, Unit("deg"), Doc("where the axis started")] = 0.0


def plan(params: TangentDobParams, dt: float) -> TangentDobPlan:
    """Shares per period."""
    return TangentDobPlan(
        params.plant_gain, params.gain, -math.expm1(-dt / params.filter_s), -math.expm1(-dt / params.axis_lag_s),
        samples(params.delay_s, dt, 0, "tangent_dob"), params.max_offset, np.zeros(RING),
    )  # fmt: skip


def align(params, command, feedback, output):
    """The state from which the next output is ``output``; with ``gain = 0`` that can only be 0."""
    share = max(params.gain, 1e-9) / params.plant_gain
    reading = feedback - command - params.plant_gain * output
    before = (-output / share - params.filtered * reading) / (1.0 - params.filtered)
    return TangentDobState(params.empty, 0, 0.0, before, output)


@controller(
    TangentDobParams(), TangentDobState(np.zeros(RING)), prepare=plan, align=align, unit="deg", drive="position"
)
def tangent_dob(p, s, command, feedback, dt):
    """Disturbance observer of a tangential axis; an offset in deg."""
    s.places[s.at] = s.axis
    then = s.start + back(s.places, s.at, p.late)
    found = s.found + p.filtered * (feedback - command - p.plant_gain * then - s.found)
    d = within(-p.gain * found / p.plant_gain, p.max_offset)
    axis = s.axis + p.axis * (d - s.start - s.axis)
    return TangentDobState(s.places, next_place(s.at), quiet(axis), quiet(found), s.start), d
