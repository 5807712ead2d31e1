"""A log of an axis played on its model: in open loop, the logged drive held between samples; or in the known cascade.

Everything is simulated by :mod:`leadscrew.plants.servo_axis` in the kernel's loops, the plant that the user gets;
:mod:`leadscrew.identify.axis.refine_replay` says how.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.identify.axis.refine_replay import LOST, Starts, as_logged, play, played
from leadscrew.kernel import validate
from leadscrew.kernel.errors import DataError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog

__all__ = [
    "LOST", "NO_STRIBECK", "SIDES", "START_S", "as_logged", "plant_values", "rms", "simulate_closed", "simulate_open",
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
        values: by key of :mod:`leadscrew.plants.servo_axis`; what is missing backwards is as forwards.
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
    starts = Starts(np.zeros(1), np.array([position]), np.array([speed]))
    point = plant_values(values, log.force_per_drive)
    return _sound(log, play(played(log), [point], starts, len(log.time), [delay_s])[0])


def simulate_closed(log: AxisLog, values: Mapping[str, float], cascade: Cascade, delay_s: float = 0.0) -> np.ndarray:
    """The axis in the known cascade under the logged command: position, m or rad, at each sample of the log.

    Raises:
        DataError: the log has no command, or the loop diverges.
        NameUnknown, ValueRefused: as :func:`simulate_open`.
    """
    from leadscrew.identify.axis.cascade import closed_loop, play_closed

    point = plant_values(values, log.force_per_drive)
    return _sound(log, play_closed(closed_loop(log, cascade), [point], _start(log), len(log.time), [delay_s])[0])


_start = start_state


def _sound(log: AxisLog, position: np.ndarray) -> np.ndarray:
    if np.max(np.abs(position)) >= LOST:
        raise DataError(f"{log.source}: the simulated axis diverges with these values")
    return position


def rms(measured: Any, simulated: Any) -> float:
    """Root mean square of the difference."""
    return float(np.sqrt(np.mean(np.square(np.asarray(measured) - np.asarray(simulated)))))
