"""Resonators: any linear controller, with one pole pair on the unit circle for each line of a known frequency.

    u   = inner(r, y) + sum over the lines of Re z
    z  <- e^(j w T) z + g T e^(j p) e                     e = command - feedback,  w = 2 pi f

Line by line that is ``v_k = 2 cos(w T) v_(k-1) - v_(k-2) + g T (cos p e_k - cos(w T - p) e_(k-1))``, ``v = Re z``: the
impulse response is ``g T cos(k w T + p)``. Kept as a rotation its frequency does not hang on the last
digits of ``2 cos(0.002)``. A line of the error at ``f`` makes ``z`` grow until the line is gone: the internal model
principle (B. A. Francis, W. M. Wonham, *The internal model principle of control theory*, Automatica 12, 1976).

**Phase and gain follow from the loop.** A voltage at the plant input moves the error by ``-H``, with
``H = P / (1 + P C)``, ``P`` the believed table (``model``), ``C`` the inner controller. With

    p = -arg H(w),      g = strength / |H(w)|

each line decays as ``exp(-strength t / 2)`` while the strength is small against ``w`` and the distance between lines:
``strength = 1`` is a time constant of 2 s. The stability margins change only inside such a narrow band around each
line. ``H`` is worked out in ``prepare``, for the period at hand and by trying the inner controller's own step.

The lines: ``frequencies_hz``; and, with ``spindle_hz > 0``, one at the spindle's speed and, with two teeth or more, one
at ``teeth`` times it. A line above half the sampling frequency is refused. Frequencies have to be right: a line that is
off by ``d`` rad/s keeps the share ``|d| / sqrt(d^2 + (strength/2)^2)`` of itself. Where they are not known:
:obj:`leadscrew.controllers.adaptive_resonant`.

``lower`` and ``upper`` limit the sum; at the limit the resonators turn but do not grow. It belongs on the outermost
block: of a limit inside, the resonators know nothing. Bumpless start as the inner controller's, with resonators at
rest.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from leadscrew.controllers._parallel import Lower, Upper, ordered
from leadscrew.controllers._response import PlantModel, law_response, plant_response
from leadscrew.controllers._wrapping import Inner, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused, entry_point

TINY = 1e-30
"""Below this a resonator is remembered as 0."""
ODD_HZ = (0.7, 2.1, 3.5, 4.9, 6.3, 7.7)
"""The motion of 0.7 Hz and the odd harmonics of Table II."""

Frequencies = Annotated[np.ndarray, Unit("Hz"), Doc("frequencies of the lines, in a row")]
Strength = Annotated[float, Unit("1/s"), Gt(0), Le(100), Doc("lines decay at half this rate")]
SpindleHz = Annotated[float, Unit("Hz"), Ge(0), Le(1e5), Doc("revolutions a second; 0: no spindle lines")]
Teeth = Annotated[int, Ge(1), Le(100), Doc("teeth of the cutter: the second spindle line is at teeth x spindle_hz")]


class Resonators(NamedTuple):
    """What every line's resonator is at this period."""

    turn_re: np.ndarray
    turn_im: np.ndarray
    in_re: np.ndarray
    in_im: np.ndarray


def checked(frequencies: Any) -> np.ndarray:
    """The frequencies as a row of numbers.

    Raises:
        ValueRefused: none, not in a row, one that is not a positive number, or one twice: its line would have twice the
            strength.
    """
    values = np.array(frequencies, dtype=np.float64)
    if values.ndim != 1 or values.size < 1 or not np.isfinite(values).all() or values.min() <= 0.0:
        raise ValueRefused(f"frequencies_hz = {frequencies!r} (resonant): expected positive numbers in one row")
    if len(np.unique(values)) < values.size:
        raise ValueRefused(f"frequencies_hz = {frequencies!r} (resonant): expected each frequency once")
    return values


def disturbance_response(part: Inner, params: Any, model: PlantModel, dt: float, w: Any) -> np.ndarray:
    """``H = P / (1 + P C)`` at ``w`` (rad/s), mm/V: believed table, and the controller with its prepared ``params``."""
    p = plant_response(model, dt, w)
    return np.asarray(p / (1.0 + p * law_response(part.law, params, part.block.state, part.motion, dt, w)))


def resonators(part: Inner, ready: Any, params: Any, dt: float) -> Resonators:
    """The resonators of all lines, spindle's last.

    Raises:
        ValueRefused: a line at or above half the sampling frequency.
    """
    spindle = np.array([1.0, float(params.teeth) if params.teeth > 1 else 0.0]) * params.spindle_hz
    f = np.concatenate([checked(params.frequencies_hz), spindle])
    if f.max() >= 0.5 / dt:
        raise ValueRefused(
            f"a resonator at {f.max():g} Hz (resonant): lines have to lie below half the sampling frequency, here "
            f"{0.5 / dt:g} Hz"
        )
    w = 2.0 * math.pi * np.maximum(f, 1e-3)
    h = disturbance_response(part, ready, params.model, dt, w)
    turn = np.exp(1j * w * dt)
    enter = np.where(f > 0.0, params.strength * dt * np.conj(h) / np.abs(h) ** 2, 0.0)
    return Resonators(*(np.ascontiguousarray(x) for x in (turn.real, turn.imag, enter.real, enter.imag)))


@entry_point
def resonant(
    inner: Block,
    frequencies_hz: Any = ODD_HZ,
    strength: float = 1.0,
    spindle_hz: float = 0.0,
    teeth: int = 2,
    *,
    model: PlantModel,
    lower: float = -math.inf,
    upper: float = math.inf,
    name: str = "",
) -> Block:
    """The controller ``inner`` with resonators; its parameters are those of ``inner`` below ``inner.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
        ValueRefused: frequencies that are not a row of positive numbers, each once.
    """
    part = wrapped(inner, "resonant")
    law, before, place = part.law, inner.prepare, part.place
    align_law: Any = part.align
    own: list[Any] = [("frequencies_hz", Frequencies), ("strength", Strength), ("spindle_hz", SpindleHz),
                      ("teeth", Teeth), ("model", PlantModel), ("lower", Lower), ("upper", Upper)]  # fmt: skip
    params_type = cast(Any, NamedTuple("ResonantParams", [("inner", type(inner.params)), *own]))
    fields: list[Any] = [("inner", type(inner.state)), ("re", np.ndarray), ("im", np.ndarray), ("aligned", float)]
    state_type = cast(Any, NamedTuple("ResonantState", fields))
    lines = checked(frequencies_hz)
    rest = state_type(inner.state, np.zeros(lines.size + 2), np.zeros(lines.size + 2), 0.0)

    def prepare(params: Any, dt: float) -> Any:
        ordered(params, dt)
        ready = params.inner if before is None else before(params.inner, dt)
        plan: list[Any] = [("inner", type(ready)), ("lines", Resonators), ("lower", float), ("upper", float),
                           ("still_re", np.ndarray), ("still_im", np.ndarray)]  # fmt: skip
        plan_type = cast(Any, NamedTuple("ResonantPlan", plan))
        lines = resonators(part, ready, params, dt)
        return plan_type(
            ready, lines, params.lower, params.upper, np.zeros(len(lines.in_re)), np.zeros(len(lines.in_re))
        )

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        after = align_law(params.inner, command, feedback, output)
        return state_type(after, params.still_re, params.still_im, 1.0)

    def with_resonators(p, s, command, feedback, dt):
        """The inner controller and its resonators."""
        error = (1.0 - s.aligned) * (place(command) - feedback)
        after, u = law(p.inner, s.inner, command, feedback, dt)
        total = u
        for i in range(s.re.shape[0]):
            total = total + p.lines.turn_re[i] * s.re[i] - p.lines.turn_im[i] * s.im[i] + p.lines.in_re[i] * error
        output = min(max(total, p.lower), p.upper)
        grown = error if total == output else 0.0
        for i in range(s.re.shape[0]):
            re = p.lines.turn_re[i] * s.re[i] - p.lines.turn_im[i] * s.im[i] + p.lines.in_re[i] * grown
            im = p.lines.turn_im[i] * s.re[i] + p.lines.turn_re[i] * s.im[i] + p.lines.in_im[i] * grown
            s.re[i] = re if abs(re) > TINY else 0.0
            s.im[i] = im if abs(im) > TINY else 0.0
        return state_type(after, s.re, s.im, 0.0), output

    return same_kind(
        with_resonators, part,
        params_type(inner.params, lines, strength, spindle_hz, teeth, model, lower, upper), rest,
        "Resonators are added.", prepare=prepare, align=None if align_law is None else align,
        name=name or f"{inner.name}_resonant",
    )  # fmt: skip
