"""A PWM amplifier's timer: the duty in whole counts of a period, and no pulse shorter than the bridge can make.

Equation (7) of Long et al. (2014) is ``rho = t_on / T``, signed: the sign chooses the pair of switches and with it the
direction, so that the mean voltage at the motor is ``U_m = rho U_s`` (:func:`mean_voltage`). A timer makes ``t_on`` of
``counts`` steps:

    rho = sign(wanted) N / counts,   N = floor(counts |wanted| + 1/2), at most counts
    rho = 0                          N < minimum_on_counts
    wanted = output + left           left: what the last period did not give, where carry = True; 0 otherwise

Without ``carry`` every duty below half a count, or below the shortest pulse, does nothing: a dead zone of
``max(minimum_on_counts - 1/2, 1/2) / counts``, in which a controller without integral action stands still. With
``carry`` the remainder goes into the next period (first-order noise shaping) and the mean is right at any size.

1,000 counts and a shortest pulse of one are assumed, 1 us in a period of 1 ms; the paper gives neither.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import actuator
from leadscrew.kernel.parameters import Doc, Ge


class PwmParams(NamedTuple):
    """The timer."""

    counts: Annotated[int, Ge(1), Doc("timer counts of one PWM period; assumed, not in the paper")] = 1000
    minimum_on_counts: Annotated[int, Ge(0), Doc("shortest pulse that the bridge makes, in counts; assumed")] = 1
    carry: Annotated[bool, Doc("whether what was rounded off goes into the next period")] = False


class PwmState(NamedTuple):
    """What rounding has kept back."""

    left: Annotated[float, Doc("duty asked for and not given so far; 0 without carry")] = 0.0


@actuator(PwmParams, PwmState, unit="1")
def pwm(p, s, output):
    """The duty that the timer makes of the one asked for."""
    wanted = min(1.0, max(-1.0, output + s.left))
    steps = math.floor(abs(wanted) * p.counts + 0.5)
    size = steps / p.counts if steps >= p.minimum_on_counts else 0.0
    rho = size if wanted > 0.0 else -size if size > 0.0 else 0.0
    left = wanted - rho if p.carry else 0.0
    return PwmState(left), rho


def mean_voltage(rho: float, supply_v: float = 30.0) -> float:
    """Mean voltage at the motor over a period, ``U_m = rho U_s`` of (7), in volt; 30 V is the gain of (2)."""
    return rho * supply_v
