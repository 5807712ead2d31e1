"""The unit of every role of a log: as told, as the file names it, or as it must be."""

from __future__ import annotations

from collections.abc import Mapping

from leadscrew.kernel import door
from leadscrew.kernel.errors import ValueRefused
from leadscrew.logs import units as unit_names
from leadscrew.logs.finding import Finding
from leadscrew.logs.header import sized
from leadscrew.logs.roles import ROLES
from leadscrew.logs.table import Table

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
        door.one_of("role", role, list(ROLES))
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
