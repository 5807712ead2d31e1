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

_CALLED = {
    "Import": "'import'", "ImportFrom": "'import'", "FunctionDef": "'def'", "ClassDef": "'class'", "Delete": "'del'",
    "ListComp": "a list", "List": "a list", "Dict": "a dictionary", "DictComp": "a dictionary", "Set": "a set",
    "SetComp": "a set", "GeneratorExp": "a generator", "JoinedStr": "an f-string", "NamedExpr": "':='",
    "Starred": "'*'",
}  # fmt: skip
_INSTEAD = {
    "'import'": "write it at the top of the file", "'def'": "write the function outside the step",
    "a list": "use a name for each number, or an array in the state", "a generator": "write a 'for' loop",
    "'raise'": "return a value that is not finite: the loop then stops", "'assert'": "remove it",
}  # fmt: skip


def outside(node: ast.AST) -> str:
    """That a construct cannot stand in a step, and what can."""
    kind = type(node).__name__
    what = _CALLED.get(kind, f"'{kind.lower()}'")
    return f"{what} is outside the step subset" + (f"; {_INSTEAD[what]}" if what in _INSTEAD else "")


SCALAR = {
    "clip": "write min(max(x, low), high)", "where": "write a if condition else b", "norm": "write math.hypot(x, y)",
    "max": "write max(a, b)", "amax": "write max(a, b)", "min": "write min(a, b)", "amin": "write min(a, b)",
    "sum": "write a + b", "mean": "write (a + b) / 2", "dot": "write a * b + c * d", "diff": "write b - a",
    "square": "write x * x", "cbrt": "write x ** (1 / 3)", "round": "write round(x)", "asarray": "write float(x)",
    "float32": "write float(x)", "deg2rad": "write x * math.pi / 180", "rad2deg": "write x * 180 / math.pi",
    "radians": "write x * math.pi / 180", "degrees": "write x * 180 / math.pi",
    "array": "use a name for each number, or an array in the state", "ones": "write np.zeros(n), then each element",
    "interp": "use an 'if' for each piece, or an array and an index", "random": "write leadscrew.uniform(noise, 0)",
    "normal": "write leadscrew.normal(noise, 0)", "uniform": "write leadscrew.uniform(noise, 0)",
}  # fmt: skip
"""What to do in a step in place of functions of ``math`` and NumPy that have no portable counterpart."""


def is_named_tuple_type(value: Any) -> bool:
    """Whether ``value`` is a NamedTuple class."""
    return isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")


PRINT = "step_print"
"""What ``print`` is called in a module: a debugger's own ``print`` stays as it is while a probe runs."""


def is_print(node: ast.AST) -> bool:
    """Whether a node of a normalised step is a call of ``print``."""
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == PRINT


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
