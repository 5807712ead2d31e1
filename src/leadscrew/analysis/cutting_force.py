"""Laws of the main cutting force in turning, what they share, and how one is turned into another.

With feed per revolution ``f`` (mm), depth of cut ``a`` (mm) and cutting edge angle ``kappa``, the chip is
``h = f sin(kappa)`` thick and ``b = a / sin(kappa)`` wide; its area is ``a f`` whatever the angle.

    power law       F = Kf a f^P
    Kienzle         F = kc11 b h^(1 - mc)                Kf = kc11 sin(kappa)^(-mc),   P = 1 - mc
    chip and edge   F = (Ktc h + Kte) b = Ktc a f + Kte a / sin(kappa)
    specific force  kc = F / (a f), N/mm^2

Power law and Kienzle's are one law in two notations. Kienzle's corrections for rake angle, cutting speed and wear are
left out: they multiply the force by a number, which a fit to forces of one tool at one speed takes into ``kc11``.

Sources: equation (1) of the paper of the study ``grey_turning``; Kienzle, VDI-Z 94 (1952); Altintas, *Manufacturing
Automation*, chapter 2 (the law of chip and edge).
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import Doc, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused

USUAL_KC = (500.0, 10000.0)
"""Specific cutting force of metals in turning, N/mm^2: outside of it a table has a wrong unit, or another material."""


class PowerLaw(NamedTuple):
    """``F = kf a f^exponent``; with a depth exponent ``F = kf a^depth_exponent f^exponent``."""

    kf: Annotated[float, Unit("N/mm^(1+P)"), Gt(0), Doc("force at 1 mm of depth and 1 mm of feed")]
    exponent: Annotated[float, Doc("P: how force grows with the feed")]
    depth_exponent: Annotated[float, Doc("how it grows with the depth; 1: in proportion")] = 1.0

    def force(self, feed: Any, depth: Any) -> np.ndarray:
        """Main cutting force in N; feed per revolution and depth in mm."""
        f, a = np.asarray(feed, dtype=np.float64), np.asarray(depth, dtype=np.float64)
        return np.asarray(self.kf * a**self.depth_exponent * f**self.exponent)


class Kienzle(NamedTuple):
    """``F = kc11 b h^(1 - mc)``."""

    kc11: Annotated[float, Unit("N/mm^2"), Gt(0), Doc("specific force of a chip 1 mm wide and 1 mm thick")]
    mc: Annotated[float, Doc("how the specific force falls with thickness")]
    kappa_deg: Annotated[float, Unit("deg"), Gt(0), Le(90), Doc("cutting edge angle")] = 90.0

    def force(self, feed: Any, depth: Any) -> np.ndarray:
        """Main cutting force in N; feed per revolution and depth in mm."""
        return self.power().force(feed, depth)

    def power(self) -> PowerLaw:
        """The same law as ``Kf a f^P``."""
        return PowerLaw(self.kc11 * _sine(self.kappa_deg) ** -self.mc, 1.0 - self.mc)


class ChipAndEdge(NamedTuple):
    """``F = Ktc a f + Kte b``: shearing in proportion to the chip's area, and what the edge takes by its length."""

    ktc: Annotated[float, Unit("N/mm^2"), Doc("force by area of the chip")]
    kte: Annotated[float, Unit("N/mm"), Doc("force by length of the edge")]
    kappa_deg: Annotated[float, Unit("deg"), Gt(0), Le(90), Doc("cutting edge angle")] = 90.0

    def force(self, feed: Any, depth: Any) -> np.ndarray:
        """Main cutting force in N; feed per revolution and depth in mm."""
        f, a = np.asarray(feed, dtype=np.float64), np.asarray(depth, dtype=np.float64)
        return np.asarray(self.ktc * a * f + self.kte * a / _sine(self.kappa_deg))


Law = PowerLaw | Kienzle | ChipAndEdge


def kienzle(law: PowerLaw, kappa_deg: float = 90.0) -> Kienzle:
    """A power law as Kienzle's, for a cutting edge angle.

    Raises:
        ValueRefused: an angle outside (0, 90] degrees; a law that is not in proportion to the depth.
    """
    if law.depth_exponent != 1.0:
        raise ValueRefused(
            f"depth_exponent = {law.depth_exponent:g}: Kienzle's law is in proportion to the depth; expected 1"
        )
    mc = 1.0 - law.exponent
    return Kienzle(law.kf * _sine(kappa_deg) ** mc, mc, kappa_deg)


def specific_force(force: Any, feed: Any, depth: Any) -> np.ndarray:
    """``kc = F / (a f)`` in N/mm^2."""
    return np.asarray(
        np.asarray(force, dtype=np.float64) / (np.asarray(feed, dtype=np.float64) * np.asarray(depth, dtype=np.float64))
    )


def feed_for(law: PowerLaw, force: float, depth: float) -> float:
    """The feed per revolution in mm at which a power law gives a force in N."""
    return float((force / (law.kf * depth**law.depth_exponent)) ** (1.0 / law.exponent))


def slope(law: PowerLaw, feed: float, depth: float) -> float:
    """``dF/df = P F / f`` in N per mm of feed per revolution; divided by the spindle speed it is per mm/min."""
    return float(law.exponent * law.force(feed, depth) / feed)


def r_squared(measured: Any, modelled: Any) -> float:
    """Share of the scatter about the mean that a model explains; NaN where there is no scatter."""
    y, m = np.asarray(measured, dtype=np.float64), np.asarray(modelled, dtype=np.float64)
    total = float(((y - y.mean()) ** 2).sum())
    return 1.0 - float(((y - m) ** 2).sum()) / total if total > 0.0 else math.nan


def _sine(kappa_deg: float) -> float:
    if not 0.0 < kappa_deg <= 90.0:
        raise ValueRefused(f"kappa = {kappa_deg!r}: allowed range is (0, 90] degrees")
    return math.sin(math.radians(kappa_deg))
