"""Short hands for building syntax trees."""

from __future__ import annotations

import ast
from typing import Any


def name(text: str) -> ast.expr:
    """A dotted name."""
    head, *rest = text.split(".")
    node: ast.expr = ast.Name(head, ast.Load())
    for part in rest:
        node = ast.Attribute(node, part, ast.Load())
    return node


def number(value: float | int) -> ast.expr:
    """A number that is not negative."""
    return ast.Constant(value)


def call(function: str, *args: ast.expr | str) -> ast.expr:
    """A call by name; strings are dotted names."""
    return ast.Call(name(function), [name(a) if isinstance(a, str) else a for a in args], [])


def item(array: str, *indices: ast.expr | str | int, store: bool = False) -> ast.expr:
    """An element of an array."""
    parts = [name(i) if isinstance(i, str) else ast.Constant(i) if isinstance(i, int) else i for i in indices]
    inside: ast.expr = parts[0] if len(parts) == 1 else ast.Tuple(parts, ast.Load())
    return ast.Subscript(name(array), inside, ast.Store() if store else ast.Load())


def put(array: str, indices: tuple[Any, ...], value: ast.expr | str) -> ast.stmt:
    """Assignment to an element of an array."""
    target = item(array, *indices, store=True)
    return ast.Assign([target], name(value) if isinstance(value, str) else value)


def assign(target: str, value: ast.expr) -> ast.stmt:
    """Assignment to a name."""
    return ast.Assign([ast.Name(target, ast.Store())], value)


def give(*values: ast.expr | str) -> ast.stmt:
    """``return``, of a tuple where there are several values."""
    parts = [name(v) if isinstance(v, str) else v for v in values]
    return ast.Return(parts[0] if len(parts) == 1 else ast.Tuple(parts, ast.Load()))


def do(value: ast.expr) -> ast.stmt:
    """An expression as a statement."""
    return ast.Expr(value)


def operate(left: ast.expr, op: ast.operator, right: ast.expr) -> ast.expr:
    """``left op right``."""
    return ast.BinOp(left, op, right)


def add(left: ast.expr | str, right: ast.expr | str) -> ast.expr:
    """``left + right``."""
    return operate(_e(left), ast.Add(), _e(right))


def minus(left: ast.expr | str, right: ast.expr | str) -> ast.expr:
    """``left - right``."""
    return operate(_e(left), ast.Sub(), _e(right))


def times(left: ast.expr | str, right: ast.expr | str) -> ast.expr:
    """``left * right``."""
    return operate(_e(left), ast.Mult(), _e(right))


def both(parts: list[ast.expr]) -> ast.expr:
    """All of the conditions, none left out by an earlier one (so that lanes stay free of branches)."""
    node = parts[0]
    for other in parts[1:]:
        node = operate(node, ast.BitAnd(), other)
    return node


def within(value: ast.expr, limit: ast.expr) -> ast.expr:
    """``abs(value) <= limit``."""
    return ast.Compare(call("abs", value), [ast.LtE()], [limit])


def _e(value: ast.expr | str) -> ast.expr:
    return name(value) if isinstance(value, str) else value
