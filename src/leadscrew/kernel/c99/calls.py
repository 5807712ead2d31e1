"""Calls in C: of other functions of the module, of NamedTuple classes, and of the few functions that C supplies."""

from __future__ import annotations

import ast
from dataclasses import replace

from leadscrew.kernel.c99.expressions import PRIMARY, UNARY, Expressions, Value, WritesConstant
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
    sizes_of,
)  # fmt: skip
from leadscrew.kernel.portable.basic import LARGEST_INT, to_int


class Calls(Expressions):
    """Prints calls, and converts what they take and give."""

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
