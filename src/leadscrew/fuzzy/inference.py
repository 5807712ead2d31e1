"""Two-input inference by its active rules: product, triangular partitions of unity, height defuzzification.

    output = sum_ij t_ij mu_i(x) nu_j(y) / sum_ij mu_i(x) nu_j(y)

The denominator is one, and of all the rules only the four around the point fire: the sum is the bilinear
interpolation of the table ``t`` between the centres. It is exact for any number of sets and any spacing.

The active-rules path: where every input is a triangular partition of unity, every combination of sets has its rule,
``and`` is the product and the output is the mean of the rules' values, the output is the multilinear interpolation of
the table of those values, and only the rules around the point have to be looked at.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.fuzzy.circuit import Circuit
from leadscrew.fuzzy.system import And, Antecedent, Is, Output
from leadscrew.kernel.parameters import Doc
from leadscrew.util.errors import ValueRefused


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


MOST = 3
"""Inputs up to which the path is taken: the points around grow as powers of two."""


# ---- steps
def linear(first, table, x):
    """One input: between two values."""
    inside = inside_universe(first, x)
    i = interval_index(first, inside)
    mu = upper_membership(first, i, inside)
    return (1.0 - mu) * table[i] + mu * table[i + 1]


def bilinear(rules, x, y):
    """Two inputs."""
    return infer(rules, x, y)


def trilinear(first, second, third, table, x, y, z):
    """Three inputs; the rows of the table run over the first two, the second one faster."""
    a, b, c = inside_universe(first, x), inside_universe(second, y), inside_universe(third, z)
    i, j, k = interval_index(first, a), interval_index(second, b), interval_index(third, c)
    mu, nu, xi = upper_membership(first, i, a), upper_membership(second, j, b), upper_membership(third, k, c)
    wide = second.centres.shape[0]
    row = i * wide + j
    far = row + wide
    near_low = (1.0 - xi) * table[row, k] + xi * table[row, k + 1]
    near_high = (1.0 - xi) * table[row + 1, k] + xi * table[row + 1, k + 1]
    far_low = (1.0 - xi) * table[far, k] + xi * table[far, k + 1]
    far_high = (1.0 - xi) * table[far + 1, k] + xi * table[far + 1, k + 1]
    return (1.0 - mu) * ((1.0 - nu) * near_low + nu * near_high) + mu * ((1.0 - nu) * far_low + nu * far_high)


# ---- recognition
def _anded(node: Antecedent) -> Iterator[Is | None]:
    """The propositions of an antecedent that is all ``and``; ``None`` where it is not."""
    if isinstance(node, Is):
        yield node
    elif isinstance(node, And):
        yield from _anded(node.left)
        yield from _anded(node.right)
    else:
        yield None


def consequents(made: Circuit, output: Output) -> dict[tuple[str, ...], str] | None:
    """The term of every combination of the inputs' terms, where an output's rules have the form of a table."""
    system = made.system
    names = [v.name for v in system.inputs]
    blocks = {f.block for f in made.firings}
    if len(blocks) != 1 or len(names) > MOST or not all(v.enabled and v.terms for v in system.inputs):
        return None
    block = system.blocks[blocks.pop()]
    if block.activation != "general" or block.conjunction != "algebraic_product":
        return None
    found: dict[tuple[str, ...], str] = {}
    for share in made.shares[output.name]:
        asked = list(_anded(made.firings[share.firing].rule.antecedent))
        sets = {there.variable: there for there in asked if there is not None}
        if share.hedges or len(asked) != len(names) or set(sets) != set(names):
            return None
        key = tuple(sets[n].term for n in names)
        if key in found or any(there.hedges for there in sets.values()):
            return None
        found[key] = share.term
    whole = set(itertools.product(*([t.name for t in v.terms] for v in system.inputs)))
    return found if whole == set(found) else None


def is_table(made: Circuit, output: Output) -> bool:
    """Whether an output is the mean of constants over a full table of rules."""
    plain = ("constant", "singleton")
    if output.defuzzifier == "height":
        fits = all(t.shape != "linear" for t in output.terms)
    else:
        fits = output.defuzzifier == "weighted_average" and all(t.shape in plain for t in output.terms)
    return fits and consequents(made, output) is not None


def table(made: Circuit, output: Output, values: dict[str, float]) -> np.ndarray:
    """The values of all combinations, of one or two dimensions."""
    found = consequents(made, output)
    assert found is not None
    names = [[t.name for t in v.terms] for v in made.system.inputs]
    flat = np.array([values[found[key]] for key in itertools.product(*names)])
    return flat if len(names) == 1 else flat.reshape(-1, len(names[-1]))


def axis_numbers(sides: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres of a partition, one over its widths, and its outer feet (NaN where there is a shoulder)."""
    centres = np.array([*sides[0][1:-1], sides[2][-2]])
    feet = [sides[0][0] if np.isfinite(sides[0][0]) else np.nan, sides[2][-1] if np.isfinite(sides[0][-1]) else np.nan]
    return centres, 1.0 / np.diff(centres), np.array(feet)


def is_pointed(sides: np.ndarray) -> bool:
    """Whether a partition has peaks, not plateaus, at its ends (a shoulder counts as a peak)."""
    left = np.isinf(sides[0][0]) or sides[2][0] == sides[0][1]
    right = np.isinf(sides[0][-1]) or sides[0][-1] == sides[2][-2]
    return bool(left and right)
