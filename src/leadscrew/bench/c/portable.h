/* The portable functions of leadscrew.kernel.portable, by hand: the same bits, given -ffp-contract=off. */
#ifndef PORTABLE_H
#define PORTABLE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define UPPER_HALF UINT64_C(0xFFFFFFFFF8000000)
#define COARSE UINT64_C(0xFFFFFFF000000000)
#define ROUND_BIASED 6755399441057790.0 /* 1.5 * 2^52 + 2046 */

static inline uint64_t bits_of(double x)
{
    uint64_t i;
    memcpy(&i, &x, sizeof i);
    return i;
}

static inline double with_bits(uint64_t i)
{
    double x;
    memcpy(&x, &i, sizeof x);
    return x;
}

static inline double upper_half(double x) { return with_bits(bits_of(x) & UPPER_HALF); }

/* exact: the hardware's own instruction gives the same number */
static inline double portable_floor(double x) { return floor(x); }

/* 2^n from n + 2046 in the low bits, as two factors, so that the result may overflow or turn subnormal */
static inline double scaled(double p, double shifted)
{
    uint64_t exponents = bits_of(shifted) & 4095, first = exponents >> 1;
    return p * with_bits(first << 52) * with_bits(((exponents - first) & 2047) << 52);
}

/* k, upper, rest with log(x) = k ln 2 + 2/3 (upper + rest), for positive finite x */
static inline void log_parts(double x, double *k, double *upper, double *rest)
{
    int subnormal = x < 2.2250738585072014e-308;
    uint64_t moved = bits_of(subnormal ? x * 18014398509481984.0 : x) + UINT64_C(0x00095F619980C433);
    *k = with_bits((moved >> 52) | UINT64_C(0x4330000000000000)) - (subnormal ? 4503599627371573.0 : 4503599627371519.0);
    double f = with_bits((moved & UINT64_C(0x000FFFFFFFFFFFFF)) + UINT64_C(0x3FE6A09E667F3BCD)) - 1.0;
    double d = 2.0 + f, d_upper = upper_half(d), d_lower = (d - d_upper) + (f - (d - 2.0));
    double inverse = 1.0 / d, s = f * inverse, s_upper = upper_half(s);
    double s_lower = ((f - s_upper * d_upper) - s_upper * d_lower) * inverse;
    double z = s * s, z2 = z * z, z4 = z2 * z2;
    double coarse = with_bits(bits_of(s) & COARSE), finer = (s_upper - coarse) + s_lower, square = coarse * coarse;
    double tail = ((0.6 + 0.4285714285714405 * z) + z2 * (0.3333333333248383 + 0.272727275030892 * z))
        + z4 * ((0.23076892443777647 + 0.20002207040770967 * z) + z2 * (0.1755935450923681 + 0.17584767935814777 * z));
    double fifth = (z2 * s) * tail + 3.0 * z2 * ((s_upper - s) + s_lower);
    *upper = upper_half(3.0 * s + s * z * (1.0 + 0.6 * z));
    *rest = ((3.0 * s_upper - *upper) + square * coarse)
        + (3.0 * s_lower + (finer * (z + s * coarse + square) + fifth));
}

/* x to the power y for x >= 0 and finite y, which is all that the lathe's controller asks for */
static inline double portable_pow(double x, double y)
{
    double k, upper, rest;
    if (y == 0.0 || x == 1.0)
        return 1.0;
    if (x == 0.0)
        return y > 0.0 ? 0.0 : INFINITY;
    if (!(x < INFINITY))
        return x != x ? x : y > 0.0 ? INFINITY : 0.0;
    log_parts(x, &k, &upper, &rest);
    double y_upper = upper_half(y), y_lower = y - y_upper;
    double factor = y * 0.9617966939259756, factor_upper = upper_half(factor);
    double factor_lower = (y_upper * 0.9617966860532761 - factor_upper)
        + (y_lower * 0.9617966860532761 + y * 7.872699542894897e-09);
    double whole = y_upper * k, part = factor_upper * upper, exponent = whole + part;
    double shifted = exponent + ROUND_BIASED, n = shifted - ROUND_BIASED;
    double g = ((whole - n) + part) + (y_lower * k + (factor_lower * upper + factor * rest));
    double g2 = g * g, g4 = g2 * g2;
    double low = (0.24022650695910078 + 0.05550410866482158 * g) + g2 * (0.00961812910761698 + 0.0013333558146422315 * g);
    double high = (0.00015403530428739626 + 1.5252733822908288e-05 * g)
        + g2 * (1.3215448732985857e-06 + 1.0178065721518527e-07 * g);
    double p = 1.0 + (g * 0.6931471805599453
        + g2 * (low + g4 * (high + g4 * (7.0716276672710415e-09 + 4.4544497768977116e-10 * g))));
    return exponent > 1025.0 ? INFINITY : exponent < -1080.0 ? 0.0 : scaled(p, shifted);
}

#endif
