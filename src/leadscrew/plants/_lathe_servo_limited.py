"""The lathe axis with a motor that has a largest current and a largest speed, in volt and ampere.

The chain (2), (3) of :obj:`leadscrew.plants.lathe_servo` written as what it is made of, with the back-EMF
``E = U_s v / K_v`` of a slide of speed ``v``:

1. PWM amplifier:   T_p dV/dt = -U_s u - V                           T_p = 0.8 ms, U_s = 30 V
2. armature:        L di/dt = V - R i - E                            kept within +-7.5 A
3. screw, slide:    dv/dt = (K_v / U_s) (R / T_s) i,   dx/dt = v     kept within +-258.7 mm/s
4. grating reader:  T_g dg/dt = x - g                                T_g = 6 ms

The two lags of (3) are the poles of 2 and 3 together, ``(T_e s + 1)(T_m s + 1) = (L/R) T_s s^2 + T_s s + 1``, hence

    T_s = T_e + T_m = 18.5 ms,   L/R = T_e T_m / (T_e + T_m) = 1.378 ms,   L = 8.82 mH at R = 6.4 ohm,

so that far from its limits this plant is ``lathe_servo``. Current limit: the amplifier lowers the voltage so that the
current stays at the limit. Speed limit: 258.7 mm/s is the fastest that Table 1 shows (the full scale 25.87 mm per 0.1 s
of ec), although the linear chain that fits the same moves makes 289 mm/s at full duty. The paper does not say what
holds the axis back; here ``v`` stays at the limit while the current pushes outward, and the 0.49 A that full duty then
draws is spent on whatever it is. ``docs/lathe_limits.md`` compares this with a lower ceiling of the voltage.

Each period is stepped in ``SUBSTEPS`` parts, each the exact zero-order-hold solution, free or with the speed held; the
limits are looked at between the parts. The error of that is second order and 0 where no limit acts.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.plants._lathe_servo import LathePosition, flushed
from leadscrew.plants._linear import hold_matrices

SUBSTEPS = 8
"""Parts of a period, between which the limits are looked at."""


class LatheLimitedParams(NamedTuple):
    """The chain of ``lathe_servo``, the motor's electrical data, and its limits."""

    full_duty_speed_mm_s: Annotated[
        float, Unit("mm/s"), Gt(0), Doc("speed that full duty would give without the limit; 288.8 fits Table 1")
    ] = 289.0
    pwm_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the PWM amplifier, (2)")] = 0.0008
    electrical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("shorter lag of the motor, (3)")] = 0.0015
    mechanical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("longer lag of the motor, (3)")] = 0.017
    grating_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the grating reader, (4)")] = 0.006
    supply_v: Annotated[float, Unit("V"), Gt(0), Doc("voltage at full duty: the gain of (2)")] = 30.0
    resistance_ohm: Annotated[float, Unit("ohm"), Gt(0), Doc("armature: 48 V / 7.5 A at locked rotor")] = 6.4
    current_limit_a: Annotated[float, Unit("A"), Gt(0), Doc("peak current at locked rotor, section II")] = 7.5
    top_speed_mm_s: Annotated[float, Unit("mm/s"), Gt(0), Doc("fastest speed in Table 1, the full scale of ec")] = 258.7


class LatheLimitedState(NamedTuple):
    """Voltage behind the amplifier's lag, armature current, speed, true position and what the grating shows of it."""

    voltage: Annotated[float, Unit("V")] = 0.0
    current: Annotated[float, Unit("A")] = 0.0
    speed: Annotated[float, Unit("mm/s")] = 0.0
    position: Annotated[float, Unit("mm")] = 0.0
    reading: Annotated[float, Unit("mm")] = 0.0


class LatheLimitedHold(NamedTuple):
    """One part of a period, ``new = sum(new_from_old old) + new_from_drive drive``; ``held_*`` with the speed held."""

    supply: float
    current_limit: float
    top_speed: float
    dt: float
    voltage_from_voltage: float
    current_from_voltage: float
    current_from_current: float
    current_from_speed: float
    speed_from_voltage: float
    speed_from_current: float
    speed_from_speed: float
    position_from_voltage: float
    position_from_current: float
    position_from_speed: float
    reading_from_voltage: float
    reading_from_current: float
    reading_from_speed: float
    reading_from_position: float
    reading_from_reading: float
    voltage_from_drive: float
    current_from_drive: float
    speed_from_drive: float
    position_from_drive: float
    reading_from_drive: float
    held_current_from_voltage: float
    held_current_from_current: float
    held_current_from_speed: float
    held_current_from_drive: float
    held_reading_from_speed: float
    speed_per_charge: float
    """Change of speed per ampere and second, times half a part."""


FREE = ((0, 0), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 2), (4, 0), (4, 1), (4, 2), (4, 3),
        (4, 4))  # fmt: skip
"""Entries of the free transition that are neither always 0 nor always 1."""


def chain_matrices(params: LatheLimitedParams) -> tuple[np.ndarray, np.ndarray]:
    """``dz/dt = a z + b w`` far from the limits: ``z`` as in the state, ``w = -u`` the duty towards positive ``x``."""
    both = params.electrical_lag_s + params.mechanical_lag_s
    inductance = params.resistance_ohm * params.electrical_lag_s * params.mechanical_lag_s / both
    a = np.zeros((5, 5))
    a[0, 0] = -1.0 / params.pwm_lag_s
    a[1, :3] = np.array([1.0, -params.resistance_ohm, -params.supply_v / params.full_duty_speed_mm_s]) / inductance
    a[2, 1] = params.full_duty_speed_mm_s / params.supply_v * params.resistance_ohm / both
    a[3, 2] = 1.0
    a[4, 3], a[4, 4] = 1.0 / params.grating_lag_s, -1.0 / params.grating_lag_s
    return a, np.array([params.supply_v / params.pwm_lag_s, 0.0, 0.0, 0.0, 0.0])


def lathe_limited_hold(params: LatheLimitedParams, dt: float) -> LatheLimitedHold:
    """The exact solution over one part of the period."""
    return LatheLimitedHold(
        params.supply_v, params.current_limit_a, params.top_speed_mm_s, *_parts(dt / SUBSTEPS, params)
    )


@lru_cache(maxsize=256)
def _parts(dt: float, params: LatheLimitedParams) -> tuple[float, ...]:
    a, b = chain_matrices(params)
    b = b / params.supply_v
    push = float(a[2, 1])
    transition, drive = hold_matrices(a, b, dt)
    a[2, 1] = 0.0
    held, held_drive = hold_matrices(a, b, dt)
    return (
        dt,
        *(float(transition[entry]) for entry in FREE),
        *drive.tolist(),
        *held[1, :3].tolist(),
        float(held_drive[1]),
        float(held[4, 2]),
        0.5 * push * dt,
    )


def show(p, s):
    """True position and lagged reading."""
    return LathePosition(s.position, s.reading)


def part(p, s, drive):
    """State one part of a period later under the voltage ``drive`` at the amplifier's input."""
    voltage = p.voltage_from_voltage * s.voltage + p.voltage_from_drive * drive
    out = 1.0 if s.speed > 0.0 else -1.0
    held_current = (
        p.held_current_from_voltage * s.voltage
        + p.held_current_from_current * s.current
        + p.held_current_from_speed * s.speed
        + p.held_current_from_drive * drive
    )
    pushed = min(p.current_limit, max(-p.current_limit, held_current))
    at_top = abs(s.speed) >= p.top_speed and out * s.current >= 0.0
    given_back = p.speed_per_charge * pushed * pushed / max(out * (s.current - pushed), 1e-30)
    held_speed = s.speed if out * pushed >= 0.0 else s.speed - out * given_back
    free_current = (
        p.current_from_voltage * s.voltage
        + p.current_from_current * s.current
        + p.current_from_speed * s.speed
        + p.current_from_drive * drive
    )
    limited = min(p.current_limit, max(-p.current_limit, free_current))
    lowered = s.voltage + (limited - free_current) / p.current_from_voltage
    free_speed = (
        p.speed_from_voltage * lowered
        + p.speed_from_current * s.current
        + p.speed_from_speed * s.speed
        + p.speed_from_drive * drive
    )
    free_position = (
        p.position_from_voltage * lowered
        + p.position_from_current * s.current
        + p.position_from_speed * s.speed
        + s.position
        + p.position_from_drive * drive
    )
    kept_reading = p.reading_from_position * s.position + p.reading_from_reading * s.reading
    free_reading = (
        p.reading_from_voltage * lowered
        + p.reading_from_current * s.current
        + p.reading_from_speed * s.speed
        + kept_reading
        + p.reading_from_drive * drive
    )
    return LatheLimitedState(
        voltage,
        pushed if at_top else limited,
        held_speed if at_top else min(p.top_speed, max(-p.top_speed, free_speed)),
        s.position + s.speed * p.dt if at_top else free_position,
        kept_reading + p.held_reading_from_speed * s.speed if at_top else free_reading,
    )


@plant(
    LatheLimitedParams, LatheLimitedState, output=show, prepare=lathe_limited_hold, unit="mm", sense=-1, drive="duty"
)
def lathe_servo_limited(p, s, u, dt):
    """State one period later under the constant duty ``u``."""
    drive = -p.supply * min(1.0, max(-1.0, u))
    now = s
    for _ in range(SUBSTEPS):
        now = part(p, now, drive)
    return LatheLimitedState(
        flushed(now.voltage), flushed(now.current), flushed(now.speed), now.position, flushed(now.reading)
    )
