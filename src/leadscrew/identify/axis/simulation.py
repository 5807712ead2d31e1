"""A log of an axis played on its model: in open loop, the logged drive held between samples; or in the known cascade.

Everything is simulated by :obj:`leadscrew.plants.servo_axis` in the kernel's loops, the plant that the user gets;
:mod:`leadscrew.identify.axis.replay` says how.

Where a stretch of a log starts: position and speed with which the model itself follows its first samples best.

A parabola through the first samples takes the speed of their middle for that of the first one; a log that begins with
full drive from rest then starts a simulation in motion, which is off by metres later. The model knows the drive, so its
start speed is solved for by Gauss and Newton over the first :data:`START_S` (9 samples at least), the position with it;
both are two numbers of the stretch's first milliseconds, not of the rest that is judged.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.identify.axis.replay import played
from leadscrew.identify.log_player import LOST, Player, Starts, as_logged, played_signal
from leadscrew.kernel import validate
from leadscrew.kernel.block import plant
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.parameters import Doc, Unit
from leadscrew.plants._mass_lugre import MassLuGreState, mass_lugre_jacobian
from leadscrew.plants._servo_axis_lugre import ServoAxisLuGreParams, lugre_axis_shown, servo_axis_lugre
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.kernel.loop import Loop
    from leadscrew.logs import AxisLog


__all__ = [
    "LOST", "NO_STRIBECK", "SIDES", "START_S", "plant_values", "rms", "simulate_closed", "simulate_open",
    "start_state",
]  # fmt: skip

SIDES = ("coulomb", "static", "stribeck_speed", "viscous")
NO_STRIBECK = 1e-3
"""m/s; any positive speed serves where static and Coulomb friction are the same."""
START_S = 0.02
"""A start in motion is measured over this time, to both sides where there are samples."""


def plant_values(values: Mapping[str, float], force_per_drive: float | None = None) -> dict[str, float]:
    """The keys of ``servo_axis`` among ``values``, each direction complete.

    What is missing backwards is as forwards; static friction is Coulomb friction where it is not given; a drive whose
    force is not given counts in its own unit.

    Raises:
        NameUnknown: a key that no model of an axis has.
        ValueRefused: mass or Coulomb friction is missing.
    """
    known = {"mass", "offset", "backlash", "force_per_drive", "delay_s", "friction.stiffness", "friction.damping"}
    known |= {f"friction.{way}.{name}" for way in ("forward", "backward") for name in SIDES}
    for key in values:
        if key not in known:
            raise NameUnknown(f"there is no parameter {key!r} of an axis; known are {', '.join(sorted(known))}")
    for key in ("mass", "friction.forward.coulomb"):
        if key not in values:
            raise ValueRefused(f"values: {key} is missing; a simulation needs mass and Coulomb friction")
    full = {
        "mass": values["mass"],
        "force_per_drive": values.get("force_per_drive", force_per_drive or 1.0),
        "offset": values.get("offset", 0.0),
        "backlash": values.get("backlash", 0.0),
    }
    usual = {"stribeck_speed": NO_STRIBECK, "viscous": 0.0}
    for way in ("forward", "backward"):
        side = {n: values.get(f"friction.{way}.{n}", values.get(f"friction.forward.{n}")) for n in SIDES}
        # what is given backwards goes before what is given forwards: Coulomb friction of one's own, static of one's own
        if f"friction.{way}.coulomb" in values and f"friction.{way}.static" not in values:
            side["static"] = None
        if side["static"] is None:
            side["static"] = side["coulomb"]
        full |= {f"friction.{way}.{n}": usual[n] if v is None else v for n, v in side.items()}
    return {key: float(v) for key, v in full.items()}


def start_state(log: AxisLog, first: int = 0, noise: float | None = None) -> tuple[float, float]:
    """Position and speed at a sample: a parabola through what was measured around it, as long as noise allows.

    Where the parabola misses by more than twice the noise it is one through fewer samples, 9 at least.
    """
    n, noise = len(log.position), log.noise if noise is None else noise
    if n < 5:
        raise DataError(f"{log.source}: {n} samples; a start needs at least 5")
    for share in (1.0, 0.5, 0.25, 0.0):
        side = max(4, round(share * START_S / log.period))
        low, high = max(0, first - side), min(n, first + side + 1)
        at = (np.arange(low, high) - first) * log.period
        fitted = np.polynomial.Polynomial.fit(at, log.position[low:high], 2)
        if np.sqrt(np.mean((fitted(at) - log.position[low:high]) ** 2)) <= 2.0 * noise:
            break
    return float(fitted(0.0)), float(fitted.deriv()(0.0))


def simulate_open(
    log: AxisLog,
    values: Mapping[str, float],
    delay_s: float = 0.0,
    start_state: tuple[float, float] | None = None,
) -> np.ndarray:
    """The axis under the logged drive, from the first sample on: position, m or rad, at each sample of the log.

    Args:
        log: what was measured; only its drive counts, and its start.
        values: by key of :obj:`leadscrew.plants.servo_axis`; what is missing backwards is as forwards.
        delay_s: from a logged drive to its act.
        start_state: position and speed at the first sample; from the measured position unless given.

    Raises:
        NameUnknown, ValueRefused: an unknown key, a missing or refused value, a negative delay.
        DataError: the simulation diverges.
    """
    if delay_s < 0.0:
        raise ValueRefused(
            f"delay_s = {validate.number('delay_s', delay_s, 's'):g}: a drive cannot act before it is given"
        )
    position, speed = start_state if start_state is not None else _start(log)
    point = plant_values(values, log.force_per_drive)
    starts = Starts.together((position, speed), 1)
    return _sound(log, played(log).play([point], starts, len(log.time), [delay_s])[0])


def simulate_closed(log: AxisLog, values: Mapping[str, float], cascade: Cascade, delay_s: float = 0.0) -> np.ndarray:
    """The axis in the known cascade under the logged command: position, m or rad, at each sample of the log.

    Raises:
        DataError: the log has no command, or the loop diverges.
        NameUnknown, ValueRefused: as :func:`simulate_open`.
    """
    from leadscrew.identify.axis.cascade import closed_loop

    point = plant_values(values, log.force_per_drive)
    starts = Starts.together(_start(log), 1)
    return _sound(log, closed_loop(log, cascade).play([point], starts, len(log.time), [delay_s])[0])


_start = start_state


def _sound(log: AxisLog, position: np.ndarray) -> np.ndarray:
    if np.max(np.abs(position)) >= LOST:
        raise DataError(f"{log.source}: the simulated axis diverges with these values")
    return position


def rms(measured: Any, simulated: Any) -> float:
    """Root mean square of the difference."""
    return float(np.sqrt(np.mean(np.square(np.asarray(measured) - np.asarray(simulated)))))


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
    loop = Loop(
        reference=played_signal(log.drive), controller=as_logged, plant=prestressed_axis,
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


LEAST, ROUNDS = 9, 3
STEP = 1e-3
"""Change of a start speed for its derivative, as a share of the largest speed of the first samples or of the log."""


def by_model(
    log: AxisLog, player: Player, point: Mapping[str, float], firsts: Sequence[int], delay_s: float = 0.0
) -> list[tuple[float, float]]:
    """Position and speed at each of the samples ``firsts``; those of a parabola where the model comes no nearer.

    Args:
        log: what was measured.
        player: of it, :func:`leadscrew.identify.axis.replay.played`.
        point: all values of the plant.
        firsts: samples that stretches begin at.
        delay_s: of the drive.
    """
    count = min(max(LEAST, round(START_S / log.period)), len(log.position) - max(firsts))
    begins = [start_state(log, first) for first in firsts]
    if count < LEAST:
        return begins
    at = np.array(firsts)
    measured = log.position[at[:, None] + np.arange(count)]
    position, speed = (np.array(column) for column in zip(*begins, strict=True))
    step = STEP * float(np.max(np.abs(np.diff(log.position)))) / log.period
    n = len(at)
    best, kept, kept_speed = np.full(n, np.inf), position.copy(), speed.copy()

    def tried(v: np.ndarray) -> np.ndarray:
        runs = Starts(np.tile(at, 2), np.tile(position, 2), np.concatenate([v, v + step]))
        return player.play([point] * (2 * n), runs, count, [delay_s] * (2 * n)).reshape(2, n, count) - measured

    # from the parabola's speed, and from rest: where the model sticks one of them has no slope
    for begin in (speed, np.zeros(n)):
        v = begin.copy()
        for _ in range(ROUNDS + 1):
            left, more = tried(v)
            shift = left.mean(axis=1)
            left, slope = left - shift[:, None], (more - left) / step
            slope = slope - slope.mean(axis=1)[:, None]
            size = np.sum(left * left, axis=1)
            better = (size < best) & (np.abs(shift) < LOST)
            best = np.where(better, size, best)
            kept, kept_speed = np.where(better, position - shift, kept), np.where(better, v, kept_speed)
            weight = np.sum(slope * slope, axis=1)
            v = v - np.sum(left * slope, axis=1) / np.where(weight > 0.0, weight, np.inf)
    return list(zip(kept.tolist(), kept_speed.tolist(), strict=True))
