"""Why a move inside the limits does not tell a parameter well enough, and what would."""

from __future__ import annotations

import math

from leadscrew.identify.excite.belief import Belief
from leadscrew.identify.excite.limits import SHARE, Limits

RISE = 0.05
"""Share of the rise of friction towards rest above which the force that no model explains hides it, not the sensor."""


def why_not(key: str, belief: Belief, half: float, target: float, limits: Limits, duration: float) -> str:
    """A sentence: what limits the interval of a key, and how much more of what would meet the target."""
    name, unit = key.rsplit(".", 1)[-1], belief.unit
    level = max(belief.side("coulomb", True), belief.side("coulomb", False))
    if not math.isfinite(half):
        return "no part of a test inside these limits tells it"
    more = half / target if target > 0.0 else math.inf
    longer = f"; a test of about {_round(duration * more**2)} s would" if more < 6.0 else ""
    if name == "viscous":
        force = belief.of(key) * SHARE * limits.speed
        return (
            f"at the top speed of {_shown(limits.speed, unit)}/s it is {force:.3g} of {level + force:.3g} "
            f"{belief.force_unit}{longer}; a higher top speed tells it better in proportion"
        )
    if name == "coulomb":
        force = belief.of(key.replace("coulomb", "viscous")) * SHARE * limits.speed
        return (
            f"it trades with viscous friction, which reaches {force:.3g} {belief.force_unit} at the top speed"
            f"{longer}; a higher top speed or a longer test tells them apart"
        )
    if name == "mass":
        force = belief.of(key) * SHARE * limits.acceleration
        return (
            f"at the top acceleration of {_shown(limits.acceleration, unit)}/s^2 it takes {force:.3g} "
            f"{belief.force_unit} beside {level:.3g} of friction{longer}; a higher acceleration tells it better"
        )
    if name in ("static", "stribeck_speed"):
        slow = belief.side("stribeck_speed", True)
        rise = max(belief.side("static", ahead) - belief.side("coulomb", ahead) for ahead in (True, False))
        if belief.force_noise > RISE * rise:
            return (
                f"friction rises by {rise:.3g} {belief.force_unit} from sliding to rest, and no model explains a force "
                f"of {belief.force_noise:.3g}{longer}"
            )
        return (
            f"creeping at {_shown(slow, unit)}/s moves the axis by {slow * belief.period / belief.noise:.2g} times the "
            f"sensor's noise in a period{longer}; a finer sensor tells it"
        )
    if name in ("stiffness", "damping"):
        bend = max(belief.side("static", True), level) / max(belief.of("friction.stiffness"), 1e-300)
        return f"the bristles bend by {_shown(bend, unit)}, the sensor's noise is {_shown(belief.noise, unit)}{longer}"
    if name == "backlash":
        return f"the gap is {_shown(belief.of(key), unit)}, the sensor's noise {_shown(belief.noise, unit)}{longer}"
    return f"the sensor's noise is {_shown(belief.noise, unit)}{longer or '; a longer test or a finer sensor tells it'}"


def _round(seconds: float) -> str:
    return f"{seconds:.2g}" if seconds < 100.0 else f"{round(seconds, -1):.0f}"


def _shown(value: float, unit: str) -> str:
    """In mm or um where the unit is m."""
    if unit != "m":
        return f"{value:.3g} {unit}"
    return f"{1e3 * value:.3g} mm" if abs(value) >= 1e-4 else f"{1e6 * value:.3g} um"
