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

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from leadscrew import toml_file
from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import DataError, entry_point

SCHEMA_VERSION = 1
KIND = "machine"


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
    from leadscrew import file_schema
    from leadscrew.machine.table import MachineTable

    if table.get("kind") != KIND:
        raise DataError(f"{where}: is not a machine file: kind = {table.get('kind')!r}, expected {KIND!r}")
    read = file_schema.validated(MachineTable, table, where)
    return MachineFile(
        name=read.name, model=read.model, position_unit=read.position_unit, drive_unit=read.drive_unit,
        period=read.period, delay_s=read.delay_s, resolution=read.resolution, noise=read.noise,
        drive=read.limits.drive, speed=read.limits.speed, acceleration=read.limits.acceleration,
        travel=read.limits.travel, parameters=read.parameters, intervals=read.interval,
        cascade=read.cascade.model_dump(exclude_unset=True), identified=read.identified,
        log={} if read.log is None else read.log.model_dump(exclude_unset=True), folder=where.resolve().parent,
    )  # fmt: skip
