"""How fast a position step can be at all, on an axis with one lag: a formula.

The axis is ``T dv/dt = K u - v``, ``dx/dt = v``, ``|u| <= 1``, from rest to rest over the way ``D``. Pontryagin's
principle leaves one switch: full duty for ``t_1``, then full duty the other way for ``t_2``. The speed ends at zero,
``t_2 = T ln(2 - e^(-t_1/T))``, and the sum of ``T dv/dt = K u - v`` over the move is ``0 = K (t_1 - t_2) - D``:

    t_1 + t_2 = D / K + 2 t_2  ->  D / K + 2 T ln 2        for moves much longer than T

With a top speed ``V`` below ``K`` the axis rises to it in ``t_r = -T ln(1 - V/K)``, stays there, and brakes in
``t_f = T ln(1 + V/K)``; together they cover ``K (t_r - t_f)``, and the rest of the way is at ``V``.

:mod:`leadscrew.analysis.time_optimal` does it for a chain of lags and whole periods.
"""

from __future__ import annotations

import math

from leadscrew.util.errors import ValueRefused


def single_lag_time(distance: float, speed: float, lag: float, top_speed: float = math.inf) -> float:
    """Least time from rest to rest of an axis with one lag, in seconds.

    Args:
        distance: way, positive.
        speed: ``K``, the speed at full duty, positive, in the unit of the way a second.
        lag: seconds, positive; a chain of lags that are short against the move counts with their sum.
        top_speed: the speed never exceeds this.

    Raises:
        ValueRefused: a distance, speed, lag or top speed that is not positive.
    """
    given = {"distance": distance, "speed": speed, "lag": lag, "top_speed": top_speed}
    for name, value in given.items():
        if not value > 0.0:
            raise ValueRefused(f"{name} = {value!r} (single_lag_time): must be positive")
    brake = lag * math.log(2.0)
    for _ in range(200):  # a contraction, of slope e^(-t_1/T) / (2 - e^(-t_1/T)) < 1
        brake = lag * math.log(2.0 - math.exp(-(distance / speed + brake) / lag))
    fastest = speed * math.expm1(brake / lag)
    if fastest <= top_speed:
        return distance / speed + 2.0 * brake
    rise, fall = -lag * math.log1p(-top_speed / speed), lag * math.log1p(top_speed / speed)
    return rise + fall + (distance - speed * (rise - fall)) / top_speed
