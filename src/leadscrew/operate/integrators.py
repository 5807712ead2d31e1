"""Integrators of a controller: each keeps its own share of the output when parameters change.

A changed integral gain multiplies what the integrator has gathered, and the output jumps by it. The integrator is
therefore multiplied by old slope over new slope, slope being d(output)/d(integrator); a change that leaves the slope as
it is, of a proportional gain, say, leaves the integrator alone: it would otherwise take up the momentary error, and a
slow one would not give it back for the rest of the run. Which numbers of the state are integrators is seen on the
machine as it stands: moved aside they stay aside, unmoved they move, and the output follows them in a straight line.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from leadscrew.kernel.layout import Leaf, is_branch, leaves
from leadscrew.kernel.live import Live
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.util.errors import ValueRefused

KEPT = 0.01
"""Share of what an integrator was moved aside that it may lose in a period."""
ALIKE = 1e-4
"""Relative difference within which two slopes are one."""
FAR = 10.0
"""How far, in sizes of the output, an integrator is moved to see that the output does not depend on it at all."""


@np.errstate(over="ignore", invalid="ignore")  # what overflows is no integrator
def touched(live: Live, part: Mapping[str, Any]) -> list[str]:
    """Integrators of the controller, by their keys, that this change would rescale."""
    saved = live.save()
    try:
        live.set_all(part)
        found = _integrators(live)
    finally:
        live.restore(saved)
    (scaled,) = factors(live, [part], found)
    return [key for key in found if abs(scaled.get(key, 1.0) - 1.0) > ALIKE]


@np.errstate(over="ignore", invalid="ignore")  # what overflows is no integrator
def factors(live: Live, steps: Sequence[Mapping[str, Any]], keys: Sequence[str]) -> list[dict[str, float]]:
    """By what each of these integrators is multiplied at each of the changes, which are made one after the other.

    One whose slope is lost on the way (an integral gain that becomes zero; an output at its limit now) is not in it:
    its share then changes with the parameters.

    Raises:
        ValueRefused: the controller's state has no such number.
    """
    if not keys:
        return [{} for _ in steps]
    held = {leaf.key: leaf for leaf in _numbers(live)}
    for key in keys:
        if key not in held:
            raise ValueRefused(f"by = {key!r}: the controller's state has no such number; it has {', '.join(held)}")
    saved = live.save()
    slopes = {key: [_slope(live, held[key])] for key in keys}
    try:
        for part in steps:
            live.set_all(part)
            for key, seen in slopes.items():
                seen.append(_slope(live, held[key]))
    finally:
        live.restore(saved)
    scaled = {k: s for k, s in slopes.items() if all(s[1:]) and np.isfinite(s).all()}
    scaled = {k: s for k, s in scaled.items() if s[0] != 0.0 or _unseen(live, held[k], s[-1])}
    return [{k: s[i] / s[i + 1] for k, s in scaled.items()} for i in range(len(steps))]


def scale(live: Live, by: Mapping[str, float]) -> None:
    """Multiplies integrators of the running machine."""
    for leaf in _numbers(live) if by else []:
        if leaf.key in by:
            live.state[0][leaf.at] *= by[leaf.key]


def _integrators(live: Live) -> list[str]:
    """The numbers of the controller's state that integrate now, by their keys."""
    if is_branch(live.loop.signals["output"]):
        return []
    unmoved, output = _period(live)
    found = []
    for leaf in _numbers(live):
        first = float(live.state[0][leaf.at])
        aside = _aside(first)
        after, other = _period(live, leaf, first + aside)
        stays = abs(after[leaf.at] - unmoved[leaf.at] - aside) <= KEPT * aside
        if stays and unmoved[leaf.at] != first and other != output and math.isfinite(other):
            slope = (other - output) / aside
            half = (output - _period(live, leaf, 0.5 * first)[1]) / (0.5 * first) if first else slope
            if abs(half - slope) <= ALIKE * abs(slope):
                found.append(leaf.key)
    return found


def _numbers(live: Live) -> list[Leaf]:
    """The floats of the controller's state."""
    block = live.loop.blocks["controller"]
    if block is None or block.state is None:
        return []
    return [leaf for leaf in leaves(live.program.plan.state.part("controller")) if leaf.kind == "float"]


def _aside(first: float) -> float:
    return 1e-3 * max(abs(first), 1e-3)


def _slope(live: Live, leaf: Leaf) -> float:
    """d(output)/d(number of the state) at the next period."""
    first = float(live.state[0][leaf.at])
    aside = first + _aside(first)
    return (_period(live, leaf, aside)[1] - _period(live)[1]) / (aside - first)


def _unseen(live: Live, leaf: Leaf, slope: float) -> bool:
    """Whether the output does not depend on the number at all: it is no limit that hides it; ``slope``: then to be."""
    first, output = float(live.state[0][leaf.at]), _period(live)[1]
    far = FAR * (1.0 + abs(output)) / abs(slope)
    return all(_period(live, leaf, first + x)[1] == output for x in (-far, far))


def _period(live: Live, leaf: Leaf | None = None, value: float = 0.0) -> tuple[np.ndarray, float]:
    """State after the next period and its output, with a number of the state moved; the machine stays where it is."""
    saved = live.save()
    if leaf is not None:
        live.state[0][leaf.at] = value
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DivergenceWarning)
        output = live.advance(1, record=("output",)).signals["output"]
    after = live.state[0].copy()
    live.restore(saved)
    return after, float(output[-1]) if len(output) else math.nan


__all__ = ["factors", "scale", "touched"]
