"""What the caller knows of an axis: values by key of the plant, checked, and as the linear stage takes them."""

from __future__ import annotations

from collections.abc import Mapping

from leadscrew.identify.axis.terms import SIDES, friction_key
from leadscrew.kernel import validate
from leadscrew.kernel.errors import NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest

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
    """The given values by key of :class:`~leadscrew.identify.axis.terms.Terms`."""
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
