"""A known cascade: P position loop over a P or PI speed loop, and whether a log's drive obeys it.

    w = kp (command - position) - v            v = (position[k] - position[k - over]) / (over dt)
    u = kv (w + ki sum(w) dt)                  |u| <= max_drive

Without ``ki`` it is the law of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot, *Data set and reference models of
EMPS*, 2019: kp = 160.18 1/s, kv = 243.45 V s/m). In its log the speed is the difference over two periods, which the
authors do not say: with it the law gives the logged drive within 0.24 %, with the difference over one within 3.3 %.
:func:`reproduced` measures this; where the law does not give the drive, a closed-loop score says nothing of the axis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np

from leadscrew.identify.axis.replay import Held, late_axis
from leadscrew.identify.log_player import Player, played_signal
from leadscrew.kernel import validate
from leadscrew.kernel.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.util.errors import DataError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.logs import AxisLog

LONGEST = 8
"""Periods that a speed is differenced over, at most."""
OBEYS = 5.0
"""Percent of the drive that a law may leave and still count as the one that was active."""


@dataclass(frozen=True)
class Cascade:
    """Gains of the loop that was active while the log was made."""

    kp: float
    """1/s, of the position loop."""
    kv: float
    """Drive's unit s/m, of the speed loop; below 0 where a positive drive moves the axis backwards."""
    ki: float = 0.0
    """1/s, of the speed loop's integral."""
    max_drive: float = math.inf
    """Drive's unit; what the drive is limited to."""
    over: int = 1
    """Periods that the speed is the difference over, 1 to 8."""

    def __post_init__(self) -> None:
        for name, unit in (("kp", "1/s"), ("kv", ""), ("max_drive", "")):
            value = validate.number(f"cascade.{name}", getattr(self, name), unit)
            if name == "kv" and value < 0.0:
                continue
            if not value > 0.0:
                beside = " (or below, where a positive drive moves the axis backwards)" if name == "kv" else ""
                raise ValueRefused(f"cascade.{name} = {value:g}: must be above 0{beside}")
        if not validate.number("cascade.ki", self.ki, "1/s") >= 0.0:
            raise ValueRefused(f"cascade.ki = {self.ki:g}: must be 0 or more")
        validate.whole("cascade.over", self.over, 1, LONGEST)


class Obeyed(NamedTuple):
    """How well a law gives the logged drive."""

    rms: float
    """Drive's unit, of what it leaves."""
    percent: float
    """The same, of the drive's standard deviation."""
    obeys: bool
    """Whether that is below :data:`OBEYS`."""
    law: Cascade


class CascadeParams(NamedTuple):
    """The law, its start and its delay."""

    kp: Annotated[float, Unit("1/s"), Ge(0)] = 1.0
    kv: float = 1.0
    ki: Annotated[float, Unit("1/s"), Ge(0)] = 0.0
    max_drive: Annotated[float, Ge(0), Doc("what the drive is limited to")] = 1e30
    over: Annotated[int, Ge(1), Doc("periods that the speed is differenced over")] = 1
    late: Annotated[int, Ge(0), Doc("whole periods from the drive to its act, up to 7")] = 0
    start_position: Annotated[float, Unit("m")] = 0.0
    start_speed: Annotated[float, Unit("m/s")] = 0.0
    start_drive: float = 0.0
    period: Annotated[float, Unit("s")] = 1e-3


class CascadeState(NamedTuple):
    """The last positions and drives, latest first, and the integral."""

    position: np.ndarray
    drive: np.ndarray
    integral: float = 0.0


def cascade_start(p):
    """As if it had moved steadily before."""
    ages = np.arange(1, LONGEST + 1)
    past = p.start_position - p.start_speed * p.period * ages
    return CascadeState(past, np.full(LONGEST + 1, p.start_drive), 0.0)


@controller(CascadeParams(), CascadeState(np.zeros(LONGEST), np.zeros(LONGEST + 1)), initial=cascade_start)
def known_cascade(p, s, command, feedback, dt):
    """The law, and the drive's values of the period, late by whole periods."""
    speed = (feedback.position - s.position[p.over - 1]) / (p.over * dt)
    w = p.kp * (command - feedback.position) - speed
    integral = s.integral + w * dt
    wanted = p.kv * (w + p.ki * integral)
    u = min(max(wanted, -p.max_drive), p.max_drive)
    for i in range(LONGEST - 1, 0, -1):
        s.position[i] = s.position[i - 1]
    s.position[0] = feedback.position
    for i in range(LONGEST, 0, -1):
        s.drive[i] = s.drive[i - 1]
    s.drive[0] = u
    # an integral does not wind up behind the limit
    kept = integral if u == wanted else s.integral
    return CascadeState(s.position, s.drive, kept), Held(s.drive[p.late + 1], s.drive[p.late], 0.0, 0.0, 0.0)


def closed_loop(log: AxisLog, cascade: Cascade) -> Player:
    """The cascade over the axis, under the logged command.

    Raises:
        DataError: the log has no command.
    """
    if log.command is None:
        raise DataError(f"{log.source}: has no command; a closed loop needs the column of the commanded position")
    law = CascadeParams(
        kp=float(cascade.kp), kv=float(cascade.kv), ki=float(cascade.ki), max_drive=min(cascade.max_drive, 1e30),
        over=int(cascade.over), start_drive=float(log.drive[0]), period=log.period,
    )  # fmt: skip
    loop = Loop(
        reference=played_signal(log.command), controller=known_cascade(**law._asdict()), plant=late_axis,
        period=log.period, metrics={}, name="cascade over an identified axis",
    )  # fmt: skip
    return Player(loop, "controller.late", ("plant.axis", "controller"), longest=LONGEST - 1)


def reproduced(log: AxisLog, cascade: Cascade) -> Obeyed:
    """How well the law gives the logged drive from the logged command and position; no model of the axis is asked.

    Raises:
        DataError: the log has no command.
    """
    error, speed = _signals(log, cascade.over)
    w = cascade.kp * error - speed
    law = cascade.kv * (w + cascade.ki * np.cumsum(w) * log.period)
    left = np.clip(law, -cascade.max_drive, cascade.max_drive) - log.drive
    # where its integral stood when the log began is not known
    left = (left - (np.mean(left) if cascade.ki else 0.0))[cascade.over :]
    size = float(np.sqrt(np.mean(left * left)))
    share = 100.0 * size / max(float(np.std(log.drive)), 1e-300)
    return Obeyed(size, share, share <= OBEYS, cascade)


def best_difference(log: AxisLog, cascade: Cascade) -> Obeyed:
    """The same law with the number of periods that gives the logged drive best, 1 to 8."""
    from dataclasses import replace

    return min((reproduced(log, replace(cascade, over=n)) for n in range(1, LONGEST + 1)), key=lambda o: o.rms)


def cascade_from(log: AxisLog) -> Obeyed:
    """A P-P law read from the log: least squares of the drive on following error and speed, for 1 to 8 periods.

    Raises:
        DataError: the log has no command, or no positive gains give its drive.
    """
    found = []
    for over in range(1, LONGEST + 1):
        columns = np.column_stack(_signals(log, over))[over:]
        (a, b), *_ = np.linalg.lstsq(columns, log.drive[over:], rcond=None)
        if a > 0.0 and b < 0.0:
            found.append(reproduced(log, Cascade(kp=float(-a / b), kv=float(-b), over=over)))
    if not found:
        raise DataError(
            f"{log.source}: no law kv (kp (command - position) - speed) with positive gains gives its drive"
        )
    return min(found, key=lambda o: o.rms)


def _signals(log: AxisLog, over: int) -> tuple[np.ndarray, np.ndarray]:
    if log.command is None:
        raise DataError(f"{log.source}: has no command; the law of a cascade needs the commanded position")
    speed = np.zeros(len(log.position))
    speed[over:] = (log.position[over:] - log.position[:-over]) / (over * log.period)
    return log.command - log.position, speed
