"""The terms of an axis that are linear in what is sought, sample by sample.

    u = M a + offset + C sgn v + B v + (S - C) sgn v exp(-(v / v_s)^2)

``C``, ``B`` and ``S - C`` once for both directions, or once for each. By direction there is no offset beside them: a
constant force pushes like a Coulomb friction that is larger one way and smaller the other, at rest as in motion, and no
log of drive and motion can tell the two apart. It is then counted as friction, unless it is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from leadscrew.identify.axis.filters import Samples

SIDES = ("forward", "backward")


def friction_key(side: str, name: str) -> str:
    """Dotted key of a friction parameter."""
    return f"friction.{side}.{name}"


@dataclass(frozen=True)
class Terms:
    """Which terms a model has, and which of them are known."""

    symmetric: bool = True
    stribeck_speed: tuple[float, float] | None = None
    """Of both directions; None: no Stribeck term."""
    known: Mapping[str, float] = field(default_factory=dict)
    """Values that are not sought, by key; ``friction.*.excess`` stands for static less Coulomb friction."""
    without: frozenset[str] = frozenset()
    """Keys that the log cannot tell: left out, which is 0."""

    @property
    def keys(self) -> tuple[str, ...]:
        """All terms of the model, known ones too; symmetric friction has the keys of ``forward``."""
        sides = SIDES[:1] if self.symmetric else SIDES
        names = ["coulomb", "viscous"] + (["excess"] if self.stribeck_speed else [])
        found = ["mass", *(friction_key(s, n) for n in names for s in sides), "offset"]
        if not self.symmetric and "offset" not in self.known:
            found.remove("offset")
        return tuple(key for key in found if key not in self.without)

    @property
    def sought(self) -> tuple[str, ...]:
        """The terms that a fit finds."""
        return tuple(key for key in self.keys if key not in self.known)


def columns(samples: Samples, terms: Terms, keys: Sequence[str]) -> np.ndarray:
    """What one unit of each key makes of force, shape (samples, keys)."""
    return np.column_stack([_column(samples, terms, key) for key in keys])


def _column(s: Samples, terms: Terms, key: str) -> np.ndarray:
    if key == "mass":
        return s.acceleration
    if key == "offset":
        return np.ones_like(s.speed)
    _, side, name = key.split(".")
    share = np.ones_like(s.sign) if terms.symmetric else 0.5 * (1.0 + (1.0 if side == "forward" else -1.0) * s.sign)
    way = s.sign if terms.symmetric else share * (1.0 if side == "forward" else -1.0)
    if name == "coulomb":
        return way
    if name == "viscous":
        return share * s.speed
    assert terms.stribeck_speed is not None
    fall = terms.stribeck_speed[0 if side == "forward" else 1]
    return np.asarray(way * np.exp(-((s.smooth / fall) ** 2)))
