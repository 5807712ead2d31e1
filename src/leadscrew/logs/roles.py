"""Which column of a table is time, drive, position, command and velocity, guessed from its name or as told.

A name counts as a whole (``qm`` is a position) or by its words (``X1_ActualPosition``: actual, position). Words of the
drive count first (``CurrentFeedback`` drives), then those of velocity, then those of a command, then those of a
position. Where no name says it, the one column whose unit fits does (``x (mm)``, ``F [N]``). What is ambiguous is
refused, never chosen by its place in the file.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from leadscrew.kernel import validate
from leadscrew.logs import units as unit_names
from leadscrew.logs.finding import Finding
from leadscrew.logs.header import sized, split
from leadscrew.logs.table import Table
from leadscrew.logs.units import DRIVES, LENGTHS, plain
from leadscrew.util.errors import DataError, ValueRefused

ROLES = ("time", "drive", "position", "command", "velocity")
NEEDED = ("drive", "position")

WHOLE = {
    "time": "t time timestamp seconds sec zeit tijd temps clock elapsed x_value sample",
    "drive": "u vir torque drive output force current effort tau i iq i_q im motor_current motor_torque control pwm "
    "duty torque_command torque_cmd force_command voltage control_output controller_output pid_output load_torque",
    "position": "position pos qm q feedback fb actual actual_position position_actual actpos act_pos measured y theta "
    "angle encoder pos_fb position_fb posfb motor_pos_fb x_actual ist istposition lage lageistwert displacement",
    "command": "command cmd qg reference ref setpoint set_point target desired position_command pos_cmd position_cmd "
    "commanded qd q_ref r soll sollposition lagesollwert pos_ref position_reference target_position",
    "velocity": "velocity vel speed v omega dq qdot actual_velocity velocity_actual vel_fb",
}  # fmt: skip
"""Names that mean one thing as a whole, in lower case with underscores between their words."""

WORDS = {
    "drive": "torque force current voltage effort output drive tau pwm duty strom kraft moment",
    "velocity": "velocity vel speed geschwindigkeit",
    "command": "command cmd commanded reference ref setpoint target desired soll sollwert",
    "position": "position pos feedback fb actual measured encoder angle displacement lage istwert",
    "time": "time timestamp zeit",
}
_NONE = (
    "acceleration accel acc jerk error err deviation disturbance normal temperature temp power bus limit enable "
    "enabled fault status state mode feedrate number sequence inertia noise true"
)
OTHER = frozenset(_NONE.split(" "))
"""Words of columns that are none of the roles."""

_WHOLE = {name: role for role, names in WHOLE.items() for name in names.split()}
_WORDS = {role: frozenset(words.split()) for role, words in WORDS.items()}
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")


def words_of(name: str) -> list[str]:
    """The words of a column's name in lower case, without its unit."""
    spaced = _CAMEL.sub(" ", split(name)[0])
    return [w for w in re.split(r"[^0-9A-Za-z\u00c0-\u024f]+", spaced.casefold()) if w]


def role_of(name: str) -> tuple[str, int] | None:
    """Role of a column by its name, and 0 where the whole name says it, 1 where one of its words does."""
    words = words_of(name)
    if (role := _WHOLE.get("_".join(words))) is not None:
        return role, 0
    if OTHER.intersection(words):
        return None
    for role, known in _WORDS.items():
        if known.intersection(words):
            if role == "velocity" and _WORDS["command"].intersection(words):
                return None
            return role, 1
    # A field of a structure, such as log.u.
    role = _WHOLE.get("_".join(words_of(name.rpartition(".")[2])))
    return None if role is None else (role, 1)


def roles(table: Table, told: Mapping[str, str] | None = None, timed: bool = True) -> dict[str, str]:
    """Column by role: as told, as the form of the file says, or guessed; time only where ``timed``.

    Raises:
        ValueRefused: a role that there is not, or one column for two roles.
        NameUnknown: no such column.
        DataError: drive, position or time cannot be told, or several columns fit: they are named.
    """
    told = dict(told or {})
    for role in told:
        validate.one_of("role", role, list(ROLES))
    found = {role: table.name(name) for role, name in told.items()}
    free = [name for name in table.columns if name not in found.values()]
    for role in ROLES:
        if role in found or (role == "time" and not timed):
            continue
        if (settled := table.guess.get(role)) in free and settled is not None:
            found[role] = settled
        elif name := _guessed(table, role, free, list(found.values())):
            found[role] = name
    _once(found, table.source)
    return found


def candidates(names: Sequence[str], role: str) -> list[str]:
    """Columns whose names fit a role best."""
    ranked = [(at[1], name) for name in names if (at := role_of(name)) is not None and at[0] == role]
    best = min((rank for rank, _ in ranked), default=0)
    return [name for rank, name in ranked if rank == best]


def _guessed(table: Table, role: str, free: Sequence[str], taken: Sequence[str]) -> str | None:
    fits = candidates(free, role)
    if len(fits) > 1 and taken:
        # One axis of several: X1_CurrentFeedback goes with X1_ActualPosition.
        first = {words_of(name)[:1][0] for name in taken if words_of(name)}
        fits = [name for name in fits if words_of(name)[:1] and words_of(name)[0] in first] or fits
    if len(fits) == 1:
        return fits[0]
    if role not in NEEDED and (role != "time" or not fits):
        return None
    if not fits and role in NEEDED:
        fits = by_unit(table, role, free)
        if len(fits) == 1:
            return fits[0]
    raise DataError(f"{table.source}: {_asked(table, role, fits, free)}")


def by_unit(table: Table, role: str, free: Sequence[str]) -> list[str]:
    """Columns that change, with a name that says nothing and a unit that fits the drive or the position."""
    fits = []
    for name in free:
        unit = plain(table.units.get(name, ""))
        # Shares are no drives for sure.
        known = unit in LENGTHS if role == "position" else unit in DRIVES and unit not in ("%", "1")
        said = role_of(name) is not None or OTHER.intersection(words_of(name))
        if known and not said and np.ptp(table.columns[name]):
            fits.append(name)
    return fits


def _asked(table: Table, role: str, fits: Sequence[str], free: Sequence[str]) -> str:
    """What is not clear, and how to say it."""
    if fits:
        return (
            f"{len(fits)} columns could be the {role}: {_listed(fits)}; name it, for example {_option(role, fits[0])}"
        )
    if free and all(re.fullmatch(r"c\d+", name) for name in table.columns):
        return f"no header names the columns {_listed(list(table.columns))}: name them, for example {_named(table)}"
    likely = [n for n in free if role_of(n) is None and not _runs(table.columns[n]) and np.ptp(table.columns[n])]
    return (
        f"no column is the {role} by its name; there are {_listed(list(table.columns))}; name it, for example "
        + _option(role, (likely or list(free) or ["NAME"])[0])
    )


def _named(table: Table) -> str:
    """Options for a table without a header: what runs on is time, what is smoothest position, the rest the drive."""
    moving = {n: x for n, x in table.columns.items() if np.ptp(x) > 0.0}
    time = next((n for n, x in moving.items() if _runs(x)), None)
    smooth = sorted(
        (n for n in moving if n != time), key=lambda n: float(np.std(np.diff(moving[n])) / np.ptp(moving[n]))
    )
    told = [] if time is None else [_option("time", time)]
    if time is not None and np.all(np.diff(moving[time]) == 1.0):
        told.append("--unit 'time=0.001 s'")
    if len(smooth) < 2:
        return " ".join([*told, "--column position=NAME --column drive=NAME"])
    return " ".join([*told, _option("position", smooth[0]), _option("drive", smooth[-1])])


def _runs(values: np.ndarray) -> bool:
    """Whether it only rises, as times and numbers of samples do."""
    return len(values) > 1 and bool(np.all(np.diff(values) > 0.0))


def _option(role: str, name: str) -> str:
    told = f"{role}={name}"
    return f"--column '{told}'" if re.search(r"[^\w=.\-]", told) else f"--column {told}"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")


def _once(found: Mapping[str, str], source: str) -> None:
    names = list(found.values())
    for role, name in found.items():
        if names.count(name) > 1:
            both = " and ".join(r for r, n in found.items() if n == name)
            raise ValueRefused(f"{source}: the column {name!r} is named for {both}; expected another one for {role}")


SI = {"time": "s", "drive": "1", "position": "m", "command": "m", "velocity": "m/s"}
"""What is taken where neither the file nor the caller names a unit; the log then says so."""


def taken_units(
    table: Table, found: Mapping[str, str], told: dict[str, str], findings: list[Finding]
) -> dict[str, str]:
    """Unit by role: as told, as the file says, as the position has it, or SI, which is said in ``findings``.

    Raises:
        ValueRefused: a unit that is not known or does not fit its role, or is told for a role that the log has not.
    """
    for role in told:
        validate.one_of("role", role, list(ROLES))
    taken: dict[str, str] = {}
    for role in ROLES:
        if role not in found:
            if role in told:
                raise ValueRefused(f"--unit {role}={told[role]}: the log has no {role}")
            continue
        if role in told:
            taken[role] = told[role]
        elif named := table.unit_of(found[role], role):
            taken[role] = named
        else:
            taken[role] = _assumed(role, taken, found[role], findings)
        try:
            sized(role, taken[role])
        except ValueRefused as error:
            raise ValueRefused(f"{table.source}, column {found[role]!r}: {error}") from None
    _same_kind(table, taken)
    return taken


def _assumed(role: str, taken: Mapping[str, str], column: str, findings: list[Finding]) -> str:
    if role == "command":
        return taken["position"]
    if role == "velocity":
        return f"{unit_names.length_in(taken['position'])[1]:.17g} {unit_names.length_in(taken['position'])[0]}/s"
    said = "its own unit" if role == "drive" else SI[role]
    findings.append(
        Finding("unit", "note", f"column {column!r} names no unit: taken as {said}; if not, say --unit {role}=UNIT")
    )
    return SI[role]


def _same_kind(table: Table, taken: Mapping[str, str]) -> None:
    for role in ("command", "velocity"):
        if role in taken and sized(role, taken[role])[0] != sized("position", taken["position"])[0]:
            raise ValueRefused(
                f"{table.source}: the position is in {taken['position']}, the {role} in {taken[role]}; expected both "
                f"along or both around: leave the {role} out, or say --unit {role}=UNIT"
            )
