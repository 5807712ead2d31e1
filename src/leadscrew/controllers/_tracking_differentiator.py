"""Tracking differentiator: a PID whose derivative comes from a second-order follower instead of a difference.

Of the signal v that the derivative term acts on, every period ``dt``, in the time-optimal form of Han:

    x1 <- x1 + dt x2
    x2 <- x2 + dt fhan(x1 - v, x2, r, h)             x1, x2 before the period on the right; then kd x2 is the D term

    fhan(x1, x2, r, h):   d = r h^2,   y = x1 + h x2
                          a = h x2 + y                                             |y| <= d
                          a = h x2 + sign(y) (sqrt(d (d + 8 |y|)) - d) / 2         otherwise
                          fhan = -r clip(a / d, -1, 1)

``x2`` follows the rate of v with an acceleration of at most ``r``, in mm/s^2. While v asks for less, this is the linear
filter ``s / (h s + 1)^2``, whatever r is; with ``h = dt`` it is the backward difference itself. A larger h takes out
more noise and adds more lag. The lag lies inside the loop: the gain margin of Table I's PID falls from 2.51 to 1.60
with h = 1 ms, and a loop that needs more is lost. While v asks for more than ``r``, the lag grows with the size of the
motion, so a loop that is stable for small motions can fall into a large limit cycle after a blow: take r several times
the acceleration of the worst start, and start smoothly.

Source: J. Han, *From PID to Active Disturbance Rejection Control*, IEEE Transactions on Industrial Electronics 56
(2009) 900-906, equations (9) to (11) there. Abdullah et al. (XY table, NPID) name a tracking differentiator as future
work; nothing of it is in their paper, so r and h are ours.
"""

from __future__ import annotations

import math
import sys
from typing import Annotated, Any, NamedTuple, cast

from leadscrew.controllers._parallel import TINY, Gains, PIDState, from_change, ordered
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.parameters import Doc, Gt, Le, Unit
from leadscrew.util.errors import BlockError, ValueRefused, entry_point

AccelerationLimit = Annotated[float, Unit("mm/s^2"), Gt(0), Doc("largest rate of change of the followed rate, r")]
FilterTime = Annotated[float, Unit("s"), Gt(0), Le(1.0), Doc("filter time h, at least one control period")]


class FollowerState(NamedTuple):
    """The PID's state, and the follower."""

    pid: PIDState = PIDState()
    followed: Annotated[float, Unit("mm"), Doc("x1: what the derivative term acts on, followed")] = 0.0
    rate: Annotated[float, Unit("mm/s"), Doc("x2: its rate")] = 0.0


def fhan(x1, x2, r, h):
    """The acceleration that brings ``x1`` and ``x2`` to zero in least time, smooth near zero."""
    d = r * h * h
    ahead = h * x2
    y = x1 + ahead
    far = math.copysign(0.5 * (math.sqrt(d * (d + 8.0 * abs(y))) - d), y)
    a = ahead + (y if abs(y) <= d else far)
    return -r * min(max(a / d, -1.0), 1.0)


def follow(x1, x2, v, r, h, dt):
    """``x1`` and ``x2`` one period later."""
    position, rate = x1 + dt * x2, x2 + dt * fhan(x1 - v, x2, r, h)
    return (position if abs(position) > TINY else 0.0), (rate if abs(rate) > TINY else 0.0)


@entry_point
def tracking_differentiator(inner: Block, name: str = "", r_mm_s2: float = 1000.0, h_s: float = 0.001) -> Block:
    """The controller ``inner``, its derivative by a tracking differentiator; its parameters lie below ``inner.``.

    ``inner`` is one of pid, npid, npid_slope and npid_after, or any that ends in
    :mod:`leadscrew.controllers._parallel` and has ``terms`` in its module. Its ``filter_s``, limit and anti-windup work
    as before. The follower starts at 0, after an align on the signal at rate 0. Bumpless start as the inner one's.

    Raises:
        BlockError: ``inner`` is another controller.
        ValueRefused: ``h_s`` is shorter than the control period, when the loop is built.
    """
    terms: Any = getattr(sys.modules.get(inner.step.__module__), "terms", None)
    if (
        inner.kind != "controller"
        or not isinstance(inner.state, PIDState)
        or terms is None
        or inner.prepare is not ordered
    ):
        raise BlockError(
            f"tracking_differentiator({inner.name}): needs a controller that ends in a parallel PID: pid, npid, "
            "npid_slope or npid_after"
        )
    align_inner: Any = inner.align
    own = [("inner", type(inner.params)), ("r_mm_s2", AccelerationLimit), ("h_s", FilterTime)]
    params_type = cast(Any, NamedTuple("TrackingDifferentiatorParams", own))

    def prepare(params: Any, dt: float) -> Any:
        ordered(params.inner, dt)
        if params.h_s < dt * (1.0 - 1e-9):
            raise ValueRefused(
                f"h_s = {params.h_s!r} s ({inner.name} with a tracking differentiator): shorter than the control "
                f"period of {dt!r} s, at which it does not settle; give at least one period"
            )
        return params

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``: the follower on the signal, at rest."""
        t = terms(params.inner, command, feedback)
        return FollowerState(align_inner(params.inner, command, feedback, output), t.differentiated, 0.0)

    def by_follower(p, s, command, feedback, dt):
        """The inner controller, its derivative from the follower."""
        q = p.inner
        t = terms(q, command, feedback)
        followed, rate = follow(s.followed, s.rate, t.differentiated, p.r_mm_s2, p.h_s, dt)
        g = Gains(
            q.kp, q.ki, q.kd, q.filter_s, q.lower / t.gain_behind, q.upper / t.gain_behind, q.anti_windup, q.tracking_s
        )
        after, output = from_change(g, s.pid, t.proportional, t.integrated, t.differentiated, dt * rate, dt)
        return FollowerState(after, followed, rate), t.gain_behind * output

    return make(
        "controller", by_follower, params_type(inner.params, r_mm_s2, h_s), FollowerState(), prepare=prepare,
        align=align, name=name or f"{inner.name}_tracking_differentiator", unit=inner.unit, drive=inner.drive,
        full_scale=inner.full_scale, sense=inner.sense, doc=f"{inner.doc} Its derivative is followed, not differenced.",
    )  # fmt: skip
