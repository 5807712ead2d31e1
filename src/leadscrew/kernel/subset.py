"""The step subset: the syntax that a step may use, and the portable functions that stand for library ones."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

import numpy as np

from leadscrew.kernel import portable

MATHS: dict[str, Callable[..., Any]] = {
    name: getattr(portable, portable_name)
    for name, portable_name in {
        **{
            n: n
            for n in [
                "exp",
                "log",
                "sin",
                "cos",
                "tan",
                "atan2",
                "atan",
                "asin",
                "acos",
                "tanh",
                "sinh",
                "cosh",
                "log10",
                "log2",
                "expm1",
                "log1p",
                "pow",
                "hypot",
                "sqrt",
                "floor",
                "ceil",
                "trunc",
                "copysign",
                "fabs",
            ]
        },
        "arctan2": "atan2",
        "arctan": "atan",
        "arcsin": "asin",
        "arccos": "acos",
        "power": "pow",
        "absolute": "fabs",
        "abs": "fabs",
        "sign": "sign",
        "rint": "round_half_even",
        "maximum": "maximum",
        "minimum": "minimum",
        "isfinite": "is_finite",
        "isnan": "is_nan",
        "isinf": "is_infinite",
    }.items()
}
"""``math`` and NumPy names and the portable functions that stand for them."""

NUMBERS = (bool, int, float, np.floating, np.integer, np.bool_)
STATEMENTS = (
    ast.Assign, ast.AnnAssign, ast.AugAssign, ast.If, ast.For, ast.While, ast.Return, ast.Pass, ast.Break,
    ast.Continue, ast.Expr,
)  # fmt: skip
EXPRESSIONS = (
    ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Call, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare,
    ast.IfExp, ast.Tuple,
)  # fmt: skip
SHAPERS = ("zeros", "empty")


def is_named_tuple_type(value: Any) -> bool:
    """Whether ``value`` is a NamedTuple class."""
    return isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")


def literal(value: Any) -> ast.expr:
    """Syntax of a number, infinities and NaN included."""
    if isinstance(value, bool | np.bool_):
        return ast.Constant(bool(value))
    if isinstance(value, int | np.integer):
        if value == -(2**63):  # its size alone would be beyond 64 bits
            return ast.BinOp(literal(value + 1), ast.Sub(), ast.Constant(1))
        whole = ast.Constant(abs(int(value)))
        return whole if value >= 0 else ast.UnaryOp(ast.USub(), whole)
    value = float(value)
    if value != value:
        return ast.Attribute(ast.Name("np", ast.Load()), "nan", ast.Load())
    if value in (float("inf"), float("-inf")):
        inf: ast.expr = ast.Attribute(ast.Name("np", ast.Load()), "inf", ast.Load())
        return inf if value > 0 else ast.UnaryOp(ast.USub(), inf)
    return ast.Constant(value) if value >= 0 and str(value)[0] != "-" else ast.UnaryOp(ast.USub(), ast.Constant(-value))


def call(name: str, *args: ast.expr) -> ast.Call:
    """Syntax of a call by name."""
    return ast.Call(ast.Name(name, ast.Load()), list(args), [])
