"""Where a set lives: the universe of a variable that a file gives none."""

from __future__ import annotations

import math

from leadscrew.fuzzy.system import Term

Ends = tuple[float, float]


def extent(term: Term, inputs: list[Ends] | None = None) -> Ends:
    """The ends between which a set changes (a gaussian: 4 deviations, a sigmoid: 9 over its slope); of a linear
    consequent, the ends of its values over the universes of the inputs.
    """
    p = term.parameters
    if term.shape == "discrete":
        return p[0], p[-2]
    if term.shape == "gaussian":
        return p[0] - 4.0 * abs(p[1]), p[0] + 4.0 * abs(p[1])
    if term.shape == "gaussian_product":
        return p[0] - 4.0 * abs(p[1]), p[2] + 4.0 * abs(p[3])
    if term.shape in ("cosine", "spike"):
        return p[0] - 0.5 * abs(p[1]), p[0] + 0.5 * abs(p[1])
    if term.shape == "bell":
        return p[0] - 4.0 * abs(p[1]), p[0] + 4.0 * abs(p[1])
    if term.shape == "sigmoid":
        width = 9.0 / abs(p[1]) if p[1] else 1.0
        return p[0] - width, p[0] + width
    if term.shape.startswith("sigmoid"):
        return min(p[0], p[3]), max(p[0], p[3])
    if term.shape == "binary":
        return p[0], p[0]
    if term.shape == "linear":
        low = high = p[-1]
        for slope, (a, b) in zip(p, inputs or [], strict=False):
            if slope:
                low, high = low + min(slope * a, slope * b), high + max(slope * a, slope * b)
        return low, high
    return min(p), max(p)


def hull(ends: list[Ends]) -> Ends:
    """The smallest universe with all of these ends that are finite; one of width 1 where they are one point."""
    finite = [x for pair in ends for x in pair if math.isfinite(x)]
    if not finite:
        return -math.inf, math.inf
    low, high = min(finite), max(finite)
    wide = 0.5 * max(1.0, abs(low) * 1e-9)
    return (low, high) if low < high else (low - wide, high + wide)
