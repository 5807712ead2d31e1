"""Hyperbolic functions: the same bits in every engine. Coefficients as in ``exponential``."""

from __future__ import annotations

from leadscrew.kernel.portable.basic import copysign, fabs
from leadscrew.kernel.portable.exponential import _exp_scaled, _expm1_parts

# (sinh(x)/x - 1)/z with z = x**2 <= 1
SINH0 = 0.16666666666666666
SINH1 = 0.008333333333333299
SINH2 = 0.00019841269841324198
SINH3 = 2.7557319191381816e-06
SINH4 = 2.5052117695907823e-08
SINH5 = 1.6057679623801638e-10
SINH6 = 7.746178593018827e-13


def tanh(x: float) -> float:
    """Hyperbolic tangent, ``-e/(2 + e)`` with ``e = exp(-2|x|) - 1`` carried to extra bits.

    Range: all doubles. Error: at most 1.4 ulp, measured. Keeps -0.0; 1 or -1 of the infinities, NaN of NaN.
    """
    e, e_lost = _expm1_parts(-2.0 * fabs(x))
    bottom = 2.0 + e
    bottom_lost = (2.0 - bottom) + e + e_lost
    quotient = e / bottom
    result = copysign(quotient + (e_lost - quotient * bottom_lost) / bottom, x)
    return x if fabs(x) < 1e-17 else result


def cosh(x: float) -> float:
    """Hyperbolic cosine, ``h + 1/(4 h)`` with ``h = exp(|x|)/2``.

    Range: all doubles. Error: at most 1.5 ulp, measured. inf above 710.47, NaN of NaN.
    """
    half = _exp_scaled(fabs(x), -1)
    return half + 0.25 / half


def sinh(x: float) -> float:
    """Hyperbolic sine: a polynomial below 1, ``h - 1/(4 h)`` with ``h = exp(|x|)/2`` above.

    Range: all doubles. Error: at most 1.7 ulp, measured. Keeps -0.0; inf above 710.47, NaN of NaN.
    """
    size = fabs(x)
    half = _exp_scaled(size, -1)
    z = x * x
    z2 = z * z
    tail = ((SINH0 + SINH1 * z) + z2 * (SINH2 + SINH3 * z)) + (z2 * z2) * ((SINH4 + SINH5 * z) + z2 * SINH6)
    return copysign(half - 0.25 / half if size > 1.0 else size + size * (z * tail), x)
