"""From a log file to the log of an axis: columns by role, units to SI, a part of the time, and all checks."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from leadscrew.kernel import validate
from leadscrew.logs.arrays import AxisLog, LogUnits, checked, screw_force, unlike
from leadscrew.logs.finding import Finding, refuse
from leadscrew.logs.read import read_table
from leadscrew.logs.roles import roles, sized, taken_units
from leadscrew.logs.table import Table
from leadscrew.util.errors import DataError, ValueRefused, entry_point


@dataclass(frozen=True)
class Seen:
    """A log file as it was understood."""

    table: Table
    columns: dict[str, str]
    """Column by role; ``time`` is missing where the period was told."""
    units: dict[str, str]
    """Unit by role, as taken."""
    log: AxisLog | None
    """None where something was refused before a log could be made."""
    findings: list[Finding]


@entry_point
def read_axis_log(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    start: float | None = None,
    end: float | None = None,
    force_per_drive: float | None = None,
    period: float | None = None,
    lead_mm: float | None = None,
    gear: float = 1.0,
) -> AxisLog:
    """The log of one axis from a file, in SI units and evenly sampled.

    ``columns`` names a column of the file by role (time, drive, position, command, velocity); those left out are
    guessed from their names. ``units`` gives the unit by role where the file names none or a wrong one; ``5e-8 m`` is
    that of counts. ``start`` and ``end`` are times of the log in seconds, ``period`` the seconds from row to row of a
    file without times. ``force_per_drive`` is N (N m) for one unit of the drive: it is kept with the log and used to
    check plausibility; the drive itself stays in its own unit. ``lead_mm`` (travel of one revolution of the screw) and
    ``gear`` (revolutions of the motor for one of the screw) make a force of a torque without losses:
    :func:`leadscrew.logs.arrays.screw_force`.

    Raises:
        DataError: the file cannot be read, a column is not recognised, or the log is refused: the first reason.
        ValueRefused: a unit that is not known, or one that does not fit its role.
        NameUnknown: no such column.
    """
    seen = look_at(path, columns, units, start, end, force_per_drive, period, lead_mm=lead_mm, gear=gear)
    refuse(str(path), seen.findings)
    assert seen.log is not None
    return seen.log


@entry_point
def look_at(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    start: float | None = None,
    end: float | None = None,
    force_per_drive: float | None = None,
    period: float | None = None,
    table: Table | None = None,
    lead_mm: float | None = None,
    gear: float = 1.0,
) -> Seen:
    """As :func:`read_axis_log`, with everything that was found; what is refused is among the findings.

    Raises:
        DataError: the file cannot be read, or a column is not recognised.
        ValueRefused: a unit that is not known, or one that does not fit its role.
        NameUnknown: no such column.
    """
    table = read_table(path) if table is None else table
    if period is not None:
        period = validate.positive("period", period, "s")
    if force_per_drive is not None and not abs(validate.number("force_per_drive", force_per_drive, "N")) > 0.0:
        raise ValueRefused(f"force_per_drive = {force_per_drive!r}: must not be 0")
    told = dict(columns or {})
    found = roles(table, told, timed=period is None and ("time" in told or _timed(table)))
    findings: list[Finding] = []
    taken = taken_units(table, found, dict(units or {}), findings)
    findings += _doubles(table, found)
    arrays = _arrays(table, found, taken, table.period if period is None else period)
    kept = _part(arrays["time"], start, end, str(path))
    rows = np.flatnonzero(kept)
    source = str(path) if kept.all() else f"{path} from {arrays['time'][rows[0]]:g} to {arrays['time'][rows[-1]]:g} s"
    lost = [int(np.searchsorted(rows, k)) for k in table.lost if k in rows]
    unit = LogUnits(sized("position", taken["position"])[0], sized("drive", taken["drive"])[0])  # type: ignore[arg-type]
    force_per_drive = screw_force(unit, force_per_drive, lead_mm, gear, str(path))
    if lead_mm is not None:
        said = f"1 {unit.drive} of the drive is {force_per_drive:.6g} N, by a lead of {lead_mm:g} mm and a gear of "
        findings.append(Finding("unit", "note", f"{said}{gear:g}, without losses"))
    elif force_per_drive is None and (said := unlike(unit)):
        findings.append(Finding("unit", "warning", said))
    log, more = checked(
        {role: values[kept] for role, values in arrays.items()}, unit, source, force_per_drive,
        lambda k: table.place(int(rows[k])), lost,
    )  # fmt: skip
    findings += more
    if log is not None:
        log = replace(log, findings=findings)
    return Seen(table, found, taken, log, findings)


def _doubles(table: Table, found: Mapping[str, str]) -> list[Finding]:
    """Which of several columns of one name was taken for a role."""
    findings = []
    for role, name in found.items():
        first = re.sub(r" \(\d+\)$", "", name)
        others = [n for n in (*table.columns, *table.texts) if n != name and re.sub(r" \(\d+\)$", "", n) == first]
        if others and any(f"is a second {first!r}" in note for note in table.notes):
            said = (
                f"the file has {len(others) + 1} columns called {first!r}: {name!r} is taken as the {role}; if it is "
                f"another one, say --column '{role}={others[0]}'"
            )
            findings.append(Finding("columns", "warning", said))
    return findings


def _timed(table: Table) -> bool:
    """Whether time should come from a column: there is one by its name, or nothing else tells it."""
    from leadscrew.logs.roles import candidates

    return table.period is None or "time" in table.guess or bool(candidates(list(table.columns), "time"))


def _arrays(
    table: Table, found: Mapping[str, str], taken: Mapping[str, str], period: float | None
) -> dict[str, np.ndarray]:
    """Signals by role in SI."""
    arrays: dict[str, np.ndarray] = {}
    for role, name in found.items():
        arrays[role] = _values(table, role, name) * sized(role, taken[role])[1]
    if "time" not in found:
        if period is None:
            raise DataError(f"{table.source}: has no column of times and names no period; say --period SECONDS")
        arrays["time"] = table.evenly(period)
    return arrays


def _values(table: Table, role: str, name: str) -> np.ndarray:
    if name in table.columns:
        return table.columns[name]
    words = table.texts[name]
    if role == "time":
        try:
            stamps = np.array([w.replace(" ", "T", 1) for w in words], dtype="datetime64[ns]")
            return (stamps - stamps[0]) / np.timedelta64(1, "s")
        except ValueError:
            pass
    raise DataError(f"{table.source}, column {name!r}: holds words such as {words[0]!r}; the {role} must be numbers")


def _part(time: np.ndarray, start: float | None, end: float | None, source: str) -> np.ndarray:
    kept = np.ones(len(time), dtype=bool)
    for bound, name in ((start, "start"), (end, "end")):
        if bound is not None:
            validate.number(name, bound, "s")
    # A stamp that is no number stays, so that the checks name it.
    if start is not None:
        kept &= ~(time < start - 1e-9)
    if end is not None:
        kept &= ~(time > end + 1e-9)
    if not kept.any():
        raise DataError(
            f"{source}: runs from {time[0]:g} to {time[-1]:g} s; nothing of it lies from "
            f"{time[0] if start is None else start:g} to {time[-1] if end is None else end:g} s"
        )
    return kept
