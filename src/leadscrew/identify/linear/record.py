"""Input and output of a linear system from arrays or from two columns of a log, checked before anything is fitted.

What is odd about the signals of a linear fit, by the checks of :mod:`leadscrew.logs`.

An output in a unit of length or angle is taken for the position of an axis: its units, its encoder and its standstill
are judged as those of any log of an axis. Of another output (a speed, a temperature) only what holds for every signal
is said. Two things that are refused of an axis are only said here, since the system may be another one: a long period
(a machine warms up in hours), and a jump (a fast stage); a jump that a step of the input comes before is an answer.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.logs.finding import Finding, refuse
from leadscrew.logs.measure import beyond_step, encoder_step, noise
from leadscrew.logs.sampling import Place
from leadscrew.logs.units import drive_in, length_in
from leadscrew.util.errors import DataError, ValueRefused
from leadscrew.util.escape import shell

if TYPE_CHECKING:
    from leadscrew.logs.finding import Finding
    from leadscrew.logs.table import Table


STEP = 0.05
"""Share of its range by which the input changes where it steps."""
SOON = 20
"""Samples in which an output answers a step of the input."""
OPTIONS = {"drive": "--input", "position": "--output", "command": "--command", "time": "--time"}


class Names(NamedTuple):
    """Columns and units as the user knows them; a unit is empty where it is not known."""

    time: str
    drive: str
    position: str
    command: str
    drive_unit: str
    position_unit: str
    command_unit: str


def odd(
    source: str, arrays: Mapping[str, np.ndarray], period: float, names: Names, place: Place, clocked: Sequence[Finding]
) -> list[str]:
    """Sentences on what is odd; ``arrays`` by role: time, drive, position, command, each in its own unit.

    ``clocked`` are the findings on the clock, of which nothing is to be refused.

    Raises:
        DataError: the output stands still, moves as no axis can, or stands in the input's place.
    """
    kind = length(names.position_unit)[0]
    found = _axis(arrays, period, names, place) if kind else _any(arrays, names, place)
    known = {f.sentence for f in clocked}
    unlike = () if kind or names.position_unit == "1" else ("unit", "rate")
    clocks = [f for f in clocked if f.kind not in unlike]
    signals = [f for f in found if f.sentence not in known]
    said = [f._replace(sentence=_asked(f.sentence, names, bool(kind))) for f in (*clocks, *signals)]
    refuse(source, [f for f in said[len(clocks) :] if f.kind != "jump"])
    return [f.sentence for f in said]


def measured(output: np.ndarray) -> tuple[float, float]:
    """The grid that an output lies on, 0 for none, and its noise besides, both in its unit."""
    step = encoder_step(output)
    return step, beyond_step(noise(output, step), step)


def length(unit: str) -> tuple[str, float]:
    """``m`` or ``rad`` and the size in it of a unit of length or angle; an empty kind for any other."""
    try:
        return length_in(unit)
    except ValueRefused:
        return "", 1.0


def _any(arrays: Mapping[str, np.ndarray], names: Names, place: Place) -> list[Finding]:
    from leadscrew.logs.signals import STANDS, check_clipped

    found, output = check_clipped(arrays["drive"], arrays["time"], place), arrays["position"]
    step = encoder_step(output)
    if 0.0 < np.ptp(output) <= STANDS * step:
        said = f"{names.position} moves by {np.ptp(output):.3g} in all, {round(np.ptp(output) / step)} of its counts"
        found.append(Finding("standstill", "warning", f"{said}: what is fitted is little but rounding"))
    return found


def _axis(arrays: Mapping[str, np.ndarray], period: float, names: Names, place: Place) -> list[Finding]:
    """Of a position, as :func:`leadscrew.logs.arrays.checked` finds it."""
    from leadscrew.logs.arrays import LogUnits, checked

    kind, scale = length(names.position_unit)
    force, size = _drive(names.drive_unit)
    si = {"time": arrays["time"], "drive": arrays["drive"] * size, "position": arrays["position"] * scale}
    if "command" in arrays and length(names.command_unit)[0] == kind:
        si["command"] = arrays["command"] * length(names.command_unit)[1]
    unit = LogUnits("rad" if kind == "rad" else "m", force)
    found = checked(si, unit, "", None, place)[1]
    # Of an input that is a position itself, or a command of speed, the force says nothing.
    left_out = {"sign", "rows"} | ({"swapped"} if length(names.drive_unit)[0] else set())
    if any(f.kind == "jump" for f in found) and _answered(si["drive"], si["position"], period):
        left_out.add("jump")
    return [f for f in found if f.kind not in left_out]


def _drive(unit: str) -> tuple[str, float]:
    try:
        return drive_in(unit)
    except ValueRefused:
        return unit, 1.0


def _answered(drive: np.ndarray, position: np.ndarray, period: float) -> bool:
    """Whether a step of the input comes before every jump, and most steps have one."""
    from leadscrew.logs.signals import jumps

    step = encoder_step(position)
    at = jumps(position, period, step, noise(position, step))[0]
    steps = np.flatnonzero(np.abs(np.diff(drive)) > STEP * np.ptp(drive))
    return len(steps) < 2 * len(at) and all(bool(np.any((steps < k) & (steps >= k - SOON))) for k in at)


def _asked(sentence: str, names: Names, axis: bool) -> str:
    """The sentence with the options of ``identify linear``, and the input for a drive that is none."""

    def unit(found: re.Match[str]) -> str:
        return f"--unit {shell(f'{getattr(names, found[1])}={found[2] or found[3]}')}"

    sentence = re.sub(r", or the force of one unit of the drive \(--force-per-drive\)", "", sentence)
    said = re.sub(r"--unit (time|drive|position|command)=(?:'([^']+)'|([A-Za-z]+))", unit, sentence)
    said = re.sub(r"--column (time|drive|position|command)=NAME", lambda m: f"{OPTIONS[m[1]]} NAME", said)
    return said if axis else said.replace("the drive", "the input")


def columns_of(table: Table, chosen: Mapping[str, str | None], timed: bool) -> dict[str, str]:
    """Columns of drive, position and time: as chosen, or by their names; no time where the file needs none.

    Raises:
        NameUnknown: no such column.
        ValueRefused: one column for two signals.
        DataError: one is not recognised; the options of ``identify linear`` are named.
    """
    from leadscrew.logs.roles import candidates, roles

    named = {role: table.name(name) for role, name in chosen.items() if name is not None}
    if len(named) == 3 or len(set(named.values())) < len(named):
        return named
    clocked = "time" in named or "time" in table.guess or bool(candidates(list(table.columns), "time"))
    try:
        found = roles(table, named, timed=timed and (table.period is None or clocked))
    except DataError as error:
        option = re.sub(
            r"--column (?:'(drive|position|time)=([^']*)'|(drive|position|time)=(\S+))",
            lambda m: f"{OPTIONS[m[1] or m[3]]} {shell(m[2] or m[4])}",
            str(error),
        )
        raise DataError(option) from None
    return {role: found[role] for role in ("drive", "position", "time") if role in found}


def doubles(notes: Sequence[str], used: Sequence[str]) -> list[str]:
    """What the file says of two columns of one name, where one of them is used."""
    return [n for n in notes if any(f"second {name!r}" in n or f"called {name!r}" in n for name in used)]


LEAST = 60
"""Samples below which no order can be chosen."""
SAME = 1e-9
"""Share of its range by which an output that is its input differs from it."""


@dataclass(frozen=True)
class LinearRecord:
    """Evenly sampled signals of equal length, read-only, each in its own unit."""

    time: np.ndarray
    """s."""
    input: np.ndarray
    """Held from sample to sample."""
    output: np.ndarray
    command: np.ndarray | None
    """The command of the loop, where the log is from a closed loop and has it."""
    period: float
    input_name: str = "input"
    output_name: str = "output"
    input_unit: str = "1"
    output_unit: str = "1"
    source: str = "arrays"
    notes: list[str] = field(default_factory=list)
    resolution: float = 0.0
    """Grid that the output lies on, in its unit; 0 for none."""
    noise: float = 0.0
    """Of the output besides its rounding, root mean square."""


def linear_record(
    time: Any, input: Any, output: Any, command: Any = None, *, input_name: str = "input", output_name: str = "output",
    input_unit: str = "1", output_unit: str = "1", source: str = "arrays",
    place: Callable[[int], str] = lambda k: f"sample {k + 1}", lost: Sequence[int] = (), command_unit: str = "",
    time_name: str = "time", command_name: str = "command",
) -> LinearRecord:  # fmt: skip
    """A record from arrays, which are copied and never changed; ``time`` in s.

    ``place`` says where a sample stands, ``lost`` are the samples before which the recorder lost some. Units are used
    to judge whether an output that is a position can be one (:mod:`leadscrew.identify.linear.record`).

    Raises:
        DataError: lengths that differ, fewer than 60 samples, a value that is no finite number, times that are not
            even, an input or output that never moves, an output that is its input, or a position that no axis can have.
    """
    given = {"time": time, input_name: input, output_name: output}
    if command is not None:
        given["command"] = command
    arrays = {name: _copied(source, name, values) for name, values in given.items()}
    if len({len(v) for v in arrays.values()}) > 1:
        sizes = ", ".join(f"{name} {len(v)}" for name, v in arrays.items())
        raise DataError(f"{source}: the signals have unequal lengths: {sizes}")
    if len(arrays["time"]) < LEAST:
        raise DataError(
            f"{source}: {len(arrays['time'])} samples; a transfer function needs at least {LEAST}, better hundreds"
        )
    stamps = arrays["time"]
    names = Names(time_name, input_name, output_name, command_name, input_unit, output_unit, command_unit)
    even, period, scattered, clocked = _even(stamps, source, place, lost)
    u, y = arrays[input_name], arrays[output_name]
    _moving(source, (("input", input_name, u), ("output", output_name, y)))
    roles = {"time": stamps, "drive": u, "position": y} | ({} if command is None else {"command": arrays["command"]})
    notes = odd(source, roles, period, names, place, clocked)
    resolution, rms = measured(y)
    if scattered:
        arrays = {name: _on(stamps, even, v, name == input_name) for name, v in arrays.items()}
    return LinearRecord(
        even, arrays[input_name], arrays[output_name], arrays.get("command"), period, input_name, output_name,
        input_unit, output_unit, source, notes, resolution, rms,
    )  # fmt: skip


def _moving(source: str, named: tuple[tuple[str, str, np.ndarray], ...]) -> None:
    for what, name, values in named:
        if np.ptp(values) == 0.0:
            raise DataError(
                f"{source}: the {what} {name} is {values[0] + 0.0:g} from first to last sample: what never changes "
                "tells no transfer function; log a move"
            )
    (_, first, u), (_, second, y) = named
    if np.max(np.abs((y - y[0]) - (u - u[0]))) <= SAME * np.ptp(u):
        raise DataError(f"{source}: {second} is {first}: name two different signals")


def read_linear(
    path: str | Path, input: str | None = None, output: str | None = None, command: str | None = None, *,
    time: str | None = None, units: dict[str, str] | None = None, start: float | None = None, end: float | None = None,
    period: float | None = None,
) -> LinearRecord:  # fmt: skip
    """A record from the columns of a log (CSV, TSV, Parquet, MATLAB, halscope, a run's folder), from start to end in s.

    Input, output and time that are not named are the drive, the position and the time that
    :mod:`leadscrew.logs.roles` tells by their names. ``units`` overrides what a header says, by column; the unit of
    ``time`` is used, those of the others are kept. ``period`` are the seconds from row to row of a file without times.

    Raises:
        DataError: the file cannot be read, or what :func:`linear_record` refuses; the first bad row is named.
        NameUnknown: no such column.
        ValueRefused: one column for two signals, a part without samples.
    """
    from leadscrew.logs.header import bare
    from leadscrew.logs.read import read_table
    from leadscrew.logs.units import plain

    table = read_table(path)
    asked = columns_of(table, {"drive": input, "position": output, "time": time}, timed=period is None)
    clock = asked.pop("time", "")
    asked |= {} if command is None else {"command": command}
    names = {role: table.name(header) for role, header in asked.items()}
    if len(set(names.values())) < len(names):
        raise ValueRefused(
            f"{path}: input, output and command must be different columns, got {', '.join(asked.values())}"
        )
    given = {table.name(header): unit for header, unit in (units or {}).items()}
    named = {**table.units, **given}
    seconds = _seconds(table, clock, given.get(clock), period)
    kept = ~(seconds < (-np.inf if start is None else start)) & ~(seconds > (np.inf if end is None else end))
    if kept.sum() < 2:
        raise ValueRefused(
            f"{path}: runs from {seconds[0]:g} to {seconds[-1]:g} s; nothing of it lies from "
            f"{seconds[0] if start is None else start:g} to {seconds[-1] if end is None else end:g} s"
        )
    columns = {role: table.numbers(name, kept) for role, name in names.items()}
    unit = {role: plain(named.get(name, "1")) for role, name in names.items()}
    rows = np.flatnonzero(kept)
    lost = [at for at, row in enumerate(rows) if at and int(row) in set(table.lost)]
    record = linear_record(
        seconds[kept], columns["drive"][kept], columns["position"][kept],
        columns["command"][kept] if command is not None else None, input_name=bare(names["drive"]),
        output_name=bare(names["position"]), input_unit=unit["drive"], output_unit=unit["position"], source=str(path),
        place=lambda k: table.place(int(rows[k])), lost=lost, time_name=bare(clock) or "time",
        command_unit=plain(named.get(names.get("command", ""), "")), command_name=bare(names.get("command", "command")),
    )  # fmt: skip
    record.notes.extend(doubles(table.notes, list(names.values())))
    return record


def _seconds(table: Any, clock: str, unit: str | None, period: float | None) -> np.ndarray:
    from leadscrew.kernel.validate import positive

    if clock:
        return table.seconds(clock, unit, np.zeros(table.rows, dtype=bool))
    step = table.period if period is None else positive("period", period, "s")
    if step is None:
        raise DataError(f"{table.source}: has no column of times and names no period; say --period SECONDS")
    return np.asarray(table.evenly(step))


def _copied(source: str, name: str, values: Any) -> np.ndarray:
    try:
        found = np.array(values, dtype=float).reshape(-1)
    except (TypeError, ValueError):
        raise DataError(f"{source}: {name} is not an array of numbers") from None
    bad = np.flatnonzero(~np.isfinite(found))
    if len(bad):
        raise DataError(f"{source}: {name}, sample {bad[0] + 1}, is {found[bad[0]]}: expected finite numbers")
    found.flags.writeable = False
    return found


def _even(
    time: np.ndarray, source: str, place: Callable[[int], str], lost: Sequence[int]
) -> tuple[np.ndarray, float, bool, list[Finding]]:
    """The even clock, its period, whether values must be brought onto it, and what is odd but not refused about it."""
    from leadscrew.logs.finding import refuse
    from leadscrew.logs.sampling import clock

    found = clock(time, place, lost)
    refuse(source, [f for f in found.findings if f.kind not in ("unit", "rate")])
    if found.time is None:
        raise DataError(f"{source}: the samples are not evenly spaced in time")
    return found.time, found.period, found.scattered, found.findings


def _on(stamps: np.ndarray, grid: np.ndarray, values: np.ndarray, held: bool) -> np.ndarray:
    from leadscrew.logs.sampling import on_grid

    found = on_grid(stamps, grid, values, held)
    found.flags.writeable = False
    return found
