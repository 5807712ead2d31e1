"""The spindle of a retrofitted lathe: inverter, induction motor, and what the cutting torque does to its speed.

    lag_s dn_0/dt = clip(gain u, 0, max_speed) - n_0               inverter: speed of the field, 1/min at the spindle
    (J d pi/30) dn/dt = n_0 - d T - n,      n >= 0                 rotor: slip in proportion to the torque
    T = F D / 2000                                                 N m, force N, diameter mm

``d``: droop, 1/min lost for each N m in the steady state; ``J``: inertia of rotor, gears, chuck and work, referred to
the spindle, kg m^2. ``J d pi/30`` is the time in which the rotor follows the field. With ``d = 0`` the speed is the
field's whatever the torque: a first-order lag. Both equations are stepped by their exact solution for
an input and a torque held over ``dt``.

Source: an inverter in front of the lathe's induction motor, section 2 of the paper of the study ``grey_turning``, which
gives no number; 150 1/min per volt and 0.3 s are ours. A droop of 2.5 1/min per N m (a motor of some 3 kW with
5 % slip at its rating) and 0.15 kg m^2 are those of a lathe of 400 mm swing.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit

TINY = 1e-30
"""Below this a speed that has decayed is 0: denormal numbers are slow."""


class SpindleMotor(NamedTuple):
    """Inverter and motor."""

    gain: Annotated[float, Unit("1/(min V)"), Gt(0), Doc("speed at 1 V without load")] = 150.0
    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the inverter's frequency")] = 0.3
    max_speed: Annotated[float, Unit("1/min"), Gt(0), Doc("largest speed of the field")] = 1500.0
    droop: Annotated[float, Unit("1/(min N m)"), Ge(0), Doc("speed lost for each N m; 0: none")] = 2.5
    inertia: Annotated[float, Unit("kg m^2"), Ge(0), Doc("of all that turns, at the spindle")] = 0.15


class SpindleHold(NamedTuple):
    """The exact step over ``dt``."""

    gain: float
    max_speed: float
    droop: float
    share: float
    """Share of its way that the field goes in a step."""
    follow: float
    """The same of the rotor."""


class Spindle(NamedTuple):
    """Speeds of field and rotor."""

    field: Annotated[float, Unit("1/min"), Doc("speed of the motor's field, at the spindle")] = 0.0
    rpm: Annotated[float, Unit("1/min"), Doc("spindle speed")] = 0.0


def spindle_hold(motor: SpindleMotor, dt: float) -> SpindleHold:
    """The shares of a step of ``dt``."""
    follows_s = motor.inertia * motor.droop * math.pi / 30.0
    follow = -math.expm1(-dt / follows_s) if follows_s > 0.0 else 1.0
    return SpindleHold(motor.gain, motor.max_speed, motor.droop, -math.expm1(-dt / motor.lag_s), follow)


def turned_on(p, s, u, torque):
    """Field and rotor one step later."""
    field = s.field + p.share * (min(max(p.gain * u, 0.0), p.max_speed) - s.field)
    rpm = max(s.rpm + p.follow * (field - p.droop * torque - s.rpm), 0.0)
    return Spindle(field if field > TINY else 0.0, rpm if rpm > TINY else 0.0)


def cutting_torque(force, diameter):
    """Torque of a main cutting force, N m."""
    return force * diameter / 2000.0
