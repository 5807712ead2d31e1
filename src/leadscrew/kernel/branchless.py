"""Conditional expressions as selections, for the compiled engines: both sides are computed, one is taken.

A branch keeps the vectoriser from a loop; every expression of the subset is safe to compute.
"""

from __future__ import annotations

import ast


def is_condition(node: ast.expr) -> bool:
    """Whether an expression is plainly true or false, so that ``and`` may be ``&``."""
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.Not)
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, ast.BitAnd | ast.BitOr) and is_condition(node.left) and is_condition(node.right)
    return isinstance(node, ast.Compare) or (isinstance(node, ast.Constant) and isinstance(node.value, bool))


class Branchless(ast.NodeTransformer):
    """Rewrites conditional expressions, chained comparisons, ``and`` and ``or``."""

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        self.generic_visit(node)
        return ast.Call(ast.Name("ieee_select", ast.Load()), [node.test, node.body, node.orelse], [])

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        """``~x`` so that a truth value counts as 0 or 1, as in Python."""
        self.generic_visit(node)
        return node if not isinstance(node.op, ast.Invert) else ast.BinOp(node.operand, ast.BitXor(), ast.Constant(-1))

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        self.generic_visit(node)
        if len(node.ops) == 1:
            return node
        ends = [node.left, *node.comparators]
        parts: list[ast.expr] = [ast.Compare(ends[i], [op], [ends[i + 1]]) for i, op in enumerate(node.ops)]
        return self.joined(parts, ast.BitAnd())

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:
        self.generic_visit(node)
        if not all(is_condition(v) for v in node.values):
            return node
        return self.joined(node.values, ast.BitAnd() if isinstance(node.op, ast.And) else ast.BitOr())

    @staticmethod
    def joined(parts: list[ast.expr], op: ast.operator) -> ast.expr:
        """All parts with one operator between."""
        made = parts[0]
        for part in parts[1:]:
            made = ast.BinOp(made, op, part)
        return made
