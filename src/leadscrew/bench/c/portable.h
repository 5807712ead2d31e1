/* The portable functions of leadscrew.kernel.portable, by hand: the same bits, given -ffp-contract=off. */
#ifndef PORTABLE_H
#define PORTABLE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define UPPER_HALF INT64_C(-134217728)
#define COARSE INT64_C(-68719476736)
#define INTEGERS_FROM 4503599627370496.0
#define ROUND_BIASED 6755399441057790.0 /* 1.5 * 2^52 + 2046 */

static inline int64_t bits_of(double x)
{
    int64_t i;
    memcpy(&i, &x, sizeof i);
    return i;
}

static inline double with_bits(int64_t i)
{
    double x;
    memcpy(&x, &i, sizeof x);
    return x;
}

/* exact: the hardware's own instruction gives the same number */
static inline double portable_floor(double x) { return floor(x); }

static inline double maximum(double a, double b) { return b > a ? b : a; }

static inline double minimum(double a, double b) { return b < a ? b : a; }

/* exponential.py, _log_parts: k, upper, rest with log(x) = k ln 2 + 2/3 (upper + rest), for positive finite x */
static inline void log_parts(double x, double *k, double *upper, double *rest)
{
    /* _exponent_and_mantissa */
    int subnormal = x < 2.2250738585072014e-308;
    double normal = subnormal ? x * 18014398509481984.0 : x;
    int64_t moved = bits_of(normal) + INT64_C(0x00095F619980C433);
    *k = with_bits((moved >> 52) | INT64_C(0x4330000000000000)) - (subnormal ? 4503599627371573.0 : 4503599627371519.0);
    double f = with_bits((moved & INT64_C(0x000FFFFFFFFFFFFF)) + INT64_C(0x3FE6A09E667F3BCD)) - 1.0;

    double d = 2.0 + f;
    double d_upper = with_bits(bits_of(d) & UPPER_HALF);
    double d_lower = (d - d_upper) + (f - (d - 2.0));
    double inverse = 1.0 / d;
    double s = f * inverse;
    double s_upper = with_bits(bits_of(s) & UPPER_HALF);
    double s_lower = ((f - s_upper * d_upper) - s_upper * d_lower) * inverse;
    double z = s * s;
    *upper = with_bits(bits_of(3.0 * s + s * z * (1.0 + 0.6 * z)) & UPPER_HALF);
    double coarse = with_bits(bits_of(s) & COARSE);
    double finer = (s_upper - coarse) + s_lower;
    double z2 = z * z;
    double z4 = z2 * z2;
    double tail = ((0.6 + 0.4285714285714405 * z) + z2 * (0.3333333333248383 + 0.272727275030892 * z))
        + z4 * ((0.23076892443777647 + 0.20002207040770967 * z) + z2 * (0.1755935450923681 + 0.17584767935814777 * z));
    double square = coarse * coarse;
    double fifth = (z2 * s) * tail + (3.0 * z2) * ((s_upper - s) + s_lower);
    double last = 3.0 * s_lower + (finer * (z + s * coarse + square) + fifth);
    *rest = ((3.0 * s_upper - *upper) + square * coarse) + last;
}

/* powers.py, pow: the same statements and the same selects, for all doubles, without an early return */
static inline double portable_pow(double x, double y)
{
    double size = fabs(x);
    double held = size > 0.0 ? size : 1.0;
    double k, upper, rest;
    log_parts(held < INFINITY ? held : 1.0, &k, &upper, &rest);

    double held_y = minimum(maximum(y, -1e300), 1e300);
    double y_upper = with_bits(bits_of(held_y) & UPPER_HALF);
    double y_lower = held_y - y_upper;
    double factor = held_y * 0.9617966939259756;
    double factor_upper = with_bits(bits_of(factor) & UPPER_HALF);
    double factor_lower = (y_upper * 0.9617966860532761 - factor_upper)
        + (y_lower * 0.9617966860532761 + held_y * 7.872699542894897e-09);

    double whole = y_upper * k;
    double part = factor_upper * upper;
    double exponent = whole + part;
    double shifted = exponent + ROUND_BIASED;
    double n = shifted - ROUND_BIASED;
    double small = y_lower * k + (factor_lower * upper + factor * rest);
    double g = ((whole - n) + part) + small;

    double g2 = g * g;
    double g4 = g2 * g2;
    double low = (0.24022650695910078 + 0.05550410866482158 * g) + g2 * (0.00961812910761698 + 0.0013333558146422315 * g);
    double high = (0.00015403530428739626 + 1.5252733822908288e-05 * g)
        + g2 * (1.3215448732985857e-06 + 1.0178065721518527e-07 * g);
    double p = 1.0
        + (g * 0.6931471805599453 + g2 * (low + g4 * (high + g4 * (7.0716276672710415e-09 + 4.4544497768977116e-10 * g))));

    int64_t exponents = bits_of(shifted) & 4095;
    int64_t first = exponents >> 1;
    double power = p * with_bits(first << 52) * with_bits(((exponents - first) & 2047) << 52);
    power = exponent > 1025.0 ? INFINITY : power;
    power = exponent < -1080.0 ? 0.0 : power;

    double limit = size > 1.0 ? (y > 0.0 ? INFINITY : 0.0) : (y > 0.0 ? 0.0 : INFINITY);
    power = size == 0.0 ? limit : (size == INFINITY ? limit : power);

    double size_y = fabs(y);
    double half_y = 0.5 * size_y;
    double whole_y = size_y < INTEGERS_FROM ? (size_y + INTEGERS_FROM) - INTEGERS_FROM : size_y;
    double whole_half_y = half_y < INTEGERS_FROM ? (half_y + INTEGERS_FROM) - INTEGERS_FROM : half_y;
    double no_real_power = size == 0.0 ? power : (size == INFINITY ? power : NAN);
    double mirrored = whole_y == size_y ? (whole_half_y == half_y ? power : -power) : no_real_power;
    power = bits_of(x) < 0 ? mirrored : power;

    power = x == x ? power : NAN;
    power = y == y ? power : NAN;
    return y == 0.0 ? 1.0 : (x == 1.0 ? 1.0 : power);
}

/* the same, but a base of 0 is answered at once: what a loop at rest asks for */
static inline double shortcut_pow(double x, double y)
{
    if (x == 0.0 && y > 0.0)
        return 0.0;
    return portable_pow(x, y);
}

#endif
