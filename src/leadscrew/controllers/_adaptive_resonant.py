"""Adaptive resonators for a spindle whose speed is known to a few percent only: lines that follow it.

    u    = inner(r, y) + sum over the lines of Re z_n             lines n = 1 and n = teeth, times the spindle's speed
    z_n <- e^(j n w T) z_n + i_n,        i_n = g_n T e^(j p_n) e        e = command - feedback
    w   <- w + T (a + rate x),           a <- a + T (rate / 2)^2 x      within spindle_hz (1 +- within), rad/s
    x    = sum n Im(i_n conj z_n) / T / (sum n^2 abs(z_n)^2 + floor^2)

With ``w`` right these are the resonators of :obj:`leadscrew.controllers.resonant`, gains and phases included. With
``w`` off by ``d`` the force still makes ``z_n`` turn at *its* frequency, so the error has to turn it: ``i_n`` is then,
on average, ``j n d T z_n``, and ``x = d`` however far off it is and however strong the lines are. That makes it a
phase-locked loop without a gain to tune by amplitude. ``a`` is its estimate of the drift of the speed: a speed that
changes at a constant rate is followed without a lag. Both lines vote, each by the square of its frequency and size.

``rate`` at most ``strength / 2``: the resonators have to settle before the speed does. With the defaults the speed is
found in about 4 s and kept within 1e-4 of itself. Lines smaller than ``floor_mv`` hardly move it. The inner controller
may have resonators of its own; gains are worked out with those in place, and lines should stay apart by a few times
``strength`` (in rad/s). A speed outside ``within`` is not followed; a steady drift of 0.2 % a second is, a swing of 2 %
in 10 s only in part.

``lower`` and ``upper`` limit the sum; at the limit the lines turn but do not grow, and the speed goes on as its drift
says. It belongs on the outermost block: of a limit inside, the lines know nothing. With ``teeth = 1`` there is one
line.

The problem is that of R. Marino, G. L. Santosuosso, P. Tomei, *Robust adaptive compensation of biased sinusoidal
disturbances with unknown frequency*, Automatica 39 (10), 2003; this simple form, normalised by ``abs(z)^2``, is ours.
No proof of convergence is given: it is measured (study ``npid_xytable``). Bumpless start as the inner controller's,
with resonators at rest at the believed speed.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from leadscrew.controllers._parallel import Lower, Upper, ordered
from leadscrew.controllers._resonant import Strength, Teeth, disturbance_response
from leadscrew.controllers._response import PlantModel
from leadscrew.controllers._wrapping import same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused, entry_point

TINY = 1e-30
"""Below this a resonator is remembered as 0."""
TWO_PI = 2.0 * math.pi

Nominal = Annotated[float, Unit("Hz"), Gt(0), Le(1e5), Doc("revolutions a second, as believed at the start")]
Within = Annotated[float, Ge(0), Le(0.2), Doc("how far the true speed may be off, as a share of the believed one")]
Rate = Annotated[float, Unit("1/s"), Ge(0), Le(100), Doc("rate of the adaptation; 0: none")]
Floor = Annotated[float, Unit("mV"), Gt(0), Doc("size of a line below which it hardly counts")]


class LineEntry(NamedTuple):
    """How a line's resonator takes in the error."""

    order: float
    re: float
    im: float


class LineState(NamedTuple):
    """A line's resonator: its output is ``re``, in V."""

    re: float = 0.0
    im: float = 0.0


class AdaptiveState(NamedTuple):
    """Both lines, and what is believed of the spindle."""

    first: LineState = LineState()
    tooth: LineState = LineState()
    offset: Annotated[float, Unit("rad/s"), Doc("speed less the believed one")] = 0.0
    drift: Annotated[float, Unit("rad/s^2"), Doc("its rate of change")] = 0.0
    spindle_hz: Annotated[float, Unit("Hz"), Doc("estimated speed; 0 before the first period")] = 0.0
    aligned: Annotated[float, Doc("1 in the first period after a bumpless start, else 0")] = 0.0


def turned(line, s, w, dt, error):
    """A resonator a period later, and what the error turned it by: the next state without the error, and its entry."""
    angle = line.order * w * dt
    c, d = math.cos(angle), math.sin(angle)
    return LineState(c * s.re - d * s.im, d * s.re + c * s.im), LineState(line.re * error, line.im * error)


def entered(before, entry):
    """A resonator with the error taken in."""
    re, im = before.re + entry.re, before.im + entry.im
    return LineState(re if abs(re) > TINY else 0.0, im if abs(im) > TINY else 0.0)


def scaled(entry, share):
    """A share of an entry."""
    return LineState(share * entry.re, share * entry.im)


@entry_point
def adaptive_resonant(
    inner: Block,
    spindle_hz: float = 50.0,
    teeth: int = 2,
    strength: float = 6.0,
    rate: float = 2.0,
    within: float = 0.03,
    floor_mv: float = 0.1,
    *,
    model: PlantModel,
    lower: float = -math.inf,
    upper: float = math.inf,
    name: str = "",
) -> Block:
    """The controller ``inner`` with adaptive resonators; its parameters are those of ``inner`` below ``inner.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
    """
    part = wrapped(inner, "adaptive_resonant")
    law, before, place = part.law, inner.prepare, part.place
    align_law: Any = part.align
    own: list[Any] = [
        ("spindle_hz", Nominal), ("teeth", Teeth), ("strength", Strength), ("rate", Rate), ("within", Within),
        ("floor_mv", Floor), ("model", PlantModel), ("lower", Lower), ("upper", Upper),
    ]  # fmt: skip
    params_type = cast(Any, NamedTuple("AdaptiveParams", [("inner", type(inner.params)), *own]))
    state_type = cast(Any, NamedTuple("AdaptiveOuter", [("inner", type(inner.state)), ("spindle", AdaptiveState)]))

    def prepare(params: Any, dt: float) -> Any:
        ordered(params, dt)
        ready = params.inner if before is None else before(params.inner, dt)
        plan: list[Any] = [("inner", type(ready)), ("first", LineEntry), ("tooth", LineEntry), ("speed", float),
                           ("most", float), ("rate", float), ("drift_rate", float), ("floor", float),
                           ("lower", float), ("upper", float)]  # fmt: skip
        plan_type = cast(Any, NamedTuple("AdaptivePlan", plan))
        orders = np.array([1.0, float(params.teeth)])
        highest = float(params.teeth) * params.spindle_hz * (1.0 + params.within)
        if highest >= 0.5 / dt:
            raise ValueRefused(
                f"spindle_hz = {params.spindle_hz!r} with teeth = {params.teeth!r} (adaptive_resonant): the highest "
                f"line, {highest:g} Hz, has to lie below half the sampling frequency, here {0.5 / dt:g} Hz"
            )
        w = TWO_PI * params.spindle_hz
        h = disturbance_response(part, ready, params.model, dt, orders * w)
        enter = params.strength * dt * np.conj(h) / np.abs(h) ** 2 * (1.0, float(params.teeth > 1))
        lines = [LineEntry(n, e.real, e.imag) for n, e in zip(orders.tolist(), enter.tolist(), strict=True)]
        return plan_type(
            ready, lines[0], lines[1], w, params.within * w, params.rate, 0.25 * params.rate**2,
            (1e-3 * params.floor_mv) ** 2, params.lower, params.upper,
        )  # fmt: skip

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        after = align_law(params.inner, command, feedback, output)
        still = LineState(0.0, 0.0)
        return state_type(after, AdaptiveState(still, still, 0.0, 0.0, 0.0, 1.0))

    def following(p, s, command, feedback, dt):
        """The inner controller and two lines that follow the spindle."""
        o = s.spindle
        error = (1.0 - o.aligned) * (place(command) - feedback)
        after, u = law(p.inner, s.inner, command, feedback, dt)
        w = p.speed + o.offset
        z1, i1 = turned(p.first, o.first, w, dt, error)
        z2, i2 = turned(p.tooth, o.tooth, w, dt, error)
        total = u + entered(z1, i1).re + entered(z2, i2).re
        output = min(max(total, p.lower), p.upper)
        acts = 1.0 if total == output else 0.0
        i1, i2 = scaled(i1, acts), scaled(i2, acts)
        first, tooth = entered(z1, i1), entered(z2, i2)
        seen = p.first.order * (i1.im * z1.re - i1.re * z1.im) + p.tooth.order * (i2.im * z2.re - i2.re * z2.im)
        weight = p.first.order * p.first.order * (z1.re * z1.re + z1.im * z1.im)
        weight = weight + p.tooth.order * p.tooth.order * (z2.re * z2.re + z2.im * z2.im)
        x = seen / (weight + p.floor)
        wanted = o.offset + o.drift * dt + p.rate * x
        offset = min(max(wanted, -p.most), p.most)
        drift = (o.drift + p.drift_rate * x) if wanted == offset else 0.0
        spindle = AdaptiveState(
            first, tooth, offset if abs(offset) > TINY else 0.0, drift if abs(drift) > TINY else 0.0, w / TWO_PI, 0.0
        )
        return state_type(after, spindle), output

    return same_kind(
        following, part,
        params_type(inner.params, spindle_hz, teeth, strength, rate, within, floor_mv, model, lower, upper),
        state_type(inner.state, AdaptiveState()), "Resonators follow the spindle's speed.", prepare=prepare,
        align=None if align_law is None else align, name=name or f"{inner.name}_adaptive",
    )  # fmt: skip
