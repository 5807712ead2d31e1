"""Exponentials and logarithms in +, -, *, / and bit operations: the same bits in every engine.

The reductions are the classical ones of fdlibm (Sun Microsystems, 1993): ``x = k ln 2 + r`` with ln 2 in two
parts, ``x = 2**k m`` with m in [sqrt(1/2), sqrt(2)) and ``s = (m - 1)/(m + 1)``. The polynomial coefficients are
our own: they interpolate the function at Chebyshev nodes, computed with mpmath at 60 digits.
"""

from __future__ import annotations

from leadscrew.kernel.bits import bits_to_float, float_to_bits
from leadscrew.kernel.portable.basic import INF, NAN, UPPER_HALF, fabs, maximum, minimum

LOG2_E = 1.4426950408889634
LN2_UPPER = 6.93147180369123816490e-01
"""The leading 32 bits of ln 2: its product with an exponent is exact."""
LN2_LOWER = 1.90821492927058770002e-10
ROUNDER = 6755399441055744.0
"""1.5 * 2**52: added and taken away again, it rounds to an integer, which the low bits of the sum then show."""
EXPONENTS = 2046
"""Twice the bias of the exponent field: keeps the sum of two biased exponents positive."""
ROUNDER_DOUBLE_BIAS = ROUNDER + 2046.0
ROUNDER_BIAS = ROUNDER + 1023.0
FIELD_DOUBLE = 4095
FIELD = 2047

SMALLEST_NORMAL = 2.2250738585072014e-308
TWO_54 = 18014398509481984.0
SQRT_HALF_BITS = 0x3FE6A09E667F3BCD
SQRT_HALF_TO_ONE = 0x00095F619980C433
"""Bits of 1.0 less bits of sqrt(1/2): added, it moves the step between exponents to sqrt(1/2)."""
MANTISSA = 0x000FFFFFFFFFFFFF
INTEGER_BITS = 0x4330000000000000
"""Bits of 2**52: or-ed to a small integer they make the double 2**52 + integer."""
INTEGER_BIAS = 4503599627371519.0
INTEGER_BIAS_54 = 4503599627371573.0

COARSE = -68719476736
"""Keeps 17 significant bits: the cube of such a number is exact."""
CUBIC_TO_LOG2 = 0.9617966939259756
"""2/(3 ln 2), and its leading 26 bits and rest."""
CUBIC_TO_LOG2_UPPER = 0.9617966860532761
CUBIC_TO_LOG2_LOWER = 7.872699542894897e-09
CUBIC_TO_LOG10_UPPER = 0.2895296514034271
CUBIC_TO_LOG10_LOWER = 3.198740761077315e-09
CUBIC_TO_LOG10 = 0.28952965460216784
LOG10_2_UPPER = 0.30102999566361177
LOG10_2_LOWER = 3.694239077158931e-13

# (exp(r) - 1 - r)/r**2 on |r| <= ln(2)/2
EXP0 = 0.5000000000000001
EXP1 = 0.16666666666666669
EXP2 = 0.041666666666623824
EXP3 = 0.008333333333330039
EXP4 = 0.0013888888917367081
EXP5 = 0.00019841269863171557
EXP6 = 2.4801521057868204e-05
EXP7 = 2.7557268276905696e-06
EXP8 = 2.7620201591031547e-07
EXP9 = 2.5100472505694996e-08
# (log(1 + f)/s - 2)/z with z = s**2
LOG0 = 0.6666666666666666
LOG1 = 0.4000000000000088
LOG2 = 0.2857142857080323
LOG3 = 0.2222222239180047
LOG4 = 0.18181795630884753
LOG5 = 0.15386240205813478
LOG6 = 0.13268759668560612
LOG7 = 0.13086767009948175
# (3 atanh(s)/s - 3 - z)/z**2
PW0 = 0.6
PW1 = 0.4285714285714405
PW2 = 0.3333333333248383
PW3 = 0.272727275030892
PW4 = 0.23076892443777647
PW5 = 0.20002207040770967
PW6 = 0.1755935450923681
PW7 = 0.17584767935814777


def _exp_polynomial(r: float) -> float:
    """``(exp(r) - 1 - r)/r**2`` for ``|r| <= ln(2)/2``."""
    r2 = r * r
    r4 = r2 * r2
    low = (EXP0 + EXP1 * r) + r2 * (EXP2 + EXP3 * r)
    high = (EXP4 + EXP5 * r) + r2 * (EXP6 + EXP7 * r)
    return low + r4 * (high + r4 * (EXP8 + EXP9 * r))


def _exp_scaled(x: float, doublings: int) -> float:
    """``exp(x) * 2**doublings`` for ``doublings`` of 0 or -1."""
    held = minimum(maximum(x, -746.0), 711.0)
    shifted = held * LOG2_E + ROUNDER_DOUBLE_BIAS
    k = shifted - ROUNDER_DOUBLE_BIAS
    r = (held - k * LN2_UPPER) - k * LN2_LOWER
    p = 1.0 + (r + r * r * _exp_polynomial(r))
    # Two factors, so that the result may overflow or turn subnormal with one rounding only.
    exponents = (float_to_bits(shifted) + doublings) & FIELD_DOUBLE
    first = exponents >> 1
    return p * bits_to_float(first << 52) * bits_to_float(((exponents - first) & FIELD) << 52)


def exp(x: float) -> float:
    """The number e to the power ``x``.

    Range: all doubles. Error: at most 1.1 ulp, measured, subnormal results included.
    exp(-inf) = 0, exp(inf) = inf, NaN of NaN; 0 below -745.14, inf above 709.79.
    """
    return _exp_scaled(x, 0)


def _expm1_parts(x: float):
    """``exp(x) - 1`` as a double and its rounding error, for ``|x| <= 50`` (held there beyond)."""
    held = minimum(maximum(x, -50.0), 50.0)
    shifted = held * LOG2_E + ROUNDER_BIAS
    k = shifted - ROUNDER_BIAS
    upper = held - k * LN2_UPPER
    lower = k * LN2_LOWER
    r = upper - lower
    r_rest = (upper - r) - lower
    scale = bits_to_float((float_to_bits(shifted) & FIELD) << 52)
    ones = scale - 1.0
    linear = scale * r
    sum_ = ones + linear
    part = sum_ - ones
    rest = (ones - (sum_ - part)) + (linear - part)
    rest = rest + scale * ((r_rest + r_rest * r) + r * r * _exp_polynomial(r))
    result = sum_ + rest
    return result, rest - (result - sum_)


def expm1(x: float) -> float:
    """The number e to the power ``x``, less 1, without loss near 0.

    Range: all doubles. Error: at most 1.5 ulp, measured. Keeps -0.0; expm1(-inf) = -1, expm1(inf) = inf, NaN of NaN.
    """
    near, _ = _expm1_parts(x)
    result = exp(x) if x > 45.0 else near
    return x if fabs(x) < 1e-17 else result


def _exponent_and_mantissa(x: float):
    """``k, m - 1`` with ``x = 2**k m``, m in [sqrt(1/2), sqrt(2)), for positive finite ``x``; exact."""
    subnormal = x < SMALLEST_NORMAL
    normal = x * TWO_54 if subnormal else x
    moved = float_to_bits(normal) + SQRT_HALF_TO_ONE
    # (2**52 + field) - (2**52 + bias): a conversion from integer that vector units have.
    k = bits_to_float((moved >> 52) | INTEGER_BITS) - (INTEGER_BIAS_54 if subnormal else INTEGER_BIAS)
    return k, bits_to_float((moved & MANTISSA) + SQRT_HALF_BITS) - 1.0


def log(x: float) -> float:
    """Natural logarithm.

    Range: all doubles, subnormals included. Error: at most 0.9 ulp, measured.
    log(0) = -inf, NaN below zero, log(inf) = inf, NaN of NaN.
    """
    held = x if x > 0.0 else 1.0
    k, f = _exponent_and_mantissa(held)
    s = f / (2.0 + f)
    z = s * s
    z2 = z * z
    z4 = z2 * z2
    tail = ((LOG0 + LOG1 * z) + z2 * (LOG2 + LOG3 * z)) + z4 * ((LOG4 + LOG5 * z) + z2 * (LOG6 + LOG7 * z))
    half_square = 0.5 * f * f
    result = k * LN2_UPPER - ((half_square - (s * (half_square + z * tail) + k * LN2_LOWER)) - f)
    result = result if x < INF else INF
    return result if x > 0.0 else (-INF if x == 0.0 else NAN)


def log1p(x: float) -> float:
    """Natural logarithm of ``1 + x``, without loss near 0.

    Range: x > -1. Error: at most 1.6 ulp, measured. Keeps -0.0; log1p(-1) = -inf, NaN below, log1p(inf) = inf.
    """
    u = 1.0 + x
    part = u - 1.0
    lost = (1.0 - (u - part)) + (x - part)
    result = log(u) + (lost / (u if u > 0.0 else 1.0) if u < INF else 0.0)
    return x if fabs(x) < 1e-17 else result


def _log_parts(x: float):
    """``k, upper, rest`` with ``log(x) = k ln 2 + 2/3 (upper + rest)``, for positive finite ``x``.

    ``upper`` has 26 bits, ``rest`` follows it: together about 66 bits of ``3 atanh(s)``, s = (m - 1)/(m + 1). The
    leading terms 3 s + s**3 are kept exact by hand: s in parts of 26 bits (and its cube from 17 bits).
    """
    k, f = _exponent_and_mantissa(x)
    d = 2.0 + f
    d_upper = bits_to_float(float_to_bits(d) & UPPER_HALF)
    d_lower = (d - d_upper) + (f - (d - 2.0))
    inverse = 1.0 / d
    s = f * inverse
    s_upper = bits_to_float(float_to_bits(s) & UPPER_HALF)
    s_lower = ((f - s_upper * d_upper) - s_upper * d_lower) * inverse
    z = s * s
    upper = bits_to_float(float_to_bits(3.0 * s + s * z * (1.0 + 0.6 * z)) & UPPER_HALF)
    coarse = bits_to_float(float_to_bits(s) & COARSE)
    finer = (s_upper - coarse) + s_lower
    z2 = z * z
    z4 = z2 * z2
    tail = ((PW0 + PW1 * z) + z2 * (PW2 + PW3 * z)) + z4 * ((PW4 + PW5 * z) + z2 * (PW6 + PW7 * z))
    square = coarse * coarse
    # 0.6 s**5 with the rounding error of s taken back: five times that error would show in the last bit of pow.
    fifth = (z2 * s) * tail + (3.0 * z2) * ((s_upper - s) + s_lower)
    rest = 3.0 * s_lower + (finer * (z + s * coarse + square) + fifth)
    return k, upper, ((3.0 * s_upper - upper) + square * coarse) + rest


def log2(x: float) -> float:
    """Logarithm to base 2.

    Range: all doubles, subnormals included. Error: at most 0.55 ulp, measured; exact for powers of two.
    log2(0) = -inf, NaN below zero, log2(inf) = inf, NaN of NaN.
    """
    held = x if x > 0.0 else 1.0
    k, upper, rest = _log_parts(held if held < INF else 1.0)
    head = CUBIC_TO_LOG2_UPPER * upper
    sum_ = k + head
    part = sum_ - k
    lost = (k - (sum_ - part)) + (head - part)
    result = sum_ + (lost + (CUBIC_TO_LOG2_LOWER * upper + CUBIC_TO_LOG2 * rest))
    result = result if x < INF else INF
    return result if x > 0.0 else (-INF if x == 0.0 else NAN)


def log10(x: float) -> float:
    """Logarithm to base 10.

    Range: all doubles, subnormals included. Error: at most 0.55 ulp, measured.
    log10(0) = -inf, NaN below zero, log10(inf) = inf, NaN of NaN.
    """
    held = x if x > 0.0 else 1.0
    k, upper, rest = _log_parts(held if held < INF else 1.0)
    whole = k * LOG10_2_UPPER
    head = CUBIC_TO_LOG10_UPPER * upper
    sum_ = whole + head
    part = sum_ - whole
    lost = (whole - (sum_ - part)) + (head - part)
    result = sum_ + (lost + (k * LOG10_2_LOWER + (CUBIC_TO_LOG10_LOWER * upper + CUBIC_TO_LOG10 * rest)))
    result = result if x < INF else INF
    return result if x > 0.0 else (-INF if x == 0.0 else NAN)
