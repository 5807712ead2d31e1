"""Follows kinds of numbers and arrays through a step and all that it calls, and refuses what engines would differ in.

Machine code gives every local one type and every array one place. A value that is a whole number on one path and a
float on another is a float there, plain Python keeps the whole number; an array that is one array on one path and
another on another has no one place. It runs on normalised trees, once for each step, into each function with what is
known of its arguments. On the way it marks whole-number arithmetic that may leave 64 bits, and whole numbers that meet
floats in comparisons, for the Python engine.
"""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import numpy as np

from leadscrew.kernel.parameters import SILENT, leaf_type, nearest, notes
from leadscrew.kernel.subset import PRINT, is_named_tuple_type
from leadscrew.util.errors import SubsetError
from leadscrew.util.frames import place

if TYPE_CHECKING:
    from leadscrew.kernel.module import Item, Module

WHOLE, FLOAT, MIXED, SIGNAL, ANY = "whole", "float", "mixed", "signal", "any"
"""Numbers: whole, float, either by path; a float or a NamedTuple of floats; what is not known."""
STATE, PARAMETERS, TABLE, FRESH = "the state", "the parameters", "a constant table", "a new array"


class Array(NamedTuple):
    """One array: where it comes from, which one of these, and whether it holds whole numbers."""

    origin: str
    key: Any
    whole: bool = False
    rank: int = 0
    """Its dimensions, 0 where they are not known."""


class Record(NamedTuple):
    """A NamedTuple."""

    cls: Any
    parts: tuple[Any, ...]

    def part(self, field: str) -> Any:
        """One field."""
        return self.parts[self.cls._fields.index(field)]


class Several(NamedTuple):
    """A plain tuple."""

    items: tuple[Any, ...]


class Clash(NamedTuple):
    """What paths disagree on."""

    what: str


Value = Any
"""A kind of number, or one of the classes above."""
ARRAYS = Clash("is one array on one path and another on another; use each under an 'if' of its own")
SHAPES = Clash("is a number, an array or a NamedTuple by path; give each a name of its own")


def number_of(value: Value) -> Value:
    """The kind of a value where it is used as a number."""
    return FLOAT if value == SIGNAL else value


def met(a: Value, b: Value) -> Value:
    """The kind of what two numbers give in arithmetic."""
    kinds = {number_of(a), number_of(b)}
    return next(k for k in (FLOAT, ANY, MIXED, WHOLE) if k in kinds)


def joined(a: Value, b: Value) -> Value:
    """What is known of a value that is either of two."""
    if a == b:
        return a
    if ANY in (a, b):
        return ANY
    if isinstance(a, Record) and isinstance(b, Record) and a.cls is b.cls:
        return Record(a.cls, tuple(joined(x, y) for x, y in zip(a.parts, b.parts, strict=True)))
    if isinstance(a, Several) and isinstance(b, Several) and len(a.items) == len(b.items):
        return Several(tuple(joined(x, y) for x, y in zip(a.items, b.items, strict=True)))
    if isinstance(a, str) and isinstance(b, str):
        kinds = {number_of(a), number_of(b)}
        return kinds.pop() if len(kinds) == 1 else MIXED
    if isinstance(a, Clash) or isinstance(b, Clash):
        return a if isinstance(a, Clash) else b
    return ARRAYS if isinstance(a, Array) and isinstance(b, Array) else SHAPES


def inside(value: Value, kind: type) -> Any:
    """The first part of a value that is of a class, or ``None``."""
    if isinstance(value, kind):
        return value
    parts = value.parts if isinstance(value, Record) else value.items if isinstance(value, Several) else ()
    return next((found for p in parts if (found := inside(p, kind)) is not None), None)


def renewed(value: Value, call: int) -> Value:
    """What a function returned, its new arrays told apart from those of other calls."""
    if isinstance(value, Array) and value.origin == FRESH:
        return value._replace(key=(call, value.key))
    if isinstance(value, Record):
        return Record(value.cls, tuple(renewed(p, call) for p in value.parts))
    return Several(tuple(renewed(p, call) for p in value.items)) if isinstance(value, Several) else value


def of_class(cls: Any, origin: str, key: str = "") -> Record:
    """What is known of a NamedTuple by its annotations; its arrays are named by their dotted keys."""
    sheet = notes(cls)
    parts: list[Value] = []
    for field in cls._fields:
        note, name = sheet.get(field, SILENT), f"{key}.{field}" if key else field
        if is_named_tuple_type(note.base):
            parts.append(of_class(note.base, origin, name))
            continue
        kind = leaf_type(note, cls._field_defaults.get(field))
        parts.append(Array(origin, name) if kind == "array" else FLOAT if kind == "float" else WHOLE)
    return Record(cls, tuple(parts))


def table(name: str, value: np.ndarray) -> Array:
    """A constant array of the module."""
    return Array(TABLE, name, value.dtype.kind == "i", value.ndim)


def other_array(old: Value, new: Value, key: str = "") -> str | None:
    """The dotted key of the first array of a state that is another one in the next."""
    if isinstance(old, Array):
        return key if new not in (old, ANY) else None
    if isinstance(old, Record) and isinstance(new, Record) and old.cls is new.cls:
        for field, a, b in zip(old.cls._fields, old.parts, new.parts, strict=True):
            found = other_array(a, b, f"{key}.{field}" if key else field)
            if found is not None:
                return found
    return None


SIGNALS = frozenset(
    ["command", "feedback", "output", "applied", "actual", "measured", "u", "load", "t", "dt", "error", "offset"]
)
"""What a loop hands to steps as floats."""
WHOLE_CALLS = frozenset(["len", "int", "bool", "to_int", "is_nan", "is_finite", "is_infinite", "float_to_bits"])
ROOMS = frozenset(["np.zeros", "np.empty", "stack_array2"])
Env = dict[str, Value]


class Flow:
    """Follows the functions of one module; what a function gives for given arguments is found once."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self.known: dict[tuple[str, tuple[Value, ...]], Value] = {}

    def root(self, name: str) -> None:
        """Follows a step from what the loop hands to it."""
        item = self.module.items[name]
        function: Any = item.value
        given = function.__code__.co_varnames[: function.__code__.co_argcount]
        values: list[Value] = []
        for arg in given:
            cls = self.module.arguments.get((id(function), arg))
            plain = SIGNAL if arg in SIGNALS else ANY
            values.append(of_class(cls, STATE if arg == "s" else PARAMETERS) if cls is not None else plain)
        Path(self, item).run(values, dict(zip(given, values, strict=True)).get("s"))

    def result(self, name: str, given: tuple[Value, ...]) -> Value:
        """What a function of the module gives for arguments of which this is known."""
        if (name, given) not in self.known:
            self.known[name, given] = Path(self, self.module.items[name]).run(list(given))
        return self.known[name, given]


class Path:
    """Follows one function."""

    def __init__(self, flow: Flow, item: Item) -> None:
        self.flow, self.item, self.items = flow, item, flow.module.items
        self.given: Value = None
        self.start: Value = None
        self.logs: list[Env] = []

    def run(self, values: list[Value], start: Value = None) -> Value:
        """What the function returns; ``start`` is the state whose arrays the next state must have."""
        node = self.item.node
        assert isinstance(node, ast.FunctionDef)
        self.start = start
        self.block(node.body, dict(zip((a.arg for a in node.args.args), values, strict=True)))
        return ANY if self.given is None else self.given

    def refuse(self, node: ast.AST, what: str) -> NoReturn:
        """Refuses by file and line."""
        line = getattr(node, "lineno", getattr(self.item.node, "lineno", 1))
        name = getattr(self.item.value, "__name__", self.item.name)
        raise SubsetError(f"{place(self.item.filename, line)}: in {name!r}: {what}")

    # ---- statements
    def block(self, body: list[ast.stmt], env: Env) -> Env | None:
        """What is known after statements; ``None`` where no path comes to their end."""
        now: Env | None = env
        for node in body:
            if now is None:
                return None
            now = self.statement(node, now)
        return now

    def statement(self, node: ast.stmt, env: Env) -> Env | None:
        """What is known after one statement."""
        if isinstance(node, ast.Assign):
            self.assign(node, env)
        elif isinstance(node, ast.Expr):
            self.value(node.value, env)
        elif isinstance(node, ast.Return) and node.value is not None:
            self.give(node, self.value(node.value, env))
            return None
        elif isinstance(node, ast.If):
            self.number(node.test, env)
            ends = [e for e in (self.block(node.body, dict(env)), self.block(node.orelse, dict(env))) if e is not None]
            if len(ends) < 2:
                return ends[0] if ends else None
            return {k: joined(v, ends[1][k]) for k, v in ends[0].items() if k in ends[1]}
        elif isinstance(node, ast.For | ast.While):
            self.loop(node, env)
        elif isinstance(node, ast.Break | ast.Continue):
            return None
        return env

    def give(self, node: ast.Return, value: Value) -> None:
        """Takes note of what is returned."""
        first = value.items[0] if isinstance(value, Several) else value
        changed = other_array(self.start, first) if self.start is not None else None
        if changed is not None:
            self.refuse(node, f"the next state has another array as {changed!r}; write into the array of the state, "
                              "element by element, and return that one")  # fmt: skip
        self.given = value if self.given is None else joined(self.given, value)
        clash = inside(self.given, Clash)
        if clash is not None:
            self.refuse(node, "what is returned is of another kind, or holds another array, than on another path; "
                              "return the same from all")  # fmt: skip

    def store(self, name: str, value: Value, env: Env) -> None:
        """Sets a local, noted for the loops around."""
        env[name] = value
        for log in self.logs:
            log[name] = joined(log[name], value) if name in log else value

    def assign(self, node: ast.Assign, env: Env) -> None:
        """An assignment to a name, to names, or to an element."""
        target, value = node.targets[0], self.value(node.value, env)
        if isinstance(target, ast.Name):
            if isinstance(value, Several):
                self.refuse(node, f"a tuple in the local {target.id!r}; give each of its values a name: a, b = ...")
            self.store(target.id, value, env)
        elif isinstance(target, ast.Tuple):
            count = len(target.elts)
            parts = value.items if isinstance(value, Several) else (value,) * count
            if len(parts) != count or not (isinstance(value, Several) or value in (ANY, SIGNAL)):
                self.refuse(node, "an assignment to other than as many names as values; read fields by their names")
            for t, v in zip(target.elts, parts, strict=True):
                self.store(getattr(t, "id", ""), v, env)
        elif isinstance(target, ast.Subscript):
            self.written(target, self.value(target.value, env))

    def loop(self, node: ast.For | ast.While, env: Env) -> None:
        """A loop: what is known at its head is what holds before it and after every assignment in it."""
        if isinstance(node, ast.For):
            assert isinstance(node.iter, ast.Call) and isinstance(node.target, ast.Name)
            for bound in node.iter.args:
                self.whole(bound, env, "range() of")
        for _ in range(6):
            log: Env = {}
            self.logs.append(log)
            if isinstance(node, ast.For):
                self.store(node.target.id, WHOLE, env)  # type: ignore[attr-defined]
            else:
                self.number(node.test, env)
            self.block(node.body, dict(env))
            self.logs.pop()
            after = {k: joined(v, log[k]) if k in log else v for k, v in env.items()}
            if after == env:
                return
            env.update(after)

    # ---- expressions
    def value(self, node: ast.expr, env: Env) -> Value:
        """What is known of an expression."""
        found = getattr(self, f"on_{type(node).__name__.lower()}")(node, env)
        if isinstance(found, Clash):
            self.refuse(node, f"{ast.unparse(node)!r} {found.what}")
        return found

    def number(self, node: ast.expr, env: Env) -> Value:
        """The kind of a number."""
        found = self.value(node, env)
        if not isinstance(found, str):
            self.refuse(node, f"{ast.unparse(node)!r} is no number here; arrays and NamedTuples are read, compared and "
                              "counted with element by element")  # fmt: skip
        return number_of(found)

    def whole(self, node: ast.expr, env: Env, what: str) -> None:
        """Refuses a number that may be a float where a whole one is needed."""
        if self.number(node, env) in (FLOAT, MIXED):
            self.refuse(node, f"{what} the float {ast.unparse(node)!r}; write int(...) around it")

    def on_constant(self, node: ast.Constant, env: Env) -> Value:
        return FLOAT if isinstance(node.value, float) else WHOLE

    def on_joinedstr(self, node: ast.JoinedStr, env: Env) -> Value:
        for part in node.values:
            self.value(part, env)
        return ANY

    def on_formattedvalue(self, node: ast.FormattedValue, env: Env) -> Value:
        return self.value(node.value, env)

    def on_name(self, node: ast.Name, env: Env) -> Value:
        if node.id in env:
            return env[node.id]
        item = self.items.get(node.id)
        return table(item.name, item.value) if item is not None and item.kind == "array" else ANY

    def on_attribute(self, node: ast.Attribute, env: Env) -> Value:
        if node.attr in ("nan", "inf") and isinstance(node.value, ast.Name) and node.value.id == "np":
            return FLOAT
        base = self.value(node.value, env)
        if isinstance(base, Record) and node.attr in base.cls._fields:
            return base.part(node.attr)
        if base not in (SIGNAL, ANY):
            fields = list(base.cls._fields) if isinstance(base, Record) else []
            self.refuse(node, f"{ast.unparse(node.value)!r} has no field {node.attr!r}{nearest(node.attr, fields)}")
        return SIGNAL if base == SIGNAL else ANY

    def on_subscript(self, node: ast.Subscript, env: Env) -> Value:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            self.value(node.value.value, env)
            if not ast.unparse(node.slice).lstrip("-").isdigit():
                self.refuse(node, "a size by an index that is no number; write .shape[0] or .shape[1]")
            return WHOLE
        array = self.value(node.value, env)
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return WHOLE if self.read(node, array, indices, env) else FLOAT

    def read(self, node: ast.expr, array: Value, indices: list[ast.expr], env: Env) -> bool:
        """Checks an access to an array; gives whether it holds whole numbers."""
        for index in indices:
            self.whole(index, env, "an index by")
        if not isinstance(array, Array) and array != ANY:
            self.refuse(node, "an index into what is no array; rows of an array cannot be taken on their own, and the "
                              "fields of a NamedTuple have names")  # fmt: skip
        if isinstance(array, Array) and array.rank not in (0, len(indices)):
            self.refuse(node, f"{len(indices)} index(es) into an array of {array.rank} dimension(s)")
        return isinstance(array, Array) and array.whole

    def written(self, node: ast.expr, array: Value) -> None:
        """Refuses a write into what others read as constant."""
        if isinstance(array, Array) and array.origin not in (STATE, FRESH):
            self.refuse(node, f"a write into {array.origin} ({array.key}); only arrays of the state and new ones "
                              "(np.zeros) can be written")  # fmt: skip

    def on_tuple(self, node: ast.Tuple, env: Env) -> Value:
        return Several(tuple(self.value(e, env) for e in node.elts))

    def on_compare(self, node: ast.Compare, env: Env) -> Value:
        ends = [node.left, *node.comparators]
        kinds = [self.number(x, env) for x in ends]
        for i in range(len(node.ops)):
            for x, mine, other in ((ends[i], kinds[i], kinds[i + 1]), (ends[i + 1], kinds[i + 1], kinds[i])):
                if mine == WHOLE and other == FLOAT and not isinstance(x, ast.Constant):
                    x.meets_float = self.item.marked = True  # type: ignore[attr-defined]
        return WHOLE

    def on_boolop(self, node: ast.BoolOp, env: Env) -> Value:
        for x in node.values:
            self.number(x, env)
        return WHOLE

    def on_ifexp(self, node: ast.IfExp, env: Env) -> Value:
        self.number(node.test, env)
        made = joined(self.value(node.body, env), self.value(node.orelse, env))
        if inside(made, Array) is not None or inside(made, Clash) is not None:
            self.refuse(node, "a choice between arrays, or between things of different kinds; choose numbers, or use "
                              "an 'if' statement")  # fmt: skip
        return made

    def on_unaryop(self, node: ast.UnaryOp, env: Env) -> Value:
        kind = self.number(node.operand, env)
        if isinstance(node.op, ast.Not):
            return WHOLE
        if isinstance(node.op, ast.Invert):
            self.whole(node.operand, env, "'~' of")
        if isinstance(node.op, ast.USub):
            if kind == MIXED:
                self.ambiguous(node, "'-'")
            self.wraps(node, kind)
        return kind

    def ambiguous(self, node: ast.AST, what: str) -> NoReturn:
        """Refuses what depends on whether a number is whole."""
        self.refuse(node, f"{what} of what is a whole number on one path and a float on another; write 0.0 for 0, or "
                          "float() around it")  # fmt: skip

    def wraps(self, node: ast.expr, kind: Value) -> None:
        """Marks an operation of whole numbers that may leave 64 bits."""
        if kind in (WHOLE, ANY):
            node.wraps = self.item.marked = True  # type: ignore[attr-defined]

    def on_binop(self, node: ast.BinOp, env: Env) -> Value:
        kinds = (self.number(node.left, env), self.number(node.right, env))
        op, kind = node.op, met(*kinds)
        if isinstance(op, ast.BitAnd | ast.BitOr | ast.BitXor | ast.LShift | ast.RShift):
            for side in (node.left, node.right):
                self.whole(side, env, "bits of")
            kind = WHOLE
        if kind == MIXED and isinstance(op, ast.Mult | ast.FloorDiv | ast.Mod) and not self.positive(node):
            self.ambiguous(node, "a product, remainder or floor division")
        if isinstance(op, ast.Add | ast.Sub | ast.Mult | ast.LShift):
            self.wraps(node, kind)
        return FLOAT if isinstance(op, ast.Div) else kind

    @staticmethod
    def positive(node: ast.BinOp) -> bool:
        """Whether the other operand is a number above zero."""
        sides = [node.left, node.right] if isinstance(node.op, ast.Mult) else [node.right]
        return any(isinstance(x, ast.Constant) and x.value > 0 for x in sides)  # type: ignore[operator]

    # ---- calls
    def on_call(self, node: ast.Call, env: Env) -> Value:
        name = node.func.id if isinstance(node.func, ast.Name) else ast.unparse(node.func)
        if name in ROOMS:
            sizes = node.args[0].elts if isinstance(node.args[0], ast.Tuple) else node.args
            return Array(FRESH, id(node), False, len(sizes))
        item = self.items.get(name)
        given = [self.value(a, env) for a in node.args]
        if item is None:
            return self.builtin(node, name, given, env)
        if item.kind == "class":
            return Record(item.value, tuple(given))
        home = getattr(item.value, "__module__", "")
        if home == "leadscrew.kernel.guards":
            return self.guarded(node, given, env)
        if not item.trusted:
            if hasattr(item.value, "unguarded"):
                return ANY
            return renewed(self.flow.result(name, tuple(given)), id(node))
        if home == "leadscrew.kernel.noise":
            return FLOAT if name in ("normal", "uniform") else ANY
        return self.portable(node, item, name, env)

    def builtin(self, node: ast.Call, name: str, given: list[Value], env: Env) -> Value:
        """What Python itself supplies, and the intrinsics."""
        if name == "len":
            return WHOLE
        if name == PRINT:
            return ANY
        for a in node.args:
            self.number(a, env)
        if name == "abs":
            self.wraps(node, number_of(given[0]))
            return number_of(given[0])
        return WHOLE if name in WHOLE_CALLS else FLOAT

    def portable(self, node: ast.Call, item: Item, name: str, env: Env) -> Value:
        """A portable function or power: numbers to a number."""
        kinds = [self.number(a, env) for a in node.args]
        title = getattr(item.value, "__name__", name)
        if title in ("maximum", "minimum"):
            return joined(*kinds)
        if item.value is None:
            self.wraps(node, kinds[0])
            return FLOAT if name == "power_0" else kinds[0]
        return WHOLE if title in WHOLE_CALLS else FLOAT

    def guarded(self, node: ast.Call, given: list[Value], env: Env) -> Value:
        """A guarded read, which gives a float, or write."""
        writes = getattr(node.func, "id", "").startswith("put")
        if writes:
            self.written(node, given[0])
            self.number(node.args[-1], env)
        self.read(node, given[0], node.args[1:-1] if writes else node.args[1:], env)
        return FLOAT
