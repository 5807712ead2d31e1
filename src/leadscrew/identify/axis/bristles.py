"""A log's drive played on an axis with bristles: :obj:`leadscrew.plants.servo_axis_lugre` in open loop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.identify.axis.refine_replay import LOST, as_logged, lengthened
from leadscrew.identify.axis.simulation import plant_values, start_state
from leadscrew.kernel.block import plant, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.sheet import Doc, Unit
from leadscrew.plants._mass_lugre import MassLuGreState, mass_lugre_jacobian
from leadscrew.plants._servo_axis_lugre import ServoAxisLuGreParams, lugre_axis_shown, servo_axis_lugre

if TYPE_CHECKING:
    from leadscrew.logs import AxisLog


class PlayedForce(NamedTuple):
    """The logged drive, and where a run begins."""

    first: Annotated[float, Doc("sample that the run starts at, less whole periods of delay")] = 0.0
    drive: Annotated[NDArray[np.float64], Doc("held from each sample to the next")] = np.zeros(1)


def force_at(p, t, dt):
    """The drive of the period that begins at ``t``."""
    row = p.first + math.floor(t / dt + 0.5)
    return p.drive[int(min(max(row, 0.0), p.drive.shape[0] - 1))]


class Prestressed(NamedTuple):
    """An axis whose run begins with bent bristles."""

    bristle: Annotated[float, Unit("m"), Doc("deflection of the bristles at the start")] = 0.0
    axis: ServoAxisLuGreParams = ServoAxisLuGreParams(per_si=1.0)


def prestressed_start(p):
    """As measured."""
    return MassLuGreState(p.axis.start_position, p.axis.start_speed, p.bristle)


def prestressed_shown(p, s):
    """Table and drive are one."""
    return lugre_axis_shown(p.axis, s)


def prestressed_jacobian(p, s):
    """That of the axis."""
    return mass_lugre_jacobian(p.axis, s)


@plant(
    Prestressed(), MassLuGreState(), output=prestressed_shown, initial=prestressed_start,
    jacobian=prestressed_jacobian, stiff=True, unit="m",
)  # fmt: skip
def prestressed_axis(p, s, u, load):
    """:obj:`leadscrew.plants.servo_axis_lugre`."""
    return servo_axis_lugre(p.axis, s, u, load)


def start_bristle(values: Mapping[str, float], force: float, speed: float, slow_speed: float) -> float:
    """At rest the bristles hold what is pushed with, up to static friction; in motion they are bent as in sliding."""
    side = "forward" if (speed if abs(speed) > slow_speed else force) >= 0.0 else "backward"
    coulomb, static = (values[f"friction.{side}.{name}"] for name in ("coulomb", "static"))
    if abs(speed) > slow_speed:
        fall = math.exp(-((speed / values[f"friction.{side}.stribeck_speed"]) ** 2))
        return math.copysign(coulomb + (static - coulomb) * fall, speed) / values["friction.stiffness"]
    return min(max(force, -static), static) / values["friction.stiffness"]


def play_lugre(
    log: AxisLog, values: Mapping[str, float], late_s: float, parts: Sequence[tuple[int, int]], slow_speed: float
) -> list[np.ndarray | None]:
    """Position over each stretch ``(first, last)`` from its measured start; None where it diverges.

    The delay is taken in whole periods; below ``slow_speed`` a start counts as at rest.
    """
    point = {k: v for k, v in plant_values(values, log.force_per_drive).items() if k != "backlash"}
    point |= {key: values[key] for key in ("friction.stiffness", "friction.damping")}
    drive = PlayedForce(drive=lengthened(log.drive))
    loop = Loop(
        reference=reference(drive, name="played force")(force_at), controller=as_logged, plant=prestressed_axis,
        period=log.period, method="rodas", rtol=1e-6, atol=1e-12, metrics={}, name="replay on bristles",
    ).using({f"plant.axis.{key}": value for key, value in point.items()})  # fmt: skip
    found: list[np.ndarray | None] = []
    for first, last in parts:
        place, speed = start_state(log, first)
        force = point["force_per_drive"] * float(log.drive[first]) - point["offset"]
        bent = start_bristle(point, force, speed, slow_speed)
        begins = {"plant.axis.start_position": place, "plant.axis.start_speed": speed, "plant.bristle": bent}
        begins["reference.first"] = float(first - round(late_s / log.period))
        run = loop.using(begins).run((last - first) * log.period, record=("actual.position",))
        position = np.asarray(run["actual.position"])
        sound = len(position) == last - first and np.max(np.abs(position)) < LOST
        found.append(position if sound else None)
    return found
