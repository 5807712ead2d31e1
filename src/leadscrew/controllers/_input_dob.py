"""Disturbance observer at the plant's input, around any controller: what the output should have done, and did not.

    u   = inner(r, y) - d
    d   = Q(s) [ P^-1(s) y - u delayed ],       Q = w^2 / (s + w)^2,       P = gain / (s^2 + damping s + stiffness)

Discrete by Tustin's rule, with ``Q P^-1`` as one filter of order two: nothing is differentiated twice. The delay of
``u`` is the dead time and half a period, because the output is held, between two samples by straight line. It is at
least one period: the output of now is not known yet.

What it does: a disturbance at the input is taken off as far as ``Q`` with its delay follows it,
``1 - Q(jw) e^(-jw tau)`` of it is left. That is below one at low frequencies and **above** one beyond, so a slow
observer makes some lines worse. What it does not do: remove a following error. While the plant is the believed one,
``P^-1 y`` is the delayed ``u``, and ``d = 0`` whatever the error is.

Gain and phase of ``d`` enter the loop's stability: look at the peak of sensitivity of the whole. Structure: K. Ohnishi,
M. Shibata, T. Murakami, *Motion control for advanced mechatronics*, IEEE/ASME Trans. Mechatronics 1 (1), 1996.

``lower`` and ``upper`` limit the sum, and the observer gets the limited one, so nothing winds up. Bumpless start:
from rest with a voltage that holds the axis where it is.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple, cast

from leadscrew.controllers._parallel import Lower, Upper, ordered
from leadscrew.controllers._response import PlantModel
from leadscrew.controllers._wrapping import same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.parameters import Doc, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused, entry_point

TINY = 1e-30
"""Below this a filter's state is remembered as 0."""
MOST = 4.0
"""Longest delay of the output, in periods."""

Bandwidth = Annotated[float, Unit("rad/s"), Gt(0), Le(1e5), Doc("corner of Q, w")]


class Second(NamedTuple):
    """A filter of order two: ``(b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2)``."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


class Weights(NamedTuple):
    """Shares of the last five outputs in the delayed one."""

    w1: float
    w2: float
    w3: float
    w4: float
    w5: float


class ObserverState(NamedTuple):
    """What the observer remembers: two filters in transposed form, and the outputs sent."""

    y1: float = 0.0
    y2: float = 0.0
    u1: float = 0.0
    u2: float = 0.0
    sent1: Annotated[float, Unit("V"), Doc("output of the last period")] = 0.0
    sent2: float = 0.0
    sent3: float = 0.0
    sent4: float = 0.0
    sent5: float = 0.0
    disturbance: Annotated[float, Unit("V"), Doc("what it found at the input, d")] = 0.0


def tustin(b: tuple[float, float, float], w: float, dt: float) -> Second:
    """``(b_2 s^2 + b_1 s + b_0) / (s + w)^2`` by Tustin's rule; ``b`` from the highest power down."""
    c = 2.0 / dt
    most, middle, least = b[0] * c * c, b[1] * c, b[2]
    scale = 1.0 / (c + w) ** 2
    return Second(
        (most + middle + least) * scale, 2.0 * (least - most) * scale, (most - middle + least) * scale,
        -2.0 * (c - w) / (c + w), ((c - w) / (c + w)) ** 2,
    )  # fmt: skip


def delay_weights(late: float) -> Weights:
    """The delay of ``late`` periods, 1 to 4, as a straight line between two outputs.

    Raises:
        ValueRefused: a longer delay.
    """
    if late > MOST:
        raise ValueRefused(
            f"a delay of {late:g} periods (input_dob): dead_time_s + dt / 2 may be up to {MOST:g} periods"
        )
    at = max(late, 1.0)
    return Weights(*(max(0.0, 1.0 - abs(at - k)) for k in (1.0, 2.0, 3.0, 4.0, 5.0)))


def flushed(x):
    """A number, or 0 where it would soon be denormal."""
    return x if abs(x) > TINY else 0.0


@entry_point
def input_dob(
    inner: Block,
    bandwidth: float = 100.0,
    *,
    model: PlantModel,
    lower: float = -math.inf,
    upper: float = math.inf,
    name: str = "",
) -> Block:
    """The controller ``inner`` with a disturbance observer; its parameters are those of ``inner`` below ``inner.``.

    A feed-forward belongs inside: what is added outside the observer takes for a disturbance.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
    """
    part = wrapped(inner, "input_dob")
    law, before = part.law, inner.prepare
    align_law: Any = part.align
    own: list[Any] = [("bandwidth", Bandwidth), ("model", PlantModel), ("lower", Lower), ("upper", Upper)]
    params_type = cast(Any, NamedTuple("InputDobParams", [("inner", type(inner.params)), *own]))
    fields: list[Any] = [("inner", type(inner.state)), ("observer", ObserverState)]
    state_type = cast(Any, NamedTuple("InputDobState", fields))

    def prepare(params: Any, dt: float) -> Any:
        ordered(params, dt)
        ready = params.inner if before is None else before(params.inner, dt)
        plan: list[Any] = [("inner", type(ready)), ("inverse", Second), ("filter", Second), ("weights", Weights),
                           ("held_per_mm", float), ("lower", float), ("upper", float)]  # fmt: skip
        plan_type = cast(Any, NamedTuple("InputDobPlan", plan))
        m, w = params.model, params.bandwidth
        k = w * w / m.gain
        inverse = tustin((k, k * m.damping, k * m.stiffness), w, dt)
        weights = delay_weights(m.dead_time_s / dt + 0.5)
        return plan_type(
            ready, inverse, tustin((0.0, 0.0, w * w), w, dt), weights, m.stiffness / m.gain, params.lower, params.upper
        )

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``: both filters settled on the axis held where it is."""
        held = params.held_per_mm * feedback
        f, g = params.inverse, params.filter
        observer = ObserverState(
            held - f.b0 * feedback, f.b2 * feedback - f.a2 * held, held - g.b0 * held, g.b2 * held - g.a2 * held,
            held, held, held, held, held, 0.0,
        )  # fmt: skip
        return state_type(align_law(params.inner, command, feedback, output), observer)

    def observed(p, s, command, feedback, dt):
        """The inner controller less what disturbs the plant."""
        after, u = law(p.inner, s.inner, command, feedback, dt)
        f, g, o, w = p.inverse, p.filter, s.observer, p.weights
        delayed = w.w1 * o.sent1 + w.w2 * o.sent2 + w.w3 * o.sent3 + w.w4 * o.sent4 + w.w5 * o.sent5
        needed = f.b0 * feedback + o.y1
        given = g.b0 * delayed + o.u1
        d = needed - given
        raw = u - d
        output = min(max(raw, p.lower), p.upper)
        observer = ObserverState(
            flushed(f.b1 * feedback - f.a1 * needed + o.y2), flushed(f.b2 * feedback - f.a2 * needed),
            flushed(g.b1 * delayed - g.a1 * given + o.u2), flushed(g.b2 * delayed - g.a2 * given),
            output, o.sent1, o.sent2, o.sent3, o.sent4, d,
        )  # fmt: skip
        return state_type(after, observer), output

    return same_kind(
        observed, part, params_type(inner.params, bandwidth, model, lower, upper),
        state_type(inner.state, ObserverState()), "A disturbance observer corrects its output.", prepare=prepare,
        align=None if align_law is None else align, name=name or f"{inner.name}_dob",
    )  # fmt: skip
