"""What the locals of a fused entry are: truth values, integers, floats, or arrays of known rank."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from llvmlite import ir

from leadscrew.kernel.errors import SubsetError

F64, I64, I1 = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
RANK = {I1: 0, I64: 1, F64: 2}


@dataclass
class Array:
    """Where an array lies, and its shape: numbers where they are known, else values."""

    base: Any
    shape: list[Any]
    element: Any


def signature(node: ast.FunctionDef, ranks: Mapping[str, tuple[int, str]]) -> list[tuple[str, int, str]]:
    """The arrays that an entry takes: name, dimensions, ``f`` or ``i``."""
    return [(a.arg, *ranks[a.arg]) for a in node.args.args]


class Locals:
    """Knows the type of every local of one entry."""

    def __init__(
        self, node: ast.FunctionDef, ranks: Mapping[str, tuple[int, str]], constants: Mapping[str, np.ndarray]
    ) -> None:
        self.node, self.constants = node, constants
        self.arguments = signature(node, ranks)
        self.module = ir.Module(name=node.name)
        self.arrays: dict[str, Array] = {}
        self.tables: dict[str, Array] = {}
        """Frozen arrays of the module."""
        self.slots: dict[str, Any] = {}
        self.types: dict[str, Any] = {}
        self.loops: list[tuple[Any, Any]] = []

    def refuse(self, node: ast.AST, what: str) -> NoReturn:
        """Says what of the generated code cannot be lowered."""
        raise SubsetError(f"{self.node.name}: {what}: {ast.unparse(node)[:120]}")

    # ---- types of the locals
    def infer(self) -> None:
        """The widest type that each local is given (truth value, integer, float), and which locals are arrays."""
        self.ranks = {name: rank for name, rank, _ in self.arguments}
        self.ranks.update({name: value.ndim for name, value in self.constants.items()})
        setters = [n for n in ast.walk(self.node) if isinstance(n, ast.For | ast.Assign)]
        while True:
            before = dict(self.types), dict(self.ranks)
            for n in setters:
                if isinstance(n, ast.For) and isinstance(n.target, ast.Name):
                    self.widen(n.target.id, I64)
                elif isinstance(n, ast.Assign) and isinstance(n.targets[0], ast.Name):
                    name, rank = n.targets[0].id, self.rank(n.value)
                    if rank:
                        self.ranks[name] = rank
                    elif name not in self.ranks:
                        self.widen(name, self.kind(n.value))
            if before == (self.types, self.ranks):
                return

    def widen(self, name: str, kind: Any) -> None:
        """Gives a local at least this type."""
        old = self.types.get(name)
        if kind is not None:
            self.types[name] = kind if old is None or RANK[kind] > RANK[old] else old

    def rank(self, node: ast.expr) -> int:
        """How many dimensions an expression has; 0 for a number."""
        if isinstance(node, ast.Name):
            return self.ranks.get(node.id, 0)
        if isinstance(node, ast.Call):
            text = ast.unparse(node.func)
            if text.endswith(".reshape") or text == "stack_array2":
                return len(node.args)
            if text in ("np.empty", "np.zeros"):
                return len(node.args[0].elts) if isinstance(node.args[0], ast.Tuple) else 1
        if isinstance(node, ast.Subscript):
            outer = self.rank(node.value)
            if isinstance(node.slice, ast.Slice):
                return outer
            return max(0, outer - (len(node.slice.elts) if isinstance(node.slice, ast.Tuple) else 1))
        return 0

    def kind(self, node: ast.expr) -> Any:
        """The type of a number, or ``None`` while it is not known."""
        if isinstance(node, ast.Constant):
            return I1 if isinstance(node.value, bool) else I64 if isinstance(node.value, int) else F64
        if isinstance(node, ast.Name):
            return self.types.get(node.id)
        if isinstance(node, ast.Attribute):
            return F64
        if isinstance(node, ast.Compare | ast.BoolOp):
            return I1
        if isinstance(node, ast.UnaryOp):
            if isinstance(node.op, ast.Not):
                return I1
            inner = self.kind(node.operand)
            return I64 if inner is I1 else inner
        if isinstance(node, ast.BinOp):
            if isinstance(node.op, ast.Div):
                return F64
            a, b = self.kind(node.left), self.kind(node.right)
            if a is None or b is None:
                return a if b is None else b
            if isinstance(node.op, ast.BitAnd | ast.BitOr | ast.BitXor) and a is I1 and b is I1:
                return I1
            return F64 if F64 in (a, b) else I64
        if isinstance(node, ast.Subscript):
            base = node.value
            if isinstance(base, ast.Attribute) and base.attr == "shape":
                return I64
            name = base.id if isinstance(base, ast.Name) else ""
            if name in self.constants:
                return I64 if self.constants[name].dtype.kind == "i" else F64
            return self.arrays[name].element if name in self.arrays else F64
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            if name == "ieee_select":
                a, b = self.kind(node.args[1]), self.kind(node.args[2])
                known = [k for k in (a, b) if k is not None]
                return max(known, key=lambda k: RANK[k]) if known else None
            if name in ("int", "len", "float_to_bits"):
                return I64
            if name == "bool":
                return I1
            if name == "abs":
                return self.kind(node.args[0])
            return F64
        return None
