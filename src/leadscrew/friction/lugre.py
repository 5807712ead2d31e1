"""LuGre friction: bristles that bend, creep and slip. Equations (1) to (3) of Shams and Safdari (2010).

    dz/dt = v - abs(v) z / g(v)                                               (1)
    F     = s0 z + s1 dz/dt + s2 v                                            (2)
    s0 g(v) = F_C + (F_S - F_C) exp(-(v / v_s)^2)                             (3)

Source: C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, *A new model for control of systems with friction*,
IEEE Trans. Automatic Control 40 (3), 1995. The paper prints the exponent's speed as v_v; v_s is meant.

``v`` is the speed, ``z`` the mean deflection of the bristles. Everything here is in rotary units (rad, N m) because
the stage's equations are; the model itself does not mind.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit

FAR = 700.0
"""Exponents of (3) and of the relaxation are cut here: e^-700 is 1e-304, and beyond begin denormal numbers."""


class Stribeck(NamedTuple):
    """Friction against steady speed, without bristles: Coulomb, static and viscous; the column of F~ in Table 2."""

    coulomb: Annotated[float, Unit("N m"), Gt(0), Doc("friction in fast sliding, F_C")] = 6.24
    static: Annotated[float, Unit("N m"), Gt(0), Doc("largest friction before sliding, F_S")] = 9.36
    stribeck_speed: Annotated[float, Unit("rad/s"), Gt(0), Doc("speed of the fall from F_S to F_C, v_s")] = 0.005
    viscous: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("viscous coefficient, sigma_2")] = 1.0


class LuGre(NamedTuple):
    """The model's six parameters; the column of the true plant in Table 2."""

    stiffness: Annotated[float, Unit("N m/rad"), Gt(0), Doc("stiffness of the bristles, sigma_0")] = 1e5
    damping: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("damping of the bristles, sigma_1")] = math.sqrt(1e5)
    viscous: Annotated[float, Unit("N m s/rad"), Ge(0), Doc("viscous coefficient, sigma_2")] = 0.4
    coulomb: Annotated[float, Unit("N m"), Gt(0), Doc("friction in fast sliding, F_C")] = 6.24
    static: Annotated[float, Unit("N m"), Gt(0), Doc("largest friction before sliding, F_S")] = 9.36
    stribeck_speed: Annotated[float, Unit("rad/s"), Gt(0), Doc("speed of the fall from F_S to F_C, v_s")] = 0.001


HAT = LuGre(stiffness=2e5, damping=2.0 * math.sqrt(1e5), viscous=1.2, stribeck_speed=0.005)
"""What the controllers believe: the column of f-hat in Table 2."""

TILDE = LuGre(stiffness=1e5, damping=math.sqrt(1e5), viscous=1.0, stribeck_speed=0.005)
"""How far the belief may be off: the column of F~ in Table 2. The switching gain uses the :class:`Stribeck` part."""

TABLE_2 = {"plant": LuGre(), "hat": HAT, "tilde": TILDE}
"""Table 2 by its columns. ``sigma_0`` and ``sigma_1`` of tilde are hat minus plant, its ``sigma_2`` 1 covers their 0.8;
``F_C`` and ``F_S`` are the same in all three, so what matters most is known exactly."""


def level(f, v):
    """``s0 g(v)``, (3): the friction of bristles in steady sliding, without the viscous part."""
    ratio = v / f.stribeck_speed
    return f.coulomb + (f.static - f.coulomb) * math.exp(-min(ratio * ratio, FAR))


def level_slope(f, v):
    """Derivative of :func:`level` with respect to the speed."""
    return -2.0 * v / (f.stribeck_speed * f.stribeck_speed) * (level(f, v) - f.coulomb)


def steady_friction(f, v):
    """Size of the friction in steady sliding at ``v``; at rest the largest that static friction can be."""
    return level(f, v) + f.viscous * abs(v)


def bristle_rate(f, v, z):
    """``dz/dt``, (1)."""
    return v - abs(v) * z * f.stiffness / level(f, v)


def friction(f, v, z, rate):
    """``F``, (2), where ``rate`` is ``dz/dt``."""
    return f.stiffness * z + f.damping * rate + f.viscous * v


def steady_bristle(f, v):
    """Deflection in steady sliding at ``v``; 0 at rest."""
    size = level(f, v) / f.stiffness
    return size if v > 0.0 else -size if v < 0.0 else 0.0


def bristle_after(f, v, z, dt):
    """Deflection after ``dt`` at a constant speed: the exact solution of (1)."""
    size = level(f, v) / f.stiffness
    gone = -math.expm1(-min(abs(v) / size * dt, FAR))
    return z + (steady_bristle(f, v) - z) * gone


def rate_by_speed(f, v, z):
    """Partial derivative of (1) by the speed; at ``v = 0``, a kink, the mean of both sides."""
    g = level(f, v)
    side = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    return 1.0 - f.stiffness * z / g * (side - abs(v) * level_slope(f, v) / g)


def rate_by_bristle(f, v):
    """Partial derivative of (1) by the deflection."""
    return -abs(v) * f.stiffness / level(f, v)
