"""Reading the log of an axis: a table like the paper's Table 1, or signals as ``leadscrew simulate --out`` writes them.

=====================  ================================================================================================
columns                what
=====================  ================================================================================================
k, r, e, ec, rho       one row an interval: number, target in mm, error, its change, duty, the last three in [-1, 1];
                       a change of ``r`` begins a new move (CSV)
time, command,         as fine as it comes: seconds, the two positions in mm, duty in [-1, 1]; a step of the command
feedback, output       begins a new move; a CSV or Parquet file, or the folder that ``simulate --out`` made
=====================  ================================================================================================
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from leadscrew.design.checks import checked
from leadscrew.design.log import Move, MoveLog
from leadscrew.kernel.errors import DataError, ValueRefused

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
            :func:`leadscrew.design.checks.checked` refuses.
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
    from leadscrew.identify.log import read_log

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
