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
    "int_abs": (
        (),
        """\
static inline int64_t int_abs(int64_t x)
{
    return x < 0 ? -x : x;
}
""",
    ),
    "int_floordiv": (
        (),
        """\
/* a // b as Python has it; 0 where b is 0. */
static inline int64_t int_floordiv(int64_t a, int64_t b)
{
    const int64_t divisor = b == 0 ? 1 : b;
    const int64_t rest = a % divisor;

    return b == 0 ? 0 : a / divisor - (rest != 0 && (rest ^ divisor) < 0);
}
""",
    ),
    "int_mod": (
        (),
        """\
/* a % b as Python has it; 0 where b is 0. */
static inline int64_t int_mod(int64_t a, int64_t b)
{
    const int64_t divisor = b == 0 ? 1 : b;
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
