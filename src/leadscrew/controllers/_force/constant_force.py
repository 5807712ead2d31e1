"""Constant cutting force: entry, depth changes and unknown material in one controller.

    feed  = f(r, b(t + preview_s))                  the feed that gives the force by the cutting law believed in
    w    := w (b_old / b_new)^(1/P),   w += share (n feed / gain - w)
    u     = clip(w + lead (w - m)),    m += T / (lead_lag_s + T) (w - m)

- **Cutting law**: level and exponent, estimated from feed per revolution and raw force, both corrected for compliance
  and for the depth that is believed to be cut now: :mod:`leadscrew.controllers._force.cutting_law`. Neither is
  filtered, so chip and force belong to the same instant; the filtered force tells only whether
  there is a cut. While little is known the feed is held back (``caution``), more so where the chip has to become
  thicker than the law is trusted for (``exponent_caution``): the belief's, or the thickest that was cut.
- **Depth**: the programme ahead of time through the radial servo believed in:
  :mod:`leadscrew.controllers._force.programme`.
- **Lead**: ``lead`` of the way more while the wanted feed changes: what the feed servo takes is partly made up for. A
  model of it, not a feedback.

The estimate follows the force, so there is no steady error but the mean of the load cell's own. A commanded force of 0
gives no feed; in the air, told as a depth of 0, the feed is that of the coming cut, else of the last one, else at most
``air_feed`` until the tool is in the cut, and nothing is learned. All knowledge of the machine is in ``gain``,
``preview_s``, ``lead_lag_s``, ``radial`` and the stiffness.

Source: ours, for the study ``grey_turning``. It reads
:class:`~leadscrew.sensors.CutReading` and is told :class:`~leadscrew.references.CutCommand`.

Bumpless start: the level of the law is set so that the output is the one of the moment, for the depth commanded then;
nothing is learned in the first revolution.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._force.cutting_law import Belief, Law, feed_for, learned, prior
from leadscrew.controllers._force.power_law_inversion import FeedGain, Rpm
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
from leadscrew.controllers._force.revolution import Turns, nothing_yet, one_ago, recorded, speed
from leadscrew.controllers._grey_fuzzy.surface import Lower, Upper
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._turning.process import RadialServo
from leadscrew.util.errors import ValueRefused

TINY = 1e-30


class ConstantForceParams(NamedTuple):
    """Beliefs, preview and how fast the feed goes where it should."""

    belief: Belief = Belief()
    radial: RadialServo = RadialServo()
    preview_s: PreviewS = 0.065
    depth_error: DepthError = 0.0
    min_depth: MinDepth = 0.2
    air: Air = 0.02
    air_feed: AirFeed = 0.1
    share: Annotated[float, Gt(0), Le(1), Doc("share of the way to the wanted feed that is gone in a period")] = 0.8
    caution: Annotated[float, Ge(0), Doc("standard deviations of the force by which the feed is held back")] = 0.5
    exponent_caution: Annotated[
        float, Ge(0), Doc("standard deviations of the exponent by which a thicker chip is approached with care")
    ] = 4.0
    known: Annotated[float, Ge(0), Doc("standard deviation of ln of the force that counts as known")] = 0.1
    lead: Annotated[float, Ge(0), Le(2), Doc("what the output goes farther while the feed changes")] = 0.3
    lead_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the feed servo, 2 zeta / w")] = 0.03
    gain: FeedGain = 150.0
    spindle_rpm: Rpm = 1200.0
    lower: Lower = 0.0
    upper: Upper = 1.0


class ConstantForcePlan(NamedTuple):
    """The parameters as the step reads them."""

    belief: Belief
    follower: Follower
    from_s: float
    depth_error: float
    min_depth: float
    air: float
    air_feed: float
    share: float
    caution: float
    exponent_caution: float
    known: float
    lead: float
    follows: float
    gain: float
    spindle_rpm: float
    lower: float
    upper: float
    blank: Turns
    """A history without a reading, that begins in the cut."""


class ConstantForceState(NamedTuple):
    """What is known of the cut, and the feed that is wanted."""

    law: Law = Law()
    turns: Turns = nothing_yet()
    now: Depth = Depth()
    ahead: Depth = Depth()
    coming: Annotated[float, Unit("mm"), Doc("mean depth that the programme asks for in this period")] = 0.0
    aim: Annotated[float, Unit("mm"), Doc("programmed depth for which the feed is set; 0: none is known")] = 0.0
    thick: Annotated[float, Unit("mm"), Doc("chip up to which the law is trusted; it goes with the depth")] = 0.0296
    blind: Annotated[float, Doc("1 from the air, the cut to come being unknown, until it has its depth; else 0")] = 0.0
    output: Annotated[float, Unit("V"), Doc("output without lead, w")] = 0.0
    model: Annotated[float, Unit("V"), Doc("output that the feed has followed, m")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0
    held: Annotated[float, Doc("1 in the first period after a bumpless start, else 0")] = 0.0


def ready(params: ConstantForceParams, dt: float) -> ConstantForcePlan:
    """The parameters as the step reads them.

    Raises:
        ValueRefused: limits the wrong way round.
    """
    p = params
    if not p.lower < p.upper:
        raise ValueRefused(f"lower = {p.lower:g} V, upper = {p.upper:g} V: the lower limit must be below")
    return ConstantForcePlan(
        p.belief, follower(p.radial, dt), p.preview_s - dt, p.depth_error, p.min_depth, p.air, p.air_feed,
        p.share, p.caution, p.exponent_caution, p.known, p.lead, dt / (p.lead_lag_s + dt), p.gain, p.spindle_rpm,
        p.lower, p.upper, nothing_yet(0.0),
    )  # fmt: skip


def begun(params: ConstantForceParams) -> ConstantForceState:
    """Nothing read yet."""
    return ConstantForceState(prior(params.belief), nothing_yet(), thick=params.belief.chip_mm)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    first = prior(params.belief)
    depth = cutting(command.depth, params.depth_error, params.min_depth)
    chip = max(params.gain * output / params.spindle_rpm, 1e-6)
    level = math.log(max(command.force, 1.0) / depth) - first.exponent * math.log(chip / params.belief.chip_mm)
    here = Depth(command.depth, 0.0)
    law = Law(level, first.exponent, first.level_level, first.level_exponent, first.exponent_exponent)
    return ConstantForceState(
        law, params.blank, here, here, command.depth, command.depth, chip, 0.0, output, output, 1.0, 1.0
    )


@controller(
    ConstantForceParams(), ConstantForceState(), prepare=ready, initial=begun, align=align, unit="V", drive="voltage",
    full_scale=1.0,
)  # fmt: skip
def constant_force(p, s, command, feedback, dt):
    """Feed from an estimate of the cutting law, with preview of the depth; a voltage."""
    started = s.started > 0.5
    follows_now = followed(p.follower, s.now, s.coming)
    aim = aimed(command, p.from_s, dt, p.depth_error, p.min_depth, p.air, s.aim)
    follows_ahead = followed(p.follower, s.ahead, aim)
    now = Depth(follows_now.depth if started else command.depth, follows_now.speed if started else 0.0)
    ahead = Depth(follows_ahead.depth if started else aim, follows_ahead.speed if started else 0.0)

    rpm = speed(s.turns, feedback.turns, p.spindle_rpm, dt)
    turns = recorded(s.turns, feedback.travel, feedback.turns, feedback.raw)
    before = one_ago(turns)
    depth = cutting(now.depth, p.depth_error, p.min_depth)
    feed = feedback.travel - before.travel
    better = learned(p.belief, s.law, depth, feed, feedback.raw, before.force, feedback.force)
    believed, wish = now.depth + p.depth_error, aim + p.depth_error
    deep = believed >= max(min(p.min_depth, NEAR * wish), p.air)
    whole = before.whole > 0.5 and deep
    law = Law(
        better.level if whole else s.law.level, better.exponent if whole else s.law.exponent,
        better.level_level if whole else s.law.level_level, better.level_exponent if whole else s.law.level_exponent,
        better.exponent_exponent if whole else s.law.exponent_exponent,
    )  # fmt: skip

    new = cutting(ahead.depth, p.depth_error, p.min_depth)
    old = cutting(s.ahead.depth, p.depth_error, p.min_depth)
    factor = (old / new) ** (1.0 / law.exponent) if started else 1.0
    cuts = command.depth + p.depth_error >= p.air
    blind = wish < p.air or (cuts and s.blind > 0.5 and believed < NEAR * wish)
    most = min(p.air_feed, p.upper) if blind else p.upper
    thick = max(s.thick * factor, feed if cuts else 0.0)
    chip = feed_for(p.belief, law, command.force, new, p.caution, p.known, thick, p.exponent_caution)
    wanted = max(rpm, 0.0) * chip / p.gain
    from_here, model = s.output * factor, s.model * factor
    moved = from_here + p.share * (min(max(wanted, p.lower), most) - from_here)
    going = s.output if s.held > 0.5 else min(max(moved, p.lower), most)
    lag = s.model if s.held > 0.5 else model
    output = min(max(going + p.lead * (going - lag), p.lower), going if s.held > 0.5 else most)
    next_model = lag + p.follows * (going - lag)
    return ConstantForceState(
        law, turns, now, ahead, programmed(command, 0.0, dt), aim, thick, 1.0 if blind else 0.0, going,
        next_model if next_model > TINY else 0.0, 1.0, 0.0,
    ), output  # fmt: skip


constant_force.step.takes_cut = True  # type: ignore[attr-defined]
