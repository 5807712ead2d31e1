"""Limits of size and rate: the value follows ``output`` by at most ``rate dt`` a period, inside ``lower .. upper``."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.util.errors import ValueRefused


class LimitsParams(NamedTuple):
    """Limits in the unit of the controller's output; +-10 is the analogue drive command in volt."""

    lower: Annotated[float, Doc("least value that reaches the plant")] = -10.0
    upper: Annotated[float, Doc("largest value that reaches the plant")] = 10.0
    rate: Annotated[float, Unit("1/s"), Gt(0), Doc("largest change per second, both ways")] = 10_000.0


class LimitsState(NamedTuple):
    """What reached the plant in the last period."""

    last: float = 0.0


class LimitsPlan(NamedTuple):
    """What the step needs."""

    lower: float
    upper: float
    change: float
    """Largest change in one period."""


def plan_limits(params: LimitsParams, dt: float) -> LimitsPlan:
    """The change that one period allows.

    Raises:
        ValueRefused: ``lower`` lies above ``upper``.
    """
    if params.lower > params.upper:
        raise ValueRefused(f"lower = {params.lower!r} (limits): must not lie above upper = {params.upper!r}")
    return LimitsPlan(params.lower, params.upper, params.rate * dt)


@actuator(LimitsParams, LimitsState, prepare=plan_limits)
def limits(p, s, output):
    """The output, first limited in rate, then in size."""
    followed = min(max(output, s.last - p.change), s.last + p.change)
    value = min(max(followed, p.lower), p.upper)
    return LimitsState(value), value
