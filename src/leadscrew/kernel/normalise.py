"""From a user's function to the step subset: one meaning for every engine, or a refusal that names the line.

What changes: ``math.*`` and NumPy scalar functions become the portable ones; constant powers become products;
``min``, ``max``, ``int`` and ``round`` become functions with one meaning for NaN and infinity; a NamedTuple is built
with all its fields, in order, each cast to its annotated type; array reads and writes are guarded (a read
outside gives NaN, a write outside poisons the array with NaN: the loop then reports divergence in the same
period on every engine), but not in steps marked :func:`leadscrew.kernel.guards.unguarded`; free names become
frozen constants or functions of the generated module.
"""

from __future__ import annotations

import ast
import types
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from leadscrew.kernel import definite, guards, portable
from leadscrew.kernel.block import Block
from leadscrew.kernel.branchless import is_condition
from leadscrew.kernel.drivers.hooks import Constant
from leadscrew.kernel.normalise_calls import Calls
from leadscrew.kernel.parameters import hints, similar
from leadscrew.kernel.source import MISSING, local_names, lookup, tree_of
from leadscrew.kernel.subset import EXPRESSIONS, NUMBERS, PRINT, STATEMENTS, call, is_named_tuple_type, outside
from leadscrew.kernel.trees import copied, each
from leadscrew.util.errors import SubsetError
from leadscrew.util.frames import place

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module


class Normaliser(Calls):
    """Rewrites one function; its callees are added to ``module`` on the way."""

    def __init__(self, module: Module, function: Callable[..., Any], trusted: bool = False) -> None:
        self.module, self.function, self.trusted = module, function, trusted
        self.unguarded = trusted or hasattr(function, "unguarded")
        self.shared, self.filename = tree_of(function)
        self.node = copied(self.shared)
        self.locals = local_names(self.node)
        self.types: dict[str, type] = {}

    def run(self, name: str) -> ast.FunctionDef:
        """The normalised function under its name in the module."""
        node = self.node
        a = node.args
        if a.vararg or a.kwarg or a.kwonlyargs or a.posonlyargs:
            self.refuse(node, "only plain positional parameters")
        node.name, node.decorator_list, node.returns = name, [], None
        for arg in a.args:
            arg.annotation = None
        a.defaults = []
        body = node.body
        if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            body = body[1:] or [ast.copy_location(ast.Pass(), body[0])]
        node.body = [new for old in body for new in self.statement(old)]
        if not self.trusted:
            definite.check(self.shared, self.locals, self.refuse)
        self.part_locals_from_globals()
        return node

    def part_locals_from_globals(self) -> None:
        """Renames a local that a name of the module would hide."""
        used = {n.id for n in each(self.node) if isinstance(n, ast.Name) and not hasattr(n, "is_local")}
        for n in each(self.node):
            if isinstance(n, ast.Name) and hasattr(n, "is_local") and n.id in used:
                n.id += "_local"
            elif isinstance(n, ast.arg) and n.arg in used:
                n.arg += "_local"

    def refuse(self, node: ast.AST, what: str) -> NoReturn:
        """Refuses a construct by file, line and what it is."""
        line = getattr(node, "lineno", self.node.lineno)
        raise SubsetError(f"{place(self.filename, line)}: in {self.function.__name__!r}: {what}")

    # ---- statements
    def statement(self, node: ast.stmt) -> list[ast.stmt]:
        """A statement, checked and rewritten; folded away where its condition is a constant of the module."""
        if not isinstance(node, STATEMENTS):
            self.refuse(node, outside(node))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return []
        if isinstance(node, ast.Expr) and self.is_print(node.value):
            return [self.printed(node)]
        if isinstance(node, ast.AnnAssign):
            if node.value is None:
                return []
            node = ast.copy_location(ast.Assign([node.target], node.value), node)
        if isinstance(node, ast.AugAssign):
            read = copied(node.target)
            for n in each(read):
                if hasattr(n, "ctx"):
                    n.ctx = ast.Load()
            value = ast.copy_location(ast.BinOp(read, node.op, node.value), node)
            node = ast.copy_location(ast.Assign([node.target], value), node)
        if isinstance(node, ast.Assign):
            return [self.assign(node)]
        if isinstance(node, ast.If):
            return self.branch(node)
        if isinstance(node, ast.For | ast.While):
            return [self.repeat(node)]
        if isinstance(node, ast.Return) and node.value is None:
            self.refuse(node, "a bare 'return'; a step returns its next state and signal")
        return [self.generic_visit(node)]  # type: ignore[list-item]

    def is_print(self, node: ast.expr) -> bool:
        """Whether an expression is a call of Python's own ``print``."""
        return isinstance(node, ast.Call) and self.value(node.func) is print

    def printed(self, node: ast.Expr) -> ast.stmt:
        """A print: it stays for the Python engine; :meth:`Module.fused` refuses it."""
        call_ = node.value
        assert isinstance(call_, ast.Call)
        if call_.keywords:
            self.refuse(node, "keywords in print()")
        call_.func = ast.copy_location(ast.Name(PRINT, ast.Load()), call_.func)
        call_.args = [self.text(a) for a in call_.args]
        return node

    def text(self, node: ast.expr) -> Any:
        """An argument of a print: an expression, a text, or a text with expressions in it."""
        if isinstance(node, ast.JoinedStr):
            node.values = [self.text(v) for v in node.values]
        elif isinstance(node, ast.FormattedValue):
            node.value = self.visit(node.value)
        elif not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
            return self.visit(node)
        return node

    def assign(self, node: ast.Assign) -> ast.stmt:
        if len(node.targets) != 1:
            self.refuse(node, "one target in an assignment")
        target = node.targets[0]
        value = self.visit(node.value)
        if isinstance(target, ast.Subscript) and not self.unguarded:
            indices = target.slice.elts if isinstance(target.slice, ast.Tuple) else [target.slice]
            if len(indices) > 2:
                self.refuse(node, "arrays of one or two dimensions")
            indices = self.from_the_end(target.value, indices)
            put = self.module.function((guards.put1, guards.put2)[len(indices) - 1])
            parts = [self.visit(target.value), *(self.visit(i) for i in indices), value]
            return ast.copy_location(ast.Expr(call(put, *parts)), node)
        if isinstance(target, ast.Attribute):
            self.refuse(node, "a field cannot be assigned; state is immutable, return a new one")
        if isinstance(target, ast.Tuple) and not all(isinstance(e, ast.Name) for e in target.elts):
            self.refuse(node, "only names on the left of a tuple assignment")
        if isinstance(target, ast.Tuple) and len({e.id for e in target.elts}) < len(target.elts):  # type: ignore[attr-defined]
            self.refuse(node, "a name twice on the left of an assignment; Python 3.11 itself has two opinions of it")
        if isinstance(target, ast.Name):
            made = self.class_of(node.value)
            if made is not None:
                self.types[target.id] = made
        node.value, node.targets = value, [self.visit(target)]
        return node

    def branch(self, node: ast.If) -> list[ast.stmt]:
        known = self.constant(node.test)
        if self.trusted and isinstance(known, bool):
            return [new for old in (node.body if known else node.orelse) for new in self.statement(old)]
        node.test = self.visit(node.test)
        node.body = [new for old in node.body for new in self.statement(old)] or [ast.Pass()]
        node.orelse = [new for old in node.orelse for new in self.statement(old)]
        return [node]

    def repeat(self, node: ast.For | ast.While) -> ast.stmt:
        if node.orelse:
            self.refuse(node, "'else' on a loop")
        if isinstance(node, ast.For):
            loop = node.iter
            if not (
                isinstance(loop, ast.Call) and self.value(loop.func) is range and isinstance(node.target, ast.Name)
            ):
                self.refuse(node, "only 'for NAME in range(...)'")
            loop.args = [self.visit(x) for x in loop.args]
            node.target = self.visit(node.target)
        else:
            if self.constant(node.test) and not self.trusted and not definite.leaves(node.body):
                self.refuse(node, "this 'while' never ends; give it a condition, or a 'break'")
            node.test = self.visit(node.test)
        node.body = [new for old in node.body for new in self.statement(old)] or [ast.Pass()]
        return node

    # ---- expressions
    def visit(self, node: ast.AST) -> Any:
        """Dispatches, refusing what is outside the subset."""
        if isinstance(node, ast.expr) and not isinstance(node, EXPRESSIONS) and not self.trusted:
            self.refuse(node, outside(node))
        return super().visit(node)

    def value(self, node: ast.expr) -> Any:
        """The Python object that a name or dotted name stands for, ``MISSING`` for a local or unknown one."""
        if isinstance(node, ast.Name):
            return MISSING if node.id in self.locals else self.outside(self.function, node.id)
        if isinstance(node, ast.Attribute):
            base = self.value(node.value)
            return MISSING if base is MISSING else self.outside(base, node.attr)
        return MISSING

    def outside(self, holder: Any, name: str) -> Any:
        """What a free name of this function, or an attribute of an object, stands for; the module takes note."""
        if not self.trusted:
            return self.module.outside(holder, name, holder is self.function)
        return lookup(holder, name) if holder is self.function else getattr(holder, name, MISSING)

    def constant(self, node: ast.expr) -> Any:
        """The number that an expression always has, or ``None``."""
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return node.value
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            inner = self.constant(node.operand)
            return None if inner is None else -inner
        found = self.value(node)
        found = self.module.constant(found.name) if isinstance(found, Constant) else found
        return found if isinstance(found, NUMBERS) else None

    def class_of(self, node: ast.expr) -> type | None:
        """The NamedTuple class that an expression makes, where that is plain to see."""
        if isinstance(node, ast.Call):
            if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
                return self.class_of(node.func.value)
            made = self.value(node.func)
            return made if is_named_tuple_type(made) else None
        if isinstance(node, ast.Name):
            return self.types.get(node.id) or self.module.argument_type(self.function, node.id)
        if isinstance(node, ast.Attribute):
            base = self.class_of(node.value)
            inner = hints(base).get(node.attr) if base else None
            return inner if is_named_tuple_type(inner) else None
        return None

    def named(self, node: ast.expr, found: Any) -> ast.expr:
        """Syntax for a free name's value: a frozen number, an array of the module, a function, a class."""
        if isinstance(found, Constant):
            found = self.module.constant(found.name)
        if isinstance(found, NUMBERS):
            return ast.copy_location(self.held(node, found), node)
        if isinstance(found, np.ndarray):
            self.check_table(node, found)
            return ast.copy_location(ast.Name(self.module.array(found, getattr(node, "id", "table")), ast.Load()), node)
        if isinstance(found, Block | types.FunctionType | types.BuiltinFunctionType) or is_named_tuple_type(found):
            return ast.copy_location(ast.Name(self.module.callable(found, self.trusted), ast.Load()), node)
        name = ast.unparse(node)
        if isinstance(found, list | tuple):
            self.refuse(node, f"{name!r} is a {type(found).__name__}; make it an array, outside the step: "
                              f"{name} = np.array({name})")  # fmt: skip
        self.refuse(node, f"{name!r} is a {type(found).__name__}; from outside a step it can use numbers, arrays, "
                          "functions, blocks and NamedTuples")  # fmt: skip

    def visit_Constant(self, node: ast.Constant) -> ast.expr:  # noqa: N802
        if not isinstance(node.value, int | float):
            self.refuse(node, f"the constant {node.value!r}; a step computes with numbers only")
        return ast.copy_location(self.held(node, node.value), node)

    def check_table(self, node: ast.expr, table: np.ndarray) -> None:
        """Refuses a constant array that cannot be frozen as 64-bit whole numbers or doubles."""
        if table.dtype.kind not in "iubf" or (table.dtype.kind == "u" and table.size and table.max() >= 2**63):
            self.refuse(node, f"{ast.unparse(node)!r} is an array of {table.dtype}; whole numbers have 64 bits and "
                              "floats are doubles: write np.array(..., dtype=float)")  # fmt: skip

    def visit_Name(self, node: ast.Name) -> ast.expr:  # noqa: N802
        if isinstance(node.ctx, ast.Store) or node.id in self.locals:
            node.is_local = True  # type: ignore[attr-defined]
            return node
        found = self.outside(self.function, node.id)
        if found is MISSING:
            known = self.readable()
            near = [known[n] for n in similar(node.id, known)]
            hint = f"; did you mean {', '.join(near)}?" if near else ""
            self.refuse(node, f"the name {node.id!r} is not defined{hint}")
        return self.named(node, found)

    def readable(self) -> dict[str, str]:
        """Locals of the step, and the fields of its parameters and state, each with how it is read."""
        known = {name: name for name in sorted(self.locals)}
        for argument in ("p", "s"):
            cls: Any = self.module.argument_type(self.function, argument)
            known |= {field: f"{argument}.{field}" for field in (cls._fields if cls else ())}
        return known

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:  # noqa: N802
        found = self.value(node)
        of_array = node.attr == "shape" and isinstance(self.value(node.value), np.ndarray)
        if found is not MISSING and not of_array:
            return self.named(node, found)
        node.value = self.visit(node.value)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:  # noqa: N802
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        of_shape = isinstance(node.value, ast.Attribute) and node.value.attr == "shape" and len(indices) == 1
        if self.unguarded or of_shape:
            return self.generic_visit(node)  # type: ignore[return-value]
        if any(isinstance(i, ast.Slice) for i in indices):
            self.refuse(node, "slices; index the elements")
        if len(indices) > 2:
            self.refuse(node, "arrays of one or two dimensions")
        table, at = self.value(node.value), self.constant(indices[0])
        if len(indices) == 1 and isinstance(table, np.ndarray) and type(at) is int:
            if not -len(table) <= at < len(table):
                self.refuse(node, f"the index {at} into an array of {len(table)}")
            return self.generic_visit(node)  # type: ignore[return-value]
        indices = self.from_the_end(node.value, indices)
        at = self.module.function((guards.at1, guards.at2)[len(indices) - 1])
        return ast.copy_location(call(at, self.visit(node.value), *(self.visit(i) for i in indices)), node)

    def from_the_end(self, array: ast.expr, indices: list[ast.expr]) -> list[ast.expr]:
        """Indices, with a constant one below zero counted from the end."""
        found = []
        for axis, index in enumerate(indices):
            at = self.constant(index)
            if isinstance(at, int) and at < 0:
                size = ast.Subscript(ast.Attribute(copied(array), "shape", ast.Load()), ast.Constant(axis), ast.Load())
                index = ast.copy_location(ast.BinOp(size, ast.Sub(), ast.Constant(-at)), index)
            found.append(index)
        return found

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:  # noqa: N802
        self.generic_visit(node)
        self.unconditional(node, node.body, node.orelse)
        return node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:  # noqa: N802
        self.generic_visit(node)
        self.unconditional(node, *node.values[1:])
        if self.trusted or all(is_condition(v) for v in node.values):
            return node
        made = node.values[-1]
        for value in reversed(node.values[:-1]):
            sides = (made, copied(value)) if isinstance(node.op, ast.And) else (copied(value), made)
            made = ast.IfExp(value, *sides)
        return ast.copy_location(made, node)

    def unconditional(self, node: ast.expr, *arms: ast.expr) -> None:
        """Refuses a call under a condition whose effects do not wait for the condition: both arms are computed."""
        for arm in () if self.trusted else arms:
            for n in each(arm):
                if isinstance(n, ast.Call) and isinstance(n.func, ast.Name) and self.module.has_effects(n.func.id):
                    self.refuse(
                        node, f"{n.func.id!r} writes an array or waits in a 'while'; call it under an 'if' statement"
                    )

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:  # noqa: N802
        if isinstance(node.op, ast.MatMult):
            self.refuse(node, "'@'; write the sums out")
        if isinstance(node.op, ast.LShift | ast.RShift) and not self.trusted:
            by = self.constant(node.right)
            if not (isinstance(by, int) and 0 <= by < 64):
                self.refuse(node, "a shift by anything but a number from 0 to 63")
        if not isinstance(node.op, ast.Pow):
            return self.generic_visit(node)  # type: ignore[return-value]
        power, base = self.constant(node.right), self.visit(node.left)
        if power is not None and abs(power) <= 64 and power == int(power):
            made: ast.expr = call(self.module.power(abs(int(power))), base)
        elif power is not None and abs(power) == 0.5:
            made = call(self.module.function(portable.sqrt), base)
        else:
            made = call(self.module.function(portable.pow), base, self.visit(node.right))
            return ast.copy_location(made, node)
        if power < 0:
            made = ast.BinOp(ast.Constant(1.0), ast.Div(), made)
        return ast.copy_location(made, node)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:  # noqa: N802
        for op in node.ops:
            if isinstance(op, ast.Is | ast.IsNot | ast.In | ast.NotIn):
                self.refuse(node, "'is' and 'in'")
        return self.generic_visit(node)  # type: ignore[return-value]
