"""A machine file: an axis as it was identified, in TOML; a name wherever a study is named.

::

    schema_version = 1
    kind = "machine"
    name = "emps"
    model = "servo_axis"                # servo_axis, servo_axis_lugre or linear
    position_unit = "mm"                # of everything that is shown, commanded and limited
    drive_unit = "V"
    period = 0.001                      # of the control, s
    delay_s = 0.0                       # from the output to its act
    resolution = 1e-4                   # of the encoder, in position_unit; 0: the position itself
    noise = 0.0                         # of a reading, standard deviation

    [limits]                            # what the log has shown that the axis bears; in position_unit and drive_unit
    drive = 10.0
    speed = 127.0
    acceleration = 900.0
    travel = [0.0, 246.0]

    [set]                               # parameters of the plant, SI: kg, N, m (or kg m^2, N m, rad)
    mass = 95.1

    [interval]                          # 95 % intervals of those that the log tells
    mass = [94.8, 95.4]

    [cascade]                           # the controller that made the log, if it is known: kp 1/s, kv drive s/mm
    kp = 160.18
    kv = 0.24345

    [log]                               # the log, if its command is to be asked for again: scenario "log"
    file = "emps.mat"                   # beside this file
    sha256 = "9f2b..."
    columns.command = "qg"              # as identify axis was told: columns, units, start, end, period

    [identified]                        # where it comes from; nothing of it changes the machine

A linear machine has ``numerator`` and ``denominator`` (lists, highest power first, drive to position) in ``[set]``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from leadscrew import toml_file
from leadscrew.kernel.parameters import nearest
from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import DataError, ValueRefused, entry_point
from leadscrew.util.escape import checked_line

LONGEST_NAME = 100
SCHEMA_VERSION = 1
KIND = "machine"
MODELS = ("servo_axis", "servo_axis_lugre", "linear")
NUMBERS = {"period": (1e-6, 1.0), "delay_s": (0.0, 1.0), "resolution": (0.0, 1e3), "noise": (0.0, 1e3)}
"""Ranges; a period of 0 is none."""
LIMITS = ("drive", "speed", "acceleration")
CASCADE = ("kp", "kv", "ki")
LOG = ("file", "sha256", "columns", "units", "start", "end", "period")


@dataclass(frozen=True)
class MachineFile:
    """What stands in the file."""

    name: str
    model: str
    position_unit: str
    drive_unit: str
    period: float
    drive: float
    """Largest drive."""
    speed: float
    acceleration: float
    travel: tuple[float, float]
    parameters: Mapping[str, Any]
    """Of the plant, by dotted key."""
    delay_s: float = 0.0
    resolution: float = 0.0
    noise: float = 0.0
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    cascade: Mapping[str, float] = field(default_factory=dict)
    identified: Mapping[str, Any] = field(default_factory=dict)
    log: Mapping[str, Any] = field(default_factory=dict)
    """``file``, ``sha256``, ``columns``, ``units``, ``start``, ``end``, ``period``: how its command is read again."""
    folder: Path = field(default=Path(), compare=False)
    """Where ``log.file`` is looked for."""

    def text(self) -> str:
        """The file."""
        return toml_file.text({
            "schema_version": SCHEMA_VERSION, "kind": KIND, "name": self.name, "model": self.model,
            "position_unit": self.position_unit, "drive_unit": self.drive_unit, "period": self.period,
            "delay_s": self.delay_s, "resolution": self.resolution, "noise": self.noise,
            "limits": {"drive": self.drive, "speed": self.speed, "acceleration": self.acceleration,
                       "travel": list(self.travel)},
            "set": dict(self.parameters), "interval": {k: list(v) for k, v in self.intervals.items()},
            "cascade": dict(self.cascade), "log": dict(self.log),
            "identified": dict(self.identified),
        })  # fmt: skip


@entry_point
def write(path: str | Path, machine: MachineFile) -> None:
    """Writes a machine file, whole or not at all.

    Raises:
        DataError: it cannot be written.
    """
    atomic_write(machine.text(), path)


@entry_point
def read(path: str | Path) -> MachineFile:
    """The contents of a machine file.

    Raises:
        DataError: no such file, bad TOML, an unknown key or a value of the wrong type or range; names file and key.
    """
    where = Path(path).expanduser()
    return validated(toml_file.read(where), where)


def validated(table: Mapping[str, Any], where: Path) -> MachineFile:
    """The machine that a TOML table describes.

    Raises:
        DataError: names file and key of what is wrong.
    """
    reader = _Reader(where)
    if table.get("kind") != KIND:
        raise DataError(f"{where}: is not a machine file: kind = {table.get('kind')!r}, expected {KIND!r}")
    texts, tables = (
        ("name", "model", "position_unit", "drive_unit"),
        ("set", "interval", "cascade", "log", "identified"),
    )
    reader.known(table, ("schema_version", "kind", *texts, *NUMBERS, "limits", *tables), "")
    if table.get("schema_version") != SCHEMA_VERSION:
        raise DataError(f"{where}: schema_version = {table.get('schema_version')!r}: expected {SCHEMA_VERSION}")
    said = {key: reader.text(table, key) for key in texts}
    try:
        for key in ("name", "position_unit", "drive_unit"):
            checked_line(key, said[key], LONGEST_NAME)
    except ValueRefused as error:
        raise DataError(f"{where}: {error}") from None
    if said["model"] not in MODELS:
        raise DataError(f"{where}: model = {said['model']!r}: expected {', '.join(MODELS)}")
    numbers = {
        key: reader.number(table, key, *span, default=None if key == "period" else 0.0) for key, span in NUMBERS.items()
    }
    limits = reader.table(table, "limits")
    reader.known(limits, (*LIMITS, "travel"), "limits.")
    bounds = {key: reader.number(limits, key, 1e-12, 1e12, prefix="limits.") for key in LIMITS}
    travel = reader.pair(limits, "travel", "limits.")
    parameters = dict(toml_file.flat(reader.table(table, "set")))
    reader.force(said, parameters)
    cascade = reader.table(table, "cascade")
    reader.known(cascade, CASCADE, "cascade.")
    intervals = dict(toml_file.flat(reader.table(table, "interval")))
    return MachineFile(
        name=said["name"], model=said["model"], position_unit=said["position_unit"], drive_unit=said["drive_unit"],
        period=numbers["period"], delay_s=numbers["delay_s"], resolution=numbers["resolution"],
        noise=numbers["noise"], drive=bounds["drive"], speed=bounds["speed"], acceleration=bounds["acceleration"],
        travel=travel, parameters=parameters,
        intervals={key: reader.pair(intervals, key, "interval.") for key in intervals},
        cascade={key: reader.number(cascade, key, 0.0, 1e12, prefix="cascade.") for key in cascade},
        identified=reader.table(table, "identified"), log=reader.log(table), folder=where.resolve().parent,
    )  # fmt: skip


class _Reader:
    """Checks of values; each names the file and the key."""

    def __init__(self, where: Path) -> None:
        self.where = where

    def known(self, table: Mapping[str, Any], keys: tuple[str, ...], prefix: str) -> None:
        for key in table:
            if key not in keys:
                raise DataError(f"{self.where}: there is no key {prefix + key!r}{nearest(key, list(keys))}")

    def text(self, table: Mapping[str, Any], key: str) -> str:
        value = table.get(key)
        if not isinstance(value, str) or not value:
            raise DataError(f"{self.where}: {key} = {value!r}: expected a text")
        return value

    def table(self, table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
        value = table.get(key, {})
        if not isinstance(value, Mapping):
            raise DataError(f"{self.where}: {key} = {value!r}: expected a table")
        return value

    def force(self, said: Mapping[str, str], parameters: Mapping[str, Any]) -> None:
        """A torque that moves a length needs its force: 1 N for 1 N m would be a lead of 6.28 m."""
        from leadscrew.logs.units import drive_in, length_in

        with suppress(ValueRefused):
            pair = length_in(said["position_unit"])[0], drive_in(said["drive_unit"])[0]
            if said["model"] != "linear" and pair == ("m", "N m") and parameters.get("force_per_drive", 1.0) == 1.0:
                raise DataError(
                    f"{self.where}: drive_unit = {said['drive_unit']!r} with position_unit = {said['position_unit']!r}"
                    ": set.force_per_drive must be the N of 1 N m, 2 pi times the gear over the lead in m"
                )

    def log(self, table: Mapping[str, Any]) -> Mapping[str, Any]:
        log = self.table(table, "log")
        self.known(log, LOG, "log.")
        for key in ("file", "sha256") if log else ():
            self.text(log, key)
        for key in ("columns", "units"):
            self.table(log, key)
        for key in ("start", "end", "period"):
            if key in log:
                self.number(log, key, -1e12, 1e12, prefix="log.")
        return log

    def number(
        self, table: Mapping[str, Any], key: str, low: float, high: float, default: float | None = None,
        prefix: str = "",
    ) -> float:  # fmt: skip
        value = table.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise DataError(f"{self.where}: {prefix}{key} = {value!r}: expected a number from {low:g} to {high:g}")
        return float(value)

    def pair(self, table: Mapping[str, Any], key: str, prefix: str) -> tuple[float, float]:
        value = table.get(key)
        good = isinstance(value, list) and len(value) == 2 and all(
            isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v) for v in value
        )  # fmt: skip
        if not good or not value[0] <= value[1]:  # type: ignore[index]
            raise DataError(f"{self.where}: {prefix}{key} = {value!r}: expected two finite numbers, the lower first")
        return float(value[0]), float(value[1])  # type: ignore[index]
