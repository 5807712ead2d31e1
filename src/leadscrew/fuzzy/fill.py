"""Rules for the cells that no sample covers, by steps that are named, optional and say what they filled.

Nothing here is data. Every step takes the table as the steps before left it and adds to it; what data says is never
changed by ``antisymmetric``, ``monotone`` and ``nearest``, and where data contradicts a step it is said.

``antisymmetric``
    the machine is the same in both directions: ``f(-x) = -f(x)``. A cell whose mirror has a rule gets the mirror of it.
    The centres of all variables must lie symmetrically about zero.
``monotone``
    the output rises (1) or falls (-1) with the inputs that ``directions`` names. With the nearest monotone values ``g``
    of the cells that have a rule (below, weighted by their samples), a cell gets the set nearest to the middle between
    the largest ``g`` before it and the smallest ``g`` after it; where there is nothing on one side, the extreme of all
    ``g`` stands in. A cell that no rule comes before or after stays empty.
``nearest``
    a copy of the nearest cell that has a rule, by the distance of the centres with every universe scaled to 1; of
    several equally near the one whose output lies nearest to the middle of its universe, then the first.
``servo``, ``servo_growth``
    the lathe study's procedure for two inputs (below), without and with its piece of prior knowledge. It alone may
    overrule cells that data covers; these are in ``changed``.

A full rule table from a few learned rules: symmetry, monotonicity and one piece of prior knowledge.

This is a step of its own, named so that nobody mistakes what it adds for data. For a servo axis the output falls
with the error and with its rate, and the machine is the same in both directions. With ``n`` sets (even) on each of
the two inputs and on the output:

1. fold: rule ``(i, j) -> k`` and its mirror ``(n-1-i, n-1-j) -> n-1-k`` are one rule of the half with negative
   error; where the two disagree the stronger stays;
2. of two seeds that break monotonicity, drop the one with fewer samples;
3. minimal monotone completion: a cell gets the largest output asked for by a seed at an equal or larger error and
   rate, and at least the smallest positive one;
4. (prior knowledge, not data) where the error is negative and still growing, one level more, up to the largest;
5. mirror to the half with positive error.

This step is ``servo``.

The monotone values nearest to given ones, on points of any number of dimensions.

    minimise  sum_i w_i (f_i - y_i)^2   subject to   f_i <= f_j  wherever  p_i comes before p_j

``p_i`` comes before ``p_j`` where it does so or is equal in every rising coordinate, the other way round in every
falling one, and equal in every other (:func:`before`). With one row of ``A`` for every neighbouring pair of that order,
``(A f)_k = f_j - f_i >= 0``, the solution is ``f = y + A' lambda / w`` with the ``lambda >= 0`` of least
``|A' lambda / sqrt(w) + sqrt(w) y|``: a non-negative least-squares problem, solved exactly by its active set.

Source: R. E. Barlow et al., Statistical Inference under Order Restrictions, 1972; C. L. Lawson, R. J. Hanson, Solving
Least Squares Problems, 1974, chapter 23.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.fuzzy.learning import LearnedRules
from leadscrew.fuzzy.partition import Partition
from leadscrew.kernel.parameters import nearest as nearest_name
from leadscrew.util.errors import NameUnknown, ValueRefused


@dataclass(frozen=True)
class Seed:
    """A folded rule: output level 1, 2, ... (small, medium, ...), its samples and its strength."""

    level: int
    count: int
    strength: float


@dataclass(frozen=True)
class Completion:
    """A full table, and how each step got there."""

    levels: np.ndarray
    """Signed output levels: -n/2 ... -1, 1 ... n/2; rows by the error's sets, columns by the rate's."""
    seeds: dict[tuple[int, int], Seed]
    """The folded rules that the table keeps."""
    dropped: dict[tuple[int, int], Seed]
    """The folded rules that broke monotonicity and had the fewer samples."""
    growth_level_added: bool
    """Whether step 4 was taken."""

    def table(self, magnitudes) -> np.ndarray:
        """Consequents, with ``magnitudes[level - 1]`` as the size of each level."""
        size = np.asarray(magnitudes, dtype=float)
        return np.sign(self.levels) * size[np.abs(self.levels) - 1]

    def agreement(self, table: np.ndarray, magnitudes) -> int:
        """How many cells equal those of ``table``."""
        return int(np.sum(np.isclose(self.table(magnitudes), table)))


def complete_rules(learned: LearnedRules, add_growth_level: bool = True) -> Completion:
    """The full table from learned rules by the five steps above; ``add_growth_level=False`` leaves out step 4.

    Raises:
        ValueRefused: the inputs and the output do not have the same, even number of sets, or no rule was learned.
    """
    n = len(learned.output)
    if n % 2 or learned.shape != (n, n):
        raise ValueRefused(
            "completion of a servo axis needs two inputs, and the same even number of sets everywhere, not "
            f"{', '.join(map(str, learned.shape))} and {n}"
        )
    if not learned.cells:
        raise ValueRefused("completion needs at least one learned rule")
    seeds, dropped = _monotone(_fold(learned, n))
    half = n // 2
    levels = np.zeros((n, n), dtype=int)
    for i in range(half):
        for j in range(n):
            asked = [seed.level for (a, b), seed in seeds.items() if a >= i and b >= j]
            level = max([1, *asked])
            growing = j < half
            levels[i, j] = min(level + 1, half) if growing and add_growth_level else level
    levels[half:] = -levels[:half][::-1, ::-1]
    return Completion(levels, seeds, dropped, add_growth_level)


def _fold(learned: LearnedRules, n: int) -> dict[tuple[int, int], Seed]:
    half = n // 2
    folded: dict[tuple[int, int], Seed] = {}
    for (i, j), cell in learned.cells.items():
        mirrored = i >= half
        at = (n - 1 - i, n - 1 - j) if mirrored else (i, j)
        output = n - 1 - cell.winner.output if mirrored else cell.winner.output
        level = max(output - half + 1, 1)
        before = folded.get(at, Seed(level, 0, 0.0))
        stronger = cell.winner.strength > before.strength
        folded[at] = Seed(
            level if stronger else before.level,
            before.count + cell.count,
            max(cell.winner.strength, before.strength),
        )
    return folded


def _monotone(seeds: dict[tuple[int, int], Seed]) -> tuple[dict, dict]:
    kept = dict(seeds)
    dropped: dict[tuple[int, int], Seed] = {}
    while True:
        pairs = [
            (p, q)
            for p in kept
            for q in kept
            if p != q and p[0] <= q[0] and p[1] <= q[1] and kept[p].level < kept[q].level
        ]
        if not pairs:
            return kept, dropped
        weakest = min({cell for pair in pairs for cell in pair}, key=lambda at: (kept[at].count, at))
        dropped[weakest] = kept.pop(weakest)


MOST = 1500
"""Points up to which data that is not monotone is fitted: the work grows with the cube."""


def before(first: np.ndarray, second: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Whether each of ``first`` comes before or is equal to each of ``second``; points as rows.

    ``directions``: 1 rising, -1 falling, 0 only comparable where equal; one a coordinate.
    """
    out = np.ones((len(first), len(second)), dtype=bool)
    for k, way in enumerate(directions.tolist()):
        a, b = first[:, None, k], second[None, :, k]
        out &= (a == b) if way == 0 else (way * a <= way * b)
    return out


def violations(points: np.ndarray, values: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Pairs of indices ``(i, j)``: point ``i`` comes before ``j`` and has the larger value."""
    pairs: np.ndarray = np.argwhere(before(points, points, directions) & (values[:, None] > values[None, :]))
    return pairs


def isotonic(points: np.ndarray, values: np.ndarray, weights: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The nearest monotone values, one a point; ``values`` themselves where they are monotone already.

    Points must differ. Errors of the result are those of rounding.

    Raises:
        ValueRefused: more than :data:`MOST` points that are not monotone.
    """
    if not len(violations(points, values, directions)):
        return values.astype(float)
    if len(points) > MOST:
        raise ValueRefused(f"{len(points)} covered cells are not monotone; a monotone fit goes up to {MOST}")
    from scipy.optimize import nnls

    pairs = _neighbours(before(points, points, directions))
    root = np.sqrt(weights)
    matrix = np.zeros((len(points), len(pairs)))
    matrix[pairs[:, 1], np.arange(len(pairs))] = 1.0
    matrix[pairs[:, 0], np.arange(len(pairs))] -= 1.0
    force, _ = nnls(matrix / root[:, None], -root * values, maxiter=30 * max(10, len(pairs)))
    fitted: np.ndarray = values + matrix @ force / weights
    # Rounding may leave neighbours out of order by an ulp: each takes the largest before it, from the start.
    comes = before(points, points, directions)
    for i in np.argsort(comes.sum(axis=0), kind="stable"):
        fitted[i] = fitted[comes[:, i]].max()
    return fitted


def _neighbours(comes: np.ndarray) -> np.ndarray:
    """The pairs of a partial order between which no third point lies."""
    strict = comes & ~np.eye(len(comes), dtype=bool)
    number = strict.astype(np.float32)
    pairs: np.ndarray = np.argwhere(strict & (number @ number < 0.5))
    return pairs


Cells = dict[tuple[int, ...], int]
"""Index of the output's set by the indices of the inputs' sets."""
MOST_CELLS = 200_000
"""Cells up to which a table is filled."""
NEAR = 1e-9
"""Differences below this part of a universe are none."""


@dataclass(frozen=True)
class Filled:
    """What one step did."""

    step: str
    filled: Cells
    changed: Cells
    """Cells that had another rule before."""
    note: str = ""
    """Where data contradicts the step, in a sentence."""


@dataclass(frozen=True)
class Completed:
    """A rule table, and where each of its rules comes from."""

    learned: LearnedRules
    outputs: Cells
    sources: dict[tuple[int, ...], str]
    """``data``, or the step that filled or changed the cell last."""
    steps: tuple[Filled, ...]

    @property
    def missing(self) -> int:
        """How many cells still have no rule."""
        return self.learned.total - len(self.outputs)

    def report(self, most: int = 30) -> str:
        """What each step filled, as text; lists are cut after ``most`` cells, and say so."""
        lines = []
        for step in self.steps:
            lines.append(f"{step.step}: {len(step.filled)} cells filled{self._cells(step.filled, most)}")
            if step.changed:
                lines.append(f"  {len(step.changed)} rules from before overruled{self._cells(step.changed, most)}")
            if step.note:
                lines.append(f"  {step.note}")
        left = f"{self.missing} of {self.learned.total} cells have no rule"
        return "\n".join([*lines, left if self.missing else f"all {self.learned.total} cells have a rule"])

    def _cells(self, cells: Cells, most: int) -> str:
        label = self.learned.output.labels
        said = [
            f"({', '.join(self.learned.labels(at))}) -> {label[k]}" for at, k in itertools.islice(cells.items(), most)
        ]
        more = f" and {len(cells) - most} more" if len(cells) > most else ""
        return f": {', '.join(said)}{more}" if said else ""

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data, for JSON."""

        def plain(cells: Cells) -> list[dict[str, Any]]:
            label = self.learned.output.labels
            return [{"sets": self.learned.labels(at), "output": label[k]} for at, k in cells.items()]

        steps = [
            {"step": s.step, "filled": plain(s.filled), "changed": plain(s.changed), "note": s.note} for s in self.steps
        ]
        return {"missing": self.missing, "steps": steps}


def complete(
    learned: LearnedRules, steps: Iterable[str] = (), directions: Mapping[str, int] | None = None
) -> Completed:
    """The table after the named steps, in their order; with no steps, what data says alone.

    ``directions`` is for ``monotone``: 1 or -1 by the name of an input; inputs without one are not compared.

    Raises:
        NameUnknown: no such step, or no such input.
        ValueRefused: a step does not fit the table (says why), or no rule was learned.
    """
    wanted = list(steps)
    for step in wanted:
        if step not in STEPS:
            raise NameUnknown(f"no step of completion {step!r}{nearest_name(step, list(STEPS))}")
    if wanted and not learned.cells:
        raise ValueRefused("completion needs at least one learned rule")
    if wanted and learned.total > MOST_CELLS:
        raise ValueRefused(f"a table of {learned.total} cells: completion goes up to {MOST_CELLS}")
    ways = _ways(learned, directions or {})
    if "monotone" in wanted and not ways.any():
        raise ValueRefused(f"monotone needs a direction for at least one of {', '.join(learned.names[:-1])}")
    outputs: Cells = {at: cell.winner.output for at, cell in learned.cells.items()}
    sources = dict.fromkeys(outputs, "data")
    done = []
    for step in wanted:
        new, note = STEPS[step](learned, outputs, ways)
        filled = {at: k for at, k in sorted(new.items()) if at not in outputs}
        changed = {at: k for at, k in sorted(new.items()) if outputs.get(at, k) != k}
        outputs = dict(sorted({**outputs, **filled, **changed}.items()))
        sources |= dict.fromkeys([*filled, *changed], step)
        done.append(Filled(step, filled, changed, note))
    return Completed(learned, outputs, {at: sources[at] for at in outputs}, tuple(done))


def _ways(learned: LearnedRules, directions: Mapping[str, int]) -> np.ndarray:
    names = learned.names[:-1]
    for name, way in directions.items():
        if name not in names:
            raise NameUnknown(f"directions: there is no input {name!r}{nearest_name(name, list(names))}")
        if way not in (1, -1):
            raise ValueRefused(f"directions: {name} = {way!r}: allowed are 1 (rising) and -1 (falling)")
    return np.array([directions.get(name, 0) for name in names])


# ---- steps: the cells that they would have, and where data contradicts them
def _antisymmetric(learned: LearnedRules, outputs: Cells, _: np.ndarray) -> tuple[Cells, str]:
    for name, p in zip(learned.names, (*learned.inputs, learned.output), strict=True):
        c = np.array(p.centres)
        if np.abs(c + c[::-1]).max() > NEAR * (c[-1] - c[0]):
            raise ValueRefused(
                f"antisymmetric: the centres of {name} ({', '.join(f'{x:g}' for x in c)}) are not symmetric about zero"
            )
    last = len(learned.output) - 1
    mirrored = {_mirror(learned, at): last - k for at, k in outputs.items()}
    at_zero = tuple((n - 1) // 2 for n in learned.shape)
    if _mirror(learned, at_zero) == at_zero and last % 2 == 0:
        mirrored.setdefault(at_zero, last // 2)
    against = [at for at, k in outputs.items() if mirrored.get(at, k) != k]
    pairs = {min(at, _mirror(learned, at)) for at in against}
    return {at: k for at, k in mirrored.items() if at not in outputs}, _against(learned, pairs, "symmetry")


def _mirror(learned: LearnedRules, at: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(n - 1 - i for n, i in zip(learned.shape, at, strict=True))


def _monotone_step(learned: LearnedRules, outputs: Cells, ways: np.ndarray) -> tuple[Cells, str]:
    have, value = np.array(list(outputs)), np.array(learned.output.centres)[list(outputs.values())]
    counts = [learned.cells[at].count if at in learned.cells else 1 for at in outputs]
    g = isotonic(have, value, np.array(counts, dtype=float), ways)
    empty = _empty(learned, outputs)
    new: Cells = {}
    for part in np.array_split(empty, max(1, len(empty) * len(have) // 10_000_000)):
        below, above = before(have, part, ways), before(part, have, ways).T
        low = np.where(below, g[:, None], g.min()).max(axis=0)
        high = np.where(above, g[:, None], g.max()).min(axis=0)
        said = below.any(axis=0) | above.any(axis=0)
        for at, middle in zip(part[said].tolist(), (0.5 * (low + high))[said].tolist(), strict=True):
            new[tuple(at)] = nearest_set(learned.output, middle)
    cells = list(outputs)
    wrong = {cells[k] for k in np.unique(violations(have, value, ways)).tolist()}
    return new, _against(learned, wrong, "monotonicity")


def _nearest(learned: LearnedRules, outputs: Cells, _: np.ndarray) -> tuple[Cells, str]:
    spans = [np.array(p.centres) / (p.centres[-1] - p.centres[0]) for p in learned.inputs]
    have, sets = np.array(list(outputs)), np.array(list(outputs.values()))
    centres = np.array(learned.output.centres)
    off = np.abs(centres[sets] - 0.5 * (centres[0] + centres[-1]))
    rank = np.argsort(np.lexsort([np.arange(len(sets)), np.round(off / (centres[-1] - centres[0]), 9)]))
    new: Cells = {}
    for at in _empty(learned, outputs).tolist():
        away = sum((spans[k][have[:, k]] - spans[k][i]) ** 2 for k, i in enumerate(at))
        near = np.flatnonzero(away <= np.min(away) + NEAR)
        new[tuple(at)] = int(sets[near[np.argmin(rank[near])]])
    return new, ""


def _servo(learned: LearnedRules, _: Cells, ways: np.ndarray, growth: bool = False) -> tuple[Cells, str]:
    done = complete_rules(learned, growth)
    half = len(learned.output) // 2
    new: Cells = {(i, j): int(k) + half - (k > 0) for (i, j), k in np.ndenumerate(done.levels)}
    return new, _against(learned, set(done.dropped), "monotonicity (folded to a negative first input)")


def _empty(learned: LearnedRules, outputs: Cells) -> np.ndarray:
    free = [at for at in itertools.product(*map(range, learned.shape)) if at not in outputs]
    return np.array(free, dtype=int).reshape(len(free), len(learned.shape))


def nearest_set(partition: Partition, value: float) -> int:
    """The set whose centre is nearest; of two equally near the one nearer to the universe's middle, then the lower."""
    c = np.array(partition.centres)
    off = np.abs(c - value)
    near = np.flatnonzero(off <= off.min() + NEAR * (c[-1] - c[0]))
    return int(near[np.argmin(np.round(np.abs(c[near] - 0.5 * (c[0] + c[-1])) / (c[-1] - c[0]), 9))])


def _against(learned: LearnedRules, cells: Iterable[tuple[int, ...]], what: str, most: int = 20) -> str:
    said = [f"({', '.join(learned.labels(at))})" for at in sorted(cells)]
    if not said:
        return ""
    more = f" and {len(said) - most} more" if len(said) > most else ""
    return f"data contradicts {what} at {', '.join(said[:most])}{more}"


STEPS: dict[str, Callable[[LearnedRules, Cells, np.ndarray], tuple[Cells, str]]] = {
    "antisymmetric": _antisymmetric,
    "monotone": _monotone_step,
    "nearest": _nearest,
    "servo": _servo,
    "servo_growth": lambda learned, outputs, ways: _servo(learned, outputs, ways, growth=True),
}
"""The steps by name."""
