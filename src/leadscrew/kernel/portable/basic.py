"""Signs, comparisons, rounding and remainders: all exact, the same bits in every engine."""

from __future__ import annotations

import math

from leadscrew.kernel.bits import bits_to_float, float_to_bits

NAN = float("nan")
INF = float("inf")
MAGNITUDE = 0x7FFFFFFFFFFFFFFF
"""All bits of a double but its sign."""
UPPER_HALF = -134217728
"""Keeps 26 of the 53 significant bits, so that the product of two such numbers is exact."""
INTEGERS_FROM = 4503599627370496.0
"""2**52: a double of this size or more is an integer."""
LARGEST_INT = 9223371487098961920
"""2**63 - 2**39, the largest number of 64 bits that a single-precision float holds too."""
QUOTIENT_LIMIT = 2251799813685248.0
"""2**51."""
STAGE = 67108864.0
"""2**26."""
STAGE_INVERSE = 1.4901161193847656e-08
NEGLIGIBLE = 1e-300


def fabs(x: float) -> float:
    """Size of ``x``: clears the sign bit, also of -0.0 and NaN. Exact."""
    return bits_to_float(float_to_bits(x) & MAGNITUDE)


def copysign(x: float, y: float) -> float:
    """Size of ``x`` with the sign bit of ``y``, also of -0.0; a NaN ``y`` counts as positive. Exact.

    Compilers and processors differ in the sign bit of the NaN that 0/0 gives.
    """
    size = fabs(x)
    return -size if (float_to_bits(y) < 0) & (y == y) else size


def sign(x: float) -> float:
    """1.0, 0.0 or -1.0; NaN of NaN. Exact."""
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else (0.0 if x == 0.0 else NAN))


def maximum(a, b):
    """``b if b > a else a``: of equals, and where one is NaN, the first."""
    return b if b > a else a


def minimum(a, b):
    """``b if b < a else a``: of equals, and where one is NaN, the first."""
    return b if b < a else a


def is_nan(x: float) -> bool:
    """Whether ``x`` is NaN."""
    return x != x


def is_finite(x: float) -> bool:
    """Whether ``x`` is neither NaN nor infinite."""
    return x - x == 0.0


def is_infinite(x: float) -> bool:
    """Whether ``x`` is plus or minus infinity."""
    return fabs(x) == INF


def flush(x: float) -> float:
    """0.0 where ``|x| < 1e-300``, else ``x``: a decaying state never turns denormal, which is 19 times slower."""
    return 0.0 if fabs(x) < NEGLIGIBLE else x


def sqrt(x: float) -> float:
    """Square root, correctly rounded (IEEE-754); -0.0 of -0.0, infinity of infinity, NaN below zero."""
    root = math.sqrt(x if x >= 0.0 else 0.0)
    return root if x >= 0.0 else NAN


def round_half_even(x: float) -> float:
    """The nearest integer as a float, the even one of two; keeps -0.0, infinities and NaN. Exact."""
    size = fabs(x)
    nearest = (size + INTEGERS_FROM) - INTEGERS_FROM
    nearest = nearest if size < INTEGERS_FROM else size
    return -nearest if float_to_bits(x) < 0 else nearest


def floor(x: float) -> float:
    """The largest integer not above ``x``, as a float; keeps -0.0, infinities and NaN. Exact."""
    nearest = round_half_even(x)
    return nearest - 1.0 if nearest > x else nearest


def ceil(x: float) -> float:
    """The smallest integer not below ``x``, as a float: -0.0 in (-1, 0); keeps -0.0, infinities and NaN. Exact."""
    nearest = round_half_even(x)
    above = -(-nearest - 1.0)
    return above if nearest < x else nearest


def trunc(x: float) -> float:
    """The integer part of ``x``, as a float; keeps the sign, infinities and NaN. Exact."""
    return copysign(floor(fabs(x)), x)


def to_int(x):
    """The integer part of ``x``: 0 of NaN, at most 2**63 - 2**39 in size.

    Numbers in (-1, 1) are set to 0 first: ``(double)(int64_t)x`` gives -0.0 of -0.5 with GCC's -fno-trapping-math.
    """
    held = minimum(maximum(x, -LARGEST_INT), LARGEST_INT)
    return int(held if fabs(x) >= 1.0 else 0)


def _upper_half(x: float) -> float:
    """The leading 26 bits of ``x``; ``x`` less this is exact too."""
    return bits_to_float(float_to_bits(x) & UPPER_HALF)


def _remainder(a: float, b: float) -> float:
    """``a - b*trunc(a/b)`` for finite ``a >= 0`` and ``b > 0``, exact while ``a/b < 2**51``."""
    upper = _upper_half(b)
    lower = b - upper
    stage = floor(a / b * STAGE_INVERSE) * STAGE
    # A quotient of 26 bits times either half of b is exact. It may come out one too large: the next stage mends it.
    rest = (a - stage * upper) - stage * lower
    count = floor(rest / b)
    rest = (rest - count * upper) - count * lower
    rest = rest + b if rest < 0.0 else rest
    return rest - b if rest >= b else rest


def _fmod(a: float, b: float) -> float:
    """C's ``fmod``: the remainder with the sign of ``a``; NaN also where ``|a/b| >= 2**51``. Exact."""
    top = fabs(a)
    size = fabs(b)
    divisor = size if size > 0.0 and size < INF else 1.0
    in_range = top / divisor < QUOTIENT_LIMIT
    rest = _remainder(top if in_range else 0.0, divisor)
    rest = rest if size > 0.0 and in_range else NAN
    rest = top if size == INF and top < INF else rest
    return copysign(rest, a)


def float_mod(a: float, b: float) -> float:
    """``a % b`` as Python has it for floats: the sign of ``b``, exact but for one rounding where signs differ.

    NaN where ``b`` is 0, ``a`` is infinite, either is NaN, or ``|a/b| >= 2**51`` (where Python still answers).
    """
    rest = _fmod(a, b)
    moved = rest if (rest < 0.0) == (b < 0.0) else rest + b
    return copysign(0.0, b) if rest == 0.0 else moved


def float_floordiv(a: float, b: float) -> float:
    """``a // b`` as Python has it for floats, and NaN wherever ``float_mod`` is NaN."""
    rest = _fmod(a, b)
    divisor = b if b != 0.0 else 1.0
    whole = (a - rest) / divisor
    whole = whole if rest == 0.0 or (rest < 0.0) == (b < 0.0) else whole - 1.0
    nearest = floor(whole)
    nearest = nearest + 1.0 if whole - nearest > 0.5 else nearest
    result = nearest if whole != 0.0 else copysign(0.0, a / divisor)
    return result if rest == rest else NAN


def int_floordiv(a: int, b: int) -> int:
    """``a // b`` as Python has it for integers up to 2**53 in size; 0 where ``b`` is 0."""
    divisor = b if b != 0 else 1
    guess = to_int(floor(float(a) / float(divisor)))
    rest = a - guess * divisor
    # The rounded quotient is off by at most one.
    below = rest < 0 if divisor > 0 else rest > 0
    above = rest >= divisor if divisor > 0 else rest <= divisor
    guess = guess - 1 if below else (guess + 1 if above else guess)
    return guess if b != 0 else 0


def int_mod(a: int, b: int) -> int:
    """``a % b`` as Python has it for integers up to 2**53 in size; 0 where ``b`` is 0."""
    return a - int_floordiv(a, b) * b if b != 0 else 0
