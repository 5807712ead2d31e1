"""What a change of parameters did, and how the controller's output is kept from jumping.

The controller's numbers go to their new values in :data:`STEPS` equal steps at most over :data:`RAMP_S`, and at every
step each integrator is rescaled so that its own share of the output stays (:mod:`~leadscrew.operate.integrators`). One
rule for all gains, and not a jump for the integral gain with a ramp for the rest: in a controller of the standard form,
``kp (e + 1/Ti sum e dt)``, one gain scales both the integrator and the momentary error. What cannot be moved gradually
(whole numbers, switches, tables) and what is not the controller's changes at once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from leadscrew.kernel.layout import numbers_of
from leadscrew.operate import integrators
from leadscrew.operate.axes import Axes, Later
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.live import Live

RAMP_S = 0.1
"""How long the controller's numbers take to their new values."""
STEPS = 20
"""Steps of a ramp at most: each prepares the loop's parameters anew."""
BETWEEN = ", "
"""Between several integrators in ``by``."""

Part = Mapping[str, Any]
Parts = list[dict[str, Any]]


@dataclass(frozen=True)
class Change:
    """What was done, and the controller's output around it."""

    period: int
    """Periods that were done when it took effect."""
    old: dict[str, Any]
    new: dict[str, Any]
    """Values by dotted key; of a switch also ``controller`` with both names."""
    how: str
    before: float | None
    """The output that the next period would have had."""
    after: float | None
    """The output that the next period has."""


class Way(NamedTuple):
    """How a change is made."""

    how: str = "at once"
    over: int = 0
    """Periods of a ramp."""
    by: str = ""
    """Integrators that are rescaled on the way, by their keys."""


AT_ONCE = Way()


def decide(axes: Axes, parts: Parts) -> Way:
    """The way to make a change by hand; nothing is changed yet.

    Raises:
        NameUnknown, ValueRefused: the change cannot be made at all.
    """
    axes.moved(parts)
    if not any(own(part) for part in parts):
        return AT_ONCE
    over = max(1, round(RAMP_S / axes.period_s))
    gradual = over > 1 and any(_gradual(live, part) for live, part in zip(axes.lives, parts, strict=True))
    found = [integrators.touched(live, part) for live, part in zip(axes.lives, parts, strict=True)]
    by = BETWEEN.join(dict.fromkeys(key for keys in found for key in keys))
    return Way("ramped", over, by) if gradual else Way("at once", 0, by)


def make(axes: Axes, parts: Parts, way: Way) -> None:
    """Makes a change in the way that was decided; nothing is changed where it is refused.

    Raises:
        NameUnknown, ValueRefused: it cannot be made, or not in this way.
    """
    if way.how not in ("ramped", "at once"):
        raise ValueRefused(f"how = {way.how!r}: values are set 'ramped' or 'at once'")
    axes.moved(parts)
    steps = _steps(axes, parts, way.over if way.how == "ramped" else 0)
    keys = way.by.split(BETWEEN) if way.by else []
    scaled = [integrators.factors(live, [p[i] for _, p in steps], keys) for i, live in enumerate(axes.lives)]
    axes.forget(parts)
    for i, (period, now) in enumerate(steps):
        axes.later(Later(period, now, scaled=tuple(f[i] for f in scaled)))
    axes.due()


def output(axes: Axes) -> float:
    """The first output that the next period would have."""
    return next(iter(numbers_of(axes.lives[0].advance_preview()["output"])))


def own(part: Part) -> dict[str, Any]:
    """What of a change is the controller's."""
    return {k: v for k, v in part.items() if k.startswith("controller.")}


def others(part: Part) -> dict[str, Any]:
    """What of a change is not the controller's."""
    return {k: v for k, v in part.items() if not k.startswith("controller.")}


def _gradual(live: Live, part: Part) -> dict[str, tuple[float, float]]:
    """The controller's numbers that can move gradually, from and to."""
    sheet = live.loop.sheet
    found = {k: (sheet[k].default, float(v)) for k, v in own(part).items() if sheet[k].type == "float"}
    return {k: (a, b) for k, (a, b) in found.items() if a != b and math.isfinite(a) and math.isfinite(b)}


def _steps(axes: Axes, parts: Parts, over: int) -> list[tuple[int, tuple[dict[str, Any], ...]]]:
    """The changes of each axis by their periods: all at once if ``over`` is 0, else with the first all not gradual."""
    if over == 0:
        return [(axes.period, tuple(map(dict, parts)))]
    moving = [_gradual(live, part) for live, part in zip(axes.lives, parts, strict=True)]
    n = max(1, min(STEPS, over))

    def step(i: int) -> tuple[dict[str, Any], ...]:
        return tuple({k: b if i == n else a + (b - a) * (i / n) for k, (a, b) in m.items()} for m in moving)

    first = tuple({**part, **values} for part, values in zip(parts, step(1), strict=True))
    return [(axes.period, first), *((axes.period + (i - 1) * over // n, step(i)) for i in range(2, n + 1))]


__all__ = ["AT_ONCE", "RAMP_S", "STEPS", "Change", "Way", "decide", "make", "others", "output", "own"]
