"""Fuzzy rules from data by a look-up table (Wang and Mendel), conflicts settled by the larger strength.

Every sample ``(x, y; z)`` gives one rule: the sets to which ``x``, ``y`` and ``z`` belong most. Its strength is

    D = mu(x) mu(y) mu(z)

Of rules with the same antecedents the strongest is kept. Nothing is guessed where there is no data: the result says
which cells of the table are covered, by how many samples, and which rules lost to which.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from leadscrew.fuzzy.partition import Partition
from leadscrew.kernel.errors import ValueRefused


@dataclass(frozen=True)
class Rule:
    """The rule of one sample: indices of its sets and its strength."""

    first: int
    second: int
    output: int
    strength: float
    sample: int
    """Number of the sample in the data, from 0."""


@dataclass(frozen=True)
class Cell:
    """One cell of the table that data covers."""

    winner: Rule
    losers: tuple[Rule, ...]
    """For each other output set, its strongest rule: what the winner had to beat."""
    count: int
    """How many samples fell into the cell."""


@dataclass(frozen=True)
class LearnedRules:
    """What data says about a rule table, and where it says nothing."""

    first: Partition
    second: Partition
    output: Partition
    cells: dict[tuple[int, int], Cell]
    samples: int
    dropped: tuple[int, ...]
    """Samples left out because a value lies exactly between two sets."""

    @property
    def covered(self) -> int:
        """Number of cells that at least one sample covers."""
        return len(self.cells)

    @property
    def conflicts(self) -> dict[tuple[int, int], Cell]:
        """The cells in which samples disagree about the output."""
        return {at: cell for at, cell in self.cells.items() if cell.losers}

    def agreement(self, table: np.ndarray) -> tuple[int, list[tuple[int, int]]]:
        """How many covered cells have the set that ``table`` has there, and the cells that have another."""
        other = [
            (i, j) for (i, j), cell in self.cells.items() if cell.winner.output != self.output.winner(table[i, j]).index
        ]
        return self.covered - len(other), other

    def say(self, rule: Rule) -> str:
        """A rule in labels and strength: ``NB, PS -> PB (0.404)``."""
        return (
            f"{self.first.labels[rule.first]}, {self.second.labels[rule.second]} -> "
            f"{self.output.labels[rule.output]} ({rule.strength:.3f})"
        )


def learn_rules(
    samples: Iterable[tuple[float, float, float]],
    first: Partition,
    second: Partition,
    output: Partition,
    ties: Literal["drop", "keep"] = "drop",
) -> LearnedRules:
    """Rules from samples ``(x, y, z)``.

    A value exactly between two sets says nothing about which of them to write down: ``ties="drop"`` leaves such a
    sample out, ``"keep"`` takes the lower set.
    """
    if ties not in ("drop", "keep"):
        raise ValueRefused(f"ties = {ties!r}: allowed are 'drop' and 'keep'")
    by_cell: dict[tuple[int, int], list[Rule]] = {}
    dropped: list[int] = []
    number = 0
    for number, (x, y, z) in enumerate(samples, start=1):
        a, b, c = first.winner(x), second.winner(y), output.winner(z)
        if ties == "drop" and (a.tied or b.tied or c.tied):
            dropped.append(number - 1)
            continue
        strength = a.membership * b.membership * c.membership
        by_cell.setdefault((a.index, b.index), []).append(Rule(a.index, b.index, c.index, strength, number - 1))
    cells = {at: _cell(rules) for at, rules in sorted(by_cell.items())}
    return LearnedRules(first, second, output, cells, number, tuple(dropped))


def _cell(rules: list[Rule]) -> Cell:
    strongest: dict[int, Rule] = {}
    for rule in rules:
        if rule.output not in strongest or rule.strength > strongest[rule.output].strength:
            strongest[rule.output] = rule
    winner, *losers = sorted(strongest.values(), key=lambda rule: -rule.strength)
    return Cell(winner, tuple(losers), len(rules))
