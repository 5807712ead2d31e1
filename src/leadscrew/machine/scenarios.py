"""What an identified axis is asked to do: moves, sines and a load, sized by what its log has shown that it bears.

The scenario ``log`` is the command of the machine's log, read again.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from leadscrew import userfile
from leadscrew.disturbances._step_load import step_load
from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.machine.file import MachineFile
from leadscrew.machine.gains import cascade, per_si
from leadscrew.references._eased_sine import eased_sine_motion
from leadscrew.references._quintic import quintic
from leadscrew.references._s_curve import s_curve
from leadscrew.study_data import Scenario
from leadscrew.util.errors import DataError


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


def logged(machine: MachineFile) -> Block:
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


Start = Annotated[float, Doc("where it starts, in the machine's unit")]


class Move(NamedTuple):
    """Point to point with limited speed, acceleration and jerk, in the machine's unit."""

    distance: Annotated[float, Doc("how far, either sign")] = 10.0
    max_speed: Annotated[float, Gt(0), Doc("limit of the speed, per second")] = 10.0
    max_acceleration: Annotated[float, Gt(0), Doc("limit of the acceleration, per s^2")] = 100.0
    max_jerk: Annotated[float, Gt(0), Doc("limit of the jerk, per s^3")] = 1000.0


class StepMove(NamedTuple):
    """A bare step from rest."""

    size: Annotated[float, Doc("of the step, in the machine's unit")] = 0.1


class Wave(NamedTuple):
    """A sine that eases in from rest."""

    amplitude: Annotated[float, Ge(0), Doc("half of peak to peak, in the machine's unit")] = 1.0
    frequency: Annotated[float, Unit("Hz"), Gt(0), Doc("cycles per second")] = 1.0


class Load(NamedTuple):
    """A load that comes on while the axis stands."""

    force: Annotated[float, Unit("N"), Doc("on the axis, positive pushes forwards")] = 10.0
    time: Annotated[float, Unit("s"), Ge(0), Doc("when it comes on")] = 0.1


def scenarios(machine: MachineFile) -> dict[str, Scenario]:
    """By name, with numbers from the machine's limits."""
    reach = machine.travel[1] - machine.travel[0]
    speed, acceleration = 0.8 * machine.speed, 0.8 * machine.acceleration
    jerk = 20.0 * acceleration
    far = 0.5 * reach
    settles = 0.5 if machine.model == "linear" else max(0.5, 10.0 / cascade(machine).kpos)
    slow, small = 0.02 * machine.speed, min(0.01 * reach, 0.2 * machine.speed)
    found = [
        Scenario("move", Move(far, speed, acceleration, jerk), "half of the travel, four fifths of the log's limits",
                 _rounded(far / speed + 2.0 * speed / acceleration + 0.1 + settles)),
        Scenario("move_slow", Move(small, slow, acceleration, jerk), "a hundredth of the travel at 2 % of the speed",
                 _rounded(small / slow + 0.1 + settles)),
        Scenario("step", StepMove(1e-3 * reach), "a step of a thousandth of the travel", _rounded(settles)),
        Scenario("sine", _wave(0.1 * reach, 0.5 * machine.speed, acceleration), "a sine at half of the speed", 6.0),
        Scenario("reversal", _wave(small, slow, acceleration), "a slow sine: what friction does where it turns round",
                 8.0),
    ]  # fmt: skip
    push = _push(machine)
    if push > 0.0:
        found.append(
            Scenario(
                "load", Load(push), f"standing, while a load of {push:.3g} N (N m) comes on", _rounded(2.0 * settles)
            )
        )
    return {s.name: s for s in found}


def _push(machine: MachineFile) -> float:
    """A load that moves the axis and leaves the drive room: three times static friction, or half of the drive's room.

    0 where half of the room does not surely overcome the friction, or where there is no friction to go by.
    """
    p = machine.parameters
    if machine.model == "linear":
        return 0.0
    static = max(float(p.get(f"friction.{side}.{of}", 0.0)) for side in ("forward", "backward") for of in
                 ("coulomb", "static"))  # fmt: skip
    force = machine.drive * float(p["force_per_drive"])
    room = 0.5 * (force - abs(float(p.get("offset", 0.0))) - static)
    push = min(3.0 * static, static + room) if static > 0.0 else room
    return float(f"{push:.4g}") if push > 1.2 * static else 0.0


def _wave(amplitude: float, speed: float, acceleration: float) -> Wave:
    """A sine of this peak speed, and of no more than this acceleration."""
    w = min(speed / amplitude, acceleration / speed)
    return Wave(float(f"{amplitude:.4g}"), float(f"{w / (2.0 * math.pi):.4g}"))


def _rounded(seconds: float) -> float:
    return math.ceil(10.0 * seconds) / 10.0


def command(params: Any, motion: bool, unit: str = "") -> Block:
    """The reference of a scenario: a :class:`~leadscrew.references.Motion`, or its position alone."""
    block: Block
    if isinstance(params, Move):
        block = s_curve(
            distance=params.distance, max_velocity=params.max_speed, max_acceleration=params.max_acceleration,
            max_jerk=params.max_jerk,
        )  # fmt: skip
    elif isinstance(params, Wave):
        block = eased_sine_motion(amplitude=params.amplitude, frequency=params.frequency)
    else:
        block = quintic(distance=params.size if isinstance(params, StepMove) else 0.0, duration=0.0)
    block = replace(block, unit=unit)
    return block if motion else position_of(block)


def position_of(inner: Block) -> Block:
    """The reference that gives the position of another one's motion."""
    whole = inner.step

    def place(p, t):
        """The position of the motion."""
        return whole(p, t).position

    return reference(inner.params, prepare=inner.prepare, unit=inner.unit, name=f"{inner.name}_position")(place)


def load(params: Any) -> Block | None:
    """What pushes at the axis, N."""
    return step_load(size=params.force, time=params.time) if isinstance(params, Load) else None
