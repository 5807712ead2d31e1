"""The worst switching of a gain between two values: how a gain that varies in time breaks a sampled loop.

    K(t) = low for n1 periods, high for n2 periods, and so on:   unstable where max abs(eig(A_high^n2 A_low^n1)) > 1

``A_k`` is the loop closed with the gain ``k`` over one period (the lifted model). It proves *instability*: no criterion
that allows a gain to vary in time can prove a sector that holds both. What it does not find may still be unstable under
another pattern: only two intervals of fewer than ``longest`` periods each are tried.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.util.errors import ValueRefused

STEPS = 24
HALVINGS = 30


@dataclass(frozen=True)
class Switching:
    """The least upper gain for which some pattern is unstable, and that pattern."""

    low: float
    high: float
    """Least upper gain with an unstable pattern; infinite where none was found."""
    periods_low: int
    periods_high: int
    radius: float
    """Largest eigenvalue of the pattern at ``high``, just above 1."""
    longest: int

    @property
    def statement(self) -> str:
        """What was found, in a sentence."""
        if math.isinf(self.high):
            return f"No unstable pattern of two intervals of fewer than {self.longest} periods was found."
        return (
            f"A gain that stays {self.periods_low} periods at {self.low:g} and {self.periods_high} at {self.high:.4g}, "
            "again and again, makes the loop unstable; no criterion for gains that vary in time can prove that sector."
        )


def pattern_radius(loop: LinearLoop, low: float, high: float, longest: int = 40) -> tuple[float, int, int]:
    """The largest eigenvalue of all patterns of two intervals, per pattern, with the periods at ``low`` and ``high``.

    Raises:
        ValueRefused: a continuous loop.
    """
    if not loop.sampled:
        raise ValueRefused(f"switching: the loop {loop.name!r} is continuous; the lifted model needs a sampled one")
    powers = []
    for gain in (low, high):
        one = loop.a - gain / (1.0 + gain * float(loop.d[0, 0])) * loop.b @ loop.c
        row = [one]
        for _ in range(longest - 2):
            row.append(one @ row[-1])
        powers.append(np.array(row))
    both = powers[1][None, :] @ powers[0][:, None]
    sizes = np.abs(np.linalg.eigvals(both)).max(axis=-1)
    i, j = np.unravel_index(int(np.argmax(sizes)), sizes.shape)
    return float(sizes[i, j]), int(i) + 1, int(j) + 1


def worst_switching(loop: LinearLoop, low: float = 1.0, longest: int = 40) -> Switching:
    """The least upper gain at which switching between ``low`` and it can be unstable.

    Searched from what the circle criterion proves up to the Nyquist limit, where a constant gain does.

    Raises:
        ValueRefused: a continuous loop; one that is unstable at ``low``; fewer than 2 periods.
    """
    if longest < 3:
        raise ValueRefused(f"switching: longest = {longest!r} periods; allowed from 3")
    proved = ask("circle", loop, low)
    if proved.limit is None:
        raise ValueRefused(f"switching: {proved.statement}")
    if math.isinf(proved.limit):
        return Switching(low, math.inf, 0, 0, 0.0, longest)
    top = min(loop.gain_limit(low), 1e3 * proved.limit)
    tried = np.linspace(proved.limit, top, STEPS)
    last = float(tried[0])
    for k in tried[1:]:
        if pattern_radius(loop, low, float(k), longest)[0] > 1.0:
            break
        last = float(k)
    else:
        return Switching(low, math.inf, 0, 0, 0.0, longest)
    high = float(k)
    for _ in range(HALVINGS):
        middle = 0.5 * (last + high)
        if pattern_radius(loop, low, middle, longest)[0] > 1.0:
            high = middle
        else:
            last = middle
        if high - last < 1e-6 * high:
            break
    radius, n1, n2 = pattern_radius(loop, low, high, longest)
    return Switching(low, high, n1, n2, radius, longest)
