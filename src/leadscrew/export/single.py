"""A step in single precision, in plain Python: the reference that a ``float`` export is held against.

Every number of the step is a NumPy ``float32`` and every operation rounds to one. The portable mathematics computes
with doubles there too, as the exported C does, and its result is rounded.
"""

from __future__ import annotations

import ast
from typing import Any

import numpy as np

from leadscrew.export.source import Source
from leadscrew.kernel import bits
from leadscrew.kernel.c99.types import DOUBLE
from leadscrew.kernel.ieee import Table, ieee_range
from leadscrew.kernel.layout import is_branch
from leadscrew.kernel.module import Module
from leadscrew.kernel.trees import code_of, copied

F = np.float32


def _zeros(shape: Any) -> np.ndarray:
    return np.zeros(shape, dtype=F)


def _divide(a: Any, b: Any) -> Any:
    return F(a) / F(b)


def _modulo(a: Any, b: Any) -> Any:
    if isinstance(a, int) and isinstance(b, int):
        return a % b if b else 0
    rest = np.fmod(F(a), F(b))
    if rest == 0:
        return np.copysign(F(0), F(b))
    return rest + F(b) if (rest < 0) != (b < 0) else rest


def _floor_divide(a: Any, b: Any) -> Any:
    if isinstance(a, int) and isinstance(b, int):
        return a // b if b else 0
    if b == 0:
        return F(a) / F(b)
    rest = np.fmod(F(a), F(b))
    whole = (F(a) - rest) / F(b)
    if rest != 0 and (rest < 0) != (b < 0):
        whole = whole - F(1)
    if whole == 0:
        return np.copysign(F(0), F(a) / F(b))
    down = np.floor(whole)
    return down + F(1) if whole - down > F(0.5) else down


_OPERATORS = {ast.Div: "_divide", ast.Mod: "_modulo", ast.FloorDiv: "_floor_divide"}


class _Single(ast.NodeTransformer):
    """Rounds every constant to single precision and takes division to the helpers above."""

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if isinstance(node.value, float):
            return ast.Call(ast.Name("_f", ast.Load()), [node], [])
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        if ast.unparse(node) in ("np.nan", "np.inf"):
            return ast.Call(ast.Name("_f", ast.Load()), [node], [])
        self.generic_visit(node)
        return node

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        self.generic_visit(node)
        return ast.Call(ast.Name("bool", ast.Load()), [node], [])

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if ast.unparse(node.func) in ("np.zeros", "np.empty"):
            return ast.Call(ast.Name("_zeros", ast.Load()), node.args, [])
        self.generic_visit(node)
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        name = _OPERATORS.get(type(node.op))
        return node if name is None else ast.Call(ast.Name(name, ast.Load()), [node.left, node.right], [])


def _rounded(function: Any) -> Any:
    """A function that computes with doubles, its result rounded to single precision."""

    def outside(*args: Any) -> Any:
        result = function(*(float(a) if isinstance(a, np.floating) else a for a in args))
        return F(result) if isinstance(result, float) else result

    return outside


def as_single(value: Any) -> Any:
    """A value with every float rounded to single precision, and every number of an array."""
    if is_branch(value):
        return type(value)(*(as_single(v) for v in value))
    with np.errstate(over="ignore"):
        if isinstance(value, np.ndarray):
            return value.astype(F)
        return F(value) if isinstance(value, float | np.floating) else value


def namespace(module: Module, source: Source) -> dict[str, Any]:
    """The functions of a module in single precision."""
    space: dict[str, Any] = {
        "np": np, "_f": F, "_zeros": _zeros, "_divide": _divide, "_modulo": _modulo, "_floor_divide": _floor_divide,
        "range": ieee_range,
    }  # fmt: skip
    doubles = module.namespace()
    space.update({name: getattr(bits, name) for name in bits.INTRINSICS})
    for item in module.ordered():
        if item.kind == "class":
            space[item.name] = item.value
        elif item.kind == "array":
            space[item.name] = Table(item.value) if item.value.dtype.kind == "i" else as_single(item.value)
        elif source.unit.real_of(item) is DOUBLE:
            space[item.name] = _rounded(doubles[item.name])
        else:
            node = _Single().visit(copied(item.node))
            exec(code_of(ast.Module([node], type_ignores=[]), item.filename or "<single>"), space)
    return space


def replay(source: Source, inputs: np.ndarray) -> np.ndarray:
    """What a controller gives in single precision for inputs, row by row from its start."""
    step = namespace(source.module, source)[source.step]
    block = source.block
    p, s = as_single(source.prepared), as_single(source.state)
    names = [a.key for a in source.inputs]
    out: list[list[float]] = []
    with np.errstate(all="ignore"):
        for k, row in enumerate(inputs.astype(F)):
            given = dict(zip(names, row, strict=True))
            known = {"t": F(k * source.period), "dt": F(source.period)}
            args = [known[n] if n in known else source.filled(n, given, F) for n in block.signals]
            lead = [x for x in (p, s) if x is not None]
            result = step(*lead, *args)
            if s is not None:
                s, result = result
                s = as_single(s)
            out.append([float(F(x)) for x in source.numbers(result)])
    return np.array(out)
