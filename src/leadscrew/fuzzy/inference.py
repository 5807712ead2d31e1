"""Two-input inference by its active rules: product, triangular partitions of unity, height defuzzification.

    output = sum_ij t_ij mu_i(x) nu_j(y) / sum_ij mu_i(x) nu_j(y)

The denominator is one, and of all the rules only the four around the point fire: the sum is the bilinear
interpolation of the table ``t`` between the centres. It is exact for any number of sets and any spacing.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.fuzzy.partition import Axis, axis, inside_universe, interval_index, upper_membership
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.sheet import Doc


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
