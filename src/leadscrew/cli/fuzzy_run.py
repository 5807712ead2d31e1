"""The inputs of a fuzzy system from the columns of a recorded run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from leadscrew.cli.fuzzy_files import known, number_of, pairs
from leadscrew.cli.fuzzy_tables import columns_of, table_of
from leadscrew.kernel.errors import DataError, NameUnknown

if TYPE_CHECKING:
    import numpy as np

_FUNCTION = re.compile(r"(change|rate)\((.+)\)")


@dataclass(frozen=True)
class Source:
    """Where an input comes from: ``scale * function(column)``."""

    column: str
    scale: float = 1.0
    function: str = ""

    def values(self, column: np.ndarray, time: np.ndarray) -> np.ndarray:
        """The input; its first change is zero, as nothing was before."""
        import numpy as np

        if self.function:
            column = np.diff(column, prepend=column[:1])
        if self.function == "rate" and len(time) > 1:
            column = column / np.append(1.0, np.diff(time))
        return self.scale * column


@dataclass(frozen=True)
class RunInputs:
    """The inputs of a system along a run."""

    time: np.ndarray
    unit: str
    """Of the times; empty where they are numbers of rows."""
    points: np.ndarray
    said: dict[str, str]
    """Where each input was taken from."""


def source_of(text: str, name: str) -> Source:
    """A source from ``COLUMN``, ``SCALE*COLUMN``, ``change(COLUMN)`` or ``SCALE*rate(COLUMN)``.

    Raises:
        ValueRefused: what stands before the star is no number.
    """
    before, star, after = text.partition("*")
    scale = number_of(before.strip(), f"--map {name}: scale") if star else 1.0
    column = (after if star else before).strip()
    match = _FUNCTION.fullmatch(column)
    return Source(match[2].strip(), scale, match[1]) if match else Source(column, scale)


def recorded_inputs(run: Path, inputs: Sequence[str], maps: Sequence[str], time: str | None) -> RunInputs:
    """The inputs along a run; a column of an input's own name unless ``maps`` say otherwise.

    Raises:
        NameUnknown: no such input.
        ValueRefused: a map that is none.
        DataError: the run cannot be read, a column is missing, a cell is no number, or the times do not rise.
    """
    import numpy as np

    path = run / "signals.parquet" if run.is_dir() else run
    given = pairs(maps, "--map")
    for name in given:
        known(name, inputs, "input")
    sources = {name: source_of(given.get(name, name), name) for name in inputs}
    there = columns_of(path)
    lost = [n for n in inputs if n not in given and n not in there]
    if lost:
        raise NameUnknown(
            f"{path} has no column {lost[0]!r} for the input {lost[0]}; say where it comes from: "
            f"--map {lost[0]}=COLUMN, columns are {', '.join(there)}"
        )
    clock = time if time is not None else "time" if "time" in there else None
    wanted = dict.fromkeys([*([] if clock is None else [clock]), *(s.column for s in sources.values())])
    table = table_of(path, list(wanted))
    rows = len(next(iter(table.values())))
    t = table[clock] if clock is not None else np.arange(1.0, rows + 1.0)
    if not (np.diff(t) > 0.0).all():
        at = int(np.argmin(np.diff(t) > 0.0)) + 1
        raise DataError(f"{path}: the times must rise, and {clock} = {t[at]:g} follows {t[at - 1]:g}")
    points = np.column_stack([s.values(table[s.column], t) for s in sources.values()])
    return RunInputs(t, "" if clock is None else "s", points, {n: given.get(n, n) for n in inputs})
