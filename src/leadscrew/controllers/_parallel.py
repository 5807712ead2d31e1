"""The parallel PID law on three inputs, shared by every controller that ends in one: pid, npid, npid_slope, npid_after.

In the order in which it happens, with ``x_p``, ``x_i``, ``x_d`` what the three terms act on:

1. ``integral = integral + x_i dt``                              backward rectangle; waits in the period after an align
2. ``slope = (filter_s slope + kd (x_d - x_d_last)) / (filter_s + dt)``    backward difference, backward-Euler lag
3. ``raw = kp x_p + ki integral + slope``
4. ``output = min(max(raw, lower), upper)``
5. ``anti_windup`` ``clamping`` (conditional integration): the integral stays as it was while ``raw`` lies outside the
   limit and ``x_i`` drives it further out.
   ``back-calculation``: ``integral += dt / max(tracking_s, dt) (output - raw) / ki``, which brings
   ``raw`` back to the limit with the time constant ``tracking_s``; with 0 in one period.

Before the first period ``x_d`` and the integral count as zero: a command that does not start at the feedback gives one
derivative kick, as the difference equation says. Back-calculation and clamping: K. J. Astrom, T. Hagglund, *Advanced
PID Control*, ISA 2006, chapter 3.

A controller that ends in this law has in its module a function ``terms(params, command, feedback)`` that gives its
:class:`Terms`, so that others can take it apart: :obj:`leadscrew.controllers.tracking_differentiator` does.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.util.errors import ValueRefused

TINY = 1e-30
"""Below this a filtered derivative is remembered as 0: its tail would end in denormal numbers, which are slow."""

Kp = Annotated[float, Unit("V/mm"), Ge(0), Doc("proportional gain, Table I")]
Ki = Annotated[float, Unit("V/(mm s)"), Ge(0), Doc("integral gain, Table I")]
Kd = Annotated[float, Unit("V s/mm"), Ge(0), Doc("derivative gain, Table I")]
Filter = Annotated[float, Unit("s"), Ge(0), Doc("lag of the derivative, by backward Euler; 0 for none")]
Lower = Annotated[float, Doc("lowest output; -inf for no limit")]
Upper = Annotated[float, Doc("highest output; inf for no limit")]
AntiWindup = Annotated[
    Literal["none", "clamping", "back-calculation"] | int, Doc("of the integral, at the limit of output")
]
Tracking = Annotated[float, Unit("s"), Ge(0), Doc("time constant of the back-calculation; 0 for one period")]


class Gains(NamedTuple):
    """What the law needs, in its own unit."""

    kp: float
    ki: float
    kd: float
    filter_s: float
    lower: float
    upper: float
    anti_windup: int
    tracking_s: float


class Terms(NamedTuple):
    """What the three terms act on, and the gain behind their sum."""

    proportional: float
    integrated: float
    differentiated: float
    gain_behind: float


class PIDState(NamedTuple):
    """What a parallel PID remembers."""

    integral: Annotated[float, Unit("s"), Doc("integral of what the integral term acts on")] = 0.0
    last: Annotated[float, Doc("what the derivative term acted on last")] = 0.0
    slope: Annotated[float, Doc("derivative term of the output")] = 0.0
    aligned: Annotated[float, Doc("1 in the first period after a bumpless start, else 0")] = 0.0


def ordered(params: Any, dt: float) -> Any:
    """The parameters as they are.

    Raises:
        ValueRefused: ``lower`` lies above ``upper``.
    """
    if params.lower > params.upper:
        raise ValueRefused(f"lower = {params.lower!r}: must not lie above upper = {params.upper!r}")
    return params


def gains(p):
    """The gains among the parameters of a controller."""
    return Gains(p.kp, p.ki, p.kd, p.filter_s, p.lower, p.upper, p.anti_windup, p.tracking_s)


def parallel(g, s, proportional, integrated, differentiated, dt):
    """Steps 1 to 5 of the module's table: the next state and the output."""
    return from_change(g, s, proportional, integrated, differentiated, differentiated - s.last, dt)


def from_change(g, s, proportional, integrated, differentiated, change, dt):
    """The same with a change of ``x_d`` over the period that comes from elsewhere."""
    integral = s.integral + (1.0 - s.aligned) * integrated * dt
    slope = (g.filter_s * s.slope + g.kd * change) / (g.filter_s + dt)
    raw = g.kp * proportional + g.ki * integral + slope
    output = min(max(raw, g.lower), g.upper)
    outwards = (raw - output) * integrated > 0.0
    share = dt / max(g.tracking_s, dt)
    brought_back = integral + share * (output - raw) / g.ki if g.ki > 0.0 else integral
    clamped = s.integral if outwards else integral
    kept = clamped if g.anti_windup == 1 else brought_back if g.anti_windup == 2 else integral
    flushed = slope if abs(slope) > TINY else 0.0
    return PIDState(kept, differentiated, flushed, 0.0), output


def aligned(g, proportional, differentiated, output):
    """The state from which the next output is ``output``; without integral action, the one of a controller at rest."""
    integral = (output - g.kp * proportional) / g.ki if g.ki > 0.0 else 0.0
    return PIDState(integral, differentiated, 0.0, 1.0)
