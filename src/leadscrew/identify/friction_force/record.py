"""A measured friction force and the motion that made it, ready to be fitted.

Signs as everywhere in Leadscrew: a positive force resists a positive speed. Friction takes energy out of the motion,
``sum F dx > 0``; a log whose sum is negative has the other sign, and is turned and said to be.

A position that flickers by a count of its encoder would bend bristles that do not move. So up to two counts against
the last direction are no reversal; three are. The speed is the slope over a few samples, so many that one count is 2 %
of the usual speed.

What is odd about the signals of a friction log, by the checks of :mod:`leadscrew.logs`.

Of an axis a top speed above 20 m/s, a travel above 100 m or a period above 0.5 s is refused as a wrong unit. A
tribometer may do that, so here it is said, with the option that mends it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from leadscrew.kernel.validate import positive
from leadscrew.logs import Table, read_table
from leadscrew.logs.finding import Finding
from leadscrew.logs.header import bare
from leadscrew.logs.measure import Motion, motion
from leadscrew.logs.plausible import check_drive, check_units
from leadscrew.logs.sampling import Place, clock
from leadscrew.logs.signals import jumps
from leadscrew.logs.units import drive_in, length_in, speed_in
from leadscrew.util.errors import DataError, ValueRefused

GAP = 1.5
"""Times the usual period that make a gap."""
INERTIA = 0.3
"""Share of the force's variance that a mass must explain for it to be said."""
GAPS = 0.05
"""Share of steps above which uneven times are the way of the log, not gaps."""


def check_time(t: np.ndarray, source: str, place: Place) -> list[Finding]:
    """Passes where times rise; says gaps, and a period that looks like another unit.

    Raises:
        DataError: a time that does not rise.
    """
    steps = np.diff(t)
    seen = clock(t, place)
    back = np.flatnonzero(steps <= 0.0)
    if len(back):
        faults = [f.sentence for f in seen.findings if f.severity == "refused"]
        k = int(back[0])
        plain = f"{place(k + 1)}: the time {t[k + 1]:g} s does not rise above {t[k]:g} s"
        raise DataError(f"{source}: {faults[0] if faults else plain}")
    found = [f._replace(severity="warning") for f in seen.findings if f.kind == "unit"]
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual)
    # an adaptive step differs from sample to sample; a gap is an exception
    if not len(gaps) or len(gaps) > GAPS * len(steps):
        return found
    first, last = int(gaps[0]), int(gaps[-1])
    many = "1 step of time is" if len(gaps) == 1 else f"{len(gaps)} steps of time are"
    return [*found, Finding(
        "gap", "note",
        f"{many} longer than {GAP:g} periods of {usual:g} s (between {t[first]:g} and {t[last + 1]:g} s, the longest "
        f"{steps.max():g} s); every sample is taken with its own step",
    )]  # fmt: skip


def check_motion(
    t: np.ndarray, force: np.ndarray, position: np.ndarray, speed: np.ndarray, unit: str, source: str
) -> list[Finding]:
    """Says speeds and travels that look like another unit.

    Raises:
        DataError: force and position are swapped.
    """
    period = float(np.median(np.diff(t)))
    arrays = {"drive": force, "position": position}
    if any(f.kind == "swapped" for f in check_drive(arrays, motion(position, period), period, unit, None)):
        raise DataError(
            f"{source}: the position looks like a force and the force like a position: the two columns are swapped; "
            "name them with --force NAME --position NAME"
        )
    # Times may be uneven, so the speed is the record's own; its acceleration is not looked at.
    moves = Motion(speed, np.zeros(len(speed)), 0)
    found = [f for f in check_units(position, moves, period, unit) if f.severity == "refused"]
    return [*(f._replace(severity="warning") for f in found), *_mass(t, force, position, period, unit)]


def _mass(t: np.ndarray, force: np.ndarray, position: np.ndarray, period: float, unit: str) -> list[Finding]:
    """A force that is mostly a mass times its acceleration is that of a drive, not of friction."""
    steps = np.diff(t)
    if float(np.ptp(steps)) > 0.1 * period:
        return []
    moves = motion(position, period)
    kept = slice(moves.margin, len(force) - moves.margin or None)
    speed, acceleration = moves.speed[kept], moves.acceleration[kept]
    size = float(np.std(acceleration)) or 1.0
    terms = np.column_stack([np.ones(len(speed)), np.sign(speed), speed / (np.std(speed) or 1.0), acceleration / size])
    spread = float(np.var(force[kept]))
    shares = []
    for count in (3, 4):
        values, *_ = np.linalg.lstsq(terms[:, :count], force[kept], rcond=1e-10)
        shares.append(1.0 - float(np.var(force[kept] - terms[:, :count] @ values)) / spread if spread else 0.0)
    if shares[1] < 0.9 or shares[1] - shares[0] < INERTIA:
        return []
    mass = abs(float(values[3])) / size
    kind = "kg" if unit == "m" else "kg m^2"
    said = (
        f"{100.0 * (shares[1] - shares[0]):.0f} % of the force is that of {mass:.3g} {kind} speeding up: it looks like "
        "the force of a drive, not of friction; leadscrew identify axis takes mass and friction apart"
    )
    return [Finding("mass", "warning", said)]


def doubles(notes: Sequence[str], used: Sequence[str]) -> list[Finding]:
    """What the file says of two columns of one name, where one of them is used."""
    return [
        Finding("columns", "warning", f"{note}; {name!r} was taken")
        for note in notes
        for name in used
        if f"second {name!r}" in note or f"called {name!r}" in note
    ]


LEAST = 50
"""Samples below which nothing is fitted."""
COUNT_IN_SPEED = 0.02
"""Share of the usual speed that one count may be."""
NO_WORK = 0.05
"""Share of ``sum |F dx|`` below which ``sum F dx`` is no work."""


@dataclass(frozen=True)
class ForceRecord:
    """Samples of a friction force."""

    time: np.ndarray
    """s, rising; steps may differ."""
    position: np.ndarray
    """m or rad, from 0 at the first sample; the integral of the speed where only that was logged."""
    travel: np.ndarray
    """m or rad, from the sample before, without flicker of two counts; 0 for the first."""
    speed: np.ndarray
    """m/s or rad/s."""
    force: np.ndarray
    """N or N m; positive against a positive speed."""
    normal: np.ndarray | None
    """N, where it was logged."""
    unit: Literal["m", "rad"]
    source: str
    turned: bool
    """The log had the other sign."""
    encoder_step: float
    """Smallest step of the position; 0 where there is none to be seen."""
    findings: list[Finding] = field(default_factory=list)

    @property
    def force_unit(self) -> str:
        """Of the force."""
        return "N" if self.unit == "m" else "N m"

    @cached_property
    def way(self) -> np.ndarray:
        """Sign of the motion, or of the last one while it rests; 0 before the first."""
        sign = np.sign(self.travel)
        last = np.maximum.accumulate(np.where(sign != 0.0, np.arange(len(sign)), -1))
        return np.where(last >= 0, sign[np.maximum(last, 0)], 0.0)

    @cached_property
    def strokes(self) -> np.ndarray:
        """Number of the stroke of each sample: one more at every reversal."""
        way = self.way
        turned = (way[1:] != way[:-1]) & (way[:-1] != 0.0)
        return np.concatenate([[0], np.cumsum(turned)])

    @cached_property
    def since_reversal(self) -> np.ndarray:
        """Travel since the last reversal, m or rad."""
        total, strokes = np.cumsum(np.abs(self.travel)), self.strokes
        first = np.searchsorted(strokes, np.arange(strokes[-1] + 1))
        before = np.where(first > 0, total[np.maximum(first - 1, 0)], 0.0)
        return total - before[strokes]


def force_record(
    time: np.ndarray, force: np.ndarray, *, position: np.ndarray | None = None, velocity: np.ndarray | None = None,
    normal: np.ndarray | None = None, unit: Literal["m", "rad"] = "m", sign: Literal["auto", 1, -1] = "auto",
    source: str = "arrays",
) -> ForceRecord:  # fmt: skip
    """A record from arrays in SI units; they are not changed.

    Args:
        time: s, rising.
        force: friction force in N (torque in N m where ``unit`` is rad).
        position: m or rad; or
        velocity: m/s or rad/s, or both.
        normal: normal force in N.
        unit: of the position.
        sign: 1 where a positive force resists a positive speed, -1 where it has the other sign; by the work it does.
        source: what a message calls the log.

    Raises:
        DataError: what is wrong with the log, in one sentence.
        ValueRefused: neither position nor velocity, or a sign that is none.
    """
    if position is None and velocity is None:
        raise ValueRefused("position = None, velocity = None: a friction force needs the motion that made it")
    if sign not in ("auto", 1, -1):
        raise ValueRefused(f"sign = {sign!r}: allowed are 'auto', 1 and -1")
    t, f = _row("time", time, source), _row("force", force, source)
    x = None if position is None else _row("position", position, source)
    v = None if velocity is None else _row("velocity", velocity, source)
    n = None if normal is None else _row("normal force", normal, source)
    for name, values in (("force", f), ("position", x), ("velocity", v), ("normal force", n)):
        if values is not None and len(values) != len(t):
            raise DataError(f"{source}: {len(values)} samples of {name}, {len(t)} of time; expected the same number")
    if len(t) < LEAST:
        raise DataError(f"{source}: {len(t)} samples; expected at least {LEAST}")
    findings = check_time(t, source, lambda k: f"sample {k + 1}")
    for name, values in (("force", f), ("position", x), ("velocity", v)):
        if values is not None and np.ptp(values) == 0.0:
            raise DataError(
                f"{source}: the {name} is {values[0]:g} in every sample; expected one that changes: look whether the "
                "right column was named"
            )
    if n is not None:
        n, said = _loaded(n, source)
        findings += said
    if x is None:
        assert v is not None
        x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        step, path = 0.0, x
    else:
        x = x - x[0]
        step = encoder_step(x)
        findings += _jumps(t, x, step, unit)
        path = without_flicker(x, step)
    travel, speed = np.diff(path, prepend=path[0]), slopes(t, path, step) if v is None else v
    findings += check_motion(t, f, x, speed, unit, source)
    work, most = float(np.sum(f * travel)), float(np.sum(np.abs(f * travel)))
    if sign == "auto" and abs(work) < NO_WORK * most:
        raise DataError(
            f"{source}: the force does no work on the motion (sum of F dx is {100.0 * work / most:.2g} % of the sum of "
            "its sizes), so it is no friction; look whether the right columns were named, or give --sign"
        )
    turned = sign == -1 or (sign == "auto" and work < 0.0)
    if turned and sign == "auto":
        findings.append(Finding("sign", "note", "the force drives the motion as it stands: its sign was turned"))
    if not (travel > 0.0).any() or not (travel < 0.0).any():
        raise DataError(f"{source}: moves one way only; expected reversals, for friction differs by direction")
    return ForceRecord(
        t, x, travel, speed, -f if turned else f, n, unit, source, turned, step,
        findings,
    )  # fmt: skip


def _row(name: str, values: np.ndarray, source: str) -> np.ndarray:
    row = np.array(values, dtype=float)
    if row.ndim != 1:
        raise DataError(f"{source}: {name} of shape {row.shape}; expected one row of numbers")
    bad = np.flatnonzero(~np.isfinite(row))
    if len(bad):
        raise DataError(f"{source}: {name}, sample {bad[0] + 1}: {row[bad[0]]} is not a finite number")
    return row


def _jumps(t: np.ndarray, x: np.ndarray, step: float, unit: str) -> list[Finding]:
    found, sizes = jumps(x, float(np.median(np.diff(t))), step, 0.0)
    if not len(found):
        return []
    k = int(np.argmax(np.abs(sizes)))
    return [Finding(
        "jump", "warning",
        f"the position jumps {len(found)} time{'s' if len(found) > 1 else ''}, by {sizes[k]:.3g} {unit} at sample "
        f"{found[k] + 1} ({t[found[k]]:.6g} s): a jump of the encoder bends bristles that did not move; leave it out "
        "with --start and --end",
    )]  # fmt: skip


def _loaded(normal: np.ndarray, source: str) -> tuple[np.ndarray, list[Finding]]:
    """The normal force, positive where it presses."""
    if not normal.any():
        raise DataError(f"{source}: the normal force is 0 in every sample; leave the column out, or name the right one")
    if normal.mean() > 0.0:
        return normal, []
    return -normal, [Finding("normal", "note", "the normal force is negative: its sign was turned")]


def encoder_step(x: np.ndarray) -> float:
    """Step that all differences are multiples of; 0 where there is none."""
    sizes = np.abs(np.diff(x))
    floor = 1e-7 * float(np.ptp(x))
    moved = sizes[sizes > floor]
    if len(moved) < 10:
        return 0.0
    step = float(np.quantile(moved, 0.001))
    least = moved[moved < 1.5 * step]
    step = float(np.median(least))
    counts = np.round(moved / step)
    if counts.max() == 1.0 and float(np.mean(sizes[1:][sizes[:-1] > floor] <= floor)) < 0.1:
        return 0.0  # one step at every sample is a constant speed, not a count
    return step if float(np.mean(np.abs(moved / step - counts) < 0.05)) > 0.99 else 0.0


def without_flicker(x: np.ndarray, step: float) -> np.ndarray:
    """The position, where up to two counts against the last direction are held back until a third one comes."""
    if step <= 0.0:
        return x
    at, way, out = float(x[0]), 0.0, []
    for value in x.tolist():
        change = value - at
        if change * way > 0.0 or abs(change) > 2.5 * step:
            at, way = value, 1.0 if change > 0.0 else -1.0
        out.append(at)
    return np.array(out)


def slopes(t: np.ndarray, x: np.ndarray, step: float) -> np.ndarray:
    """Slope over as many samples as a count needs to be 2 % of the usual speed, at least 3."""
    rates = np.abs(np.diff(x) / np.diff(t))
    moving = rates[rates > 0.0]
    usual = float(np.median(moving)) if len(moving) else 0.0
    period = float(np.median(np.diff(t)))
    wide = 3 if usual == 0.0 else int(np.ceil(step / (COUNT_IN_SPEED * usual * period)))
    half = min(max(1, wide // 2), 25)
    k = np.arange(len(x))
    a, b = np.maximum(k - half, 0), np.minimum(k + half, len(x) - 1)
    return (x[b] - x[a]) / (t[b] - t[a])


NAMES = {
    "time": ("time", "t", "timestamp", "elapsed"),
    "force": ("friction", "friction force", "friction_force", "tangential", "tangential force", "force", "f"),
    "position": ("position", "pos", "x", "displacement", "travel", "stroke"),
    "velocity": ("velocity", "speed", "v"),
    "normal": ("normal", "normal force", "normal_force", "load", "fn", "n"),
}
"""What the columns are usually called, the likeliest first; case does not matter."""
NEEDED = ("time", "force")


def read_force_record(
    path: str | Path, *, columns: Mapping[str, str] | None = None, units: Mapping[str, str] | None = None,
    sign: Literal["auto", 1, -1] = "auto", start: float | None = None, end: float | None = None,
    period: float | None = None,
) -> ForceRecord:  # fmt: skip
    """A friction force and its motion from a file.

    Args:
        path: CSV, TSV, white space, Parquet, MATLAB, or a folder of ``leadscrew simulate --out``.
        columns: header by role (``time``, ``force``, ``position``, ``velocity``, ``normal``), where it is not a usual
            name.
        units: unit by role, where the header says none; SI unless said.
        sign: see :func:`force_record`.
        start: s; earlier samples are left out.
        end: s; later samples are left out.
        period: s from row to row, for a file without times.

    Raises:
        DataError: what is wrong with the file, in one sentence.
        ValueRefused: no such role or unit.
        NameUnknown: no such column.
    """
    columns, units = dict(columns or {}), dict(units or {})
    for given in (columns, units):
        for role in given:
            if role not in NAMES:
                raise ValueRefused(f"{role} = {given[role]!r}: allowed are {', '.join(NAMES)}")
    table = read_table(path)
    if period is not None:
        positive("period", period, "s")
        if "time" in columns:
            raise ValueRefused(f"period = {period:g} s, and a column of times, {columns['time']!r}: give one of them")
    timed = period is None
    names = {role: _column(table, role, columns.get(role)) for role in NAMES if timed or role != "time"}
    if names["position"] is None and names["velocity"] is None:
        raise DataError(
            f"{table.source}: no column is the position or the velocity (there are {_there(table)}); name one with "
            "--position or --velocity"
        )
    said = {role: units.get(role) or table.units.get(name, "") for role, name in names.items() if name is not None}
    unit = _unit(table.source, said, names)
    read = {role: table.numbers(name) for role, name in names.items() if name is not None}
    t = table.evenly(period) if period is not None else table.seconds(names["time"] or "", units.get("time"))
    kept = np.ones(len(t), dtype=bool)
    if start is not None:
        kept &= t >= start
    if end is not None:
        kept &= t <= end
    if not kept.any():
        raise DataError(
            f"{table.source}: runs from {t[0]:g} to {t[-1]:g} s; nothing of it lies from "
            f"{t[0] if start is None else start:g} to {t[-1] if end is None else end:g} s"
        )
    size = _sizes(said, unit)
    made = {role: values[kept] * size[role] for role, values in read.items() if role != "time"}
    record = force_record(
        t[kept], made["force"], position=made.get("position"), velocity=made.get("velocity"),
        normal=made.get("normal"), unit=unit, sign=sign, source=table.source,
    )  # fmt: skip
    shown = ", ".join(f"{role} {name!r} in {said[role] or _SI[role][unit]}" for role, name in names.items() if name)
    record.findings[:0] = [Finding("columns", "note", shown), *doubles(table.notes, [n for n in names.values() if n])]
    return record


_SI = {
    "time": {"m": "s", "rad": "s"}, "force": {"m": "N", "rad": "N m"}, "position": {"m": "m", "rad": "rad"},
    "velocity": {"m": "m/s", "rad": "rad/s"}, "normal": {"m": "N", "rad": "N"},
}  # fmt: skip


def _column(table: Table, role: str, asked: str | None) -> str | None:
    if asked is not None:
        return table.name(asked)
    plain = {bare(name).casefold(): name for name in reversed(list(table.columns))}
    found = next((plain[word] for word in NAMES[role] if word in plain), None)
    if found is None and role in NEEDED:
        raise DataError(
            f"{table.source}: no column is the {role} (there are {_there(table)}); name it with --{role} COLUMN"
            + (", or say how far apart the rows are with --period SECONDS" if role == "time" else "")
        )
    return found


def _there(table: Table) -> str:
    return ", ".join(map(repr, table.columns))


def _unit(source: str, said: Mapping[str, str], names: Mapping[str, str | None]) -> Literal["m", "rad"]:
    """Metres or radians, from whatever names a unit."""
    kinds: dict[str, str] = {}
    if said.get("position"):
        kinds["position"] = length_in(said["position"])[0]
    if said.get("velocity"):
        kinds["velocity"] = speed_in(said["velocity"])[0]
    if said["force"]:
        kept = drive_in(said["force"])[0]
        if kept not in ("N", "N m"):
            raise ValueRefused(
                f"{source}: the column {names['force']!r} is in {said['force']}; a friction force is in N or N m"
            )
        kinds["force"] = "m" if kept == "N" else "rad"
    if len(set(kinds.values())) > 1:
        shown = ", ".join(f"{role} in {said[role]}" for role in kinds)
        raise ValueRefused(f"{source}: {shown} do not go together; a force in N needs lengths, a torque in N m angles")
    return "rad" if "rad" in kinds.values() else "m"


def _sizes(said: Mapping[str, str], unit: Literal["m", "rad"]) -> dict[str, float]:
    size = {"force": drive_in(said["force"])[1] if said["force"] else 1.0}
    if "position" in said:
        size["position"] = length_in(said["position"])[1] if said["position"] else 1.0
    if "velocity" in said:
        size["velocity"] = speed_in(said["velocity"])[1] if said["velocity"] else 1.0
    if "normal" in said:
        kept, factor = drive_in(said["normal"] or "N")
        if kept != "N":
            raise ValueRefused(f"the normal force is in {said['normal']}; expected N, mN, uN or kN")
        size["normal"] = factor
    return size
