"""What was learned from data, as text and as plain data: coverage, rules with what they beat, conflicts."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import Any

from leadscrew.fuzzy.learning import Cell, LearnedRules, Rule

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
        "rules": [_cell(learned, at, cell) for at, cell in learned.cells.items()],
        "uncovered": [learned.labels(at) for at in learned.uncovered()] if learned.total <= MOST_CELLS else None,
    }


def _cell(learned: LearnedRules, at: tuple[int, ...], cell: Cell) -> dict[str, Any]:
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
