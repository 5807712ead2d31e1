"""The few lines of C that stand for what Python has and C has not; a file gets the ones that it uses."""

from __future__ import annotations

GUARD = """\
#if defined(__FAST_MATH__)
#error "compile without -ffast-math: it changes the results"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "this target computes with more digits than a double has; on 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif
"""

HELPERS: dict[str, tuple[tuple[str, ...], str]] = {
    "float_to_bits": (
        ("string.h",),
        """\
/* The 64 bits of a double as an integer. */
static inline int64_t float_to_bits(double x)
{
    int64_t bits;

    memcpy(&bits, &x, sizeof bits);
    return bits;
}
""",
    ),
    "bits_to_float": (
        ("string.h",),
        """\
/* The double whose 64 bits are these. */
static inline double bits_to_float(int64_t bits)
{
    double x;

    memcpy(&x, &bits, sizeof x);
    return x;
}
""",
    ),
    "shift_left": (
        (),
        """\
/* A shift of all 64 bits, the sign included. */
static inline int64_t shift_left(int64_t x, int64_t by)
{
    return (int64_t)((uint64_t)x << by);
}
""",
    ),
    "whole": (
        (),
        """\
static inline int64_t whole(int64_t x)
{
    return x;
}
""",
    ),
    "int_add": (
        (),
        """\
/* a + b in 64 bits, which wrap. */
static inline int64_t int_add(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a + (uint64_t)b);
}
""",
    ),
    "int_sub": (
        (),
        """\
/* a - b in 64 bits, which wrap. */
static inline int64_t int_sub(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a - (uint64_t)b);
}
""",
    ),
    "int_mul": (
        (),
        """\
/* a * b in 64 bits, which wrap. */
static inline int64_t int_mul(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a * (uint64_t)b);
}
""",
    ),
    "range_next": (
        (),
        """\
/* What follows in a range: its end where the sum would have more than 64 bits. */
static inline int64_t range_next(int64_t at, int64_t by, int64_t end)
{
    const uint64_t left = by > 0 ? (uint64_t)end - (uint64_t)at : (uint64_t)at - (uint64_t)end;

    return left > (by > 0 ? (uint64_t)by : 0 - (uint64_t)by) ? at + by : end;
}
""",
    ),
    "int_abs": (
        (),
        """\
static inline int64_t int_abs(int64_t x)
{
    return x < 0 ? (int64_t)(0 - (uint64_t)x) : x;
}
""",
    ),
    "int_floordiv": (
        ("stdbool.h",),
        """\
/* a // b as Python has it; 0 where b is 0 or the quotient has more than 64 bits. */
static inline int64_t int_floordiv(int64_t a, int64_t b)
{
    const bool lost = b == 0 || (b == -1 && a == INT64_MIN);
    const int64_t divisor = lost ? 1 : b;
    const int64_t rest = a % divisor;

    return lost ? 0 : a / divisor - (rest != 0 && (rest ^ divisor) < 0);
}
""",
    ),
    "int_mod": (
        (),
        """\
/* a % b as Python has it; 0 where b is 0. */
static inline int64_t int_mod(int64_t a, int64_t b)
{
    const int64_t divisor = b == 0 || b == -1 ? 1 : b;
    const int64_t rest = a % divisor;

    return b == 0 ? 0 : rest + (rest != 0 && (rest ^ divisor) < 0 ? divisor : 0);
}
""",
    ),
    "float_mod": (
        ("math.h",),
        """\
/* a % b as Python has it for floats; NaN where b is 0. */
static inline REAL float_mod(REAL a, REAL b)
{
    const REAL rest = FMOD(a, b);

    if (rest == 0) {
        return COPYSIGN(0, b);
    }
    return (rest < 0) != (b < 0) ? rest + b : rest;
}
""",
    ),
    "float_floordiv": (
        ("math.h",),
        """\
/* a // b as Python has it for floats; a / b where b is 0. */
static inline REAL float_floordiv(REAL a, REAL b)
{
    const REAL rest = FMOD(a, b);
    REAL whole = (a - rest) / b;
    REAL down;

    if (b == 0) {
        return a / b;
    }
    if (rest != 0 && (rest < 0) != (b < 0)) {
        whole = whole - 1;
    }
    if (whole == 0) {
        return COPYSIGN(0, a / b);
    }
    down = FLOOR(whole);
    return whole - down > HALF ? down + 1 : down;
}
""",
    ),
}
"""Name: headers, text."""


def helper(name: str, real: str) -> str:
    """A helper's text for ``double`` or ``float``."""
    end = "f" if real == "float" else ""
    text = HELPERS[name][1]
    for token, value in {
        "REAL": real, "FMOD": f"fmod{end}", "COPYSIGN": f"copysign{end}", "FLOOR": f"floor{end}", "HALF": f"0.5{end}",
    }.items():  # fmt: skip
        text = text.replace(token, value)
    return text
