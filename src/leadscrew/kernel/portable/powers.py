"""Powers and roots: the same bits in every engine. Coefficients as in ``exponential``."""

from __future__ import annotations

from leadscrew.kernel.bits import bits_to_float, float_to_bits
from leadscrew.kernel.portable.basic import (
    INF,
    INTEGERS_FROM,
    NAN,
    UPPER_HALF,
    copysign,
    fabs,
    maximum,
    minimum,
    sqrt,
)
from leadscrew.kernel.portable.exponential import (
    CUBIC_TO_LOG2,
    CUBIC_TO_LOG2_LOWER,
    CUBIC_TO_LOG2_UPPER,
    FIELD,
    FIELD_DOUBLE,
    ROUNDER_DOUBLE_BIAS,
    SMALLEST_NORMAL,
    TWO_54,
    _log_parts,
)

LARGEST_EXPONENT = 1e300
LN2 = 0.6931471805599453
TWO_600 = 4.149515568880993e180
TWO_MINUS_600 = 2.409919865102884e-181
ONE_BITS = 0x3FF0000000000000
MANTISSA = 0x000FFFFFFFFFFFFF

# (2**g - 1 - g ln 2)/g**2 on |g| <= 0.51
TWO0 = 0.24022650695910078
TWO1 = 0.05550410866482158
TWO2 = 0.00961812910761698
TWO3 = 0.0013333558146422315
TWO4 = 0.00015403530428739626
TWO5 = 1.5252733822908288e-05
TWO6 = 1.3215448732985857e-06
TWO7 = 1.0178065721518527e-07
TWO8 = 7.0716276672710415e-09
TWO9 = 4.4544497768977116e-10
# cbrt(m) on [1, 2], to 1.3e-5
CBRT0 = 0.5092481335492415
CBRT1 = 0.7117423866025924
CBRT2 = -0.2939541180848237
CBRT3 = 0.08307903547963541
CBRT4 = -0.010102212336338642
CBRT_2 = 1.2599210498948732
CBRT_4 = 1.5874010519681994


def pow(x: float, y: float) -> float:
    """``x`` to the power ``y``.

    Range: all doubles. Error: at most 1.6 ulp, measured where the result is a normal number.
    As C99 has it: 1 where y is 0 or x is 1, whatever the other; NaN of a finite negative x to a power that is not
    an integer; the sign of x (also of -0.0) kept for odd integers y; 0 and infinite x give 0 or inf.

    ``y log2(x) = n + g``, log2(x) to about 66 bits from ``_log_parts``; then ``2**n 2**g``. What decides n and the
    bulk of g runs ahead on products of 26 bit halves, which are exact; all small terms join in one sum, late.
    """
    size = fabs(x)
    held = size if size > 0.0 else 1.0
    k, upper, rest = _log_parts(held if held < INF else 1.0)

    held_y = minimum(maximum(y, -LARGEST_EXPONENT), LARGEST_EXPONENT)
    y_upper = bits_to_float(float_to_bits(held_y) & UPPER_HALF)
    y_lower = held_y - y_upper
    factor = held_y * CUBIC_TO_LOG2
    factor_upper = bits_to_float(float_to_bits(factor) & UPPER_HALF)
    factor_lower = (y_upper * CUBIC_TO_LOG2_UPPER - factor_upper) + (
        y_lower * CUBIC_TO_LOG2_UPPER + held_y * CUBIC_TO_LOG2_LOWER
    )

    whole = y_upper * k
    part = factor_upper * upper
    exponent = whole + part
    shifted = exponent + ROUNDER_DOUBLE_BIAS
    n = shifted - ROUNDER_DOUBLE_BIAS
    small = y_lower * k + (factor_lower * upper + factor * rest)
    g = ((whole - n) + part) + small

    g2 = g * g
    g4 = g2 * g2
    low = (TWO0 + TWO1 * g) + g2 * (TWO2 + TWO3 * g)
    high = (TWO4 + TWO5 * g) + g2 * (TWO6 + TWO7 * g)
    p = 1.0 + (g * LN2 + g2 * (low + g4 * (high + g4 * (TWO8 + TWO9 * g))))

    exponents = float_to_bits(shifted) & FIELD_DOUBLE
    first = exponents >> 1
    power = p * bits_to_float(first << 52) * bits_to_float(((exponents - first) & FIELD) << 52)
    power = INF if exponent > 1025.0 else power
    power = 0.0 if exponent < -1080.0 else power

    limit = (INF if y > 0.0 else 0.0) if size > 1.0 else (0.0 if y > 0.0 else INF)
    power = limit if size == 0.0 else (limit if size == INF else power)

    size_y = fabs(y)
    half_y = 0.5 * size_y
    whole_y = (size_y + INTEGERS_FROM) - INTEGERS_FROM if size_y < INTEGERS_FROM else size_y
    whole_half_y = (half_y + INTEGERS_FROM) - INTEGERS_FROM if half_y < INTEGERS_FROM else half_y
    no_real_power = power if size == 0.0 else (power if size == INF else NAN)
    mirrored = (power if whole_half_y == half_y else -power) if whole_y == size_y else no_real_power
    power = mirrored if float_to_bits(x) < 0 else power

    power = power if x == x else NAN
    power = power if y == y else NAN
    return 1.0 if y == 0.0 else (1.0 if x == 1.0 else power)


def hypot(x: float, y: float) -> float:
    """``sqrt(x**2 + y**2)`` without overflow or underflow on the way.

    Range: all doubles. Error: at most 1.2 ulp, measured. inf where either is infinite, even if the other is NaN.
    """
    a = fabs(x)
    b = fabs(y)
    larger = maximum(a, b)
    scale = TWO_MINUS_600 if larger > 1e150 else (TWO_600 if larger < 1e-150 else 1.0)
    unscale = TWO_600 if larger > 1e150 else (TWO_MINUS_600 if larger < 1e-150 else 1.0)
    a_scaled = a * scale
    b_scaled = b * scale
    result = sqrt(a_scaled * a_scaled + b_scaled * b_scaled) * unscale
    return INF if a == INF else (INF if b == INF else result)


def cbrt(x: float) -> float:
    """Cube root.

    Range: all doubles. Error: at most 0.7 ulp, measured. Keeps -0.0, infinities and NaN.
    A polynomial on [1, 2), then one step of Newton and one of Halley whose square is exact (fdlibm's way).
    """
    size = fabs(x)
    subnormal = size < SMALLEST_NORMAL
    held = size * TWO_54 if subnormal else size
    bits = float_to_bits(held)
    # The bias 1023 and the 54 of subnormals are multiples of 3; n/3 as n*21846 >> 16.
    field = bits >> 52
    third = (field * 21846) >> 16
    over = field - 3 * third
    m = bits_to_float((bits & MANTISSA) | ONE_BITS)
    m2 = m * m
    guess = (CBRT0 + CBRT1 * m) + m2 * ((CBRT2 + CBRT3 * m) + m2 * CBRT4)
    guess = guess * (CBRT_4 if over == 2 else (CBRT_2 if over == 1 else 1.0))
    cube = m * (4.0 if over == 2 else (2.0 if over == 1 else 1.0))
    guess = guess - (guess - cube / (guess * guess)) * 0.3333333333333333
    guess = bits_to_float(float_to_bits(guess) & UPPER_HALF)
    ratio = cube / (guess * guess)
    root = guess + guess * ((ratio - guess) / (guess + guess + ratio))
    root = root * bits_to_float((third + 1023 - (359 if subnormal else 341)) << 52)
    return x if size == 0.0 else copysign(root if size < INF else size, x)
