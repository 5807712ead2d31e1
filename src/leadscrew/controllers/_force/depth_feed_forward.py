"""Depth feed-forward: when the programmed depth of cut changes, the feed changes with it, a little before.

    u(k-1) := u(k-1) (b_old / b_new)^(1 / exponent),      then the inner controller adds its increment to it

With ``F = kf b (v / n)^P`` the force keeps its value if the feed goes with ``b^(-1/P)``. ``b_old`` and ``b_new`` are
the depth that is believed at ``t + preview_s`` in the last period and in this one: the programme, plus ``depth_error``,
through the radial servo that is believed in (``radial``, gain 0: the depth changes at once); see
:mod:`leadscrew.controllers._force.programme`. ``preview_s`` makes up for what delays the feed: lag of its servo,
``2 zeta / w``, half a revolution of the spindle until the chip has its thickness, half a period of hold, dead time.

In the air (told as a depth of 0) the force says nothing and an integrating inner controller runs up to full feed.
There, and until the tool has its depth, the output is at most what it was in the last cut, gone with the depth that
comes next, and at most ``air_feed`` where there was no cut.

The programme is known, so nothing is guessed but the exponent; it is not a reaction to a depth that is wrong. A change
of depth that comes at once cannot be met: the force follows it at once, the feed within 0.1 s.

Source: ours, for the study ``grey_turning``.

Bumpless start: as the inner controller's.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from leadscrew.controllers._force.programme import (
    NEAR,
    Air,
    AirFeed,
    Depth,
    DepthError,
    Follower,
    MinDepth,
    PreviewS,
    aimed,
    cutting,
    followed,
    follower,
    programmed,
)
from leadscrew.controllers._force.wrapped import same_kind, wrapped
from leadscrew.controllers._wrapping import around
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._turning.process import RadialServo
from leadscrew.util.errors import entry_point

Exponent = Annotated[float, Gt(0), Le(1), Doc("P that is believed in: how force grows with chip thickness")]


class FeedForwardState(NamedTuple):
    """The depth now and ahead, the most that is allowed in the air, and whether there was a period before."""

    now: Depth = Depth()

    ahead: Depth = Depth()
    coming: Annotated[float, Unit("mm"), Doc("mean depth that the programme asks for in this period")] = 0.0
    aim: Annotated[float, Unit("mm"), Doc("programmed depth for which the output is set; 0: none is known")] = 0.0
    most: Annotated[float, Unit("V"), Ge(0), Doc("most in the air; 0 before the first cut: air_feed")] = 0.0
    entering: Annotated[float, Doc("1 in the air and until the tool has its depth, else 0")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


@entry_point
def depth_feed_forward(
    inner: Block,
    exponent: float = 0.77,
    preview_s: float = 0.065,
    depth_error: float = 0.0,
    radial: RadialServo | None = None,
    min_depth: float = 0.05,
    air: float = 0.02,
    air_feed: float = 0.1,
    name: str = "",
) -> Block:
    """The controller ``inner`` with depth feed-forward; its parameters are below ``inner.``.

    It takes the programme (:class:`~leadscrew.references.CutCommand`) and reads all sensors
    (:class:`~leadscrew.sensors.CutReading`); ``inner`` gets the forces alone unless it takes these too.

    Raises:
        BlockError: ``inner`` is not an incremental controller with a state field ``output``.
    """
    part = wrapped(inner, "depth_feed_forward")
    law, its, with_output = part.law, part.its, part.with_output
    params_type = around(
        "DepthFeedForwardParams", inner.params, ("exponent", Exponent), ("preview_s", PreviewS),
        ("depth_error", DepthError), ("radial", RadialServo), ("min_depth", MinDepth), ("air", Air),
        ("air_feed", AirFeed),
    )  # fmt: skip
    state_type = around("DepthFeedForwardState", inner.state, ("programme", FeedForwardState))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        plan_type = around(
            "DepthFeedForwardPlan", ready, ("power", float), ("from_s", float), ("depth_error", float),
            ("follower", Follower), ("min_depth", float), ("air", float), ("air_feed", float),
        )  # fmt: skip
        return plan_type(
            ready, 1.0 / params.exponent, params.preview_s - dt, params.depth_error, follower(params.radial, dt),
            params.min_depth, params.air, params.air_feed,
        )  # fmt: skip

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        state, here = part.align(params.inner, its(command), its(feedback), output), Depth(command.depth, 0.0)
        return state_type(state, FeedForwardState(here, here, command.depth, command.depth, output, 0.0, 0.0))

    def fed_forward(p, s, command, feedback, dt):
        """The inner controller, from an output that goes with the depth ahead."""
        f = s.programme
        begun = f.started > 0.5
        aim = aimed(command, p.from_s, dt, p.depth_error, p.min_depth, p.air, f.aim)
        follows = followed(p.follower, f.now, f.coming)
        now = Depth(follows.depth if begun else command.depth, follows.speed if begun else 0.0)
        moved = followed(p.follower, f.ahead, aim)
        ahead = Depth(moved.depth if begun else aim, moved.speed if begun else 0.0)
        old = cutting(f.ahead.depth, p.depth_error, p.min_depth)
        new = cutting(ahead.depth, p.depth_error, p.min_depth)
        factor = (old / new) ** p.power if begun else 1.0
        start = with_output(s.inner, s.inner.output * factor)
        after, asked = law(p.inner, start, its(command), its(feedback), dt)
        cut = command.depth + p.depth_error >= p.air
        near = now.depth + p.depth_error >= NEAR * (aim + p.depth_error)
        entering = not cut or (f.entering > 0.5 and not near)
        most = f.most * factor if f.most > 0.0 else p.air_feed
        output = min(asked, most) if entering else asked
        kept = with_output(after, min(after.output, most) if entering else after.output)
        return state_type(kept, FeedForwardState(
            now, ahead, programmed(command, 0.0, dt), aim, most if entering else output, 1.0 if entering else 0.0, 1.0
        )), output  # fmt: skip

    servo = RadialServo() if radial is None else radial
    return same_kind(
        fed_forward, part,
        params_type(inner.params, exponent, preview_s, depth_error, servo, min_depth, air, air_feed),
        state_type(inner.state, FeedForwardState()), "Its output goes with the programmed depth of cut.", True,
        prepare=prepare, align=align, name=name or f"{inner.name}_depth_ff",
    )  # fmt: skip
