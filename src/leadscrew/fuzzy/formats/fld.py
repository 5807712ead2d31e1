"""Writes ``.fld`` tables: the inputs of a grid and the outputs of a system, a line each, as fuzzylite does."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from leadscrew.fuzzy.formats.place import plain
from leadscrew.fuzzy.system import System
from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import ValueRefused

__all__ = ["dumps", "grid", "write"]

MOST_LINES = 10_000_000
Evaluate = Callable[[Sequence[float]], Sequence[float]]


def grid(system: System, values: int = 1024, each: bool = False) -> Iterator[tuple[float, ...]]:
    """The points of a grid over the universes of the inputs, the last input fastest.

    ``values`` is the number of points of the whole grid (the largest grid with the same number for each input that
    has no more points), or of each input where ``each`` is true.

    Raises:
        ValueRefused: there are too many or too few points, or a universe is infinite.
    """
    count = values if each else _root(values, len(system.inputs))
    if not system.inputs or count < 2 or count ** len(system.inputs) > MOST_LINES:
        raise ValueRefused(
            f"a grid of {values} values{' for each' if each else ''} over {len(system.inputs)} inputs: allowed are 2 "
            f"values or more for each input and {MOST_LINES} lines"
        )
    axes = []
    for variable in system.inputs:
        if not (math.isfinite(variable.low) and math.isfinite(variable.high)):
            raise ValueRefused(f"input {variable.name}: universe [{variable.low}, {variable.high}]: a grid needs ends")
        width = variable.high - variable.low
        axes.append([variable.low + width * k / (count - 1) for k in range(count)])
    return itertools.product(*axes)


def dumps(system: System, evaluate: Evaluate, values: int = 1024, each: bool = False) -> str:
    """The table as text: a line of names, then a line for each point of :func:`grid`.

    ``evaluate`` gives the outputs of the system, in order, from its inputs, in order.

    Raises:
        ValueRefused: see :func:`grid`; or ``evaluate`` gives another number of outputs.
    """
    names = [variable.name for variable in (*system.inputs, *system.outputs)]
    if spaced := [name for name in names if not name or any(c.isspace() for c in name)]:
        raise ValueRefused(f"a .fld file cannot express the name {spaced[0]!r}: it is empty or holds a space")
    lines = [" ".join(names)]
    for point in grid(system, values, each):
        outputs = tuple(evaluate(point))
        if len(outputs) != len(system.outputs):
            raise ValueRefused(f"evaluate gave {len(outputs)} outputs of {system.name}; expected {len(system.outputs)}")
        lines.append(" ".join(map(plain, (*point, *outputs))))
    return "\n".join(lines) + "\n"


def write(system: System, path: str | Path, evaluate: Evaluate, values: int = 1024, each: bool = False) -> None:
    """Writes the table of :func:`dumps` to a file.

    Raises:
        ValueRefused: see :func:`dumps`.
        DataError: the file cannot be written.
    """
    atomic_write(dumps(system, evaluate, values, each), path)


def _root(values: int, inputs: int) -> int:
    """The largest whole number whose power ``inputs`` is no more than ``values``."""
    if inputs < 1 or values < 1:
        return 0
    count = round(min(values, MOST_LINES + 1) ** (1.0 / inputs))
    return count if count**inputs <= values else count - 1
