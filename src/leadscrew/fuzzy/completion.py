"""A full rule table from a few learned rules: symmetry, monotonicity and one piece of prior knowledge.

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

General steps, for any number of inputs, stand in :mod:`leadscrew.fuzzy.fill`; this one is ``servo`` there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadscrew.fuzzy.learning import LearnedRules
from leadscrew.kernel.errors import ValueRefused


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
