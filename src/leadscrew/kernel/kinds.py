"""Which locals of a step are whole numbers on one path and floats on another.

Machine code makes such a local a float throughout, plain Python does not. That shows in one place only: a remainder or
floor division by zero, which is 0 for whole numbers and not finite for floats.
"""

from __future__ import annotations

import ast
from collections.abc import Callable

from leadscrew.kernel.trees import each

WHOLE, FLOAT, MIXED = "whole", "float", "mixed"
_WHOLE_CALLS = ("int", "round", "len")
_EITHER_CALLS = ("abs", "min", "max")


class Kinds:
    """The kind of every local of a function and of what is computed from them."""

    def __init__(self, node: ast.FunctionDef, field: Callable[[ast.Attribute], str]) -> None:
        self.field = field
        self.locals: dict[str, str] = {}
        assigned = [n for n in each(node) if isinstance(n, ast.Assign | ast.AnnAssign | ast.AugAssign | ast.For)]
        for _ in range(len(assigned) + 1):
            before = dict(self.locals)
            for n in assigned:
                target = n.targets[0] if isinstance(n, ast.Assign) else n.target
                if isinstance(target, ast.Name):
                    self.note(target.id, self.assigned(n))
            if before == self.locals:
                break

    def assigned(self, node: ast.stmt) -> str:
        """The kind of what a statement assigns."""
        if isinstance(node, ast.For):
            return WHOLE
        if isinstance(node, ast.AugAssign):
            return self.of(ast.BinOp(ast.Name(getattr(node.target, "id", ""), ast.Load()), node.op, node.value))
        value = getattr(node, "value", None)
        return self.of(value) if value is not None else FLOAT

    def note(self, name: str, kind: str) -> None:
        """Notes an assignment."""
        old = self.locals.get(name, kind)
        self.locals[name] = kind if old == kind else MIXED

    def of(self, node: ast.expr) -> str:
        """The kind of an expression; what is not known counts as a float."""
        if isinstance(node, ast.Constant):
            return FLOAT if isinstance(node.value, float) else WHOLE
        if isinstance(node, ast.Name):
            return self.locals.get(node.id, FLOAT)
        if isinstance(node, ast.Attribute):
            return self.field(node)
        if isinstance(node, ast.Compare | ast.BoolOp):
            return WHOLE if isinstance(node, ast.Compare) else self.either([self.of(v) for v in node.values])
        if isinstance(node, ast.UnaryOp):
            return WHOLE if isinstance(node.op, ast.Not) else self.of(node.operand)
        if isinstance(node, ast.IfExp):
            return self.either([self.of(node.body), self.of(node.orelse)])
        if isinstance(node, ast.BinOp):
            sides = {self.of(node.left), self.of(node.right)}
            return FLOAT if isinstance(node.op, ast.Div) or FLOAT in sides else MIXED if MIXED in sides else WHOLE
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id in _WHOLE_CALLS:
                return WHOLE
            if node.func.id in _EITHER_CALLS:
                return self.either([self.of(a) for a in node.args])
        return FLOAT

    @staticmethod
    def either(kinds: list[str]) -> str:
        """The kind of what may be any of several."""
        return kinds[0] if len(set(kinds)) == 1 else MIXED

    def ambiguous(self, node: ast.BinOp) -> bool:
        """Whether plain Python may take this remainder of whole numbers on one path and of floats on another."""
        if isinstance(node.right, ast.Constant) and node.right.value:
            return False
        sides = {self.of(node.left), self.of(node.right)}
        return MIXED in sides and FLOAT not in sides
