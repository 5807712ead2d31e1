"""Two-input inference by its active rules: product, triangular partitions of unity, height defuzzification.

    output = sum_ij t_ij mu_i(x) nu_j(y) / sum_ij mu_i(x) nu_j(y)

The denominator is one, and of all the rules only the four around the point fire: the sum is the bilinear
interpolation of the table ``t`` between the centres. It is exact for any number of sets and any spacing.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.sheet import Doc


class Axis(NamedTuple):
    """One input of a rule base, as a step reads it."""

    centres: Annotated[np.ndarray, Doc("peaks of the sets, increasing")]
    reciprocal_widths: Annotated[np.ndarray, Doc("one over the distance to the next centre")]


def axis(centres) -> Axis:
    """The partition with these centres, ready for a step.

    Raises:
        ValueRefused: fewer than two centres, or centres that do not increase.
    """
    c = np.array(centres, dtype=float)
    if c.ndim != 1 or c.size < 2:
        raise ValueRefused(f"centres = {c.tolist()}: a partition needs at least two centres in one row")
    width = np.diff(c)
    if not (np.isfinite(c).all() and (width > 0.0).all()):
        raise ValueRefused(f"centres = {c.tolist()}: centres must be finite and strictly increasing")
    return Axis(c, 1.0 / width)


def inside_universe(axis, x):
    """``x`` held between the first and the last centre."""
    return min(max(x, axis.centres[0]), axis.centres[axis.centres.shape[0] - 1])


def interval_index(axis, x):
    """Number of the interval that holds ``x``, from 0: how many inner centres lie at or below it."""
    index = 0
    for i in range(1, axis.centres.shape[0] - 1):
        index = index + (1 if x >= axis.centres[i] else 0)
    return index


def upper_membership(axis, index, x):
    """Membership of ``x`` in the upper set of its interval; the lower set has the rest to one."""
    return (x - axis.centres[index]) * axis.reciprocal_widths[index]


class RuleBase(NamedTuple):
    """A two-input rule base, as a step reads it."""

    first: Axis
    second: Axis
    table: Annotated[np.ndarray, Doc("consequents: rows by the first input's sets, columns by the second's")]


def rule_base(first_centres, second_centres, table) -> RuleBase:
    """The rule base with these centres and consequents, ready for :func:`infer`.

    Raises:
        ValueRefused: centres that are no partition, or a table of another shape.
    """
    first, second, t = axis(first_centres), axis(second_centres), np.array(table, dtype=float)
    if t.shape != (len(first.centres), len(second.centres)):
        raise ValueRefused(
            f"a table of shape {t.shape} does not fit {len(first.centres)} by {len(second.centres)} sets"
        )
    return RuleBase(first, second, t)


def infer(rules, x, y):
    """Output of the rule base at ``(x, y)``, each held inside its universe."""
    x_inside = inside_universe(rules.first, x)
    y_inside = inside_universe(rules.second, y)
    i = interval_index(rules.first, x_inside)
    j = interval_index(rules.second, y_inside)
    mu = upper_membership(rules.first, i, x_inside)
    nu = upper_membership(rules.second, j, y_inside)
    lower = (1.0 - nu) * rules.table[i, j] + nu * rules.table[i, j + 1]
    upper = (1.0 - nu) * rules.table[i + 1, j] + nu * rules.table[i + 1, j + 1]
    return (1.0 - mu) * lower + mu * upper
