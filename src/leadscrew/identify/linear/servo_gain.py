"""The gain of an integrating plant with known lags from files of moves.

    position(t) = K / (s (T_1 s + 1) (T_2 s + 1) ...) input(t)

The position of each move is counted from its start.

The fit is output-error least squares. The input drives a chain of lags with unit dc gain and then an integrator, all
known; the one unknown is the gain:

    position(t) = K * travel(t),    travel = 1 / (s (T_1 s + 1) (T_2 s + 1) ...) applied to the input

so the least-squares gain is the projection of the measured position on ``travel``. What the input did between the
samples is not in a log, and it matters when the samples are coarse: :data:`Hold` says what is assumed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from leadscrew.identify.linear.record import Names, doubles, odd
from leadscrew.kernel.one_thread import one_thread
from leadscrew.kernel.validate import one_of
from leadscrew.logs.finding import refuse
from leadscrew.logs.sampling import clock
from leadscrew.logs.table import Table
from leadscrew.plants._linear import hold_matrices
from leadscrew.util.errors import DataError, ValueRefused

Hold = Literal["linear", "previous", "current"]
"""Between two samples the input runs in a straight line, keeps the earlier value, or has the later one already."""

HOLDS: tuple[Hold, ...] = ("linear", "previous", "current")


class Record(NamedTuple):
    """One logged move: time from its start, input, and position relative to its start."""

    time_s: np.ndarray
    input: np.ndarray
    position: np.ndarray


@dataclass(frozen=True)
class GainFit:
    """A gain for all records together, and how well it fits each."""

    gain: float
    """Position units per second and unit of input."""
    nrmse_percent: Mapping[str, float]
    """Root mean square error over the range of the measured position, by record, with the common gain."""
    gain_alone: Mapping[str, float]
    """The gain that each record would ask for by itself."""
    hold: Hold

    @property
    def spread_percent(self) -> float:
        """How far apart the records' own gains lie, in percent of the common one: large means not linear."""
        own = list(self.gain_alone.values())
        return 100.0 * (max(own) - min(own)) / abs(self.gain)


def unit_travel(record: Record, lags_s: Sequence[float], hold: Hold = "linear") -> np.ndarray:
    """Position that a plant of unit gain would reach under the record's input; exact for what ``hold`` assumes."""
    order = len(lags_s) + 2  # position, what each lag gives, input: each drives the one before
    chain, ramp = np.diag(np.ones(order - 1), 1), np.zeros(order)
    ramp[-1] = 1.0
    for i, lag in enumerate(lags_s, start=1):
        chain[i, i : i + 2] = -1.0 / lag, 1.0 / lag
    dt = float(record.time_s[1] - record.time_s[0])
    step, ramped = hold_matrices(chain, ramp, dt)
    u = record.input[1:] if hold == "current" else record.input[:-1]
    slopes = np.diff(record.input) / dt if hold == "linear" else np.zeros(len(u))
    state, travel = np.zeros(order), np.zeros(len(u) + 1)
    for k, (now, slope) in enumerate(zip(u, slopes, strict=True), start=1):
        state[-1] = now
        state = step @ state + ramped * slope
        travel[k] = state[0]
    return travel


@one_thread()
def fit_gain(records: Mapping[str, Record], lags_s: Sequence[float], hold: Hold = "linear") -> GainFit:
    """The gain that fits all records best in position.

    Raises:
        DataError: no records, a record of fewer than three samples or not evenly sampled, an input that never acts, or
            a position that never moves.
        ValueRefused: a lag that is not positive, or an unknown hold.
    """
    if hold not in HOLDS:
        raise ValueRefused(f"hold = {hold!r}: allowed are {', '.join(HOLDS)}")
    if any(not lag > 0.0 for lag in lags_s):
        raise ValueRefused(f"lags_s = {list(lags_s)}: every lag must be above 0 s")
    if not records:
        raise DataError("no records to fit a gain to")
    travel = {}
    for name, record in records.items():
        _check(name, record)
        travel[name] = unit_travel(record, lags_s, hold)
        if not np.any(travel[name]):
            raise DataError(f"record {name}: its input never acts, so it says nothing about the gain")
    own = {n: float(travel[n] @ r.position / (travel[n] @ travel[n])) for n, r in records.items()}
    gain = float(sum(travel[n] @ r.position for n, r in records.items()) / sum(travel[n] @ travel[n] for n in records))
    nrmse = {
        n: float(100.0 * np.sqrt(np.mean((gain * travel[n] - r.position) ** 2)) / np.ptp(r.position))
        for n, r in records.items()
    }
    return GainFit(gain, nrmse, own, hold)


def _check(name: str, record: Record) -> None:
    if len({len(part) for part in record}) != 1:
        lengths = ", ".join(str(len(part)) for part in record)
        raise DataError(f"record {name}: time, input and position have {lengths} samples")
    if len(record.time_s) < 3:
        raise DataError(f"record {name}: {len(record.time_s)} samples; a fit needs at least three")
    steps = np.diff(record.time_s)
    if not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * steps.mean():
        raise DataError(f"record {name}: the samples are not evenly spaced in time")
    if np.ptp(record.position) == 0.0:
        raise DataError(f"record {name}: the position never moves")


LONG = 200
"""Samples of a move that are enough to judge its units and its encoder."""
APART = 10.0
"""Percent between the moves' own gains above which one gain is no model of all."""
COARSE = 0.5
"""Change of the gain with the hold, in percent, above which what happens between samples matters."""


class Move(NamedTuple):
    """One move and how the common gain fits it."""

    name: str
    samples: int
    gain_alone: float
    nrmse_percent: float
    """Of the range of its position, with the common gain."""
    travel: float


@dataclass(frozen=True)
class ServoGain:
    """A gain for all moves together."""

    gain: float
    unit: str
    lags_s: tuple[float, ...]
    hold: str
    moves: list[Move]
    spread_percent: float
    other_holds: dict[str, float]
    """The gain under the other assumptions about the input between samples."""
    notes: list[str] = field(default_factory=list)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "gain": self.gain, "unit": self.unit, "lags_s": list(self.lags_s), "hold": self.hold,
            "moves": [m._asdict() for m in self.moves], "spread_percent": self.spread_percent,
            "other_holds": self.other_holds, "notes": self.notes,
        }  # fmt: skip


def servo_gain(
    paths: Sequence[str | Path], input: str, position: str, *, time: str = "time", split: str | None = None,
    lags_s: Sequence[float] = (), hold: str = "linear", units: Mapping[str, str] | None = None,
) -> ServoGain:  # fmt: skip
    """One gain for all moves of some files, with each move's own.

    ``units`` by column: of ``time`` (``ms``, ``0.1 s`` for counts of samples), of input and position any with a factor
    before it: ``-190 mm`` multiplies the column by -190.

    Raises:
        DataError: a file that cannot be read, or a move that tells no gain: what :func:`fit_gain` refuses.
        NameUnknown: no such column.
        ValueRefused: no file, a lag that is not above 0, an unknown hold or unit.
    """
    one_of("hold", hold, list(HOLDS))
    said: list[str] = []
    records, names = read_moves(paths, input, position, time=time, split=split, units=units, notes=said)
    fits = {h: fit_gain(records, tuple(lags_s), h) for h in HOLDS}
    fit = fits[hold]  # type: ignore[index]
    moves = [
        Move(name, len(r.time_s), fit.gain_alone[name], fit.nrmse_percent[name], float(r.position[-1]))
        for name, r in records.items()
    ]
    found = ServoGain(
        fit.gain, f"{names[1]}/s" if names[0] == "1" else f"{names[1]}/({names[0]} s)", tuple(lags_s), hold, moves,
        fit.spread_percent, {h: f.gain for h, f in fits.items() if h != hold},
    )  # fmt: skip
    found.notes.extend([*said, *_notes(found)])
    return found


def read_moves(
    paths: Sequence[str | Path], input: str, position: str, *, time: str = "time", split: str | None = None,
    units: Mapping[str, str] | None = None, notes: list[str] | None = None,
) -> tuple[dict[str, Record], tuple[str, str]]:  # fmt: skip
    """Moves by name, each from time 0 and position 0, and the units of input and position; what is odd in ``notes``."""
    if not paths:
        raise ValueRefused("no logs: expected at least one file")
    records: dict[str, Record] = {}
    named = ("1", "1")
    for path in paths:
        columns, those, table = _columns(path, (time, input, position), split, units or {})
        if records and those != named:
            raise DataError(
                f"{path}: {input!r} is in {those[0]} and {position!r} in {those[1]}, in the files before it in "
                f"{named[0]} and {named[1]}; expected the same units in every file (--unit COLUMN=UNIT)"
            )
        named = those
        t, u, x, parts = columns
        names = Names(time, input, position, "", *named, "")
        told = doubles(table.notes, [table.name(n) for n in (time, input, position)])
        edges = [0, *(np.flatnonzero(parts[1:] != parts[:-1]) + 1).tolist(), len(t)]
        for first, last in pairwise(edges):
            label = Path(path).name if split is None else f"{split}={parts[first]:g}"
            if label in records:
                label = f"{Path(path).name}, {label}"
            if label in records:
                raise DataError(f"{path}: the move {label} appears in two places")
            at = slice(first, last)
            told += _odd(f"{path}, {label}" if split else str(path), (t[at], u[at], x[at]), names, table, first)
            records[label] = Record(t[at] - t[first], u[at], x[at] - x[first])
        if notes is not None:
            notes.extend(told)
    return records, named


def _odd(source: str, signals: Sequence[np.ndarray], names: Names, table: Table, first: int) -> list[str]:
    """What is odd about one move; of a short one its clock alone is judged."""
    if len(signals[0]) < 3:
        return []

    def place(k: int) -> str:
        return table.place(first + k)

    stamps = clock(signals[0], place, ())
    try:
        refuse(source, [f for f in stamps.findings if f.kind not in ("unit", "rate")])
        if len(signals[0]) < LONG or not all(np.ptp(v) for v in signals):
            return []
        arrays = dict(zip(("time", "drive", "position"), signals, strict=True))
        return [_here(s) for s in odd(source, arrays, stamps.period, names, place, stamps.findings)]
    except DataError as error:
        raise DataError(_here(str(error))) from None


def _here(sentence: str) -> str:
    """With the options of ``identify servo-gain``, which takes no part of a file."""
    said = sentence.replace("--output", "--position").replace(" with --start and --end", "")
    return re.sub(r"--start (\S+) --end (\S+)", r"\1 to \2 s", said)


def _columns(
    path: str | Path, names: tuple[str, str, str], split: str | None, units: Mapping[str, str]
) -> tuple[list[np.ndarray], tuple[str, str], Table]:
    from leadscrew.logs.read import read_table

    table = read_table(path)
    given = {table.name(header): unit for header, unit in units.items()}
    clocked = table.name(names[0])
    found, said = [table.seconds(clocked, given.get(clocked))], []
    for header in (*names[1:], *([] if split is None else [split])):
        name = table.name(header)
        factor, rest = _factor(given.get(name, table.units.get(name, "")))
        found.append(table.numbers(name) * (factor if header != split else 1.0))
        said.append(rest)
    if split is None:
        found.append(np.zeros(len(found[0])))
    return found, (said[0], said[1]), table


def _factor(unit: str) -> tuple[float, str]:
    first, _, rest = unit.strip().partition(" ")
    try:
        factor = float(first)
    except ValueError:
        return 1.0, unit.strip() or "1"
    if factor == 0.0 or not np.isfinite(factor):
        raise ValueRefused(f"unit {unit!r}: the factor must be a finite number other than 0")
    return factor, rest.strip() or "1"


def _notes(found: ServoGain) -> list[str]:
    said = []
    if found.gain < 0.0:
        said.append("the gain is negative: a positive input moves the position backwards")
    if found.spread_percent > APART:
        said.append(
            f"the moves' own gains differ by {found.spread_percent:.3g} %: the plant is not linear (friction, a "
            "limit), or a lag is wrong"
        )
    apart = max(abs(g / found.gain - 1.0) for g in found.other_holds.values()) * 100.0
    if apart > COARSE:
        said.append(f"what the input did between the samples changes the gain by {apart:.2g} %: sample faster")
    return said
