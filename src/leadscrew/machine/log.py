"""The command of a machine's log, read again: scenario ``log``."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from leadscrew import userfile
from leadscrew.kernel.block import Block
from leadscrew.kernel.errors import DataError
from leadscrew.machine.file import MachineFile
from leadscrew.machine.gains import per_si


class Played(NamedTuple):
    """The command of the log, as it was asked for."""


@lru_cache(maxsize=4)
def _read(path: Path, digest: str, how: str) -> tuple[Any, float, float]:
    import json

    from leadscrew.logs import read_axis_log

    told = json.loads(how)
    log = read_axis_log(path, **told)
    if log.command is None:
        raise DataError(f"{path}: has no column of the command: name it, [log.columns] command = ...")
    return log.command, log.period, float(log.position[0])


def command(machine: MachineFile) -> Block:
    """The reference: the logged command less where the axis stood, so that it begins near 0.

    Raises:
        DataError: the log is not there, has changed, or has no command.
    """
    import json

    from leadscrew.references._logged import logged_command

    path = machine.folder / str(machine.log["file"])
    now = userfile.digest(path)
    if not now:
        raise DataError(f"{path}: the log of {machine.name} is not there: put it beside the machine file")
    if now != machine.log["sha256"]:
        raise DataError(f"{path}: is not the log that {machine.name} was identified from; put the old file back")
    how = {k: v for k, v in machine.log.items() if k not in ("file", "sha256")}
    position, interval, start = _read(path, now, json.dumps(how, sort_keys=True))
    return logged_command(per_si(machine) * (position - start), interval, machine.position_unit)


def of_log(path: Path, folder: Path, **how: Any) -> dict[str, Any]:
    """The ``[log]`` of a machine file in ``folder``: where the log lies from there, its checksum, how it is read."""
    import os

    told = {k: v for k, v in how.items() if v not in (None, {}, "")}
    return {"file": os.path.relpath(path.resolve(), folder.resolve()), "sha256": userfile.digest(path), **told}
