"""Fuzzy rules from data by a look-up table (Wang and Mendel 1992), conflicts settled by the larger strength.

Every sample ``(x_1, ..., x_n; z)`` gives one rule: the sets to which the ``x_i`` and ``z`` belong most. Its strength is

    D = mu(x_1) ... mu(x_n) mu(z) m

with ``m = 1``, or the weight of the sample in ``(0, 1]`` ("the degree assigned by the expert"). Of rules with the same
antecedents the strongest is kept, of equal ones the earlier. Nothing is guessed where there is no data: the result says
which cells of the table are covered, by how many samples, and which rules lost to which.

Samples outside a universe count as its end; how many there are, and how far out, is in the result. Values are in the
units of the partitions. The rules become a system by :func:`leadscrew.fuzzy.from_data.to_system`; cells that no
sample covers are filled only by a step of :mod:`leadscrew.fuzzy.fill` that is asked for by name.

Source: L.-X. Wang, J. M. Mendel, Generating fuzzy rules by learning from examples, IEEE Trans. SMC 22 (1992)
1414-1427.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from leadscrew.fuzzy.partition import Partition
from leadscrew.util.errors import ValueRefused


def names_of(names: Sequence[str] | None, inputs: int) -> tuple[str, ...]:
    """Names of the inputs, and of the output last: those given, or ``x1``, ``x2``, ..., ``y``."""
    if inputs < 1:
        raise ValueRefused("rules need at least one input")
    called = tuple(names) if names is not None else (*(f"x{k + 1}" for k in range(inputs)), "y")
    if len(called) != inputs + 1 or len(set(called)) != len(called):
        raise ValueRefused(f"names = {list(called)}: expected {inputs + 1} different ones, the output's last")
    return called


def rows_of(samples: Any, names: tuple[str, ...], numbers: Any) -> tuple[np.ndarray, np.ndarray]:
    """The samples as an array, empty where there are none, and their numbers."""
    wanted = f"expected rows of {len(names)} numbers ({', '.join(names)})"
    given = list(samples) if isinstance(samples, Iterable) and not isinstance(samples, np.ndarray) else samples
    try:
        rows = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise ValueRefused(f"samples: {wanted}") from None
    rows = np.empty((0, len(names))) if rows.size == 0 else rows
    if rows.ndim != 2 or rows.shape[1] != len(names):
        raise ValueRefused(f"samples of shape {rows.shape}: {wanted}")
    number = np.arange(len(rows)) if numbers is None else np.asarray(numbers)
    if number.shape != (len(rows),):
        raise ValueRefused(f"numbers of shape {number.shape} for {len(rows)} samples")
    bad = np.argwhere(~np.isfinite(rows))
    if len(bad):
        row, column = bad[0].tolist()
        raise ValueRefused(
            f"samples, row {number[row]} (from 0): {names[column]} = {rows[row, column]}: must be finite"
        )
    return rows, number


def weights_of(weights: Any, number: np.ndarray) -> np.ndarray | None:
    """One weight in (0, 1] for each of the samples with these numbers."""
    if weights is None:
        return None
    given = np.asarray(weights, dtype=float)
    if given.shape != number.shape:
        raise ValueRefused(f"weights of shape {given.shape} for {len(number)} samples")
    bad = np.flatnonzero(~((given > 0.0) & (given <= 1.0)))
    if len(bad):
        raise ValueRefused(f"weights, row {number[bad[0]]} (from 0): {given[bad[0]]}: allowed is above 0 to 1")
    return given


Ties = Literal["drop", "keep"]


@dataclass(frozen=True)
class Rule:
    """The strongest rule that says the same: indices of its sets and its strength."""

    sets: tuple[int, ...]
    """One index an input."""
    output: int
    strength: float
    sample: int
    """Number of the sample in the data, from 0."""
    count: int = 1
    """How many samples say the same."""


@dataclass(frozen=True)
class Cell:
    """One cell of the table that data covers."""

    winner: Rule
    losers: tuple[Rule, ...]
    """For each other output set, its strongest rule: what the winner had to beat."""
    count: int
    """How many samples fell into the cell."""

    @property
    def drawn(self) -> bool:
        """The strongest loser is as strong as the winner, which only came earlier."""
        return bool(self.losers) and self.losers[0].strength == self.winner.strength


@dataclass(frozen=True)
class Outside:
    """Samples outside the universe of a variable."""

    count: int
    farthest: float
    """The value that lies farthest out."""


@dataclass(frozen=True)
class LearnedRules:
    """What data says about a rule table, and where it says nothing."""

    inputs: tuple[Partition, ...]
    output: Partition
    cells: dict[tuple[int, ...], Cell]
    """By the indices of the inputs' sets, in order."""
    samples: int
    dropped: tuple[int, ...]
    """Samples left out because a value lies exactly between two sets."""
    names: tuple[str, ...]
    """Of the inputs, and of the output last."""
    outside: dict[str, Outside]
    """By name, for variables that have any."""
    weighted: bool = False
    """Samples had weights."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Sets of each input."""
        return tuple(len(p) for p in self.inputs)

    @property
    def total(self) -> int:
        """Number of cells of the table."""
        return math.prod(self.shape)

    @property
    def covered(self) -> int:
        """Number of cells that at least one sample covers."""
        return len(self.cells)

    def uncovered(self) -> Iterator[tuple[int, ...]]:
        """The cells that no sample covers, in order."""
        return (at for at in itertools.product(*map(range, self.shape)) if at not in self.cells)

    @property
    def conflicts(self) -> dict[tuple[int, ...], Cell]:
        """The cells in which samples disagree about the output."""
        return {at: cell for at, cell in self.cells.items() if cell.losers}

    def agreement(self, table: np.ndarray) -> tuple[int, list[tuple[int, ...]]]:
        """How many covered cells have the set that ``table`` has there, and the cells that have another.

        ``table`` holds values of the output, one axis an input.
        """
        other = [at for at, cell in self.cells.items() if cell.winner.output != self.output.winner(table[at]).index]
        return self.covered - len(other), other

    def labels(self, at: tuple[int, ...]) -> list[str]:
        """Labels of the sets of a cell."""
        return [p.labels[i] for p, i in zip(self.inputs, at, strict=True)]

    def say(self, rule: Rule) -> str:
        """A rule in labels and strength: ``NB, PS -> PB (0.404)``."""
        return f"{', '.join(self.labels(rule.sets))} -> {self.output.labels[rule.output]} ({rule.strength:.3f})"

    def report(self, most: int = 30) -> str:
        """Coverage, rules and conflicts as text for a reader; lists are cut after ``most`` lines, and say so."""
        return report(self, most)

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data, for JSON."""
        return as_dict(self)


def learn_rules(
    samples: Any,
    inputs: Sequence[Partition],
    output: Partition,
    ties: Ties = "drop",
    *,
    weights: Any = None,
    names: Sequence[str] | None = None,
    numbers: Sequence[int] | np.ndarray | None = None,
) -> LearnedRules:
    """Rules from samples ``(x_1, ..., x_n, z)``: an array with one row a sample, or any iterable of such rows.

    A value exactly between two sets says nothing about which of them to write down: ``ties="drop"`` leaves such a
    sample out, ``"keep"`` takes the lower set. ``weights`` holds one number in (0, 1] a sample; ``names`` those of the
    inputs and, last, of the output (``x1``, ``x2``, ..., ``y`` unless given); ``numbers`` what the samples are called
    in the result and in errors (0, 1, ... unless given).

    Raises:
        ValueRefused: a row of another length, a value that is not finite (with its row, from 0), a weight out of
            range, an unknown ``ties``, or names that do not fit.
    """
    if ties not in ("drop", "keep"):
        raise ValueRefused(f"ties = {ties!r}: allowed are 'drop' and 'keep'")
    called = names_of(names, len(inputs))
    partitions = (*inputs, output)
    rows, number = rows_of(samples, called, numbers)
    weight = weights_of(weights, number)
    found = [p.winners(rows[:, k]) for k, p in enumerate(partitions)]
    strengths = np.ones(len(rows)) if weight is None else weight
    for one in found:
        # In this order, from the left: 1 times mu is mu, so without weights it is the plain product.
        strengths = strengths * one.membership
    tied = np.any([one.tied for one in found], axis=0) if ties == "drop" else np.zeros(len(rows), dtype=bool)
    indices = np.array([one.index for one in found]).T
    by_cell: dict[tuple[int, ...], dict[int, Rule]] = {}
    for row in np.flatnonzero(~tied).tolist():
        *at, z = indices[row].tolist()
        rule = Rule(tuple(at), z, float(strengths[row]), int(number[row]))
        _enter(by_cell.setdefault(rule.sets, {}), rule)
    return LearnedRules(
        tuple(inputs), output, {at: _cell(rules) for at, rules in sorted(by_cell.items())}, len(rows),
        tuple(number[tied].tolist()), called, _outside(rows, partitions, called), weight is not None,
    )  # fmt: skip


def _enter(strongest: dict[int, Rule], rule: Rule) -> None:
    before = strongest.get(rule.output)
    if before is None:
        strongest[rule.output] = rule
    else:
        best = rule if rule.strength > before.strength else before
        strongest[rule.output] = Rule(best.sets, best.output, best.strength, best.sample, before.count + 1)


def _cell(strongest: dict[int, Rule]) -> Cell:
    winner, *losers = sorted(strongest.values(), key=lambda rule: (-rule.strength, rule.sample))
    return Cell(winner, tuple(losers), sum(rule.count for rule in strongest.values()))


def _outside(rows: np.ndarray, partitions: Sequence[Partition], names: tuple[str, ...]) -> dict[str, Outside]:
    out: dict[str, Outside] = {}
    for column, partition, name in zip(rows.T, partitions, names, strict=True):
        beyond = np.maximum(partition.centres[0] - column, column - partition.centres[-1])
        if (beyond > 0.0).any():
            out[name] = Outside(int((beyond > 0.0).sum()), float(column[int(np.argmax(beyond))]))
    return out


MOST_CELLS = 100_000
"""Cells up to which :func:`as_dict` lists those that no sample covers."""


def report(learned: LearnedRules, most: int = 30) -> str:
    """Coverage, rules and conflicts; lists are cut after ``most`` lines, and say so."""
    used = learned.samples - len(learned.dropped)
    share = 100.0 * learned.covered / learned.total
    conflicts = learned.conflicts
    lines = [
        f"{learned.samples} samples, {used} used, {len(learned.dropped)} left out (a value exactly between two sets)",
        *(outside_line(learned, name) for name in learned.outside),
        f"{learned.covered} of {learned.total} cells covered ({share:.1f} %), {len(conflicts)} in conflict",
        "",
        *rule_table(learned, most),
    ]
    missing = learned.total - learned.covered
    if missing:
        shown = [f"({', '.join(learned.labels(at))})" for at in itertools.islice(learned.uncovered(), most)]
        more = f" and {missing - len(shown)} more" if missing > len(shown) else ""
        lines += ["", f"no sample covers {', '.join(shown)}{more}"]
    return "\n".join(lines)


def outside_line(learned: LearnedRules, name: str) -> str:
    """One sentence on the samples outside the universe of a variable."""
    centres = dict(zip(learned.names, (*learned.inputs, learned.output), strict=True))[name].centres
    said = learned.outside[name]
    verb = "sample lies" if said.count == 1 else "samples lie"
    return (
        f"{said.count} {verb} outside the universe of {name}, [{centres[0]:g}, {centres[-1]:g}], the farthest at "
        f"{said.farthest:g}: held at its end"
    )


def rule_table(learned: LearnedRules, most: int) -> list[str]:
    """Lines of a table: rule, strength, samples that say so of those in the cell, what it beat."""
    rows = [_row(learned, cell) for cell in itertools.islice(learned.cells.values(), most)]
    lines = aligned([(*learned.names, "strength", "samples", "beat"), *rows])
    if learned.covered > most:
        lines.append(f"... and {learned.covered - most} more rules")
    return lines


def _row(learned: LearnedRules, cell: Cell) -> tuple[str, ...]:
    rule = cell.winner
    of = f"{rule.count} of {cell.count}" if cell.losers else str(rule.count)
    beat = ", ".join(f"{learned.output.labels[r.output]} ({r.strength:.3f}, {r.count})" for r in cell.losers)
    beat += "; a draw, the earlier sample wins" if cell.drawn else ""
    return (*learned.labels(rule.sets), learned.output.labels[rule.output], f"{rule.strength:.3f}", of, beat)


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of texts as lines with straight columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows]


def runs(numbers: Iterable[int]) -> str:
    """Rising whole numbers in few words: ``1-4, 7``."""
    parts: list[list[int]] = []
    for n in numbers:
        if parts and n == parts[-1][-1] + 1:
            parts[-1] = [parts[-1][0], n]
        else:
            parts.append([n])
    return ", ".join("-".join(map(str, part)) for part in parts)


def finite(value: Any) -> Any:
    """Plain data with None for numbers that are not finite, as JSON wants it."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def as_dict(learned: LearnedRules) -> dict[str, Any]:
    """The same as plain data, for JSON; ``uncovered`` is None for a table of more than :data:`MOST_CELLS` cells."""
    return {
        "names": list(learned.names),
        "partitions": {
            name: {"centres": [float(c) for c in p.centres], "labels": list(p.labels)}
            for name, p in zip(learned.names, (*learned.inputs, learned.output), strict=True)
        },
        "samples": learned.samples,
        "weighted": learned.weighted,
        "dropped": list(learned.dropped),
        "outside": {name: vars(o) for name, o in learned.outside.items()},
        "cells": learned.total,
        "covered": learned.covered,
        "conflicts": len(learned.conflicts),
        "rules": [_cell_words(learned, at, cell) for at, cell in learned.cells.items()],
        "uncovered": [learned.labels(at) for at in learned.uncovered()] if learned.total <= MOST_CELLS else None,
    }


def _cell_words(learned: LearnedRules, at: tuple[int, ...], cell: Cell) -> dict[str, Any]:
    def plain(rule: Rule) -> dict[str, Any]:
        output = learned.output.labels[rule.output]
        return {"output": output, "strength": rule.strength, "samples": rule.count, "sample": rule.sample}

    return {
        "sets": learned.labels(at),
        **plain(cell.winner),
        "cell_samples": cell.count,
        "drawn": cell.drawn,
        "beat": [plain(rule) for rule in cell.losers],
    }
