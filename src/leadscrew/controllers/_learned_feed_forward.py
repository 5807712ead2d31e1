"""Learned feed-forward: any controller, with the voltage of the commanded motion and of friction, learned as it runs.

    output = v + a w_a + b w_b + f w_f                         v: output of the inner controller
    w_a = (r'' + stiffness r) / gain,    w_b = damping r' / gain                  equation (1), inverted
    w_f = F_C z / z_s,    dz = dr - abs(dr) z / (z_s (1 + (F_S / F_C - 1) exp(-(r' / v_s)^2)))
    a' = rate v w_a / (5 mV^2 + mean of w_a^2)                 and so for b and f; the mean is one of 2 s

``r`` is the command when the output acts: from ``dead_time_s`` to ``dead_time_s + T`` after the sample; ``w_f`` is
averaged over that period, in four pieces. ``z`` is the bristle of ``xy_table_lugre``, bent by the *command*: friction
goes through a reversal as on the axis, from ``-F_C`` to ``F_C`` over the presliding travel; a sign function would kick.

``a = b = share`` and ``f = friction_share`` at the start: 1 is the believed table. What the inner controller still has
to add in phase with a part is what this part lacks, so its share moves until nothing is left: feedback-error learning
(M. Kawato, K. Furukawa, R. Suzuki, *A hierarchical neural-network model for control and learning of voluntary
movement*, Biological Cybernetics 57, 1987), linear in three shares. ``rate = 0`` is a fixed feed-forward, as
:obj:`leadscrew.controllers.friction_feed_forward` around :obj:`leadscrew.controllers.inverse_feed_forward`.

What has to be known: ``presliding_um``. The shares make up for friction of another size and for another gain or damping
of the table; a presliding travel of half or double stays as an error at every reversal. Odd resonators
(:obj:`leadscrew.controllers.resonant`) as the inner controller take part of that.

The command is a :class:`~leadscrew.references.Motion`; the inner controller gets its position. A limit of the
inner controller's output does not count what is added. Bumpless start as the inner controller's; the shares start anew.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

from leadscrew.controllers._look_ahead import advanced
from leadscrew.controllers._wrapping import around, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import BlockError, entry_point

PIECES = 4
"""Of a period, in which friction is followed."""
LEAST = 25e-6
"""V^2: a part smaller than 5 mV is not learned from."""
MEMORY_S = 2.0
"""Of the mean squares."""
FAR = 700.0
"""The exponent of the Stribeck curve is cut here."""
TINY = 1e-30
"""Below this a mean square is 0."""


class LearnedBelief(NamedTuple):
    """What is believed of the table, and how fast the shares are learned."""

    gain: Annotated[float, Unit("mm/(V s^2)"), Gt(0), Doc("numerator of the model: acceleration at 1 V, (1)")] = 69380.0
    damping: Annotated[float, Unit("1/s"), Ge(0), Doc("denominator of the model, coefficient of s, (1)")] = 144.8
    stiffness: Annotated[float, Unit("1/s^2"), Ge(0), Doc("denominator of the model, constant coefficient, (1)")] = (
        166.3
    )
    friction_mv: Annotated[float, Unit("mV"), Ge(0), Doc("believed friction in fast sliding, F_C")] = 20.0
    presliding_um: Annotated[
        float, Unit("um"), Gt(0), Doc("believed deflection at which friction reaches F_C, z_s")
    ] = 5.0
    static_ratio: Annotated[float, Ge(1), Doc("believed F_S / F_C")] = 1.2
    stribeck_mm_s: Annotated[float, Unit("mm/s"), Gt(0), Doc("believed speed of the fall to F_C, v_s")] = 1.0
    dead_time_s: Annotated[float, Unit("s"), Ge(0), Le(0.1), Doc("from the sample to the voltage")] = 0.775e-3
    share: Annotated[float, Ge(0), Le(2), Doc("share of the motion's voltage at the start, a and b")] = 1.0
    friction_share: Annotated[float, Ge(0), Le(2), Doc("share of friction at the start, f")] = 1.0
    rate: Annotated[float, Unit("1/s"), Ge(0), Le(10), Doc("how fast the shares are learned; 0: not")] = 0.5


class LearnedShares(NamedTuple):
    """What was learned, the bristle, and how large the parts are."""

    bristle: Annotated[float, Unit("um")] = 0.0
    inertia: Annotated[float, Doc("learned, added to the share a")] = 0.0
    viscous: Annotated[float, Doc("learned, added to the share b")] = 0.0
    friction: Annotated[float, Doc("learned, added to the share f")] = 0.0
    inertia_square: Annotated[float, Unit("V^2")] = 0.0
    viscous_square: Annotated[float, Unit("V^2")] = 0.0
    friction_square: Annotated[float, Unit("V^2")] = 0.0
    aligned: Annotated[float, Doc("1 in the first period after a bumpless start, else 0")] = 0.0


class Parts(NamedTuple):
    """Voltages of the commanded motion."""

    inertia: float
    viscous: float


def motion_parts(p, then):
    """``w_a`` and ``w_b`` of a command."""
    return Parts((then.acceleration + p.stiffness * then.position) / p.gain, p.damping * then.velocity / p.gain)


def faded(square, part, dt):
    """Running mean of the square of a part."""
    mean = square + dt / MEMORY_S * (part * part - square)
    return mean if mean > TINY else 0.0


def added(p, s, command, v, dt):
    """The next shares and the voltage that is added to ``v``."""
    running = 1.0 - s.aligned
    z = s.bristle
    mean = 0.0
    for k in range(PIECES):
        now = advanced(command, p.dead_time_s + (k + 0.5) * dt / PIECES)
        ratio = now.velocity / p.stribeck_mm_s
        most = p.presliding_um * (1.0 + (p.static_ratio - 1.0) * math.exp(-min(ratio * ratio, FAR)))
        moved = 1e3 * dt / PIECES * now.velocity
        x = abs(moved) / most
        after = (z + moved * (1.0 + 0.5 * x)) / (1.0 + x + 0.5 * x * x)
        mean = mean + 0.5 * (z + after) / PIECES
        z = after
    parts = motion_parts(p, advanced(command, p.dead_time_s + 0.5 * running * dt))
    rubbed = 1e-3 * p.friction_mv * running * mean / p.presliding_um
    a2 = faded(s.inertia_square, parts.inertia, dt)
    b2 = faded(s.viscous_square, parts.viscous, dt)
    f2 = faded(s.friction_square, rubbed, dt)
    learned = dt * p.rate * running * v
    a = s.inertia + learned * parts.inertia / (a2 + LEAST)
    b = s.viscous + learned * parts.viscous / (b2 + LEAST)
    f = s.friction + learned * rubbed / (f2 + LEAST)
    voltage = (p.share + a) * parts.inertia + (p.share + b) * parts.viscous + (p.friction_share + f) * rubbed
    return LearnedShares(z, a, b, f, a2, b2, f2, 0.0), voltage


@entry_point
def learned_feed_forward(inner: Block, name: str = "", **values: float) -> Block:
    """The controller ``inner`` with learned feed-forward; its parameters are those of ``inner`` below ``inner.``.

    ``values``: of :class:`LearnedBelief`, below ``belief.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller of a position with parameters and state, or takes other
            signals.
    """
    part = wrapped(inner, "learned_feed_forward")
    if part.motion:
        raise BlockError(f"learned_feed_forward({inner.name}): needs a controller of a position, not of a motion")
    law = part.law
    params_type = around("LearnedParams", inner.params, ("belief", LearnedBelief))
    state_type = around("LearnedState", inner.state, ("shares", LearnedShares))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        return around("LearnedPlan", ready, ("belief", LearnedBelief))(ready, params.belief)

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        b = params.belief
        parts = motion_parts(b, advanced(command, b.dead_time_s))
        rest = output - b.share * (parts.inertia + parts.viscous)
        return state_type(part.align(params.inner, command.position, feedback, rest), LearnedShares(aligned=1.0))

    def with_learning(p, s, command, feedback, dt):
        """The inner controller on the commanded position, and what was learned to add for the commanded motion."""
        after, v = law(p.inner, s.inner, command.position, feedback, dt)
        shares, voltage = added(p.belief, s.shares, command, v, dt)
        return state_type(after, shares), v + voltage

    block = same_kind(
        with_learning, part, params_type(inner.params, LearnedBelief()), state_type(inner.state, LearnedShares()),
        "Feed-forward of motion and friction is learned.", motion=True, prepare=prepare,
        align=align, name=name or f"{inner.name}_learned",
    )  # fmt: skip
    return block.using(**{f"belief.{key}": value for key, value in values.items()})
