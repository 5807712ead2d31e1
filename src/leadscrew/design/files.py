"""Reading the log of an axis: a table like the paper's Table 1, or signals as ``leadscrew simulate --out`` writes them.

=====================  ================================================================================================
columns                what
=====================  ================================================================================================
k, r, e, ec, rho       one row an interval: number, target in mm, error, its change, duty, the last three in [-1, 1];
                       a change of ``r`` begins a new move (CSV)
time, command,         as fine as it comes: seconds, the two positions in mm, duty in [-1, 1]; a step of the command
feedback, output       begins a new move; a CSV or Parquet file, or the folder that ``simulate --out`` made
=====================  ================================================================================================

Logged moves of a servo axis, as a design reads them: error, its change per interval, and the duty.

Two kinds of log:

``normalised``
    the layout of the paper's Table 1: ``e`` and ``ec`` are fractions of their universes, ``rho`` is the duty;
``measured``
    signals against time, as ``leadscrew simulate --out`` writes them: the error is command minus feedback, taken every
    interval, and ``ec`` its change from the interval before.

The sign of ``ec`` must be that of the change of ``e``. A move whose ``ec`` is the change turned round (Table 1 prints
magnitudes where the target is positive) is turned back, and named in :attr:`MoveLog.turned`.

What a log must be before anything is designed from it: enough rows, things that change, columns that are what they
say.

Columns are checked by physics, not by their names. ``ec`` must be the change of ``e`` in one interval, and no other
pair of columns may fit that better; the duty must drive the error to zero, in the sense of the lathe's controllers
(a positive duty makes the error rise, so the duty has the sign of ``-e``).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from leadscrew.util.errors import DataError, ValueRefused

Layout = Literal["normalised", "measured"]


@dataclass(frozen=True)
class Move:
    """One logged move, a sample an interval."""

    name: str
    target_mm: float | None
    """Where it went from 0, where the log says so."""
    number: np.ndarray
    """Of the sample; 0 is the instant of the step."""
    error: np.ndarray
    """Normalised, or in mm."""
    change: np.ndarray
    """Of the error since the sample before, with its sign; says nothing at 0. Normalised, or in mm."""
    duty: np.ndarray

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Indices of neighbouring samples, one interval apart: the earlier and the later ones."""
        later = np.flatnonzero(np.diff(self.number) == 1.0) + 1
        return later - 1, later

    def columns(self) -> dict[str, np.ndarray]:
        """By the names of Table 1."""
        return {"e": self.error, "ec": self.change, "rho": self.duty}


@dataclass(frozen=True)
class MoveLog:
    """All moves of a log."""

    sources: tuple[str, ...]
    layout: Layout
    moves: tuple[Move, ...]
    interval_s: float
    """To which the change of the error refers."""
    peak_change: float
    """Largest change of the error in one interval, wherever the interval begins if the log is finer than that."""
    turned: tuple[str, ...] = ()
    """Moves whose ec had the wrong sign."""

    @property
    def rows(self) -> int:
        """Samples that a rule can come from: all but the first of each move."""
        return sum(int((m.number > 0).sum()) for m in self.moves)

    def samples(self) -> np.ndarray:
        """Rows ``(e, ec, rho)`` of these samples, in the log's units."""
        parts = [np.column_stack([m.error, m.change, m.duty])[m.number > 0] for m in self.moves]
        return np.concatenate(parts) if parts else np.empty((0, 3))

    def scale(self, moves: tuple[Move, ...] | None = None) -> tuple[float, float]:
        """Change of the error per unit of ec by least squares over ``moves`` (all unless given), and what is left.

        The second number is the root mean square of what is left, over that of the change.
        """
        d, x = _stacked([m.columns() for m in moves or self.moves], moves or self.moves, "e", "ec")
        return slope(d, x)


def slope(d: np.ndarray, x: np.ndarray) -> tuple[float, float]:
    """The factor that turns ``x`` into ``d`` best, and the root mean square of the rest over that of ``d``."""
    size, power = float(d @ d), float(x @ x)
    if size == 0.0 or power == 0.0:
        return 0.0, 1.0
    factor = float(x @ d) / power
    return factor, float(np.sqrt(np.sum((d - factor * x) ** 2) / size))


def misfit(moves: tuple[Move, ...], error: str, change: str) -> float:
    """How badly column ``change`` is the change of column ``error``: 0 exactly, 1 not at all; each move by itself."""
    left = whole = 0.0
    for move in moves:
        d, x = _stacked([move.columns()], (move,), error, change)
        size = float(d @ d)
        left += size * slope(d, x)[1] ** 2
        whole += size
    return float(np.sqrt(left / whole)) if whole > 0.0 else 1.0


def _stacked(
    columns: Sequence[Mapping[str, np.ndarray]], moves: tuple[Move, ...], error: str, change: str
) -> tuple[np.ndarray, np.ndarray]:
    d, x = [], []
    for named, move in zip(columns, moves, strict=True):
        before, after = move.pairs()
        d.append(named[error][after] - named[error][before])
        x.append(named[change][after])
    return np.concatenate(d), np.concatenate(x)


LEAST_ROWS = 10
"""Samples after the first of each move; each of the paper's moves has 20."""
MOST_MISFIT = 0.35
"""Of ec as the change of e: Table 1 has 0.007 to 0.094 by its rounding, unrelated columns 0.8 and more."""
LEAST_OPPOSED = 0.5
"""Correlation of -e and the duty, about zero, from which the duty drives the error to zero; Table 1 has 0.96."""
SAID = {"normalised": ("e", "ec", "rho"), "measured": ("command - feedback", "its change", "output")}


def checked(log: MoveLog) -> MoveLog:
    """The log with the sign of ``ec`` put right where a move has it turned round.

    Raises:
        DataError: too few rows, a column that never changes, columns that look swapped, or a duty that does not drive
            the error to zero; one sentence.
    """
    where = ", ".join(log.sources)
    if log.rows < LEAST_ROWS:
        raise DataError(
            f"{where}: {log.rows} row{'' if log.rows == 1 else 's'} after the start of a move: a rule base needs "
            f"{LEAST_ROWS} at least"
        )
    _changing(log, where)
    if not any(len(m.pairs()[0]) for m in log.moves):
        raise DataError(
            f"{where}: no two rows are one interval apart (columns k and r): ec cannot be checked against e"
        )
    if log.layout == "normalised":
        _check_columns(log, where)
        log = _turned(log)
    _opposed(log, where)
    return log


def _changing(log: MoveLog, where: str) -> None:
    rows = log.samples()
    for name, column in zip(SAID[log.layout], rows.T, strict=True):
        if np.ptp(column) == 0.0:
            raise DataError(f"{where}: {name} is always {column[0]:g}: there is nothing to learn from")


def _check_columns(log: MoveLog, where: str) -> None:
    """``ec`` is the change of ``e``, and no other pair of columns fits better."""
    fits = {pair: misfit(log.moves, *pair) for pair in itertools.permutations(("e", "ec", "rho"), 2)}
    own = fits["e", "ec"]
    best = min(fits, key=lambda pair: fits[pair])
    if best == ("e", "ec") and own <= MOST_MISFIT:
        return
    if fits[best] <= MOST_MISFIT:
        raise DataError(
            f"{where}: columns look swapped: {best[1]} is the change of {best[0]} per row (misfit "
            f"{100.0 * fits[best]:.0f} %), ec is not that of e ({100.0 * own:.0f} %)"
        )
    raise DataError(
        f"{where}: ec is not the change of e per row (misfit {100.0 * own:.0f} %, allowed are "
        f"{100.0 * MOST_MISFIT:.0f} %), nor is any other pair of columns: are they e, ec and rho, one row an interval?"
    )


def _turned(log: MoveLog) -> MoveLog:
    moves, turned = [], []
    for move in log.moves:
        if _slope_of(move) < 0.0:
            turned.append(move.name)
            move = replace(move, change=-move.change)
        moves.append(move)
    return replace(log, moves=tuple(moves), turned=tuple(turned))


def _slope_of(move: Move) -> float:
    before, after = move.pairs()
    return slope(move.error[after] - move.error[before], move.change[after])[0]


def _opposed(log: MoveLog, where: str) -> None:
    e, _, rho = log.samples().T
    size = float(np.sqrt((e @ e) * (rho @ rho)))
    agreement = -float(e @ rho) / size if size > 0.0 else 0.0
    if agreement >= LEAST_OPPOSED:
        return
    error, _, duty = SAID[log.layout]
    if agreement <= -LEAST_OPPOSED:
        swapped = "command and feedback are swapped, or " if log.layout == "measured" else ""
        raise DataError(
            f"{where}: {duty} has the sign of {error} (correlation {-agreement:.2f}): {swapped}the duty's sense is "
            "the other one; these controllers take a positive duty to make the error rise, so turn its sign"
        )
    raise DataError(
        f"{where}: {duty} does not drive {error} to zero (correlation with its negative {agreement:.2f}, at least "
        f"{LEAST_OPPOSED:g} is expected): are the columns what they say?"
    )


TABLE = ("k", "r", "e", "ec", "rho")
SIGNALS = ("time", "command", "feedback", "output")
UNIVERSE = (-1.0, 1.0)
INTERVAL_S = 0.1
"""At which the paper logged Table 1 (section IV.b, step 4)."""
HEAD = 100_000
"""Characters in which the header of a log is looked for."""
DUTY_BEYOND = 1e-3
"""By which a logged duty may pass 1 and count as 1: the printed law gives 1.0001 by its floor."""


def read_moves(paths: str | Path | Sequence[str | Path], interval_s: float = INTERVAL_S) -> MoveLog:
    """The moves of one log or several, checked; all of the same kind.

    Raises:
        DataError: a file that cannot be read, a column missing, a value out of range, or a log that
            :func:`checked` refuses.
        ValueRefused: no log, or an interval that is not positive.
    """
    given = [paths] if isinstance(paths, str | Path) else list(paths)
    if not given:
        raise ValueRefused("a design needs one log at least")
    if not interval_s > 0.0:
        raise ValueRefused(f"interval_s = {interval_s!r}: must be above 0")
    sources = tuple(str(p) for p in given)
    found = [_read(Path(p), interval_s) for p in given]
    layouts = {log.layout for log in found}
    if len(layouts) > 1:
        raise DataError(f"{', '.join(sources)}: tables (k, r, e, ec, rho) and signals against time cannot be mixed")
    moves = tuple(move for log in found for move in log.moves)
    whole = MoveLog(sources, found[0].layout, moves, interval_s, max(log.peak_change for log in found))
    return checked(whole)


def _read(path: Path, interval_s: float) -> MoveLog:
    if path.is_dir():
        return _signals(path / "signals.parquet", str(path), interval_s)
    if path.suffix.casefold() in (".parquet", ".pq"):
        return _signals(path, str(path), interval_s)
    header = _header(path)
    if {"command", "feedback"} & set(header):
        return _signals(path, str(path), interval_s)
    return _table(path, interval_s)


def _header(path: Path) -> list[str]:
    """Names of the columns of a CSV file; none where it cannot be read, which the reader then says."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            head = file.read(HEAD).splitlines()
    except OSError:
        return []
    line = next((x for x in head if x.strip() and not x.lstrip().startswith("#")), "")
    return [cell.strip() for cell in line.split(",")]


def _table(path: Path, interval_s: float) -> MoveLog:
    from leadscrew.logs.csv_columns import read_log

    limits = dict.fromkeys(("e", "ec", "rho"), UNIVERSE)
    log = read_log(path, TABLE, increasing="k", within="r", limits=limits)
    starts = [0, *(np.flatnonzero(np.diff(log["r"])) + 1).tolist(), len(log["r"])]
    moves: list[Move] = []
    for first, last in pairwise(starts):
        k, r, e, ec, rho = (log[name][first:last] for name in TABLE)
        name = f"r={r[0]:g}"
        if any(m.name == name for m in moves):
            raise DataError(f"{path}: the target {name} appears in two places")
        moves.append(Move(name, float(r[0]), k, e, ec, rho))
    peak = max(float(np.abs(m.change).max()) for m in moves)
    return MoveLog((str(path),), "normalised", tuple(moves), interval_s, peak)


def _signals(path: Path, name: str, interval_s: float) -> MoveLog:
    time, command, feedback, output = _columns(path)
    output = _in_range(path, output)
    steps = np.diff(time)
    if len(time) < 2 or not (steps > 0.0).all():
        raise DataError(f"{path}: time does not rise from row to row")
    if steps.max() > interval_s * (1.0 + 1e-9):
        raise DataError(
            f"{path}: rows are up to {steps.max():g} s apart, more than the interval of {interval_s:g} s: log finer, "
            "or choose a longer interval"
        )
    if np.ptp(feedback) == 0.0:
        moved = ", while command does: are the two swapped?" if np.ptp(command) > 0.0 else ": nothing moved"
        raise DataError(f"{path}: feedback never changes from {feedback[0]:g}{moved}")
    moves: list[Move] = []
    peaks = [0.0]
    for first, last in pairwise([0, *_jumps(command), len(time)]):
        t, e, rho = time[first:last], (command - feedback)[first:last], output[first:last]
        if len(t) < 2 or np.ptp(e) == 0.0:
            continue
        at = _nearest(t, t[0] + interval_s * np.arange(int((t[-1] - t[0]) / interval_s * (1.0 + 1e-12)) + 1))
        number = np.arange(len(at), dtype=float)
        own = name if not moves else f"{name}#{len(moves) + 1}"
        moves.append(Move(own, float(command[first]), number, e[at], np.diff(e[at], prepend=e[at[0]]), rho[at]))
        inside = t + interval_s <= t[-1] + 1e-9 * interval_s
        peaks += np.abs(np.interp(t[inside] + interval_s, t, e) - e[inside]).tolist()
    if not moves:
        raise DataError(f"{path}: command - feedback never changes: nothing to learn from")
    return MoveLog((name,), "measured", tuple(moves), interval_s, max(peaks))


def _jumps(command: np.ndarray) -> list[int]:
    """Rows at which the command steps from one rest to another: a new move begins there."""
    moved = np.diff(command) != 0.0
    alone = moved & ~np.r_[False, moved[:-1]] & ~np.r_[moved[1:], False]
    return (np.flatnonzero(alone) + 1).tolist()


def _nearest(time: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Index of the row nearest to each of the wanted times."""
    after = np.clip(np.searchsorted(time, wanted), 1, len(time) - 1)
    return after - (wanted - time[after - 1] < time[after] - wanted)


def _in_range(path: Path, output: np.ndarray) -> np.ndarray:
    bad = np.flatnonzero(np.abs(output) > 1.0 + DUTY_BEYOND)
    if len(bad):
        raise DataError(
            f"{path}, row {bad[0] + 1}, column 'output': {output[bad[0]]:g} is outside [-1, 1]: is it the duty?"
        )
    return np.clip(output, -1.0, 1.0)


def _columns(path: Path) -> list[np.ndarray]:
    """The signals in s, mm and shares of the full duty; without a unit in its header a column is in that."""
    from leadscrew.logs import read_table
    from leadscrew.logs.header import sized

    table = read_table(path)
    found = [table.seconds("time")]
    for wanted, role, kind, own in (
        ("command", "position", "m", 1e-3), ("feedback", "position", "m", 1e-3), ("output", "drive", "1", 1.0)
    ):  # fmt: skip
        name = table.name(wanted)
        unit = table.unit_of(name, role)
        seen, size = sized(role, unit) if unit else (kind, own)
        if seen != kind:
            raise DataError(
                f"{path}, column {name!r}: is in {unit}; expected {'mm' if kind == 'm' else 'a duty, 1 or %'}"
            )
        found.append(table.numbers(name) * (size / own))
    return found
