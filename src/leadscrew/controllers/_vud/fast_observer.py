"""An observer of the lathe's chain: undoes the sensor's lag, knows where the axis would coast to, learns its gain.

The chain of :mod:`leadscrew.plants.lathe_servo` (lags 0.8, 1.5 and 17 ms, an integrator, the grating's 6 ms) is driven
by a duty ``u`` that the controller knows. In partial fractions every lag is a mode of its own, exact for a held duty:

1. ``I   <- I + u dt``,   ``m_i <- a_i m_i + (1 - a_i) u``,   ``a_i = exp(-dt / T_i)``
2. position  ``x = x_0 - K (I + sum_i c_i m_i)``,  sum over the three lags of the drive,
   ``c_i = -T_i / prod_(j != i) (1 - T_j / T_i)``
3. reading   ``g = x_0 - K (I + sum_i d_i m_i)``, sum over all four lags, ``d_i`` the same product over all four

``K`` is the speed at full duty and ``x_0`` where the axis would rest had nothing moved it. With the duty at zero every
mode dies out, so ``x_0 - K I`` is where the axis will come to rest; ``m_m``, the mode of the mechanical lag, is the
slow part of its speed, ``-K m_m`` in the end.

The feedback tells ``x_0`` and ``K``, the only two things that the controller does not know, by a Kalman filter whose
regressor is ``(1, -G)``, ``G = I + sum_i d_i m_i``:

4. ``nu = feedback - (x_0 - K G)``; at rest ``nu <- nu - clip(nu, -band, band)``, because a reading inside half a count
   of the prediction contradicts nothing, and following it would make the axis hunt between two counts
5. gain ``k = P h / (h' P h + R)``, ``(x_0, K) += k nu``, ``P <- P - k h' P``,
   ``R = q^2 / 12 + (timing v)^2``: a count of ``q``, and lags that are not exactly the believed ones at speed ``v``
6. ``P_00 += walk^2 dt``, ``P_11 += (forget K_n m_m)^2 dt``: the offset drifts always, the gain while the axis moves

``K`` is held between half and twice its nominal value ``K_n``. With ``gain_doubt = 0`` and ``forget = 0`` the gain
stays ``K_n`` and only ``x_0`` follows the feedback. Ours; the filter is R. E. Kalman's, *J. Basic Eng.* 82 (1960) 35.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.util.errors import ValueRefused

APART = 1e-3
"""Least relative distance of two lags: the partial fractions of equal ones do not exist."""


class ChainParams(NamedTuple):
    """What the observer believes of the axis, and how far."""

    full_duty_speed_mm_s: Annotated[float, Unit("mm/s"), Gt(0), Doc("nominal speed at full duty, K_n")] = 289.0
    pwm_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the PWM amplifier, (2)")] = 0.0008
    electrical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("electrical lag of the motor, (3)")] = 0.0015
    mechanical_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("mechanical lag of motor and screw, (3)")] = 0.017
    grating_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the grating reader, (4)")] = 0.006
    count_mm: Annotated[float, Unit("mm"), Gt(0), Doc("one count of the sensor, q")] = 0.000625
    band_mm: Annotated[float, Unit("mm"), Ge(0), Doc("surprise that counts as none at rest: half a count")] = 0.0003125
    rest_mm_s: Annotated[float, Unit("mm/s"), Ge(0), Doc("slow speed below which the axis counts as at rest")] = 0.1
    walk_mm: Annotated[float, Unit("mm/s^0.5"), Gt(0), Doc("drift of the offset in one second")] = 0.0003
    gain_doubt: Annotated[float, Ge(0), Doc("standard deviation of K / K_n at the start; 0: the gain is known")] = 0.0
    forget: Annotated[float, Unit("1/s^0.5"), Ge(0), Doc("drift of K / K_n in one second at full speed")] = 0.0
    timing_s: Annotated[float, Unit("s"), Ge(0), Doc("doubt about the sum of the lags")] = 0.0


class ChainState(NamedTuple):
    """Modes of the chain, what is believed of offset and gain, and the covariance of the two."""

    travel: Annotated[float, Unit("s"), Doc("I, integral of the duty")] = 0.0
    pwm: Annotated[float, Doc("mode of the PWM lag, in duty")] = 0.0
    electrical: Annotated[float, Doc("mode of the electrical lag, in duty")] = 0.0
    slow: Annotated[float, Doc("mode of the mechanical lag, in duty")] = 0.0
    grating: Annotated[float, Doc("mode of the grating's lag, in duty")] = 0.0
    offset: Annotated[float, Unit("mm"), Doc("x_0")] = 0.0
    gain: Annotated[float, Doc("K / K_n")] = 1.0
    p_offset: Annotated[float, Unit("mm^2"), Doc("variance of the offset")] = 0.0
    p_both: Annotated[float, Unit("mm"), Doc("covariance of offset and gain")] = 0.0
    p_gain: Annotated[float, Doc("variance of K / K_n")] = 0.0


class Chain(NamedTuple):
    """The parameters as the step reads them; ``c``, ``d`` and ``k`` of each mode."""

    speed: float
    k_pwm: float
    k_electrical: float
    k_slow: float
    k_grating: float
    c_pwm: float
    c_electrical: float
    c_slow: float
    d_pwm: float
    d_electrical: float
    d_slow: float
    d_grating: float
    slow_share: float
    """Speed in the slow mode at full duty, over the speed at full duty."""
    variance: float
    band: float
    rest: float
    walk: float
    doubt: float
    forget: float
    timing: float


def ready_chain(p: ChainParams, dt: float) -> Chain:
    """The chain in partial fractions, for a period of ``dt``.

    Raises:
        ValueRefused: two lags that are the same within 0.1 %.
    """
    drive = (p.pwm_lag_s, p.electrical_lag_s, p.mechanical_lag_s)
    every = (*drive, p.grating_lag_s)
    near = [(a, b) for i, a in enumerate(every) for b in every[:i] if abs(a - b) <= APART * max(a, b)]
    if near:
        raise ValueRefused(
            f"lags of {near[0][0]:g} s and {near[0][1]:g} s (vud_fast): the observer needs lags that differ by more "
            f"than {100 * APART:g} %"
        )
    c, d = _fractions(drive), _fractions(every)
    kept = [math.exp(-dt / lag) for lag in every]
    numbers = (
        p.full_duty_speed_mm_s, *kept, *c, *d, -c[2] / p.mechanical_lag_s, p.count_mm**2 / 12.0, p.band_mm,
        p.rest_mm_s / p.full_duty_speed_mm_s, p.walk_mm**2 * dt, p.gain_doubt**2, p.forget**2 * dt, p.timing_s,
    )  # fmt: skip
    return Chain(*numbers)


def _fractions(lags: tuple[float, ...]) -> list[float]:
    return [-t / math.prod(1.0 - other / t for other in lags if other != t) for t in lags]


def flushed(x):
    """Zero in place of a value that has decayed to nothing: denormal numbers are slow."""
    return x if abs(x) > 1e-30 else 0.0


def corrected(p, s, feedback, started):
    """Steps 4 and 5: the state after the feedback. In the first period it gives the offset, whatever the modes."""
    shown = s.travel + p.d_pwm * s.pwm + p.d_electrical * s.electrical + p.d_slow * s.slow + p.d_grating * s.grating
    regressor = -p.speed * shown
    offset = s.offset if started > 0.0 else feedback - s.gain * regressor
    p_offset = s.p_offset if started > 0.0 else p.variance
    p_gain = s.p_gain if started > 0.0 else p.doubt
    surprise = feedback - (offset + s.gain * regressor)
    ignored = p.band if abs(s.slow) < p.rest else 0.0
    used = surprise - min(max(surprise, -ignored), ignored)
    to_offset = p_offset + regressor * s.p_both
    to_gain = s.p_both + regressor * p_gain
    noise = p.timing * p.speed * s.slow
    scale = 1.0 / (to_offset + regressor * to_gain + p.variance + noise * noise)
    gain = min(max(s.gain + scale * to_gain * used, 0.5), 2.0)
    return ChainState(
        s.travel,
        s.pwm,
        s.electrical,
        s.slow,
        s.grating,
        offset + scale * to_offset * used,
        gain,
        max(p_offset - scale * to_offset * to_offset, 0.0),
        flushed(s.p_both - scale * to_offset * to_gain),
        flushed(max(p_gain - scale * to_gain * to_gain, 0.0)),
    )


def moved(p, s, duty, dt):
    """Steps 1 and 6: the state one period later under this duty."""
    return ChainState(
        s.travel + duty * dt,
        flushed(p.k_pwm * s.pwm + (1.0 - p.k_pwm) * duty),
        flushed(p.k_electrical * s.electrical + (1.0 - p.k_electrical) * duty),
        flushed(p.k_slow * s.slow + (1.0 - p.k_slow) * duty),
        flushed(p.k_grating * s.grating + (1.0 - p.k_grating) * duty),
        s.offset,
        s.gain,
        s.p_offset + p.walk,
        s.p_both,
        s.p_gain + p.forget * s.slow * s.slow,
    )
