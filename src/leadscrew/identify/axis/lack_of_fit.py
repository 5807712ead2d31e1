"""Whether the form of friction fits: what inverse dynamics leaves of the force, by speed and direction.

The residuals of the training part are gathered in bins of speed. Each passage through a bin counts as one observation,
its mean; where the form is right these scatter around 0, and

    t = mean / (s / sqrt(n))        n passages with the standard deviation s

is Student's. A bin in which ``t`` is beyond what all bins together let expect by chance once in a thousand logs, and
whose mean is more than :data:`OF_FRICTION` of the friction there, is friction that the model has no term for. No
interval of a parameter knows of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from leadscrew.identify.axis.inverse_dynamics import stretches
from leadscrew.identify.axis.judge import force_left, speed_of
from leadscrew.identify.axis.record import Record

EDGES = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
"""Of the bins, as shares of the top speed."""
CHANCE = 1e-3
OF_FRICTION = 0.05
LEAST = 5
"""Passages through a bin that are judged at least."""


class Bin(NamedTuple):
    """Force that the model lacks in a range of speeds, one direction."""

    way: int
    """1 forwards, -1 backwards."""
    slow: float
    fast: float
    mean: float
    """Against the motion: above 0 the axis resists more than the model."""
    error: float
    """Standard error of the mean."""
    passages: int
    lacks: bool


def bins(record: Record, values: Mapping[str, float], length: int, delay: float) -> list[Bin]:
    """All bins with passages enough; ``delay`` in periods."""
    from scipy.stats import t

    left, _ = force_left(record, values, length, delay)
    speed, known = speed_of(record), np.isfinite(left)
    if not known.any():
        return []
    top, found = float(np.max(np.abs(speed[known]))), []
    for way in (1, -1):
        side = "forward" if way > 0 else "backward"
        for low, high in pairwise(EDGES):
            inside = known & (way * speed > low * top) & (way * speed <= high * top)
            means = np.array([way * np.mean(left[a:b]) for a, b in stretches(inside)])
            if len(means) < LEAST:
                continue
            mean, error = float(np.mean(means)), float(np.std(means, ddof=1) / np.sqrt(len(means)))
            friction = values[f"friction.{side}.coulomb"] + values.get(f"friction.{side}.viscous", 0.0) * low * top
            sure = t.isf(0.5 * CHANCE / (2 * (len(EDGES) - 1)), len(means) - 1)
            lacks = abs(mean) > max(float(sure) * error, OF_FRICTION * friction)
            found.append(Bin(way, low * top, high * top, mean, error, len(means), lacks))
    return found


def sentence(found: list[Bin], position_unit: str, force_unit: str) -> str:
    """What the model lacks most in each direction, or nothing."""
    parts = []
    for way, word in ((1, "forwards"), (-1, "backwards")):
        worst = max((b for b in found if b.way == way and b.lacks), key=lambda b: abs(b.mean), default=None)
        if worst is not None:
            more = "more" if worst.mean > 0.0 else "less"
            parts.append(
                f"{word} from {worst.slow:.3g} to {worst.fast:.3g} {position_unit}/s the axis resists by "
                f"{abs(worst.mean):.2g} {force_unit} {more} than the model ({worst.passages} passages, standard error "
                f"{worst.error:.2g})"
            )
    if not parts:
        return ""
    return (
        f"The form of friction does not fit: {' and '.join(parts)}. The intervals are those of this form; "
        "friction, and a delay, may be off by more."
    )
