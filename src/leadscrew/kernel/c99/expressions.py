"""Expressions of the step subset as C, each with its type: calls, and the arithmetic of IEEE-754 and of Python.

Nothing is fused. Calls are of other functions of the module, of NamedTuple classes, and of the few functions that C
supplies.
"""

from __future__ import annotations

import ast
import math
import operator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import numpy as np

from leadscrew.kernel.c99.types import (
    BOOL,
    DOUBLE,
    FLOAT,
    INT,
    Array,
    Number,
    Pair,
    Struct,
    Type,
    arrays_of,
    as_local,
    joined,
    sizes_of,
)
from leadscrew.kernel.portable.basic import LARGEST_INT, to_int
from leadscrew.util.errors import SubsetError

if TYPE_CHECKING:
    from leadscrew.kernel.c99.translation import Translation

PRIMARY, UNARY, PRODUCT, SUM, RELATION, EQUALITY, BITS, AND, OR, CHOICE = 10, 9, 8, 7, 6, 5, 4, 3, 2, 1


LITERALLY: dict[type, Any] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_, ast.BitXor: operator.xor, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge, ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip
"""What operators give of two literals."""
WRAPPING: dict[type, str] = {ast.Add: "int_add", ast.Sub: "int_sub", ast.Mult: "int_mul"}


class Value(NamedTuple):
    """An expression in C: its text, its type, how tightly it binds, and its number where it is one."""

    text: str
    type: Type
    level: int = PRIMARY
    literal: float | int | None = None
    narrow: bool = False
    """Whether C computes this integer with fewer than 64 bits."""
    size: int = 2**63
    """What an integer does not exceed in magnitude."""

    @property
    def reach(self) -> int:
        """``size``, known of literals and truth values too."""
        return 1 if self.type is BOOL else self.size if self.literal is None else abs(int(self.literal))


class Unknown(Exception):
    """The type of a local that is not known yet."""


class WritesConstant(SubsetError):
    """A write into an array that cannot be written, in a function of our own."""


class Expressions:
    """Prints expressions of one function; ``types`` are those of its locals, ``real`` is what a float is here."""

    unit: Translation
    node: ast.FunctionDef
    real: Number
    types: dict[str, Type]
    names: dict[str, str]
    place: str
    top: ast.expr | None = None
    """The expression of which nobody wants the value."""
    sizes: dict[str, int]
    """Magnitudes that whole locals do not exceed, of those that are set once."""
    uses: set[str]
    """The functions and tables of the file that are used."""

    def refuse(self, node: ast.AST, what: str) -> NoReturn:
        """Says what cannot be printed, and where it was written."""
        file, _, first = self.place.rpartition(":")
        at = f"{file}:{getattr(node, 'lineno', first)}: " if file else ""
        text = " ".join(ast.unparse(node)[:100].split())
        raise SubsetError(f"{at}in {self.node.name!r}: {what} cannot be translated to C: {text}")

    def hoisted(self, value: Value) -> Value:
        """A call's value; kept in a local where the order of effects matters."""
        return value

    def held(self, value: Value) -> Value:
        """A value kept in a local."""
        return value

    # ---- printing
    @staticmethod
    def inside(value: Value, level: int) -> str:
        """The text of an operand, in brackets where it binds less tightly than ``level``."""
        return value.text if value.level >= level else f"({value.text})"

    def number(self, value: float | int | bool, kind: Number) -> Value:
        """A literal."""
        if kind is BOOL:
            self.unit.include("stdbool.h")
            return Value("true" if value else "false", BOOL, PRIMARY, int(value))
        if kind is INT:
            return self.whole(int(value))
        with np.errstate(over="ignore"):
            value = float(np.float32(value)) if kind is FLOAT else float(value)
        if not math.isfinite(value):
            self.unit.include("math.h")
            sign = "-" if value < 0 else ""
            return Value(f"{sign}{'NAN' if math.isnan(value) else 'INFINITY'}", kind, UNARY if sign else PRIMARY)
        text = f"{np.float32(value)!s}f" if kind is FLOAT else repr(value)
        return Value(text, kind, PRIMARY if text[0] != "-" else UNARY, value)

    @staticmethod
    def whole(value: int) -> Value:
        """An integer literal, of 64 bits at most."""
        value = (value + 2**63) % 2**64 - 2**63
        if value == -(2**63):
            return Value("INT64_MIN", INT, PRIMARY, value)
        narrow = abs(value) < 2**31
        text = str(value) if narrow else f"INT64_C({value})"
        return Value(text, INT, PRIMARY if value >= 0 else UNARY, value, narrow)

    def wide(self, value: Value) -> Value:
        """An integer with all its 64 bits, where C would compute with fewer."""
        if value.type is not BOOL and not value.narrow:
            return value
        return Value(f"(int64_t){self.inside(value, UNARY)}", INT, UNARY, value.literal, size=value.size)

    def cast(self, value: Value, kind: Type) -> Value:
        """A number as another type, where C would not do it by itself; a literal is written anew."""
        if value.type == kind or not isinstance(kind, Number) or not isinstance(value.type, Number):
            return value
        if kind is BOOL:
            return self.truth(value)
        if value.literal is not None and kind.rank > INT.rank:
            return self.number(value.literal, kind)
        return Value(f"({kind.c}){self.inside(value, UNARY)}", kind, UNARY)

    def truth(self, value: Value) -> Value:
        """Whether a number is not zero; NaN is true, as in Python."""
        if value.type is BOOL:
            return value
        return Value(f"{self.inside(value, RELATION)} != 0", BOOL, EQUALITY)

    def met(self, a: Value, b: Value, least: Number = INT) -> tuple[Value, Value, Number]:
        """Two numbers and the type in which they meet; a literal is written in it."""
        kind = joined(a.type, b.type)
        if not isinstance(kind, Number):
            raise Unknown
        kind = kind if kind.rank >= least.rank else least
        a, b = (self.number(v.literal, kind) if v.literal is not None and v.type is not BOOL else v for v in (a, b))
        return a, b, kind

    # ---- dispatch
    def value(self, node: ast.expr) -> Value:
        """An expression."""
        method = getattr(self, f"on_{type(node).__name__.lower()}", None)
        if method is None:
            self.refuse(node, "this expression")
        found: Value = method(node)
        return found

    def on_constant(self, node: ast.Constant) -> Value:
        v = node.value
        if isinstance(v, bool):
            return self.number(v, BOOL)
        if isinstance(v, int):
            return self.number(v, INT)
        return self.number(float(v), self.real)  # type: ignore[arg-type]

    def on_name(self, node: ast.Name) -> Value:
        if node.id in self.names:
            if node.id not in self.types:
                raise Unknown
            return Value(self.names[node.id], self.types[node.id], size=self.sizes.get(node.id, 2**63))
        found = self.unit.table(node.id)
        if found is None:
            self.refuse(node, f"the value {node.id!r}")
        self.uses.add(found.text)
        return found

    def on_attribute(self, node: ast.Attribute) -> Value:
        text = ast.unparse(node)
        if text in ("np.nan", "np.inf"):
            return self.number(math.nan if text == "np.nan" else math.inf, self.real)
        base = self.value(node.value)
        if not isinstance(base.type, Struct):
            self.refuse(node, "a field of what is not a NamedTuple")
        field = self.unit.field(base.type, node.attr)
        return Value(f"{self.inside(base, PRIMARY)}.{field}", base.type.field(node.attr), size=LARGEST_INT)

    # ---- arrays
    def on_subscript(self, node: ast.Subscript) -> Value:
        inner = node.value
        if isinstance(inner, ast.Attribute) and inner.attr == "shape":
            shape, at = self.shape(inner.value), self.value(node.slice).literal
            if at is None or not -len(shape) <= at < len(shape):
                self.refuse(node, "this size")
            size = shape[int(at)]
            return self.number(size, INT) if isinstance(size, int) else Value(size, INT)
        array = self.value(inner)
        if not isinstance(array.type, Array):
            self.refuse(node, "an element of what is not an array")
        base = self.inside(array, PRIMARY)
        if isinstance(node.slice, ast.Slice):
            assert node.slice.lower is not None and node.slice.upper is not None
            low, high = (self.value(x).literal for x in (node.slice.lower, node.slice.upper))
            assert low is not None and high is not None
            text = base if low == 0 else f"{base} + {low}"
            return Value(text, replace(array.type, shape=(int(high - low),)), SUM)
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        shape = array.type.shape
        offset = self.index(node, indices[0], shape[0])
        for size, index in zip(shape[1:], indices[1:], strict=False):
            scaled = self.by(offset, size)
            more = self.index(node, index, size)
            offset = Value(f"{scaled.text} + {self.inside(more, PRODUCT)}", INT, SUM)
        rest = shape[len(indices) :]
        if rest:
            for size in rest:
                offset = self.by(offset, size)
            return Value(f"{base} + {offset.text}", replace(array.type, shape=rest), SUM)
        return self.hoisted(Value(f"{base}[{offset.text}]", array.type.element))

    def shape(self, node: ast.expr) -> tuple[int | str, ...]:
        """The sizes of an array."""
        uses = set(self.uses)
        array = self.value(node)
        self.uses = uses
        if not isinstance(array.type, Array):
            self.refuse(node, "the size of what is not an array")
        return array.type.shape

    def index(self, node: ast.expr, index: ast.expr, size: int | str) -> Value:
        """One index; a literal one below zero is counted from the end."""
        found = self.value(index)
        if found.literal is None or not isinstance(size, int):
            return found
        place = int(found.literal) + (size if found.literal < 0 else 0)
        if not 0 <= place < size:
            self.refuse(node, f"the index {found.literal} into an array of {size}")
        return self.whole(place)

    def by(self, offset: Value, size: int | str) -> Value:
        """An offset times a size."""
        if offset.literal is not None and isinstance(size, int):
            return self.number(int(offset.literal) * size, INT)
        return Value(f"{self.inside(offset, PRODUCT)} * {size}", INT, PRODUCT)

    # ---- operators
    def on_unaryop(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not) and value.literal is not None:
            return self.number(not value.literal, BOOL)
        if isinstance(node.op, ast.Not):
            return Value(f"!{self.inside(self.truth(value), UNARY)}", BOOL, UNARY)
        if not isinstance(value.type, Number):
            self.refuse(node, "this operator")
        kind = value.type if value.type.rank >= INT.rank else INT
        if isinstance(node.op, ast.UAdd):
            return self.wide(value) if value.type is BOOL else value
        if isinstance(node.op, ast.USub) and value.literal is not None:
            signed_zero = value.literal == 0 and kind is not INT
            return Value(f"-{value.text}", kind, UNARY) if signed_zero else self.number(-value.literal, kind)
        if isinstance(node.op, ast.Invert) and value.literal is not None:
            return self.whole(~int(value.literal))
        if isinstance(node.op, ast.USub) and kind is INT and self.wraps(node, value.reach):
            self.unit.help("int_sub")
            return Value(f"int_sub(0, {value.text})", INT)
        sign = "~" if isinstance(node.op, ast.Invert) else "-"
        return Value(f"{sign}{self.inside(self.wide(value), PRIMARY)}", kind, UNARY)

    def on_boolop(self, node: ast.BoolOp) -> Value:
        sign, level = ("&&", AND) if isinstance(node.op, ast.And) else ("||", OR)
        parts = [self.inside(self.truth(self.value(v)), EQUALITY) for v in node.values]
        return Value(f" {sign} ".join(parts), BOOL, level)

    def on_compare(self, node: ast.Compare) -> Value:
        signs = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
        ends = [self.value(x) for x in (node.left, *node.comparators)]
        parts = []
        for i, op in enumerate(node.ops):
            a, b, kind = self.met(*self.beside(ends[i], ends[i + 1]))
            if a.text == b.text:
                parts.append(self.with_itself(a, op, kind))
                continue
            if a.literal is not None and b.literal is not None:
                parts.append(self.number(LITERALLY[type(op)](a.literal, b.literal), BOOL))
                continue
            level = RELATION if isinstance(op, ast.Lt | ast.LtE | ast.Gt | ast.GtE) else EQUALITY
            texts = (f"({v.text})" if v.text[0] == "!" else self.inside(v, SUM) for v in (a, b))
            parts.append(Value(f" {signs[type(op)]} ".join(texts), BOOL, level))
        return parts[0] if len(parts) == 1 else Value(" && ".join(self.inside(x, EQUALITY) for x in parts), BOOL, AND)

    def beside(self, a: Value, b: Value) -> tuple[Value, Value]:
        """Two values that are compared; truth values as integers, unless neither is a literal."""
        if a.type is BOOL and b.type is BOOL and a.literal is None and b.literal is None:
            return a, b
        return self.counted(a, b), self.counted(b, a)

    def counted(self, value: Value, other: Value) -> Value:
        """A truth value or masked integer as one of which C compilers do not know that it has few values."""
        if value.literal is not None or not (value.type is BOOL or (value.level == BITS and other.literal is not None)):
            return self.wide(value) if value.type is BOOL else value
        self.unit.help("whole")
        return Value(f"whole({value.text})", INT)

    def with_itself(self, value: Value, op: ast.cmpop, kind: Number) -> Value:
        """A number compared with itself: what Python code asks NaN by, and C compilers warn of."""
        equal = isinstance(op, ast.Eq | ast.LtE | ast.GtE)
        if kind is INT or isinstance(op, ast.Lt | ast.Gt):
            return self.number(equal and kind is INT, BOOL)
        self.unit.include("math.h")
        return Value(f"{'!' if equal else ''}isnan({value.text})", BOOL, UNARY if equal else PRIMARY)

    def on_ifexp(self, node: ast.IfExp) -> Value:
        return self.choice(self.truth(self.value(node.test)), self.value(node.body), self.value(node.orelse), node)

    def choice(self, test: Value, a: Value, b: Value, node: ast.expr) -> Value:
        """``test ? a : b``."""
        kind = joined(a.type, b.type)
        if kind is None:
            self.refuse(node, "a choice between values of two types")
        if isinstance(kind, Number) and kind is not BOOL:
            a, b, _ = self.met(a, b, kind)
        elif not isinstance(kind, Number):
            a, b = self.converted(a, kind), self.converted(b, kind)
        text = f"{self.inside(test, AND)} ? {self.inside(a, OR)} : {self.inside(b, CHOICE)}"
        return Value(text, kind, CHOICE, narrow=all(v.narrow or v.type is BOOL for v in (a, b)))

    def on_binop(self, node: ast.BinOp) -> Value:
        left, right = self.value(node.left), self.value(node.right)
        op = type(node.op)
        if not (isinstance(left.type, Number) and isinstance(right.type, Number)):
            self.refuse(node, "arithmetic of whole arrays or NamedTuples")
        if op in (ast.BitAnd, ast.BitOr, ast.BitXor):
            kind = BOOL if left.type is BOOL and right.type is BOOL else INT
            sign = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"}[op]
            if kind is INT and left.literal is not None and right.literal is not None:
                return self.whole(LITERALLY[op](int(left.literal), int(right.literal)))
            left, right = (Value(f"(int64_t){self.inside(v, UNARY)}", INT, UNARY) if v.type in (FLOAT, DOUBLE) else v
                           for v in (left, right))  # fmt: skip
            narrow = all(v.narrow or v.type is BOOL for v in (left, right))
            texts = (f"({v.text})" if v.text[0] == "!" else self.inside(v, UNARY) for v in (left, right))
            return Value(f" {sign} ".join(texts), kind, BITS, narrow=narrow)
        if op is ast.LShift:
            self.unit.help("shift_left")
            return Value(f"shift_left({left.text}, {right.text})", INT)
        if op is ast.RShift:
            if left.literal is not None and right.literal is not None:
                return self.whole(int(left.literal) >> int(right.literal))
            return Value(f"{self.inside(self.wide(left), UNARY)} >> {self.inside(right, UNARY)}", INT, BITS)
        if op is ast.Div:
            a, b, kind = self.met(left, right, self.real)
            if a.type.rank < self.real.rank and b.type.rank < self.real.rank:  # type: ignore[union-attr]
                a = self.cast(a, self.real)
            return Value(f"{self.inside(a, PRODUCT)} / {self.inside(b, UNARY)}", kind, PRODUCT)
        a, b, kind = self.met(left, right)
        if kind is INT and a.literal is not None and b.literal is not None and op in (ast.Add, ast.Sub, ast.Mult):
            return self.whole(LITERALLY[op](int(a.literal), int(b.literal)))
        size = 2**63
        if kind is INT and op in WRAPPING:
            size = a.reach * b.reach if op is ast.Mult else a.reach + b.reach
            if self.wraps(node, size):
                self.unit.help(WRAPPING[op])
                return Value(f"{WRAPPING[op]}({a.text}, {b.text})", INT)
        if kind is INT and all(v.narrow or v.type is BOOL for v in (a, b)):
            a = self.wide(a)
        if op in (ast.Mod, ast.FloorDiv):
            name = f"{'int' if kind is INT else 'float'}_{'mod' if op is ast.Mod else 'floordiv'}"
            self.unit.help(name)
            size = 2**63 if kind is not INT else b.reach if op is ast.Mod else a.reach
            return Value(f"{name}({a.text}, {b.text})", kind, size=size)
        if op is ast.Mult:
            return Value(f"{self.inside(a, PRODUCT)} * {self.inside(b, UNARY)}", kind, PRODUCT, size=size)
        if op not in (ast.Add, ast.Sub):
            self.refuse(node, "this operator")
        sign = "+" if op is ast.Add else "-"
        return Value(f"{self.inside(a, SUM)} {sign} {self.inside(b, PRODUCT)}", kind, SUM, size=size)

    @staticmethod
    def wraps(node: ast.expr, size: int) -> bool:
        """Whether whole-number arithmetic of a step may leave 64 bits, where C says nothing of the result."""
        return size >= 2**63 and hasattr(node, "wraps")

    # ---- tuples
    def on_tuple(self, node: ast.Tuple) -> Value:
        parts = [self.value(e) for e in node.elts]
        kind = Pair(tuple(p.type for p in parts))
        return Value(f"({self.unit.name_of(kind)}){{{', '.join(p.text for p in parts)}}}", kind)

    # ---- calls
    def on_call(self, node: ast.Call) -> Value:
        name = ast.unparse(node.func)
        intrinsic = getattr(self, f"call_{name.replace('.', '_')}", None)
        if intrinsic is not None:
            found: Value = intrinsic(node)
            return found
        if name.endswith(".reshape") and isinstance(node.func, ast.Attribute):
            array = self.value(node.func.value)
            assert isinstance(array.type, Array)
            sizes = tuple(self.value(a).literal for a in node.args)
            return array._replace(type=replace(array.type, shape=sizes))  # type: ignore[arg-type]
        if self.unit.is_class(name):
            return self.built(name, [self.value(self.uncast(a)) for a in node.args])
        found = self.called(node, name, [self.value(a) for a in node.args])
        return found if node is self.top else self.hoisted(found)

    @staticmethod
    def uncast(node: ast.expr) -> ast.expr:
        """What a field is set to, without the ``1.0 *`` that makes it a float in Python: in C the field does that."""
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and isinstance(node.left, ast.Constant):
            return node.right if isinstance(node.left.value, float) and node.left.value == 1.0 else node
        return node

    def built(self, name: str, parts: list[Value]) -> Value:
        """A NamedTuple from all its fields."""
        kind = self.unit.struct_of(name, [p.type for p in parts])
        pairs = zip(kind.fields, parts, strict=True)
        inits = [f".{self.unit.field(kind, f)} = {self.assigned(v, t)}" for (f, t), v in pairs]
        return Value(f"({self.unit.name_of(kind)}){{{', '.join(inits) or '0'}}}", kind)

    def assigned(self, value: Value, kind: Type) -> str:
        """The text of a value where a value of a type is wanted."""
        if isinstance(kind, Number) and value.literal is not None and value.type is not BOOL:
            return self.number(value.literal, kind).text if kind is not BOOL else self.truth(value).text
        return self.truth(value).text if kind is BOOL else self.converted(value, kind).text

    def converted(self, value: Value, kind: Type) -> Value:
        """A tuple or NamedTuple as one of another type, item by item."""
        if value.type == kind or not isinstance(kind, Pair | Struct):
            return value
        mine, wanted = self.unit.items(value.type), self.unit.items(kind)
        base = self.held(value)
        parts = [Value(f"{self.inside(base, PRIMARY)}.{field}", k) for field, k in mine]
        texts = (f".{field} = {self.assigned(v, k)}" for v, (field, k) in zip(parts, wanted, strict=True))
        return Value(f"({self.unit.name_of(kind)}){{{', '.join(texts) or '0'}}}", kind)

    def called(self, node: ast.Call, name: str, args: list[Value]) -> Value:
        """A call of another function of the module."""
        try:
            made = self.unit.function(name, [a.type for a in args], self, node)
        except WritesConstant:
            if not self.place:
                raise
            self.refuse(node, "a write into parameters or a constant array")
        self.uses.add(made.name)
        pairs = zip(args, made.arguments, strict=True)
        given = [[self.assigned(a, t), *sizes_of(a.type)] for a, t in pairs]
        result = as_local(made.result) if any(x.local for a in args for x in arrays_of(a.type)) else made.result
        size = LARGEST_INT if self.unit.module.items[name].value is to_int else 2**63
        found = Value(f"{made.name}({', '.join(x for group in given for x in group)})", result, size=size)
        return self.cast(found, self.real) if made.result is DOUBLE else found

    def call_len(self, node: ast.Call) -> Value:
        size = self.shape(node.args[0])[0]
        return self.number(size, INT) if isinstance(size, int) else Value(size, INT)

    def call_ieee_select(self, node: ast.Call) -> Value:
        test, a, b = (self.value(x) for x in node.args)
        return self.choice(self.truth(test), a, b, node)

    def call_abs(self, node: ast.Call) -> Value:
        value = self.value(node.args[0])
        if value.type in (INT, BOOL):
            self.unit.help("int_abs")
            return Value(f"int_abs({value.text})", INT)
        self.unit.include("math.h")
        return Value(f"{'fabsf' if value.type is FLOAT else 'fabs'}({value.text})", value.type)

    def call_float_to_bits(self, node: ast.Call) -> Value:
        self.unit.help("float_to_bits")
        return Value(f"float_to_bits({self.value(node.args[0]).text})", INT)

    def call_bits_to_float(self, node: ast.Call) -> Value:
        self.unit.help("bits_to_float")
        return self.cast(Value(f"bits_to_float({self.value(node.args[0]).text})", DOUBLE), self.real)

    def call_int(self, node: ast.Call) -> Value:
        value = self.value(node.args[0])
        whole = value.type in (INT, BOOL)
        return self.wide(value) if whole else Value(f"(int64_t){self.inside(value, UNARY)}", INT, UNARY)

    def call_bool(self, node: ast.Call) -> Value:
        return self.truth(self.value(node.args[0]))

    def call_float(self, node: ast.Call) -> Value:
        return self.cast(self.value(node.args[0]), self.real)

    def call_math_sqrt(self, node: ast.Call) -> Value:
        self.unit.include("math.h")
        return self.cast(Value(f"sqrt({self.value(node.args[0]).text})", DOUBLE), self.real)
