"""What is odd about the signals of a linear fit, by the checks of :mod:`leadscrew.logs`.

An output in a unit of length or angle is taken for the position of an axis: its units, its encoder and its standstill
are judged as those of any log of an axis. Of another output (a speed, a temperature) only what holds for every signal
is said. Two things that are refused of an axis are only said here, since the system may be another one: a long period
(a machine warms up in hours), and a jump (a fast stage); a jump that a step of the input comes before is an answer.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.escape import shell
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.logs.finding import Finding, refuse
from leadscrew.logs.measure import beyond_step, encoder_step, noise
from leadscrew.logs.sampling import Place
from leadscrew.logs.units import drive_in, length_in

if TYPE_CHECKING:
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
    from leadscrew.logs.jumps import jumps

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


def columns_of(table: Table, told: Mapping[str, str | None], timed: bool) -> dict[str, str]:
    """Columns of drive, position and time: as told, or by their names; no time where the file needs none.

    Raises:
        NameUnknown: no such column.
        ValueRefused: one column for two signals.
        DataError: one cannot be told; the options of ``identify linear`` are named.
    """
    from leadscrew.logs.roles import candidates, roles

    named = {role: table.name(name) for role, name in told.items() if name is not None}
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
