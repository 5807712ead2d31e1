"""Conditional expressions as selections, for the compiled engines: both sides are computed, one is taken.

A branch keeps the vectoriser from a loop; every expression of the subset is safe to compute.
"""

from __future__ import annotations

import ast

from leadscrew.kernel.trees import Rules, rewritten


def is_condition(node: ast.expr) -> bool:
    """Whether an expression is plainly true or false, so that ``and`` may be ``&``."""
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.Not)
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, ast.BitAnd | ast.BitOr) and is_condition(node.left) and is_condition(node.right)
    return isinstance(node, ast.Compare) or (isinstance(node, ast.Constant) and isinstance(node.value, bool))


def _joined(parts: list[ast.expr], op: ast.operator) -> ast.expr:
    """All parts with one operator between."""
    made = parts[0]
    for part in parts[1:]:
        made = ast.BinOp(made, op, part)
    return made


def _choice(node: ast.IfExp) -> ast.expr:
    return ast.Call(ast.Name("ieee_select", ast.Load()), [node.test, node.body, node.orelse], [])


def _inverted(node: ast.UnaryOp) -> ast.expr:
    """``~x`` so that a truth value counts as 0 or 1, as in Python."""
    return node if not isinstance(node.op, ast.Invert) else ast.BinOp(node.operand, ast.BitXor(), ast.Constant(-1))


def _compared(node: ast.Compare) -> ast.expr:
    if len(node.ops) == 1:
        return node
    ends = [node.left, *node.comparators]
    parts: list[ast.expr] = [ast.Compare(ends[i], [op], [ends[i + 1]]) for i, op in enumerate(node.ops)]
    return _joined(parts, ast.BitAnd())


def _all_or_any(node: ast.BoolOp) -> ast.expr:
    if not all(is_condition(v) for v in node.values):
        return node
    return _joined(node.values, ast.BitAnd() if isinstance(node.op, ast.And) else ast.BitOr())


def branchless(node: ast.FunctionDef) -> ast.FunctionDef:
    """A function with its conditional expressions, chained comparisons, ``and`` and ``or`` rewritten, in place."""
    rules: Rules = {ast.IfExp: _choice, ast.UnaryOp: _inverted, ast.Compare: _compared, ast.BoolOp: _all_or_any}
    changed: ast.FunctionDef = rewritten(node, rules)
    return changed
