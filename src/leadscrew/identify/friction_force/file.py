"""The door for logs of a friction force: any table that :func:`leadscrew.logs.read_table` reads."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from leadscrew.identify.friction_force.checks import doubles
from leadscrew.identify.friction_force.record import ForceRecord, force_record
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.kernel.validate import positive
from leadscrew.logs import Table, read_table
from leadscrew.logs.finding import Finding
from leadscrew.logs.header import bare
from leadscrew.logs.units import drive_in, length_in, speed_in

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
        sign: see :func:`~leadscrew.identify.friction_force.record.force_record`.
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
