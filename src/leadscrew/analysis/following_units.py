"""Units of the columns of a following error: everything of an axis in the unit of its command.

A header that names a unit (``X [mm]``) is taken at its word; what the caller tells comes first. Where a column names
none it is taken to be in the unit of the others, as logs of one control are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from leadscrew.analysis.following_odd import Track
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.logs.table import Table
from leadscrew.logs.units import length_in, speed_in, time_in

ROLES = ("time", "position", "command", "actual", "velocity")
"""What a unit is told of; ``position`` is command and actual."""


def checked(told: Mapping[str, str]) -> dict[str, str]:
    """The units by role, each one that is known.

    Raises:
        ValueRefused: no such role or unit.
    """
    for role, unit in told.items():
        if role not in ROLES:
            raise ValueRefused(f"--unit {role}={unit}: allowed are {', '.join(ROLES)}")
        {"time": time_in, "velocity": speed_in}.get(role, length_in)(unit)
    return dict(told)


def in_one_unit(track: Track, names: Mapping[str, str], table: Table, told: Mapping[str, str]) -> Track:
    """The track with actual position and velocities in the unit of the command; ``names``: column by role.

    Raises:
        DataError: units that do not go together.
    """
    units = {role: _unit(table, name, role, told) for role, name in names.items()}
    own = units["command"] or units["actual"]
    if not own:
        return track
    kind, size = length_in(own)
    changed: dict[str, object] = {"unit": own}
    if units["actual"] and length_in(units["actual"])[0] != kind:
        raise DataError(
            f"{table.source}: {names['command']!r} is in {own}, {names['actual']!r} in {units['actual']}; expected "
            "both along or both around: name other columns with --pair, or say --unit position=UNIT"
        )
    scale = length_in(units["actual"])[1] / size if units["actual"] else 1.0
    if scale != 1.0:
        changed["actual"] = scale * track.actual
    for role in ("command_speed", "actual_speed"):
        speed = getattr(track, role)
        if speed is not None and units.get(role):
            way, rate = speed_in(units[role])
            if way == kind and rate != size:
                changed[role] = rate / size * speed
    return replace(track, **changed)  # type: ignore[arg-type]


def _unit(table: Table, name: str, role: str, told: Mapping[str, str]) -> str:
    """As told, or as the header says, where that is a unit of such a column; else nothing."""
    if role.endswith("_speed"):
        return _fits(told.get("velocity") or table.units.get(name, ""), True)
    return told.get(role) or told.get("position") or _fits(table.units.get(name, ""), False)


def _fits(unit: str, speed: bool) -> str:
    try:
        (speed_in if speed else length_in)(unit)
    except ValueRefused:
        return ""
    return unit
