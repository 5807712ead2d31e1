"""Parameters of the plant from a fit: both directions, what is given, and what is fixed and why."""

from __future__ import annotations

from collections.abc import Mapping

from leadscrew.identify.axis.delay import Delay
from leadscrew.identify.axis.intervals import Estimates, fixed, given, parameter
from leadscrew.identify.axis.result import Parameter
from leadscrew.identify.axis.terms import SIDES, friction_key

CLOCK = 2e-3
"""Periods; a delay below is 0."""
ONE_WAY = "the log moves one way only: taken as in the other direction"
WITH_OFFSET = "with the offset in it: while the axis moves one way the two act alike"
NO_OFFSET = (
    "fixed at 0: a constant force acts like Coulomb friction that differs by direction, and no log of drive and motion "
    "tells them apart; give the offset where it is known (a weight)"
)
WEIGHT = (
    "fixed at the offset that friction alike both ways has, since it is larger than friction (a weight): no log of "
    "drive and motion tells a constant force from Coulomb friction that differs by direction; give the offset where it "
    "is known"
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
        return parameter(estimates, key, units[key], note)
    return fixed(0.0, units[key], why.get(key, "the log does not tell it: fixed at 0"))


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
        return found._replace(told=False, note=WITH_OFFSET)
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
        return Parameter(value, "s", low, high, "fitted", high - low <= 2.0 * period)
    assert found is not None
    low, high = found.low * period, found.high * period
    if found.used > 0.0:
        return Parameter(found.value * period, "s", low, high, "fitted", found.sharp)
    if high < 0.0:
        return fixed(
            0.0, "s", f"the motion leads the drive by {-found.value:.2g} periods, which no axis does: taken as 0"
        )
    if not found.sharp:
        return fixed(0.0, "s", f"the log does not tell it, {low:.3g} to {high:.3g} s: taken as 0")
    note = "its 95 % interval holds 0: taken as 0"
    return Parameter(0.0, "s", min(low, 0.0), max(high, 0.0), "fitted", True, note)
