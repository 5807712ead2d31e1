"""The axis under a drive that acts late by any part of a period, and a log's drive played on it.

With a delay ``d`` between the logged drive and its act, the drive over the period after sample ``k`` is

    u[k - n - 1] for f dt, then u[k - n] for (1 - f) dt        d = (n + f) dt

and both parts are steps of :obj:`leadscrew.plants.servo_axis`, exact as one is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.identify.log_player import Player, as_logged, lengthened, row_at
from leadscrew.kernel.block import plant, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import Doc, Unit
from leadscrew.plants._servo_axis import (
    ServoAxisParams,
    ServoAxisState,
    ServoAxisStep,
    axis_shown,
    servo_axis,
    servo_axis_start,
    servo_axis_step,
)

if TYPE_CHECKING:
    from leadscrew.logs import AxisLog


class Held(NamedTuple):
    """The drive of one period: first the sample before, then this one; and where a run begins."""

    before: float = 0.0
    now: float = 0.0
    begins: float = 0.0
    """1 in the first period, which then begins at ``position`` with ``speed``."""
    position: float = 0.0
    speed: float = 0.0


class PlayedDrive(NamedTuple):
    """The logged drive, and where a run begins."""

    first: Annotated[float, Doc("sample that the run starts at")] = 0.0
    late: Annotated[float, Doc("whole periods of delay")] = 0.0
    start_position: Annotated[float, Unit("m")] = 0.0
    start_speed: Annotated[float, Unit("m/s")] = 0.0
    drive: Annotated[NDArray[np.float64], Doc("held from each sample to the next")] = np.zeros(1)


def drive_at(p, t, dt):
    """The drive's two values of the period that begins at ``t``."""
    last = p.drive.shape[0] - 1
    row = row_at(p.first - p.late, t, dt)
    now = int(min(max(row, 0.0), last))
    before = int(min(max(row - 1.0, 0.0), last))
    return Held(p.drive[before], p.drive[now], 1.0 if t <= 0.0 else 0.0, p.start_position, p.start_speed)


class LateAxis(NamedTuple):
    """An axis whose drive acts a part of a period late."""

    part: Annotated[float, Doc("share of a period for which the sample before still acts")] = 0.0
    axis: ServoAxisParams = ServoAxisParams(per_si=1.0)


class LateAxisStep(NamedTuple):
    """The exact steps of both parts of a period."""

    before_s: float
    now_s: float
    before: ServoAxisStep
    now: ServoAxisStep


def late_axis_step(params: LateAxis, dt: float) -> LateAxisStep:
    """Coefficients of both parts."""
    early = params.part * dt
    return LateAxisStep(
        early, dt - early, servo_axis_step(params.axis, early), servo_axis_step(params.axis, dt - early)
    )


def late_axis_start(params: LateAxis) -> ServoAxisState:
    """As the axis starts."""
    return servo_axis_start(params.axis)


def late_axis_shown(p, s):
    """The table and the drive's side."""
    return axis_shown(p.now, s)


@plant(LateAxis(), ServoAxisState(), output=late_axis_shown, prepare=late_axis_step, initial=late_axis_start, unit="m")
def late_axis(p, s, u, load, dt):
    """:obj:`leadscrew.plants.servo_axis` under a drive that changes once within the period."""
    begins = u.begins > 0.5
    # in motion the table begins behind the flank that pushes it
    lead = p.now.half_gap if u.speed > 0.0 else -p.now.half_gap if u.speed < 0.0 else 0.0
    start = ServoAxisState(
        u.position + lead if begins else s.position, u.speed if begins else s.speed, u.position if begins else s.table
    )
    middle = servo_axis(p.before, start, u.before, load, p.before_s)
    return servo_axis(p.now, middle, u.now, load, p.now_s)


def played(log: AxisLog) -> Player:
    """A log's drive played on the axis."""
    drive = PlayedDrive(drive=lengthened(log.drive))
    loop = Loop(
        reference=reference(drive, name="played drive")(drive_at), controller=as_logged, plant=late_axis,
        period=log.period, metrics={}, name="replay of an axis log",
    )  # fmt: skip
    return Player(loop, "reference.late", ("reference",), "reference.first")
