"""The lathe axis behind a ball screw with errors: the table is not quite where the motor has turned the nut to.

The chain of :obj:`leadscrew.plants.lathe_servo` gives the nominal position ``n`` of the nut, turns times lead, which an
encoder on the motor sees. The table follows it with the errors of the screw:

1. play:     h  = play(n, b)              |h - n| <= b/2, and h stands still while it may
2. table:    x  = h (1 + s + a dT) + c sin(2 pi n / lead)
3. grating:  T_g dg/dt = x - g                                    (4), on the table

with the backlash ``b``, the relative lead error ``s`` (12 um per 300 mm: 4e-5), the thermal growth ``a dT`` from the
fixed bearing at 0, and the cyclic error ``c`` of one turn. Long et al. (2014) name the screw's error as the reason for
the grating and give no number for it, nor the lead; the defaults are a perfect screw of 10 mm, and then this is
``lathe_servo`` to the last bit.

Exactness: ``n`` and its part of the grating's lag are the exact zero-order-hold solution. The lag of the small rest
``x - n`` takes that rest as linear over a period, and the play sees the ends of the periods only, not a turning point
between them. Both errors fall with the loop's ``substeps``; ``docs/lathe_limits.md`` gives their size.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._lathe_servo import (
    LatheServoHold,
    LatheServoParams,
    LatheServoState,
    flushed,
    lathe_servo,
    lathe_servo_hold,
)


class LatheScrewParams(NamedTuple):
    """The chain of ``lathe_servo``, and the errors of the screw behind it."""

    full_duty_speed_mm_s: Annotated[
        float, Unit("mm/s"), Gt(0), Doc("speed of the nut at full duty; 288.8 fits Table 1, 259 to 334 its runs")
    ] = 289.0
    pwm_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the PWM amplifier, (2)")] = 0.0008
    electrical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("electrical lag of the motor, (3)")] = 0.0015
    mechanical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("mechanical lag of the motor and screw, (3)")] = 0.017
    grating_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the grating reader, (4)")] = 0.006
    lead_mm: Annotated[float, Unit("mm"), Gt(0), Doc("travel per turn; assumed, not in the paper")] = 10.0
    lead_error: Annotated[float, Gt(-1), Doc("relative error of the lead; 4e-5 is 12 um per 300 mm")] = 0.0
    cyclic_error_mm: Annotated[float, Unit("mm"), Doc("amplitude of the error that repeats every turn")] = 0.0
    backlash_mm: Annotated[float, Unit("mm"), Ge(0), Doc("play between nut and table, from end to end")] = 0.0
    expansion: Annotated[float, Unit("1/K"), Ge(0), Doc("thermal expansion of the screw; steel")] = 11.7e-6
    warming_K: Annotated[float, Unit("K"), Doc("how much warmer the screw is than when its lead was right")] = 0.0  # noqa: N815


class LatheScrewState(NamedTuple):
    """The chain, the side of the play, and the table's distance from the nut, true and as the grating lags it."""

    pwm: Annotated[float, Unit("mm/s")] = 0.0
    current: Annotated[float, Unit("mm/s")] = 0.0
    speed: Annotated[float, Unit("mm/s")] = 0.0
    nut: Annotated[float, Unit("mm")] = 0.0
    nut_reading: Annotated[float, Unit("mm")] = 0.0
    driven: Annotated[float, Unit("mm"), Doc("where the play has taken the table, before lead and warmth")] = 0.0
    rest: Annotated[float, Unit("mm"), Doc("table minus nut")] = 0.0
    rest_reading: Annotated[float, Unit("mm")] = 0.0


class LatheScrewPosition(NamedTuple):
    """What the axis shows: the table, the lagged table that a grating reader counts, the nut that an encoder counts."""

    position: float = 0.0
    reading: float = 0.0
    motor: float = 0.0


class LatheScrewHold(NamedTuple):
    """The exact step of the chain, and what the screw adds."""

    servo: LatheServoHold
    scale: float
    cyclic: float
    radians_per_mm: float
    half_play: float
    lag_from_reading: float
    lag_from_start: float
    lag_from_end: float


def lathe_screw_hold(params: LatheScrewParams, dt: float) -> LatheScrewHold:
    """The step over ``dt``; the lag of a ramp from ``d0`` to ``d1`` is exact for a ramp."""
    kept = math.exp(-dt / params.grating_lag_s)
    share = -math.expm1(-dt / params.grating_lag_s) * params.grating_lag_s / dt
    return LatheScrewHold(
        servo=lathe_servo_hold(LatheServoParams(*params[:5]), dt),
        scale=1.0 + params.lead_error + params.expansion * params.warming_K,
        cyclic=params.cyclic_error_mm,
        radians_per_mm=2.0 * math.pi / params.lead_mm,
        half_play=0.5 * params.backlash_mm,
        lag_from_reading=kept,
        lag_from_start=share - kept,
        lag_from_end=1.0 - share,
    )


def show(p, s):
    """Table, lagged table, nut."""
    return LatheScrewPosition(s.nut + s.rest, s.nut_reading + s.rest_reading, s.nut)


@plant(LatheScrewParams, LatheScrewState, output=show, prepare=lathe_screw_hold, unit="mm", sense=-1, drive="duty")
def lathe_screw(p, s, u, dt):
    """State one period later under the constant duty ``u``."""
    servo = lathe_servo(p.servo, LatheServoState(s.pwm, s.current, s.speed, s.nut, s.nut_reading), u, dt)
    nut = servo.position
    driven = min(max(s.driven, nut - p.half_play), nut + p.half_play)
    rest = driven * p.scale + p.cyclic * math.sin(p.radians_per_mm * nut) - nut
    lagged = p.lag_from_reading * s.rest_reading + p.lag_from_start * s.rest + p.lag_from_end * rest
    return LatheScrewState(servo.pwm, servo.current, servo.speed, nut, servo.reading, driven, rest, flushed(lagged))
