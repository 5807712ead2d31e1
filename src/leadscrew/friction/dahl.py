"""Dahl friction: a spring that yields, the older sister of LuGre; it depends on travel, not on speed.

    dF/dx = sigma (1 - sgn(v) F / F_C)^n         so dF/dt = v dF/dx
    total = F + sigma_2 v

The base may be negative (a force above ``F_C``): then its sign is kept, ``sgn(b) |b|^n``. Over a travel ``d`` without a
reversal, with ``b = 1 - sgn(d) F / F_C`` and ``a = sigma |d| / F_C``, the exact solution is

    n = 1:   b exp(-a)
    else:    sgn(b) max(abs(b)^(1-n) + (n - 1) a, 0)^(1 / (1-n))

Source: P. Dahl, *A solid friction model*, Aerospace Corp. TOR-0158(3107-18), 1968. With ``n = 1`` it
is LuGre without Stribeck (``F_S = F_C``) and without bristle damping. It has pre-sliding and hysteresis, and no static
friction above ``F_C``: no Stribeck curve and no stick-slip.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit


class Dahl(NamedTuple):
    """Dahl's model; the numbers are those of Canudas de Wit et al. (1995), Table I, as far as the model has them."""

    stiffness: Annotated[float, Unit("N/m"), Gt(0), Doc("slope at zero force, sigma")] = 1e5
    coulomb: Annotated[float, Unit("N"), Gt(0), Doc("force that long travel ends at, F_C")] = 1.0
    exponent: Annotated[float, Gt(0), Le(20), Doc("shape, n: below 1 brittle, 1 the usual choice, above 1 ductile")] = (
        1.0
    )
    viscous: Annotated[float, Unit("N s/m"), Ge(0), Doc("viscous coefficient, sigma_2")] = 0.4


def force_slope(f, direction, force):
    """``dF/dx`` while moving in this direction (its sign alone counts)."""
    side = 1.0 if direction > 0.0 else -1.0 if direction < 0.0 else 0.0
    base = 1.0 - side * force / f.coulomb
    return f.stiffness * math.copysign(math.pow(abs(base), f.exponent), base)


def force_rate(f, v, force):
    """``dF/dt``."""
    return v * force_slope(f, v, force)


def rate_by_force(f, v, force):
    """Partial derivative of ``dF/dt`` by the force."""
    side = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    size = max(abs(1.0 - side * force / f.coulomb), 1e-15)
    return -f.stiffness * f.exponent * math.pow(size, f.exponent - 1.0) * abs(v) / f.coulomb


def force_after(f, travel, force):
    """``F`` after a travel without a reversal: the exact solution."""
    side = 1.0 if travel >= 0.0 else -1.0
    base = 1.0 - side * force / f.coulomb
    way = f.stiffness * abs(travel) / f.coulomb
    plain = f.exponent == 1.0
    bent = 0.5 if plain else 1.0 - f.exponent
    size = max(abs(base), 1e-15)
    rest = max(math.pow(size, bent) - bent * way, 1e-300)
    other = 0.0 if bent > 0.0 and rest <= 1e-300 else math.pow(rest, 1.0 / bent)
    left = size * math.exp(-min(way, 700.0)) if plain else other
    return side * f.coulomb * (1.0 - math.copysign(left, base))
