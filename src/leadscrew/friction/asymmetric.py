"""LuGre friction of a slide, in newtons and metres, and with values for each direction.

    dz/dt = v - abs(v) z / g(v)       g(v) = g+(v) for v >= 0, g-(v) for v < 0
    F     = s0 z + s1 dz/dt + s2 v    s2 likewise

Equations and functions are those of :mod:`leadscrew.friction.lugre`; :func:`one_way_lugre` gives them the values of the
direction of motion. ``F_C``, ``F_S``, ``v_s`` and ``s2`` differ by direction. Stiffness and damping belong to the
bristles, which bend both ways: they must be common, or the force would jump at a reversal. At ``v = 0`` the two sides
meet, for ``|v| / g`` is 0 in both.

Source: Canudas de Wit et al. (1995), which says that g need not be symmetrical; numbers: its Table I, both sides alike.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.friction.static_map import Sliding, one_way
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit


class LuGreSlide(NamedTuple):
    """The six parameters of LuGre for a slide; Canudas de Wit et al. (1995), Table I."""

    stiffness: Annotated[float, Unit("N/m"), Gt(0), Doc("stiffness of the bristles, sigma_0")] = 1e5
    damping: Annotated[float, Unit("N s/m"), Ge(0), Doc("damping of the bristles, sigma_1")] = math.sqrt(1e5)
    viscous: Annotated[float, Unit("N s/m"), Ge(0), Doc("viscous coefficient, sigma_2")] = 0.4
    coulomb: Annotated[float, Unit("N"), Gt(0), Doc("friction in fast sliding, F_C")] = 1.0
    static: Annotated[float, Unit("N"), Gt(0), Doc("largest friction before sliding, F_S")] = 1.5
    stribeck_speed: Annotated[float, Unit("m/s"), Gt(0), Doc("speed of the fall from F_S to F_C, v_s")] = 0.001


class TwoSidedLuGre(NamedTuple):
    """LuGre with values for each direction."""

    stiffness: Annotated[float, Unit("N/m"), Gt(0), Doc("stiffness of the bristles, sigma_0")] = 1e5
    damping: Annotated[float, Unit("N s/m"), Ge(0), Doc("damping of the bristles, sigma_1")] = math.sqrt(1e5)
    forward: Sliding = Sliding()
    backward: Sliding = Sliding()


def one_way_lugre(f, v):
    """The six parameters that hold while moving at ``v``."""
    way = one_way(f, v)
    return LuGreSlide(f.stiffness, f.damping, way.viscous, way.coulomb, way.static, way.stribeck_speed)
