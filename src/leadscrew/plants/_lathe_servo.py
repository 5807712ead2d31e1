"""X axis of a CNC lathe: PWM amplifier, torque motor, screw and the lag of the grating reader.

Equations, from Long, Yuan, Xu, Du (2014), with ``u`` the signed duty of (7), clipped to [-1, 1]:

1. PWM amplifier, (2):              T_p dp/dt = -K_v u - p           T_p = 0.8 ms
2. motor, electrical part of (3):   T_e dc/dt = p - c                T_e = 1.5 ms
3. motor, mechanical part of (3):   T_m dv/dt = c - v                T_m = 17 ms
4. slide:                           dx/dt = v
5. grating reader, (4):             T_g dg/dt = x - g                T_g = 6 ms

The paper prints no slide (4. here), so its chain ends in a speed, and dc gains of 30 and 0.26 that make 7.8 rad/s at
full duty. Here every lag has a gain of one and ``K_v`` is the speed of the slide at full duty, identified from the
paper's Table 1 (288.8 mm/s, see the study ``vud_lathe``). A positive duty moves the slide towards negative ``x``,
as in Table 1.

The chain is linear, so it is stepped by its exact zero-order-hold solution: no integration error at any period.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.plants._linear import hold_matrices


class LatheServoParams(NamedTuple):
    """Speed at full duty and the four lags."""

    full_duty_speed_mm_s: Annotated[
        float, Unit("mm/s"), Gt(0), Doc("speed of the slide at full duty; 288.8 fits Table 1, 259 to 334 its runs")
    ] = 289.0
    pwm_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the PWM amplifier, (2)")] = 0.0008
    electrical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("electrical lag of the motor, (3)")] = 0.0015
    mechanical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("mechanical lag of the motor and screw, (3)")] = 0.017
    grating_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the grating reader, (4)")] = 0.006


class LatheServoState(NamedTuple):
    """The chain's lagged speeds, the slide's true position and what the grating shows of it."""

    pwm: Annotated[float, Unit("mm/s")] = 0.0
    current: Annotated[float, Unit("mm/s")] = 0.0
    speed: Annotated[float, Unit("mm/s")] = 0.0
    position: Annotated[float, Unit("mm")] = 0.0
    reading: Annotated[float, Unit("mm")] = 0.0


class LathePosition(NamedTuple):
    """What the axis shows: where the slide is, and the lagged value that a grating reader counts."""

    position: float = 0.0
    reading: float = 0.0


class LatheServoHold(NamedTuple):
    """The exact step over one period: ``new = sum(new_from_old old) + new_from_drive drive``."""

    full_duty_speed: float
    pwm_from_pwm: float
    current_from_pwm: float
    current_from_current: float
    speed_from_pwm: float
    speed_from_current: float
    speed_from_speed: float
    position_from_pwm: float
    position_from_current: float
    position_from_speed: float
    reading_from_pwm: float
    reading_from_current: float
    reading_from_speed: float
    reading_from_position: float
    reading_from_reading: float
    pwm_from_drive: float
    current_from_drive: float
    speed_from_drive: float
    position_from_drive: float
    reading_from_drive: float


def lathe_servo_hold(params: LatheServoParams, dt: float) -> LatheServoHold:
    """The exact step; the gain stays outside the matrices, so that a sweep of it computes them once."""
    return LatheServoHold(params.full_duty_speed_mm_s, *_chain(dt, *params[1:]))


USED = tuple(np.array([(i, j) for i in range(5) for j in range(i + 1) if (i, j) != (3, 3)]).T)
"""Entries of the transition that are neither always 0 nor always 1."""


@lru_cache(maxsize=256)
def _chain(dt: float, pwm: float, electrical: float, mechanical: float, grating: float) -> tuple[float, ...]:
    a = np.zeros((5, 5))
    a[0, 0] = -1.0 / pwm
    a[1, 0], a[1, 1] = 1.0 / electrical, -1.0 / electrical
    a[2, 1], a[2, 2] = 1.0 / mechanical, -1.0 / mechanical
    a[3, 2] = 1.0
    a[4, 3], a[4, 4] = 1.0 / grating, -1.0 / grating
    b = np.array([1.0 / pwm, 0.0, 0.0, 0.0, 0.0])
    transition, drive = hold_matrices(a, b, dt)
    return (*transition[USED].tolist(), *drive.tolist())


def show(p, s):
    """True position and lagged reading."""
    return LathePosition(s.position, s.reading)


def flushed(x):
    """Zero in place of a value that has decayed to nothing: denormal numbers are slow."""
    return x if abs(x) > 1e-30 else 0.0


@plant(LatheServoParams, LatheServoState, output=show, prepare=lathe_servo_hold, unit="mm", sense=-1, drive="duty")
def lathe_servo(p, s, u, dt):
    """State one period later under the constant duty ``u``."""
    drive = -p.full_duty_speed * min(1.0, max(-1.0, u))
    pwm = p.pwm_from_pwm * s.pwm + p.pwm_from_drive * drive
    current = p.current_from_pwm * s.pwm + p.current_from_current * s.current + p.current_from_drive * drive
    speed = (
        p.speed_from_pwm * s.pwm
        + p.speed_from_current * s.current
        + p.speed_from_speed * s.speed
        + p.speed_from_drive * drive
    )
    position = (
        p.position_from_pwm * s.pwm
        + p.position_from_current * s.current
        + p.position_from_speed * s.speed
        + s.position
        + p.position_from_drive * drive
    )
    reading = (
        p.reading_from_pwm * s.pwm
        + p.reading_from_current * s.current
        + p.reading_from_speed * s.speed
        + p.reading_from_position * s.position
        + p.reading_from_reading * s.reading
        + p.reading_from_drive * drive
    )
    return LatheServoState(flushed(pwm), flushed(current), flushed(speed), position, flushed(reading))
