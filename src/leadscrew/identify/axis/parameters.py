"""Parameters of the plant from a fit: both directions, what is given, and what is fixed and why.

Intervals, and the rule by which a parameter is identifiable, are those of :mod:`leadscrew.identify.estimation`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from leadscrew.identify.axis.delay import Delay
from leadscrew.identify.axis.inverse_dynamics import SIDES, LinearFit, friction_key
from leadscrew.identify.estimation import LITTLE, Parameter, correlations, fitted, fixed, given, quantile
from leadscrew.kernel import validate
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import NameUnknown, ValueRefused

BIAS, BIAS_STRIBECK = 3e-4, 3e-3
"""What the linear stage may be off by on its own, as a share of the value, met on simulated axes of known parameters:
signs of the speed are timed by a smoothed speed, and the Stribeck term is made of one (static friction, its speed)."""


@dataclass(frozen=True)
class Estimates:
    """Fitted parameters by key of the plant, with what they cost and act."""

    keys: tuple[str, ...]
    values: dict[str, float]
    covariance: np.ndarray
    degrees: np.ndarray
    """Of freedom of Student's t, by key."""
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
        i = self.keys.index(key)
        return quantile(float(self.degrees[i])) * math.sqrt(max(float(self.covariance[i, i]), 0.0))

    def correlation(self) -> dict[str, dict[str, float]]:
        """Between the parameters."""
        return correlations(self.covariance, self.keys)

    def parameter(self, key: str, unit: str, note: str = "", coulomb: float | None = None) -> Parameter:
        """A parameter with its interval; ``coulomb``: what static friction counts above."""
        effect = self.effect.get(key, 0.0) if key.split(".")[-1] in ("offset", "coulomb", "viscous") else 0.0
        negligible = LITTLE * self.rms_force / effect if effect > 0.0 else 0.0
        value = self.values[key]
        counted = None if coulomb is None else value - coulomb
        return fitted(value, self.ends(key), unit, counted=counted, negligible=negligible, note=note)


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
        keys, values, covariance, np.array([float(fit.degrees[row != 0.0].min()) for row in turn]), fit.condition,
        {new: fit.effect[old] for old, new in zip(fit.keys, keys, strict=True)}, fit.rms_force,
    )  # fmt: skip


def interval_half(fit: LinearFit, key: str) -> float:
    """Half of the 95 % interval of a term of the line."""
    return quantile(float(fit.degrees[fit.keys.index(key)])) * fit.standard_error[key]


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


CLOCK = 2e-3
"""Periods; a delay below is 0."""
ONE_WAY = "the log moves one way only: taken as in the other direction"
WITH_OFFSET = "with the offset in it: while the axis moves one way the two act alike"
NO_OFFSET = (
    "fixed at 0: a constant force acts like Coulomb friction that differs by direction, and no log of drive and motion "
    "separates them; give the offset where it is known (a weight)"
)
WEIGHT = (
    "fixed at the offset that friction alike both ways has, since it is larger than friction (a weight): no log of "
    "drive and motion separates a constant force from Coulomb friction that differs by direction; give the offset "
    "where it is known"
)
NO_OFFSET_ONE_WAY = "fixed at 0: while the axis moves one way a constant force and Coulomb friction act alike"
NO_RISE = "equal to Coulomb friction: the log shows no rise towards rest"


def parameters(
    estimates: Estimates,
    why: Mapping[str, str],
    known: Mapping[str, float],
    units: Mapping[str, str],
    symmetric: bool,
    both_ways: bool,
    stribeck: bool,
    gauge: float = 0.0,
) -> dict[str, Parameter]:
    """Parameters by key: mass, offset, friction of both directions."""
    found = {"mass": _one("mass", estimates, why, known, units)}
    for side in SIDES:
        for name in ("coulomb", "viscous"):
            found[friction_key(side, name)] = _friction(side, name, estimates, why, known, units, symmetric, both_ways)
        key = friction_key(side, "static")
        if stribeck and friction_key(side if not symmetric else "forward", "excess") not in why:
            found[key] = _friction(side, "static", estimates, why, known, units, symmetric, both_ways)
            found[friction_key(side, "stribeck_speed")] = _friction(
                side, "stribeck_speed", estimates, why, known, units, True, both_ways
            )
        elif key in known:
            found[key] = given(known[key], units[key])
        else:
            note = why.get(friction_key(side if not symmetric else "forward", "excess"), NO_RISE)
            found[key] = fixed(found[friction_key(side, "coulomb")].value, units[key], note)
    found["offset"] = _offset(estimates, why, known, units, symmetric, both_ways, gauge)
    return found


def _one(
    key: str, estimates: Estimates, why: Mapping[str, str], known: Mapping[str, float], units: Mapping[str, str],
    note: str = "",
) -> Parameter:  # fmt: skip
    if key in known:
        return given(known[key], units[key])
    if key in estimates.values:
        below = key.replace(".static", ".coulomb")
        coulomb = None if below == key else estimates.values.get(below, known.get(below))
        return estimates.parameter(key, units[key], note, coulomb)
    return fixed(0.0, units[key], why.get(key, "not identifiable from the log: fixed at 0"))


def _friction(
    side: str, name: str, estimates: Estimates, why: Mapping[str, str], known: Mapping[str, float],
    units: Mapping[str, str], symmetric: bool, both_ways: bool,
) -> Parameter:  # fmt: skip
    key, source = friction_key(side, name), friction_key("forward" if symmetric else side, name)
    found = _one(key if key in known else source, estimates, why, known, units)
    if both_ways or found.how == "given":
        return found
    if side == "backward":
        return fixed(found.value, found.unit, ONE_WAY)
    if name in ("coulomb", "static") and "offset" not in known:
        return found._replace(identifiable=False, note=WITH_OFFSET)
    return found


def _offset(
    estimates: Estimates, why: Mapping[str, str], known: Mapping[str, float], units: Mapping[str, str],
    symmetric: bool, both_ways: bool, gauge: float,
) -> Parameter:  # fmt: skip
    if gauge and "offset" not in known and not symmetric:
        return fixed(gauge, units["offset"], WEIGHT)
    if "offset" in known or "offset" in estimates.values or "offset" in why:
        return _one("offset", estimates, why, known, units)
    return fixed(0.0, units["offset"], NO_OFFSET if both_ways and not symmetric else NO_OFFSET_ONE_WAY)


def delay_parameter(found: Delay | None, period: float, estimates: Estimates, given_s: float | None) -> Parameter:
    """The delay, s: given, refined, from the linear stage, or 0 where its interval holds 0."""
    if given_s is not None:
        return given(given_s, "s")
    if "delay_s" in estimates.values:
        low, high = estimates.ends("delay_s")
        low, value = max(low, 0.0), estimates.values["delay_s"]
        value = value if value > CLOCK * period else 0.0
        return fitted(value, (low, high), "s", negligible=period)
    assert found is not None
    low, high = found.low * period, found.high * period
    if found.used > 0.0:
        return Parameter(found.value * period, "s", low, high, "fitted", found.sharp)
    if high < 0.0:
        return fixed(
            0.0, "s", f"the motion leads the drive by {-found.value:.2g} periods, which no axis does: taken as 0"
        )
    if not found.sharp:
        return fixed(0.0, "s", f"not identifiable from the log, {low:.3g} to {high:.3g} s: taken as 0")
    note = "its 95 % interval holds 0: taken as 0"
    return Parameter(0.0, "s", min(low, 0.0), max(high, 0.0), "fitted", True, note)


FRICTION = ("coulomb", "static", "stribeck_speed", "viscous")
KEYS = (
    "mass", "offset", "backlash", "force_per_drive", "delay_s", "friction.stiffness", "friction.damping",
    *(friction_key(side, name) for side in SIDES for name in FRICTION),
)  # fmt: skip
POSITIVE = ("mass", "stribeck_speed")
ANY_SIGN = ("offset", "force_per_drive")


def checked(given: Mapping[str, float]) -> dict[str, float]:
    """The given values as floats.

    Raises:
        NameUnknown: no such key.
        ValueRefused: a value that no plant takes, or static friction without Coulomb friction.
    """
    found = {}
    for key, value in given.items():
        if key not in KEYS:
            raise NameUnknown(f"given: there is no parameter {key!r} of an axis{nearest(key, list(KEYS))}")
        number = validate.number(f"given.{key}", value, "")
        name = key.split(".")[-1]
        if name in POSITIVE and not number > 0.0:
            raise ValueRefused(f"given.{key} = {number:g}: must be above 0")
        if name not in ANY_SIGN and number < 0.0:
            raise ValueRefused(f"given.{key} = {number:g}: must be 0 or more")
        found[key] = number
    if found.get("force_per_drive") == 0.0:
        raise ValueRefused("given.force_per_drive = 0: such a drive pushes nothing")
    for side in SIDES:
        if friction_key(side, "static") in found and friction_key(side, "coulomb") not in found:
            raise ValueRefused(
                f"given.{friction_key(side, 'static')}: what is fitted is static less Coulomb friction, so give "
                f"{friction_key(side, 'coulomb')} too"
            )
    return found


def terms_known(given: Mapping[str, float]) -> dict[str, float]:
    """The given values by key of :class:`~leadscrew.identify.axis.inverse_dynamics.Terms`."""
    known = {}
    for key, value in given.items():
        if key in ("mass", "offset") or key.split(".")[-1] in ("coulomb", "viscous", "stribeck_speed"):
            known[key] = value
        elif key.endswith(".static"):
            known[key.replace(".static", ".excess")] = value - given[key.replace(".static", ".coulomb")]
    return known


def unlike(given: Mapping[str, float]) -> bool:
    """Whether what is given differs by direction."""
    return any(
        f"friction.backward.{name}" in given
        and given[f"friction.backward.{name}"] != given.get(f"friction.forward.{name}")
        for name in FRICTION
    )
