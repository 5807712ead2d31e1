"""Portable mathematics: functions that give the same bits in plain Python, machine code (scalar or vectorised) and C99.

They use +, -, *, /, square root and bit operations on doubles and int64 only: no library function whose last bits
depend on the machine, no fused multiply-add, no branch and no table, so that compilers vectorise them across
lanes. A NaN is a NaN in every engine, but its sign and payload are not promised.
"""

from leadscrew.kernel.portable.basic import (
    ceil,
    copysign,
    fabs,
    float_floordiv,
    float_mod,
    floor,
    flush,
    int_floordiv,
    int_mod,
    is_finite,
    is_infinite,
    is_nan,
    maximum,
    minimum,
    round_half_even,
    sign,
    sqrt,
    to_int,
    trunc,
)
from leadscrew.kernel.portable.circular import acos, asin, atan, atan2, cos, sin, tan
from leadscrew.kernel.portable.exponential import exp, expm1, log, log1p, log2, log10
from leadscrew.kernel.portable.hyperbolic import cosh, sinh, tanh
from leadscrew.kernel.portable.powers import cbrt, hypot, pow

__all__ = [
    "acos",
    "asin",
    "atan",
    "atan2",
    "cbrt",
    "ceil",
    "copysign",
    "cos",
    "cosh",
    "exp",
    "expm1",
    "fabs",
    "float_floordiv",
    "float_mod",
    "floor",
    "flush",
    "hypot",
    "int_floordiv",
    "int_mod",
    "is_finite",
    "is_infinite",
    "is_nan",
    "log",
    "log1p",
    "log2",
    "log10",
    "maximum",
    "minimum",
    "pow",
    "round_half_even",
    "sign",
    "sin",
    "sinh",
    "sqrt",
    "tan",
    "tanh",
    "to_int",
    "trunc",
]
