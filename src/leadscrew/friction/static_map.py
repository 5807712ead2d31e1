"""Static friction: Coulomb, viscous and Stribeck, each direction with values of its own.

Sliding at the speed ``v``, with the four values of that direction:

    F(v) = sgn(v) (F_C + (F_S - F_C) exp(-(v / v_s)^2)) + sigma_2 v
    F_S = F_C: Coulomb and viscous        F_C = F_S = 0: viscous        sigma_2 = 0, F_S = F_C: Coulomb

At rest the friction is what is pushed with, up to ``F_S`` of the direction of the push. So the map has a jump at rest;
it knows no bending before sliding, no memory, and no dependence on rates.

Source: R. Stribeck (1902) for the fall; the exponential form: B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit,
*A survey of models, analysis tools and compensation methods for the control of machines with friction*, Automatica 30
(1994) 1083. Default numbers: Canudas de Wit et al. (1995), Table I, a unit mass; that table has one set for both ways.

Signs as everywhere in this package: a positive ``F`` resists a positive ``v``.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.friction.lugre import level
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit


class Sliding(NamedTuple):
    """Friction of a slide against steady speed, in one direction."""

    coulomb: Annotated[float, Unit("N"), Ge(0), Doc("friction in fast sliding, F_C")] = 1.0
    static: Annotated[float, Unit("N"), Ge(0), Doc("largest friction before sliding, F_S")] = 1.5
    stribeck_speed: Annotated[float, Unit("m/s"), Gt(0), Doc("speed of the fall from F_S to F_C, v_s")] = 0.001
    viscous: Annotated[float, Unit("N s/m"), Ge(0), Doc("viscous coefficient, sigma_2")] = 0.4


class TwoSided(NamedTuple):
    """Friction against steady speed with values for each direction."""

    forward: Sliding = Sliding()
    backward: Sliding = Sliding()


def one_way(f, direction):
    """The values of the direction: ``forward`` for a positive number and 0, ``backward`` for a negative one."""
    ahead = direction >= 0.0
    return Sliding(
        f.forward.coulomb if ahead else f.backward.coulomb,
        f.forward.static if ahead else f.backward.static,
        f.forward.stribeck_speed if ahead else f.backward.stribeck_speed,
        f.forward.viscous if ahead else f.backward.viscous,
    )


def sliding_friction(f, v):
    """``F(v)`` of a :class:`TwoSided`; 0 at rest, where it is what :func:`resting_friction` says."""
    way = one_way(f, v)
    side = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    return side * level(way, v) + way.viscous * v


def resting_friction(f, push):
    """Friction at rest under ``push``: all of it, up to the static friction of its direction."""
    return min(max(push, -f.backward.static), f.forward.static)


def speed_after(f, v, push, mass, dt):
    """Speed after ``dt`` of a mass under a constant push, friction taken at the end of the step (implicit).

        w  = v + push dt / m
        v' = sgn(w) max(abs(w) - dt level / m, 0) / (1 + sigma_2 dt / m)

    ``level`` is that of the speed ``v``, at rest ``F_S``. A mass that friction can hold stands still exactly, without
    creep. First order in ``dt`` while the level changes; exact for Coulomb friction between stops.
    """
    free = v + push * dt / mass
    way = one_way(f, free)
    left = max(abs(free) - dt * level(way, v) / mass, 0.0)
    return math.copysign(left / (1.0 + way.viscous * dt / mass), free)
