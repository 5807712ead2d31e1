"""Calls in a step: to other steps, to NamedTuple classes, to library functions; each with one meaning."""

from __future__ import annotations

import ast
import types
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from leadscrew.kernel import portable
from leadscrew.kernel.block import Block
from leadscrew.kernel.parameters import SILENT, notes
from leadscrew.kernel.source import MISSING
from leadscrew.kernel.subset import MATHS, NUMBERS, SCALAR, SHAPERS, call, is_named_tuple_type, literal
from leadscrew.kernel.trees import copied

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module


class Calls(ast.NodeTransformer):
    """The part of the normaliser that rewrites calls."""

    module: Module
    trusted: bool

    def refuse(self, node: ast.AST, what: str) -> NoReturn:
        """Refuses a construct; the normaliser says where."""
        raise NotImplementedError

    def value(self, node: ast.expr) -> Any:
        """The object that a name stands for."""
        raise NotImplementedError

    def constant(self, node: ast.expr) -> Any:
        """The number that an expression always has."""
        raise NotImplementedError

    def class_of(self, node: ast.expr) -> type | None:
        """The NamedTuple class that an expression makes."""
        raise NotImplementedError

    def held(self, node: ast.AST, number: Any) -> ast.expr:
        """A number from the source, from outside the step or a default, as a literal; refused beyond 64 bits."""
        if isinstance(number, int | np.integer) and not -(2**63) <= number < 2**63:
            self.refuse(node, f"the whole number {number}; whole numbers have 64 bits: write it as a float, with '.0'")
        return literal(number)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self.replaced(node)
        found = self.value(node.func)
        if found is MISSING:
            if self.trusted and isinstance(node.func, ast.Attribute):
                return self.generic_visit(node)  # type: ignore[return-value]
            self.refuse(node, f"{ast.unparse(node.func)!r} is not a function that can be compiled")
        if any(isinstance(a, ast.Starred) for a in node.args) or any(k.arg is None for k in node.keywords):
            self.refuse(node, "'*' and '**' in a call")
        if is_named_tuple_type(found):
            return self.built(node, found)
        module = getattr(found, "__module__", "") or ""
        name = getattr(found, "__name__", "")
        if isinstance(found, np.ufunc) or module in ("math", "_math") or module.startswith("numpy"):
            if self.trusted:
                return ast.copy_location(ast.Call(node.func, [self.visit(a) for a in node.args], []), node)
            return self.mathematics(node, found, name)
        if module == "builtins":
            return self.builtin(node, name)
        target = found.step if isinstance(found, Block) else found
        if not isinstance(target, types.FunctionType):
            self.refuse(node, f"{ast.unparse(node.func)!r} is a {type(found).__name__}, not a plain Python function")
        args = self.arguments(node, target)
        return ast.copy_location(call(self.module.callable(target, self.trusted), *args), node)

    def arguments(self, node: ast.Call, target: types.FunctionType) -> list[ast.expr]:
        """The arguments of a call to a plain function, keywords and defaults put in order."""
        names = target.__code__.co_varnames[: target.__code__.co_argcount]
        given = dict(zip(names, (self.visit(a) for a in node.args), strict=False))
        for k in node.keywords:
            if k.arg not in names or k.arg in given:
                self.refuse(node, f"{target.__name__}() has no free parameter {k.arg!r}")
            given[str(k.arg)] = self.visit(k.value)
        defaults = dict(zip(reversed(names), reversed(target.__defaults__ or ()), strict=False))
        for n in names:
            if n not in given:
                if n not in defaults or not isinstance(defaults[n], NUMBERS):
                    self.refuse(node, f"{target.__name__}() misses its argument {n!r}")
                given[n] = self.held(node, defaults[n])
        if len(node.args) > len(names):
            self.refuse(node, f"{target.__name__}() takes {len(names)} arguments, {len(node.args)} given")
        return [given[n] for n in names]

    def built(self, node: ast.Call, cls: Any) -> ast.expr:
        """A NamedTuple with every field in order, each cast to what its annotation says."""
        given = dict(zip(cls._fields, (self.visit(a) for a in node.args), strict=False))
        for k in node.keywords:
            if k.arg not in cls._fields or k.arg in given:
                self.refuse(node, f"{cls.__name__} has no free field {k.arg!r}; it has {', '.join(cls._fields)}")
            given[str(k.arg)] = self.visit(k.value)
        for field in cls._fields:
            if field not in given:
                if not isinstance(cls._field_defaults.get(field), NUMBERS):
                    self.refuse(node, f"{cls.__name__}: the field {field!r} is missing")
                given[field] = self.held(node, cls._field_defaults[field])
        return self.constructed(node, cls, given)

    def constructed(self, node: ast.AST, cls: Any, given: dict[str, ast.expr]) -> ast.expr:
        sheet = notes(cls)
        args = []
        for field in cls._fields:
            value = given[field]
            note = sheet.get(field, SILENT)
            cast = note.base in (float, int, bool) and not self.trusted
            args.append(self.cast(note.type, value) if cast else value)
        return ast.copy_location(call(self.module.callable(cls, self.trusted), *args), node)

    def cast(self, kind: str, value: ast.expr) -> ast.expr:
        """A value as ``float``, ``int`` or ``bool``, with one meaning on every engine."""
        if kind == "float":
            if isinstance(value, ast.Constant):
                return literal(float(value.value))  # type: ignore[arg-type]
            return ast.BinOp(ast.Constant(1.0), ast.Mult(), value)
        if isinstance(value, ast.Constant) and isinstance(value.value, int):
            return (
                value
                if kind == "bool" and isinstance(value.value, bool)
                else ast.Constant({"int": int, "bool": bool}[kind](value.value))
            )
        return call(self.module.function(portable.to_int), value) if kind == "int" else call("bool", value)

    def replaced(self, node: ast.Call) -> ast.expr:
        """``x._replace(a=1)`` as a full constructor call."""
        source = node.func.value  # type: ignore[attr-defined]
        cls: Any = self.class_of(source)
        if cls is None:
            self.refuse(node, f"the type of {ast.unparse(source)!r} is not plain; build the NamedTuple by its name")
        if not isinstance(source, ast.Name | ast.Attribute):
            self.refuse(node, "'_replace' on a name only")
        changes = {str(k.arg): self.visit(k.value) for k in node.keywords}
        for key in changes:
            if key not in cls._fields:
                self.refuse(node, f"{cls.__name__} has no field {key!r}; it has {', '.join(cls._fields)}")
        read = self.visit(copied(source))
        given = {f: changes.get(f, ast.Attribute(copied(read), f, ast.Load())) for f in cls._fields}
        return self.constructed(node, cls, given)

    def field(self, node: ast.Call) -> ast.expr:
        """``getattr(x, NAME)``, of a name that is a constant outside of the step, as ``x.name``."""
        name = self.value(node.args[1])
        if not isinstance(name, str):
            self.refuse(node, "getattr() by a name that is no constant text outside of the step")
        return ast.copy_location(ast.Attribute(self.visit(node.args[0]), name, ast.Load()), node)

    def mathematics(self, node: ast.Call, found: Any, name: str) -> ast.expr:
        if name not in MATHS and name in SCALAR:
            self.refuse(node, f"{ast.unparse(node.func)!r} cannot be used in a step; {SCALAR[name]}")
        args = [self.visit(a) for a in node.args]
        if name == "float64" and len(args) == 1:
            return ast.copy_location(self.cast("float", args[0]), node)
        if name in SHAPERS:
            sizes = node.args[0].elts if node.args and isinstance(node.args[0], ast.Tuple) else node.args
            known = [self.constant(x) for x in sizes]
            if not (0 < len(known) <= 2 and all(isinstance(n, int) and n > 0 for n in known)):
                self.refuse(node, f"np.{name} needs a constant size of one or two dimensions")
            return ast.copy_location(
                ast.Call(ast.Attribute(ast.Name("np", ast.Load()), "zeros", ast.Load()), args, []), node
            )
        if name not in MATHS or node.keywords:
            what = ast.unparse(node.func)
            self.refuse(node, f"{what!r} cannot be used in a step; the page 'Blocks' lists the functions that can")
        return ast.copy_location(call(self.module.function(MATHS[name]), *args), node)

    def builtin(self, node: ast.Call, name: str) -> ast.expr:
        if name == "print":
            self.refuse(node, "print() inside an expression; write it on a line of its own")
        if name == "sum":
            self.refuse(node, "sum() is outside the step subset; write a + b, or a 'for' loop")
        if node.keywords:
            self.refuse(node, f"keywords in {name}()")
        if name == "getattr" and len(node.args) == 2:
            return self.field(node)
        args = [self.visit(a) for a in node.args]
        if name in ("min", "max") and len(args) >= 2:
            pick = self.module.function(portable.maximum if name == "max" else portable.minimum)
            made = args[0]
            for other in args[1:]:
                made = call(pick, made, other)
            return ast.copy_location(made, node)
        if name in ("abs", "bool", "len", "range") and args:
            return ast.copy_location(call(name, *args), node)
        if name == "float" and len(args) == 1:
            return ast.copy_location(self.cast("float", args[0]), node)
        if name == "int" and len(args) == 1:
            if self.trusted:
                return ast.copy_location(call("int", *args), node)
            return ast.copy_location(call(self.module.function(portable.to_int), *args), node)
        if name == "round" and len(args) == 1:
            even = call(self.module.function(portable.round_half_even), *args)
            return ast.copy_location(call(self.module.function(portable.to_int), even), node)
        self.refuse(node, f"{name}() with {len(args)} argument(s) is outside the step subset")
