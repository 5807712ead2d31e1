"""Step 5 of a design: rules from the samples, and the rest of the table by steps that are named.

Rules come by look-up table and strength (:mod:`leadscrew.fuzzy.learning`, equations (11) to (16)); samples exactly
between two sets are left out. The cells that no sample covers are filled by the steps asked for
(:mod:`leadscrew.fuzzy.fill`): with an even number of sets ``servo_growth`` unless told otherwise, with an odd number
``antisymmetric`` and ``monotone``, both falling with e and ec. A cell without a rule is refused: the controller would
have no duty there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadscrew.controllers.vud.universe import TABLE_2
from leadscrew.fuzzy.fill import Completed, complete
from leadscrew.fuzzy.learning import LearnedRules, aligned, learn_rules
from leadscrew.fuzzy.partition import Partition
from leadscrew.kernel.errors import ValueRefused

NAMES = ("e", "ec", "rho")
EVEN_STEPS = ("servo_growth",)
ODD_STEPS = ("antisymmetric", "monotone")
FALLING = {"e": -1, "ec": -1}
"""The duty of a servo axis falls with the error and with its change."""


@dataclass(frozen=True)
class Compared:
    """A table beside the printed Table 2, by output sets."""

    agree: int
    """Covered cells whose winner is Table 2's."""
    other: tuple[tuple[int, ...], ...]
    """Covered cells with another."""
    equal: int
    """Cells of the completed table that equal Table 2's."""


@dataclass(frozen=True)
class Rules:
    """Learned rules, their completion and the consequents."""

    learned: LearnedRules
    completed: Completed
    steps: tuple[str, ...]
    table: np.ndarray
    """Duty of each rule, rows by e and columns by ec."""
    compared: Compared | None
    """With Table 2, where the table has its size."""

    def lines(self, most: int = 30) -> list[str]:
        """The step as text."""
        lines = self.learned.report(most).splitlines()
        if self.compared is not None:
            names = ", ".join(f"({', '.join(self.learned.labels(at))})" for at in self.compared.other)
            rest = f"; the data disagrees with it in {names}" if names else ""
            lines += [
                "",
                f"{self.compared.agree} of {self.learned.covered} covered cells agree with the printed Table 2{rest}",
            ]
        lines += ["", "completion, which is not data:", *(f"  {x}" for x in self.completed.report(most).splitlines())]
        if self.compared is not None:
            lines.append(f"  {self.compared.equal} of {self.table.size} cells are those of Table 2")
        return [*lines, "", *self._drawn(most)]

    def _drawn(self, most: int) -> list[str]:
        """The completed table, data in brackets."""
        p = self.learned.output
        if len(p) > most:
            return []
        sources = self.completed.sources
        rows = [
            [f"e {label}", *(
                f"[{p.labels[k]}]" if sources[i, j] == "data" else f" {p.labels[k]}"
                for j, k in enumerate(self.completed.outputs[i, j] for j in range(len(p)))
            )]
            for i, label in enumerate(p.labels)
        ]  # fmt: skip
        return ["the table, rules from data in brackets:", *aligned([["", *(f"ec {x}" for x in p.labels)], *rows])]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        compared = None if self.compared is None else {
            "agree": self.compared.agree,
            "other": [self.learned.labels(at) for at in self.compared.other],
            "equal_cells": self.compared.equal,
        }  # fmt: skip
        return {
            "learning": self.learned.as_dict(),
            "completion": self.completed.as_dict(),
            "steps": list(self.steps),
            "table": self.table.tolist(),
            "compared_with_table_2": compared,
        }


def find_rules(
    samples: np.ndarray,
    sets: Partition,
    steps: Sequence[str] | None = None,
    levels: Sequence[float] | None = None,
) -> Rules:
    """The table for samples ``(e, ec, duty)``, the same sets on all three universes.

    ``levels``: sizes of the consequents of the positive sets, small to big, in place of the sets' centres (Table 2
    prints 0.333, 0.677, 1 beside centres 0.33, 0.67, 1).

    Raises:
        ValueRefused: no rule is learned, a step that does not fit, levels that do not, or cells left without a rule.
    """
    size = _sizes(sets, levels)
    learned = learn_rules(samples, (sets, sets), sets, names=NAMES)
    chosen = tuple(steps) if steps is not None else EVEN_STEPS if len(sets) % 2 == 0 else ODD_STEPS
    completed = complete(learned, chosen, FALLING)
    if completed.missing:
        done = f"after {', '.join(chosen)}" if chosen else "without a step of completion"
        raise ValueRefused(
            f"{completed.missing} of {learned.total} cells have no rule {done}, and the controller would have no duty "
            "there: log more moves, take fewer sets, or add the step nearest"
        )
    index = np.zeros(learned.shape, dtype=int)
    for at, output in completed.outputs.items():
        index[at] = output
    return Rules(learned, completed, chosen, size[index], _compared(learned, index))


def _sizes(sets: Partition, levels: Sequence[float] | None) -> np.ndarray:
    """The consequent of each output set."""
    c = np.array(sets.centres)
    if levels is None:
        return c
    positive = int((c > 0.0).sum())
    given = np.array([float(x) for x in levels])
    if len(given) != positive or not (np.diff(given) > 0.0).all() or not 0.0 < given[0] <= given[-1] <= 1.0:
        raise ValueRefused(
            f"levels = {', '.join(f'{x:g}' for x in given)}: expected {positive} rising numbers above 0 up to 1"
        )
    middle = [0.0] * (len(c) - 2 * positive)
    return np.array([*(-given[::-1]), *middle, *given])


def _compared(learned: LearnedRules, index: np.ndarray) -> Compared | None:
    if index.shape != TABLE_2.shape:
        return None
    agree, other = learned.agreement(TABLE_2)
    order = np.unique(TABLE_2)
    printed = np.searchsorted(order, TABLE_2)
    return Compared(agree, tuple(other), int((index == printed).sum()))
