"""Repetitive control: any linear controller, and a memory of one period of what it did not manage.

    v_k = sum over m of q_m (v_(k-N-m) + strength e_(k-N-m+lead))         N = period_s / T,   e = r - y
    u   = inner(r, y - v)

One period later the error is met by what it was: every line at a multiple of ``1 / period_s`` below the cut-off goes,
also those that nobody counted. ``q`` is a low-pass without phase shift (the memory holds its future): a Gaussian of
``cutoff_hz`` at -3 dB, sampled at ``2 taps + 1`` points around ``N``, which need not be a whole number, and of unit
sum. ``lead`` (``lead_s`` in whole periods) makes up for the lag of the closed loop ``T_c = L / (1 + L)``.

**Convergence.** The error shrinks from period to period by ``|Q (1 - strength T_c e^(j w lead T))|``, which has to stay
below one at all frequencies; :func:`contraction` gives it. What ``Q`` takes away is not learned: of a line the share
``(1 - Q) / (1 - Q (1 - strength T_c e^(j w lead T)))`` stays. Where the loop does not follow (``T_c`` far from one),
``Q`` has to have cut off. K. Srinivasan, F.-R. Shaw, *Analysis and design of repetitive control systems using the
regeneration spectrum*, ASME J. Dynamic Systems 113, 1991; plug-in form: M. Tomizuka, T.-C. Tsao, K.-K. Chew, *Analysis
and synthesis of discrete-time repetitive controllers*, ASME J. Dynamic Systems 111, 1989.

The price: between the multiples of ``1 / period_s`` errors grow, up to twofold, and it takes some periods to learn. A
line that is no multiple (a spindle's) stays.

``lower`` and ``upper`` limit the output; while it is at the limit, its own or the same one of the inner controller, the
error is not learned, and what is remembered fades by ``q``. Bumpless start as the inner controller's, with an empty
memory.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from leadscrew.controllers._parallel import Lower, Upper, ordered
from leadscrew.controllers._response import PlantModel, law_response, plant_response
from leadscrew.controllers._wrapping import same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import BlockError, ValueRefused, entry_point

TINY = 1e-30
"""Below this the memory holds 0."""
TAPS = 40
"""The low-pass reaches this many samples to either side."""

PeriodS = Annotated[float, Unit("s"), Gt(0), Le(1e3), Doc("what repeats itself: period of the motion")]
CutoffHz = Annotated[float, Unit("Hz"), Gt(0), Doc("where the low-pass has lost 3 dB")]
LeadS = Annotated[float, Unit("s"), Ge(0), Le(0.1), Doc("lag of the closed loop that is made up for")]
Share = Annotated[float, Ge(0), Le(2), Doc("share of the error that is learned in a period")]


def low_pass(cutoff_hz: float, dt: float, shift: float = 0.0) -> np.ndarray:
    """The Gaussian low-pass around ``shift`` samples, of unit sum.

    Raises:
        ValueRefused: a cut-off so low that the taps do not reach its ends.
    """
    width = math.sqrt(math.log(2.0)) / (2.0 * math.pi * cutoff_hz * dt)
    if 3.0 * width > TAPS:
        least = 3.0 * math.sqrt(math.log(2.0)) / (2.0 * math.pi * TAPS * dt)
        raise ValueRefused(f"cutoff_hz = {cutoff_hz!r} (repetitive): expected {math.ceil(least)} or more here")
    at = np.arange(-TAPS, TAPS + 1) - shift
    weights = np.exp(-0.5 * (at / width) ** 2)
    return weights / weights.sum()


@entry_point
def repetitive(
    inner: Block,
    period_s: float = 1.0 / 0.7,
    cutoff_hz: float = 30.0,
    lead_s: float = 2e-3,
    strength: float = 0.7,
    room: int = 4096,
    lower: float = -math.inf,
    upper: float = math.inf,
    name: str = "",
) -> Block:
    """The controller ``inner`` with repetitive control; its parameters are those of ``inner`` below ``inner.``.

    ``room``: samples in the memory; a period may have up to 40 less.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals; a room of
            less than 100.
    """
    part = wrapped(inner, "repetitive")
    if room < 100:
        raise BlockError(f"repetitive({inner.name}): room = {room!r}; expected 100 or more")
    law, before, place = part.law, inner.prepare, part.place
    align_law: Any = part.align
    own: list[Any] = [("period_s", PeriodS), ("cutoff_hz", CutoffHz), ("lead_s", LeadS), ("strength", Share),
                      ("lower", Lower), ("upper", Upper)]  # fmt: skip
    params_type = cast(Any, NamedTuple("RepetitiveParams", [("inner", type(inner.params)), *own]))
    fields: list[Any] = [("inner", type(inner.state)), ("memory", np.ndarray), ("at", int), ("added", float)]
    state_type = cast(Any, NamedTuple("RepetitiveState", fields))
    rest = state_type(inner.state, np.zeros(room), 0, 0.0)

    def prepare(params: Any, dt: float) -> Any:
        ordered(params, dt)
        ready = params.inner if before is None else before(params.inner, dt)
        plan: list[Any] = [("inner", type(ready)), ("taps", np.ndarray), ("back", int), ("strength", float),
                           ("lead", int), ("lower", float), ("upper", float), ("still", np.ndarray)]  # fmt: skip
        plan_type = cast(Any, NamedTuple("RepetitivePlan", plan))
        late = params.period_s / dt
        near = round(late)
        least = TAPS + 1 + round(params.lead_s / dt)
        if near < least or near + TAPS >= room:
            raise ValueRefused(
                f"period_s = {params.period_s!r} (repetitive): {near} samples, expected {least} to "
                f"{room - TAPS - 1}; a longer one needs more room"
            )
        taps = low_pass(params.cutoff_hz, dt, near - late)  # tap i is near + TAPS - i samples old
        return plan_type(
            ready, taps, near, params.strength, round(params.lead_s / dt), params.lower, params.upper, np.zeros(room)
        )

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        return state_type(align_law(params.inner, command, feedback, output), params.still, 0, 0.0)

    def remembering(p, s, command, feedback, dt):
        """The inner controller, its command corrected by what it did not manage a period ago."""
        n = s.memory.shape[0]
        first = s.at - p.back - (p.taps.shape[0] - 1) // 2
        start = first + n if first < 0 else first
        added = 0.0
        for i in range(p.taps.shape[0]):
            k = start + i
            added = added + p.taps[i] * s.memory[k - n if k >= n else k]
        error = place(command) - feedback
        after, u = law(p.inner, s.inner, command, feedback - added, dt)
        output = min(max(u, p.lower), p.upper)
        acts = u > p.lower and u < p.upper
        learned = error if acts else 0.0
        s.memory[s.at] = added if abs(added) > TINY else 0.0
        ahead = s.at - p.lead if s.at >= p.lead else s.at - p.lead + n
        s.memory[ahead] = s.memory[ahead] + p.strength * learned
        return state_type(after, s.memory, s.at + 1 if s.at + 1 < n else 0, added), output

    return same_kind(
        remembering, part, params_type(inner.params, period_s, cutoff_hz, lead_s, strength, lower, upper), rest,
        "A memory of one period corrects its command.", prepare=prepare, align=None if align_law is None else align,
        name=name or f"{inner.name}_repetitive",
    )  # fmt: skip


def contraction(
    inner: Block,
    w: Any,
    cutoff_hz: float,
    lead_s: float,
    strength: float,
    dt: float = 0.5e-3,
    *,
    model: PlantModel,
) -> np.ndarray:
    """By what the error at ``w`` (rad/s) shrinks from one period to the next: below one everywhere, and it converges.

    ``inner`` is the controller without memory, in the loop around ``model``.
    """
    part, w = wrapped(inner, "contraction"), np.asarray(w, dtype=float)
    loop = plant_response(model, dt, w) * law_response(part.law, part.ready(dt), inner.state, part.motion, dt, w)
    q = np.cos(np.outer(w * dt, np.arange(-TAPS, TAPS + 1))) @ low_pass(cutoff_hz, dt)
    return np.asarray(np.abs(q * (1.0 - strength * loop / (1.0 + loop) * np.exp(1j * w * dt * round(lead_s / dt)))))
