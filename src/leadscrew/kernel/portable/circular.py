"""Circular functions and their inverses: the same bits in every engine.

Reductions and the order of summing follow fdlibm (Sun Microsystems, 1993); the polynomial coefficients are our own
(interpolation at Chebyshev nodes, mpmath at 60 digits).
"""

from __future__ import annotations

from leadscrew.kernel.bits import bits_to_float, float_to_bits
from leadscrew.kernel.portable.basic import INF, NAN, UPPER_HALF, copysign, fabs, sqrt
from leadscrew.kernel.portable.exponential import ROUNDER

TWO_OVER_PI = 0.6366197723675814
# pi/2 in parts of 30 bits, so that their products with a quadrant number up to 2**23 are exact.
HALF_PI_1 = 1.570796325802803
HALF_PI_2 = 9.920935791635221e-10
HALF_PI_3 = 5.17018297889025e-19
HALF_PI_4 = 2.9038559739793605e-28
ANGLE_LIMIT = 1e12
TINY_ANGLE = 7.450580596923828e-09
"""2**-27: below it sin(x) and tan(x) are x to the last bit."""

QUARTER_PI = 0.7853981633974483
QUARTER_PI_REST = 3.061616997868383e-17
HALF_PI = 1.5707963267948966
HALF_PI_REST = 6.123233995736766e-17
THREE_QUARTER_PI = 2.356194490192345
THREE_QUARTER_PI_REST = 9.184850993605148e-17
PI = 3.141592653589793
PI_REST = 1.2246467991473532e-16
TAN_EIGHTH_PI = 0.41421356237309503

# (sin(x)/x - 1)/z with z = x**2 <= (pi/4)**2
SIN0 = -0.16666666666666666
SIN1 = 0.008333333333330936
SIN2 = -0.00019841269836740527
SIN3 = 2.7557316093196066e-06
SIN4 = -2.5051129895962807e-08
SIN5 = 1.5917988944318716e-10
# (cos(x) - 1 + z/2)/z**2
COS0 = 0.041666666666666664
COS1 = -0.0013888888888887389
COS2 = 2.48015872987544e-05
COS3 = -2.7557317265876615e-07
COS4 = 2.087614504910828e-09
COS5 = -1.1382544623404291e-11
# (atan(t)/t - 1)/z on |t| <= tan(pi/8)
ATAN0 = -0.3333333333333333
ATAN1 = 0.19999999999995438
ATAN2 = -0.14285714284649173
ATAN3 = 0.11111111013860688
ATAN4 = -0.0909090452147169
ATAN5 = 0.07692181876036845
ATAN6 = -0.06664492945806264
ATAN7 = 0.05857988350245762
ATAN8 = -0.05084610357631765
ATAN9 = 0.03920743321261196
ATAN10 = -0.019147248964611764
# (asin(x)/x - 1)/z on |x| <= 1/2
ASIN0 = 0.16666666666666666
ASIN1 = 0.07500000000000119
ASIN2 = 0.04464285714255019
ASIN3 = 0.030381944475693704
ASIN4 = 0.022372157435623815
ASIN5 = 0.017352816768546473
ASIN6 = 0.013963775787848137
ASIN7 = 0.011566511821890942
ASIN8 = 0.00962140274734483
ASIN9 = 0.009322101501082774
ASIN10 = 0.0030350071727267623
ASIN11 = 0.019579201619744684
ASIN12 = -0.019277545928584557
ASIN13 = 0.02963502626354855


def _reduced_angle(x: float):
    """``quadrant, r, rest`` with ``x = quadrant*pi/2 + r + rest``, ``|r| <= pi/4``; quadrant modulo 4.

    The sum carries 143 bits of pi/2, so that nothing is lost near its multiples.
    """
    shifted = x * TWO_OVER_PI + ROUNDER
    n = shifted - ROUNDER
    first = x - n * HALF_PI_1
    second = n * HALF_PI_2
    sum_2 = first - second
    part_2 = sum_2 - first
    lost_2 = (first - (sum_2 - part_2)) - (second + part_2)
    third = n * HALF_PI_3
    sum_3 = sum_2 - third
    part_3 = sum_3 - sum_2
    lost_3 = (sum_2 - (sum_3 - part_3)) - (third + part_3)
    rest = (lost_2 + lost_3) - n * HALF_PI_4
    r = sum_3 + rest
    return float_to_bits(shifted) & 3, r, rest - (r - sum_3)


def _sin_rest(r: float, rest: float) -> float:
    """``sin(r + rest) - r`` for ``|r| <= pi/4``."""
    z = r * r
    z2 = z * z
    tail = (SIN1 + SIN2 * z) + z2 * ((SIN3 + SIN4 * z) + z2 * SIN5)
    cube = z * r
    return cube * SIN0 + (rest - z * (0.5 * rest - cube * tail))


def _cos_parts(r: float, rest: float):
    """``cos(r + rest)`` as a double and what is missing from it, for ``|r| <= pi/4``."""
    z = r * r
    z2 = z * z
    tail = (COS0 + COS1 * z) + z2 * ((COS2 + COS3 * z) + z2 * (COS4 + COS5 * z))
    half = 0.5 * z
    head = 1.0 - half
    return head, ((1.0 - head) - half) + (z2 * tail - r * rest)


def sin(x: float) -> float:
    """Sine of ``x`` rad.

    Range: ``|x| <= 2**23 pi/2`` (1.3e7), near multiples of pi/2 too. Error: at most 0.9 ulp, measured.
    Beyond it the error grows to about an ulp of x, up to ``|x| = 1e12``; NaN above.
    Keeps -0.0; NaN of infinities and NaN.
    """
    valid = fabs(x) <= ANGLE_LIMIT
    quadrant, r, rest = _reduced_angle(x if valid else 0.0)
    head, missing = _cos_parts(r, rest)
    sine = r + _sin_rest(r, rest)
    cosine = head + missing
    result = sine if quadrant & 1 == 0 else cosine
    result = result if quadrant & 2 == 0 else -result
    result = x if fabs(x) < TINY_ANGLE else result
    return result if valid else NAN


def cos(x: float) -> float:
    """Cosine of ``x`` rad.

    Range: ``|x| <= 2**23 pi/2`` (1.3e7), near multiples of pi/2 too. Error: at most 0.9 ulp, measured.
    Beyond it the error grows to about an ulp of x, up to ``|x| = 1e12``; NaN above.
    NaN of infinities and NaN.
    """
    valid = fabs(x) <= ANGLE_LIMIT
    quadrant, r, rest = _reduced_angle(x if valid else 0.0)
    head, missing = _cos_parts(r, rest)
    sine = r + _sin_rest(r, rest)
    cosine = head + missing
    result = cosine if quadrant & 1 == 0 else -sine
    result = result if quadrant & 2 == 0 else -result
    return result if valid else NAN


def tan(x: float) -> float:
    """Tangent of ``x`` rad.

    Range: ``|x| <= 2**23 pi/2`` (1.3e7), near multiples of pi/2 too. Error: at most 1.6 ulp, measured.
    Beyond it the error grows with that of the angle, up to ``|x| = 1e12``; NaN above.
    Keeps -0.0; NaN of infinities and NaN.
    """
    valid = fabs(x) <= ANGLE_LIMIT
    quadrant, r, rest = _reduced_angle(x if valid else 0.0)
    head, missing = _cos_parts(r, rest)
    sine_rest = _sin_rest(r, rest)
    sine = r + sine_rest
    sine_lost = sine_rest - (sine - r)
    cosine = head + missing
    cosine_lost = missing - (cosine - head)
    even = quadrant & 1 == 0
    top = sine if even else -cosine
    top_lost = sine_lost if even else -cosine_lost
    # Never zero but for x = 0, where the angle itself is returned.
    bottom = cosine if even else (sine if sine != 0.0 else 1.0)
    bottom_lost = cosine_lost if even else sine_lost
    quotient = top / bottom
    result = quotient + (top_lost - quotient * bottom_lost) / bottom
    result = x if fabs(x) < TINY_ANGLE else result
    return result if valid else NAN


def atan2(y: float, x: float) -> float:
    """The angle of the point (x, y), from -pi to pi rad.

    Range: all doubles. Error: at most 1.6 ulp, measured.
    Quadrants, zeros of either sign and infinities are as C99 has them; NaN of NaN.
    """
    size_x = fabs(x)
    size_y = fabs(y)
    steep = size_y > size_x
    a = size_x if steep else size_y
    b = size_y if steep else size_x
    a = 1.0 if a == INF else (0.0 if b == INF else a)
    b = 1.0 if b == INF else (1.0 if b == 0.0 else b)
    huge = b > 1e300
    tiny = b < 1e-290
    scale = 7.888609052210118e-31 if huge else (1.2676506002282294e30 if tiny else 1.0)
    a = a * scale
    b = b * scale
    # atan(a/b) = pi/4 + atan((a - b)/(a + b)): one division either way.
    wide = a > TAN_EIGHTH_PI * b
    top = a - b if wide else a
    bottom = a + b if wide else b
    top_lost = a - (top + b) if wide else 0.0
    bottom_lost = (b - bottom) + a if wide else 0.0
    t = top / bottom
    z = t * t
    z2 = z * z
    z4 = z2 * z2
    low = (ATAN0 + ATAN1 * z) + z2 * (ATAN2 + ATAN3 * z)
    high = (ATAN4 + ATAN5 * z) + z2 * (ATAN6 + ATAN7 * z)
    tail = low + z4 * (high + z4 * ((ATAN8 + ATAN9 * z) + z2 * ATAN10))
    rest = (top_lost - t * bottom_lost) / bottom + t * z * tail

    left = float_to_bits(x) < 0
    turned = steep != left
    t = -t if turned else t
    rest = -rest if turned else rest
    narrow_base = HALF_PI if steep else (PI if left else 0.0)
    narrow_rest = HALF_PI_REST if steep else (PI_REST if left else 0.0)
    wide_base = THREE_QUARTER_PI if left else QUARTER_PI
    wide_rest = THREE_QUARTER_PI_REST if left else QUARTER_PI_REST
    base = wide_base if wide else narrow_base
    rest = rest + (wide_rest if wide else narrow_rest)
    angle = copysign(base + (t + rest), y)
    angle = angle if x == x else NAN
    return angle if y == y else NAN


def atan(x: float) -> float:
    """Arc tangent, from -pi/2 to pi/2 rad.

    Range: all doubles. Error: at most 1.1 ulp, measured. Keeps -0.0; atan(inf) = pi/2, NaN of NaN.
    """
    return atan2(x, 1.0)


def _asin_tail(z: float) -> float:
    """``(asin(x)/x - 1)/z`` for ``z = x**2 <= 1/4``."""
    z2 = z * z
    z4 = z2 * z2
    low = (ASIN0 + ASIN1 * z) + z2 * (ASIN2 + ASIN3 * z)
    middle = (ASIN4 + ASIN5 * z) + z2 * (ASIN6 + ASIN7 * z)
    high = (ASIN8 + ASIN9 * z) + z2 * (ASIN10 + ASIN11 * z)
    return low + z4 * (middle + z4 * (high + z4 * (ASIN12 + ASIN13 * z)))


def asin(x: float) -> float:
    """Arc sine, from -pi/2 to pi/2 rad.

    Range: -1 to 1, NaN beyond. Error: at most 0.9 ulp, measured. Keeps -0.0.
    Above 1/2 by ``pi/2 - 2 asin(sqrt((1 - x)/2))``.
    """
    size = fabs(x)
    outer = size > 0.5
    z = 0.5 * (1.0 - size) if outer else size * size
    s = sqrt(z) if outer else size
    s_upper = bits_to_float(float_to_bits(s) & UPPER_HALF)
    s_lower = (z - s_upper * s_upper) / (s + s_upper if s > 0.0 else 1.0) if outer else 0.0
    bulge = s * (z * _asin_tail(z))
    near_one = QUARTER_PI - 2.0 * s_upper
    far = near_one - (2.0 * (bulge + s_lower) - HALF_PI_REST) + QUARTER_PI
    result = far if outer else size + bulge
    return copysign(result if size <= 1.0 else NAN, x)


def acos(x: float) -> float:
    """Arc cosine, from 0 to pi rad.

    Range: -1 to 1, NaN beyond. Error: at most 0.9 ulp, measured.
    """
    size = fabs(x)
    outer = size > 0.5
    z = 0.5 * (1.0 - size) if outer else size * size
    s = sqrt(z) if outer else x
    s_upper = bits_to_float(float_to_bits(s) & UPPER_HALF)
    s_lower = (z - s_upper * s_upper) / (s + s_upper if s > 0.0 else 1.0) if outer else 0.0
    bulge = s * (z * _asin_tail(z))
    middle = HALF_PI - (x - (HALF_PI_REST - bulge))
    right = 2.0 * (s_upper + (s_lower + bulge))
    left = PI - 2.0 * (s_upper + ((s_lower + bulge) - 0.5 * PI_REST))
    result = (right if x > 0.0 else left) if outer else middle
    return result if size <= 1.0 else NAN
