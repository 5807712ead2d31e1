"""The arithmetic of machine code for the plain Python engine: IEEE-754 division, whole numbers of 64 bits.

Where a division lost a finite quotient is remembered.
"""

from __future__ import annotations

import ast
import math
import sys
from typing import Any

import numpy as np

from leadscrew.kernel.subset import call

WHOLE = (int, np.integer, np.bool_)
lost: dict[str, Any] = {}
"""Where the last division of finite numbers gave a value that is not finite: ``file``, ``line``, ``what``."""


def _remember(what: str) -> None:
    frame = sys._getframe(2)
    lost.update(file=frame.f_code.co_filename, line=frame.f_lineno, what=what)


def ieee_divide(a: Any, b: Any) -> Any:
    """``a / b``; infinity or NaN where ``b`` is zero."""
    if b != 0:
        try:
            return float(a) / float(b)
        except OverflowError:
            return math.inf if (a > 0) == (b > 0) else -math.inf
    _remember(f"{a!r} / {b!r}")
    if a != a or a == 0:
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def ieee_floor_divide(a: Any, b: Any) -> Any:
    """``a // b``; where ``b`` is zero the IEEE quotient for floats, 0 for integers; NaN of an infinite ``a``.

    0 too where the quotient of integers has more than 64 bits.
    """
    whole = isinstance(a, WHOLE) and isinstance(b, WHOLE)
    if b != 0 and (whole or math.isfinite(a)):
        if not whole:
            return a // b
        quotient = int(a) // int(b)
        return quotient if quotient < 2**63 else 0
    _remember(f"{a!r} // {b!r}")
    if whole:
        return 0
    return ieee_divide(float(a), b) if b == 0 else math.nan


def ieee_modulo(a: Any, b: Any) -> Any:
    """``a % b``; for floats NaN, for integers 0 where ``b`` is zero."""
    whole = isinstance(a, WHOLE) and isinstance(b, WHOLE)
    if b != 0 and (whole or math.isfinite(a)):
        return int(a) % int(b) if whole else a % b
    _remember(f"{a!r} % {b!r}")
    return 0 if whole else math.nan


def ieee_wrap(x: Any) -> Any:
    """A whole number with its lowest 64 bits, the first of them the sign, as machine code has it; a float as it is."""
    if not isinstance(x, WHOLE) or -(2**63) <= x < 2**63:
        return x
    return (int(x) + 2**63) % 2**64 - 2**63


def ieee_range(*bounds: int) -> range:
    """``range``, empty where the step is zero."""
    return range(*bounds) if len(bounds) < 3 or bounds[2] != 0 else range(0)


OPERATORS: dict[str, Any] = {f.__name__: f for f in (ieee_divide, ieee_floor_divide, ieee_modulo, ieee_wrap)} | {
    "range": ieee_range
}


class Table:
    """A constant array of whole numbers, which gives them as Python's own."""

    def __init__(self, value: np.ndarray) -> None:
        self.value, self.shape = value, value.shape

    def __len__(self) -> int:
        return len(self.value)

    def __getitem__(self, at: Any) -> int:
        return int(self.value[at])


class Ieee(ast.NodeTransformer):
    """Brings a function to that arithmetic: its divisions, marked whole numbers, plain truth values."""

    names: dict[type, str] = {ast.Div: "ieee_divide", ast.FloorDiv: "ieee_floor_divide", ast.Mod: "ieee_modulo"}  # noqa: RUF012

    def __init__(self, trusted: bool) -> None:
        self.trusted = trusted

    def visit(self, node: ast.AST) -> Any:
        """A node and what is below it, with what the marks on it ask for."""
        test = getattr(node, "test", None)
        if isinstance(test, ast.Compare):
            test.is_test = True  # type: ignore[attr-defined]
        wraps, meets_float = hasattr(node, "wraps"), hasattr(node, "meets_float")
        made = super().visit(node)
        if wraps:
            made = ast.copy_location(call("ieee_wrap", made), node)
        return ast.copy_location(call("float", made), node) if meets_float else made

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        """A comparison; NumPy's numbers give truth values that cannot be counted with."""
        self.generic_visit(node)
        return node if hasattr(node, "is_test") else ast.copy_location(call("bool", node), node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """A division in a function of the user's."""
        self.generic_visit(node)
        name = None if self.trusted else self.names.get(type(node.op))
        return node if name is None else ast.copy_location(call(name, node.left, node.right), node)
