"""From a fit to what can be said: parameters of the plant with 95 % intervals, and whether they are told.

An interval is ``value +- t(0.975, freedom) standard error``; it belongs to the data that were used for it. A parameter
counts as told when half of its interval is at most :data:`TOLD` of its value. An offset, Coulomb or viscous friction
counts as told too when the force that this half can change is at most :data:`LITTLE` of the root mean square of the
force: then it is known to be small, whatever it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from leadscrew.identify.axis.inverse_dynamics import LinearFit
from leadscrew.identify.axis.result import Parameter

BIAS, BIAS_STRIBECK = 3e-4, 3e-3
"""What the linear stage may be off by on its own, as a share of the value, met on simulated axes of known parameters:
signs of the speed are timed by a smoothed speed, and the Stribeck term is made of one (static friction, its speed)."""
TOLD = 0.25
LITTLE = 0.01
NAN = math.nan


@dataclass(frozen=True)
class Estimates:
    """Fitted parameters by key of the plant, with what they cost and act."""

    keys: tuple[str, ...]
    values: dict[str, float]
    covariance: np.ndarray
    freedom: float
    condition: float
    effect: dict[str, float]
    """Root mean square of the force that one unit of each parameter makes."""
    rms_force: float
    interval: dict[str, tuple[float, float]] = field(default_factory=dict)
    """95 %, where a method has its own; else from the covariance."""

    def ends(self, key: str) -> tuple[float, float]:
        """The 95 % interval."""
        if key in self.interval:
            return self.interval[key]
        value, half = self.values[key], self.half(key)
        return value - half, value + half

    def half(self, key: str) -> float:
        """Half of the 95 % interval."""
        if key in self.interval:
            return 0.5 * (self.interval[key][1] - self.interval[key][0])
        from scipy.special import stdtrit

        i = self.keys.index(key)
        return float(stdtrit(max(self.freedom, 1.0), 0.975) * math.sqrt(max(float(self.covariance[i, i]), 0.0)))

    def correlation(self) -> dict[str, dict[str, float]]:
        """Between the parameters."""
        spread = np.sqrt(np.diag(self.covariance))
        safe = np.where(spread > 0.0, spread, 1.0)
        table = self.covariance / np.outer(safe, safe)
        return {a: {b: float(table[i, j]) for j, b in enumerate(self.keys)} for i, a in enumerate(self.keys)}


def estimates_of(fit: LinearFit) -> Estimates:
    """The line's parameters as the plant has them: ``static`` is ``coulomb`` and ``excess`` together."""
    keys = tuple(key.replace(".excess", ".static") for key in fit.keys)
    turn = np.eye(len(keys))
    values = {}
    for i, (old, new) in enumerate(zip(fit.keys, keys, strict=True)):
        values[new] = fit.values[old]
        if old != new:
            coulomb = old.replace(".excess", ".coulomb")
            values[new] += fit.values.get(coulomb, fit.terms.known.get(coulomb, 0.0))
            if coulomb in fit.keys:
                turn[i, fit.keys.index(coulomb)] = 1.0
    bias = [values[k] * (BIAS_STRIBECK if k.split(".")[-1] in ("static", "stribeck_speed") else BIAS) for k in keys]
    covariance = turn @ fit.covariance @ turn.T + np.diag(np.square(0.5 * np.array(bias)))
    return Estimates(
        keys, values, covariance, fit.freedom, fit.condition,
        {new: fit.effect[old] for old, new in zip(fit.keys, keys, strict=True)}, fit.rms_force,
    )  # fmt: skip


def interval_half(fit: LinearFit, key: str) -> float:
    """Half of the 95 % interval of a term of the line."""
    from scipy.special import stdtrit

    return float(stdtrit(max(fit.freedom, 1), 0.975) * fit.standard_error[key])


def parameter(estimates: Estimates, key: str, unit: str, note: str = "") -> Parameter:
    """A fitted parameter with its interval."""
    low, high = estimates.ends(key)
    return Parameter(estimates.values[key], unit, low, high, "fitted", is_told(estimates, key), note)


def is_told(estimates: Estimates, key: str) -> bool:
    """Whether the interval is narrow enough to be of use."""
    half = estimates.half(key)
    if not math.isfinite(half):
        return False
    if half <= TOLD * abs(estimates.values[key]):
        return True
    of_no_matter = key == "offset" or key.split(".")[-1] in ("coulomb", "viscous")
    return of_no_matter and half * estimates.effect.get(key, math.inf) <= LITTLE * estimates.rms_force


def fixed(value: float, unit: str, note: str) -> Parameter:
    """A parameter that the log does not tell."""
    return Parameter(value, unit, NAN, NAN, "fixed", False, note)


def given(value: float, unit: str) -> Parameter:
    """A parameter that the caller knows."""
    return Parameter(value, unit, NAN, NAN, "given", True)


def units(position_unit: str, drive_unit: str, force_known: bool) -> dict[str, str]:
    """Unit of each key: where the force of the drive is not known its own unit stands for the newton."""
    rotary = position_unit == "rad"
    force = ("N m" if rotary else "N") if force_known else drive_unit
    mass = {("N", "m"): "kg", ("N m", "rad"): "kg m^2"}.get((force, position_unit), f"{force} s^2/{position_unit}")
    found = {"mass": mass, "offset": force, "delay_s": "s", "backlash": position_unit,
             "force_per_drive": f"{force}/{drive_unit}"}  # fmt: skip
    for side in ("forward", "backward"):
        found |= {f"friction.{side}.{n}": force for n in ("coulomb", "static")}
        found |= {
            f"friction.{side}.viscous": f"{force} s/{position_unit}",
            f"friction.{side}.stribeck_speed": f"{position_unit}/s",
        }
    return found | {
        "friction.stiffness": f"{force}/{position_unit}",
        "friction.damping": f"{force} s/{position_unit}",
    }


def weakest(matrix: np.ndarray, keys: Sequence[str]) -> Mapping[str, float]:
    """The direction in which the columns, scaled to equal length, say least: key and share."""
    size = np.sqrt(np.mean(matrix * matrix, axis=0))
    _, _, directions = np.linalg.svd(matrix / np.where(size > 0.0, size, 1.0), full_matrices=False)
    return {key: float(part) for key, part in zip(keys, directions[-1], strict=True)}
