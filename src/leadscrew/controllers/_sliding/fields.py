"""Parameters that the stage's controllers have in common, each with its unit, range and help; and what a law without a
switching gain hands to :mod:`leadscrew.controllers._sliding.stage`.
"""

from __future__ import annotations

from typing import Annotated, Any

from leadscrew.controllers._sliding.stage import SlidingParams
from leadscrew.friction.lugre import steady_bristle
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

Lam = Annotated[float, Unit("1/s"), Gt(0), Doc("rate of the error on the surface, lambda")]
Inertia = Annotated[float, Unit("kg m^2"), Gt(0), Doc("believed inertia at the screw, J")]
Travel = Annotated[
    float, Unit("1/rad"), Gt(0), Doc("command and feedback per radian: 1 for rad, 1.5923 for mm of the table")
]
SpeedFilter = Annotated[float, Unit("s"), Ge(0), Doc("lag of the measured speed; 0 for none")]
MaxTorque = Annotated[float, Unit("N m"), Ge(0), Doc("largest size of the torque; 0 for no limit")]
Pieces = Annotated[int, Ge(0), Le(1000), Doc("pieces of a period in the mean of f_hat; 0 for f_hat at the sample")]


def stage_params(params: Any) -> SlidingParams:
    """The fields of ``params`` that :func:`~leadscrew.controllers._sliding.stage.view` and ``ended`` read.

    The switching gain is left at its defaults: a law that has none does not read it.
    """
    shared = SlidingParams._fields
    return SlidingParams(**{name: value for name, value in params._asdict().items() if name in shared})


def first_friction(p, command, bristle):
    """``F_hat`` of the first period after an align that leaves the bristles at ``bristle``; ``p``: SlidingParams.

    In motion they start at steady sliding. The mean over a period may differ by what the friction changes in it.
    """
    v = command.velocity / p.travel_per_rad
    start = steady_bristle(p.hat, v) if v != 0.0 else bristle
    return p.hat.stiffness * start + p.hat.viscous * v if p.friction_from > 0 else 0.0
