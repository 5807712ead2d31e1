"""Dead-zone compensator: any controller, with what a dead zone in the drive will take away added to its output.

    output = u + width sign(u)                  softness 0: the inverse of a dead zone that subtracts its width
    output = u + width tanh(u / softness)       softness > 0: the same, without the jump at u = 0

``u`` is the inner controller's output. The dead zone is :obj:`leadscrew.actuators.dead_zone` with ``subtract``: with
``threshold = width`` and softness 0 it gives ``u`` again; a smaller width leaves the difference as a dead zone. With a
width larger than the dead zone's, or a softness so small that noise around zero switches the sign, the drive is hit
from both sides: choose the softness above the output's noise at rest.

``width`` and ``softness`` are in the unit of the inner controller's output. A limit of the inner controller does not
count what is added. Source: the standard inverse, as in G. Tao, P. V. Kokotovic, *Adaptive Control of Systems with
Actuator and Sensor Nonlinearities*, Wiley 1996, chapter 2; the softening is ours. Abdullah et al. (XY table, NPID) name
a dead-zone compensator as future work.

Bumpless start as the inner controller's. With softness 0 no output has a size between 0 and ``width``: a start at one
of these is a start at 0.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from leadscrew.controllers._wrapping import around, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge
from leadscrew.util.errors import entry_point

Width = Annotated[float, Ge(0), Doc("half the dead zone: the smallest output that moves anything")]
Softness = Annotated[float, Ge(0), Doc("output over which the addition grows to 76 % of the width; 0 for a jump")]


def widened(u, width, softness):
    """``u`` and what the dead zone will take away."""
    hard = 1.0 if u > 0.0 else -1.0 if u < 0.0 else 0.0
    return u + width * (math.tanh(u / softness) if softness > 0.0 else hard)


def narrowed(output, width, softness):
    """The ``u`` of an output: the inverse of :func:`widened`, by bisection."""
    size = abs(output)
    low, high = 0.0, size
    for _ in range(64):
        middle = 0.5 * (low + high)
        below = widened(middle, width, softness) < size
        low, high = (middle if below else low), (high if below else middle)
    return math.copysign(low, output)


@entry_point
def dead_zone_inverse(inner: Block, name: str = "", width: float = 0.02, softness: float = 0.001) -> Block:
    """The controller ``inner`` with a dead-zone compensator; its parameters are those of ``inner`` below ``inner.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
    """
    part = wrapped(inner, "dead_zone_inverse")
    law = part.law
    own: list[Any] = [("width", Width), ("softness", Softness)]
    params_type = around("DeadZoneInverseParams", inner.params, *own)

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        return around("DeadZoneInversePlan", ready, *own)(ready, params.width, params.softness)

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        return part.align(params.inner, command, feedback, narrowed(output, params.width, params.softness))

    def compensated(p, s, command, feedback, dt):
        """The inner controller, its output widened by the dead zone."""
        after, u = law(p.inner, s, command, feedback, dt)
        return after, widened(u, p.width, p.softness)

    return same_kind(
        compensated, part, params_type(inner.params, width, softness), inner.state, "A dead zone is compensated.",
        prepare=prepare, align=align, name=name or f"{inner.name}_dead_zone_inverse",
    )  # fmt: skip
