"""The cross slide: a servo that takes a voltage for a speed, and moves the tool to depth.

    lag_s dv/dt = clip(gain u, -max_speed, max_speed) - v,      db/dt = v      mm/s and mm; positive: deeper

Stepped by its exact solution for a voltage held over ``dt``. With the voltage in proportion to the error the loop is of
type 1: no steady error without an integral term.

Source: the second AC servo motor of the lathe, section 2 of the paper of the study ``grey_turning``, which gives no
number; 5 mm/s per volt and 30 ms are ours.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Gt, Unit

TINY = 1e-30
"""Below this a speed that has decayed is 0: denormal numbers are slow."""


class CrossServo(NamedTuple):
    """The servo of the cross slide."""

    gain: Annotated[float, Unit("mm/(s V)"), Gt(0), Doc("speed at 1 V")] = 5.0
    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of its speed")] = 0.03
    max_speed: Annotated[float, Unit("mm/s"), Gt(0), Doc("largest speed")] = 50.0


class CrossHold(NamedTuple):
    """The exact step over ``dt``."""

    gain: float
    max_speed: float
    dt: float
    share: float
    """Share of its way that the speed goes in a step."""
    reach: float
    """Way that a speed of 1 mm/s, decaying, still makes in a step, s."""


class Cross(NamedTuple):
    """Place and speed of the tool across the work."""

    depth: Annotated[float, Unit("mm"), Doc("depth of the tool below the nominal surface")] = 0.0
    speed: Annotated[float, Unit("mm/s"), Doc("its speed")] = 0.0


def cross_hold(servo: CrossServo, dt: float) -> CrossHold:
    """The shares of a step of ``dt``."""
    share = -math.expm1(-dt / servo.lag_s)
    return CrossHold(servo.gain, servo.max_speed, dt, share, servo.lag_s * share)


def moved_across(p, s, u):
    """Place and speed one step later."""
    asked = min(max(p.gain * u, -p.max_speed), p.max_speed)
    over = s.speed - asked
    speed = asked + (1.0 - p.share) * over
    return Cross(s.depth + p.dt * asked + p.reach * over, speed if abs(speed) > TINY else 0.0)
