"""From a user's function to the step subset: one meaning for every engine, or a refusal that names the line.

What changes: ``math.*`` and NumPy scalar functions become the portable ones; constant powers become products;
``min``, ``max``, ``int`` and ``round`` become functions with one meaning for NaN and infinity; a NamedTuple is built
with all its fields, in order, each cast to its annotated type; array reads and writes are guarded (a read
outside gives NaN, a write outside poisons the array with NaN: the loop then reports divergence in the same
period on every engine); free names become frozen constants or functions of the generated module.
"""

from __future__ import annotations

import ast
import types
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from leadscrew.kernel import definite, guards, portable
from leadscrew.kernel.block import Block
from leadscrew.kernel.drivers.holes import Constant
from leadscrew.kernel.errors import SubsetError
from leadscrew.kernel.sheet import hints, leaf_type
from leadscrew.kernel.source import MISSING, local_names, lookup, tree_of
from leadscrew.kernel.trees import copied, each

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module

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

_NUMBERS = (bool, int, float, np.floating, np.integer, np.bool_)
_STATEMENTS = (
    ast.Assign, ast.AnnAssign, ast.AugAssign, ast.If, ast.For, ast.While, ast.Return, ast.Pass, ast.Break,
    ast.Continue, ast.Expr,
)  # fmt: skip
_EXPRESSIONS = (
    ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Call, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare,
    ast.IfExp, ast.Tuple,
)  # fmt: skip
_SHAPERS = ("zeros", "empty")


def is_named_tuple_type(value: Any) -> bool:
    """Whether ``value`` is a NamedTuple class."""
    return isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")


def literal(value: Any) -> ast.expr:
    """Syntax of a number, infinities and NaN included."""
    if isinstance(value, bool | np.bool_):
        return ast.Constant(bool(value))
    if isinstance(value, int | np.integer):
        return ast.Constant(int(value))
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


class Normaliser(ast.NodeTransformer):
    """Rewrites one function; its callees are added to ``module`` on the way."""

    def __init__(self, module: Module, function: Callable[..., Any], trusted: bool = False) -> None:
        self.module, self.function, self.trusted = module, function, trusted
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
        return ast.fix_missing_locations(node)

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
        raise SubsetError(f"{self.filename}:{line}: in {self.function.__name__!r}: {what}")

    # ---- statements
    def statement(self, node: ast.stmt) -> list[ast.stmt]:
        """A statement, checked and rewritten; folded away where its condition is a constant of the module."""
        if not isinstance(node, _STATEMENTS):
            self.refuse(node, f"'{type(node).__name__.lower()}' is outside the step subset")
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return []
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

    def assign(self, node: ast.Assign) -> ast.stmt:
        if len(node.targets) != 1:
            self.refuse(node, "one target in an assignment")
        target = node.targets[0]
        value = self.visit(node.value)
        if isinstance(target, ast.Subscript) and not self.trusted:
            indices = target.slice.elts if isinstance(target.slice, ast.Tuple) else [target.slice]
            if len(indices) > 2:
                self.refuse(node, "arrays of one or two dimensions")
            put = self.module.function((guards.put1, guards.put2)[len(indices) - 1])
            parts = [self.visit(target.value), *(self.visit(i) for i in indices), value]
            return ast.copy_location(ast.Expr(call(put, *parts)), node)
        if isinstance(target, ast.Attribute):
            self.refuse(node, "a field cannot be assigned; state is immutable, return a new one")
        if isinstance(target, ast.Tuple) and not all(isinstance(e, ast.Name) for e in target.elts):
            self.refuse(node, "only names on the left of a tuple assignment")
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
            node.test = self.visit(node.test)
        node.body = [new for old in node.body for new in self.statement(old)] or [ast.Pass()]
        return node

    # ---- expressions
    def visit(self, node: ast.AST) -> Any:
        """Dispatches, refusing what is outside the subset."""
        if isinstance(node, ast.expr) and not isinstance(node, _EXPRESSIONS) and not self.trusted:
            self.refuse(node, f"'{type(node).__name__.lower()}' is outside the step subset")
        return super().visit(node)

    def value(self, node: ast.expr) -> Any:
        """The Python object that a name or dotted name stands for, ``MISSING`` for a local or unknown one."""
        if isinstance(node, ast.Name):
            return MISSING if node.id in self.locals else lookup(self.function, node.id)
        if isinstance(node, ast.Attribute):
            base = self.value(node.value)
            return MISSING if base is MISSING else getattr(base, node.attr, MISSING)
        return MISSING

    def constant(self, node: ast.expr) -> Any:
        """The number that an expression always has, or ``None``."""
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return node.value
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            inner = self.constant(node.operand)
            return None if inner is None else -inner
        found = self.value(node)
        found = self.module.constants.get(found.name) if isinstance(found, Constant) else found
        return found if isinstance(found, _NUMBERS) else None

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
            found = self.module.constants[found.name]
        if isinstance(found, _NUMBERS):
            return ast.copy_location(literal(found), node)
        if isinstance(found, np.ndarray):
            return ast.copy_location(ast.Name(self.module.array(found, getattr(node, "id", "table")), ast.Load()), node)
        if isinstance(found, Block | types.FunctionType | types.BuiltinFunctionType) or is_named_tuple_type(found):
            return ast.copy_location(ast.Name(self.module.callable(found, self), ast.Load()), node)
        self.refuse(node, f"{ast.unparse(node)!r} is a {type(found).__name__}; only numbers, arrays, functions, blocks "
                          "and NamedTuple classes can be used from outside a step")  # fmt: skip

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if not isinstance(node.value, int | float):
            self.refuse(node, f"the constant {node.value!r}; only numbers")
        return ast.copy_location(literal(node.value), node)

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if isinstance(node.ctx, ast.Store) or node.id in self.locals:
            node.is_local = True  # type: ignore[attr-defined]
            return node
        found = lookup(self.function, node.id)
        if found is MISSING:
            self.refuse(node, f"the name {node.id!r} is not defined")
        return self.named(node, found)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        found = self.value(node)
        if found is not MISSING:
            return self.named(node, found)
        node.value = self.visit(node.value)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if self.trusted or (isinstance(node.value, ast.Attribute) and node.value.attr == "shape" and len(indices) == 1):
            return self.generic_visit(node)  # type: ignore[return-value]
        if any(isinstance(i, ast.Slice) for i in indices):
            self.refuse(node, "slices; index the elements")
        if len(indices) > 2:
            self.refuse(node, "arrays of one or two dimensions")
        table, at = self.value(node.value), self.constant(indices[0])
        if len(indices) == 1 and isinstance(table, np.ndarray) and isinstance(at, int):
            if not -len(table) <= at < len(table):
                self.refuse(node, f"the index {at} into an array of {len(table)}")
            return self.generic_visit(node)  # type: ignore[return-value]
        for axis, index in enumerate(indices):
            if isinstance(self.constant(index), int) and (self.constant(index) or 0) < 0:
                size = ast.parse(f"({ast.unparse(node.value)}).shape[{axis}]", mode="eval").body
                indices[axis] = ast.copy_location(ast.BinOp(size, ast.Add(), index), index)
        at = self.module.function((guards.at1, guards.at2)[len(indices) - 1])
        return ast.copy_location(call(at, self.visit(node.value), *(self.visit(i) for i in indices)), node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        if isinstance(node.op, ast.MatMult):
            self.refuse(node, "'@'; write the sums out")
        if not isinstance(node.op, ast.Pow):
            return self.generic_visit(node)  # type: ignore[return-value]
        power, base = self.constant(node.right), self.visit(node.left)
        if power is not None and power == int(power) and abs(power) <= 64:
            made: ast.expr = call(self.module.power(abs(int(power))), base)
        elif power is not None and abs(power) == 0.5:
            made = call(self.module.function(portable.sqrt), base)
        else:
            made = call(self.module.function(portable.pow), base, self.visit(node.right))
            return ast.copy_location(made, node)
        if power < 0:
            made = ast.BinOp(ast.Constant(1.0), ast.Div(), made)
        return ast.copy_location(made, node)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        for op in node.ops:
            if isinstance(op, ast.Is | ast.IsNot | ast.In | ast.NotIn):
                self.refuse(node, "'is' and 'in'")
        return self.generic_visit(node)  # type: ignore[return-value]

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
        target = found.step if isinstance(found, Block) else getattr(found, "py_func", found)
        if not isinstance(target, types.FunctionType):
            self.refuse(node, f"{ast.unparse(node.func)!r} is a {type(found).__name__}, not a plain Python function")
        args = self.arguments(node, target)
        return ast.copy_location(call(self.module.callable(target, self), *args), node)

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
                if n not in defaults or not isinstance(defaults[n], _NUMBERS):
                    self.refuse(node, f"{target.__name__}() misses its argument {n!r}")
                given[n] = literal(defaults[n])
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
                if not isinstance(cls._field_defaults.get(field), _NUMBERS):
                    self.refuse(node, f"{cls.__name__}: the field {field!r} is missing")
                given[field] = literal(cls._field_defaults[field])
        return self.constructed(node, cls, given)

    def constructed(self, node: ast.AST, cls: Any, given: dict[str, ast.expr]) -> ast.expr:
        sheet = hints(cls)
        args = []
        for field in cls._fields:
            value = given[field]
            kind = leaf_type(sheet.get(field), None) if not is_named_tuple_type(sheet.get(field)) else ""
            base = getattr(sheet.get(field), "__origin__", sheet.get(field))
            cast = kind in ("float", "int", "bool") and base in (float, int, bool) and not self.trusted
            args.append(self.cast(kind, value) if cast else value)
        return ast.copy_location(call(self.module.callable(cls, self), *args), node)

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

    def mathematics(self, node: ast.Call, found: Any, name: str) -> ast.expr:
        args = [self.visit(a) for a in node.args]
        if name == "float64" and len(args) == 1:
            return ast.copy_location(self.cast("float", args[0]), node)
        if name in _SHAPERS:
            return ast.copy_location(
                ast.Call(ast.Attribute(ast.Name("np", ast.Load()), name, ast.Load()), args, []), node
            )
        if name not in MATHS or node.keywords:
            self.refuse(
                node, f"{ast.unparse(node.func)!r} has no portable counterpart; there are {', '.join(sorted(MATHS))}"
            )
        return ast.copy_location(call(self.module.function(MATHS[name]), *args), node)

    def builtin(self, node: ast.Call, name: str) -> ast.expr:
        if node.keywords:
            self.refuse(node, f"keywords in {name}()")
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
