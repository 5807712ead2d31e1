"""Ball-screw stage under generalised Maxwell-slip friction: a second truth for controllers that believe in LuGre.

    J d speed/dt = u + load - F        F: :mod:`leadscrew.friction.maxwell_slip`        shown = travel_per_rad angle

Inertia: Table 1 of Shams and Safdari (2010); friction: its Table 2 as far as the model has the parameters, and six
elements of our choice (:class:`~leadscrew.friction.maxwell_slip.MaxwellSlipScrew`). First loading follows ``F_S (1 -
exp(-sigma_0 x / F_S))``, what LuGre bends by, within 4 % of ``F_S``; but turning points are remembered, and steady
sliding is left and entered element by element.

The plant brings its own step, the semi-implicit one of :obj:`leadscrew.plants.mass_maxwell_slip`, in pieces no longer
than ``longest_step``. It is stable at any step and of first order: with 1 us an open loop of 11 N m at 2.5 Hz is within
3 nm (at the table) of half the step. Under control that sticks and slips single slips move; largest and RMS errors then
change by up to 5 % from 0.25 us to 5 us. Method, tolerances and ``substeps`` of a loop do not matter to it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from leadscrew.friction.lugre import level
from leadscrew.friction.maxwell_slip import (
    Elements,
    MaxwellSlipScrew,
    checked,
    move_elements,
    speed_after,
    total_stiffness,
    unloaded,
)
from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.plants._ballscrew_stage import INERTIA

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block


class BallscrewGmsParams(NamedTuple):
    """Inertia, what is shown, friction, and the step."""

    inertia: Annotated[float, Unit("kg m^2"), Gt(0), Doc("inertia at the screw; 2.12e-4 without a table")] = INERTIA
    travel_per_rad: Annotated[
        float, Unit("1/rad"), Gt(0), Doc("what is shown per radian: 1 for rad, 1.5923 for mm of the table")
    ] = 1.0
    friction: MaxwellSlipScrew = MaxwellSlipScrew()
    longest_step: Annotated[float, Unit("s"), Gt(0), Doc("a period is cut into equal steps no longer than this")] = 1e-6


class BallscrewGmsPlan(NamedTuple):
    """The parameters, and how a step of the loop is cut."""

    inertia: float
    travel_per_rad: float
    friction: MaxwellSlipScrew
    pieces: int
    stiffness: float


class BallscrewGmsState(NamedTuple):
    """The screw, and the elements."""

    angle: Annotated[float, Unit("rad")] = 0.0
    speed: Annotated[float, Unit("rad/s")] = 0.0
    elements: Elements = Elements(np.zeros(6), np.zeros(6))


def start(params: BallscrewGmsParams) -> BallscrewGmsState:
    """At rest at 0, elements without force."""
    return BallscrewGmsState(elements=unloaded(params.friction))


def cut(params: BallscrewGmsParams, dt: float) -> BallscrewGmsPlan:
    """The parameters, if their elements make sense; else ``ValueRefused``."""
    f = checked(params.friction)
    pieces = max(1, math.ceil(dt / params.longest_step * (1.0 - 1e-9)))
    return BallscrewGmsPlan(params.inertia, params.travel_per_rad, f, pieces, float(total_stiffness(f)))


def shown(p, s):
    """The angle, or the table's position."""
    return p.travel_per_rad * s.angle


@plant(BallscrewGmsParams, BallscrewGmsState, output=shown, initial=start, prepare=cut, drive="torque")
def ballscrew_gms(p, s, u, dt):
    """Ball-screw stage with generalised Maxwell-slip friction: state after ``dt`` under a torque, in N m."""
    f = p.friction
    h = dt / p.pieces
    angle = s.angle
    speed = s.speed
    elements = s.elements
    for _ in range(p.pieces):
        speed = speed_after(f, elements, p.stiffness, p.inertia, speed, u, h)
        elements = move_elements(f, elements, speed, h)
        angle = angle + h * speed
    return BallscrewGmsState(angle, speed, elements)


def sliding_at(block: Block, speed: float) -> Block:
    """The plant in steady sliding at this speed, rad/s: every element slips with its share of the friction."""
    f = block.params.friction
    way = float(np.sign(speed))
    force = way * np.asarray(f.share) * level(f, speed)
    return block.starting(**{"speed": speed, "elements.force": force, "elements.slips": np.full(len(f.share), way)})
