"""What a refinement fits, in variables of the size of one; and the full set of a model's values at each point."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.axis.simulation import NO_STRIBECK, plant_values
from leadscrew.kernel.errors import NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.logs import AxisLog

LOGARITHMS = ("mass", "force_per_drive", "stribeck_speed")
"""Fitted as logarithms; all others as multiples of their own size, so that they may come down to zero."""
FACTOR = 100.0
"""A logarithm stays within this factor of where it starts."""
LONGEST_DELAY = 7.0
"""Periods."""


@dataclass(frozen=True)
class Scales:
    """Fitted keys, and how each becomes a variable."""

    keys: tuple[str, ...]
    base: dict[str, float]
    """All values at the start."""
    symmetric: bool
    size: np.ndarray
    """Value of one unit of each variable, for those that are not logarithms."""
    logs: np.ndarray
    origin: np.ndarray
    low: np.ndarray
    high: np.ndarray
    force_per_drive: float | None
    delay_s: float

    def values(self, x: np.ndarray) -> dict[str, float]:
        """All values at a point, both directions."""
        found = dict(self.base)
        for key, at, size, log in zip(self.keys, x, self.size, self.logs, strict=True):
            found[key] = float(size * math.exp(at) if log else size * at)
        return {k: v for k, v in found.items() if not (self.symmetric and k.startswith("friction.backward."))}

    def point(self, x: np.ndarray) -> dict[str, float]:
        """The plant's values at a point."""
        return plant_values(self.values(x), self.force_per_drive)

    def delay(self, x: np.ndarray) -> float:
        """Seconds from a logged drive to its act."""
        return float(x[self.keys.index("delay_s")] * self.size[self.keys.index("delay_s")]) if (
            "delay_s" in self.keys
        ) else self.delay_s  # fmt: skip

    def per_variable(self, x: np.ndarray) -> np.ndarray:
        """Change of each value for a change of its variable."""
        return np.where(self.logs, self.size * np.exp(np.where(self.logs, x, 0.0)), self.size)


def scales(log: AxisLog, start: Mapping[str, float], fitted: Sequence[str], symmetric: bool, delay_s: float) -> Scales:
    """The variables of a fit.

    Raises:
        NameUnknown: a fitted key that no axis has.
        ValueRefused: nothing to fit; a key twice; a backward key of a symmetric model; a drive's force and all that is
            in its unit together, which no log can tell; a start that is not positive where it must be.
    """
    keys = tuple(fitted)
    if not keys or len(set(keys)) != len(keys):
        raise ValueRefused(f"fitted = {list(keys)}: expected one or more keys, each once")
    if symmetric and any(k.startswith("friction.backward.") for k in keys):
        raise ValueRefused("fitted: a symmetric model has no backward friction of its own; leave out its keys")
    if {"mass", "force_per_drive"} <= set(keys):
        raise ValueRefused("fitted: mass and force_per_drive cannot both be told by a log; give one of them")
    if not symmetric and {"offset", "friction.forward.coulomb", "friction.backward.coulomb"} <= set(keys):
        raise ValueRefused(
            "fitted: offset and Coulomb friction of both directions together; no log tells them apart, since what is "
            "added to one may be taken from the others: leave out offset"
        )
    base = _tied({k: float(v) for k, v in start.items()}, keys, symmetric)
    full = plant_values(base, log.force_per_drive) | {"delay_s": delay_s}
    for key in keys:
        if key not in full:
            raise NameUnknown(f"fitted: {key!r} is not what a refinement fits; it fits {', '.join(sorted(full))}")
    top = float(np.max(np.abs(np.gradient(log.position, log.period))))
    force = max(full["friction.forward.coulomb"], 0.02 * float(np.std(log.drive)) * abs(full["force_per_drive"]))
    sizes = {"offset": force, "coulomb": force, "static": force, "viscous": force / max(top, 1e-12)}
    sizes |= {"delay_s": log.period, "backlash": 1e-4 * float(np.ptp(log.position))}
    size, logs, origin, low, high = [], [], [], [], []
    for key in keys:
        name = key.rsplit(".", 1)[-1]
        log_like = name in LOGARITHMS
        if log_like and full[key] == 0.0:
            raise ValueRefused(f"start: {key} = 0; its fit needs a start that is not 0")
        unit = full[key] if log_like else max(sizes[name], abs(full[key]) if name != "offset" else 0.0)
        size.append(unit)
        logs.append(log_like)
        origin.append(0.0 if log_like else full[key] / unit)
        low.append(-math.log(FACTOR) if log_like else -np.inf if name == "offset" else 0.0)
        high.append(math.log(FACTOR) if log_like else LONGEST_DELAY if name == "delay_s" else np.inf)
    return Scales(
        keys, base, symmetric, np.array(size), np.array(logs), np.array(origin), np.array(low), np.array(high),
        log.force_per_drive, delay_s,
    )  # fmt: skip


def _tied(base: dict[str, float], keys: Sequence[str], symmetric: bool) -> dict[str, float]:
    """Without what follows another value: static friction that is Coulomb friction, backward that is forward."""
    found = dict(base)
    found.pop("delay_s", None)
    for way in ("forward", "backward"):
        static, coulomb = f"friction.{way}.static", f"friction.{way}.coulomb"
        same = found.get(static) == found.get(coulomb, found.get("friction.forward.coulomb"))
        if static not in keys and same:
            found.pop(static, None)
        speed = f"friction.{way}.stribeck_speed"
        if speed in keys and not found.get(speed, NO_STRIBECK) > 0.0:
            raise ValueRefused(f"start: {speed} = {found[speed]:g}: must be above 0")
    if symmetric:
        found = {k: v for k, v in found.items() if not k.startswith("friction.backward.")}
    return found
