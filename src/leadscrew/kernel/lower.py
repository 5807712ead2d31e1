"""From a fused entry to LLVM: floats, integers, truth values and arrays, nothing else.

An entry comes here with its calls fused and its NamedTuples taken apart, so that every local is a number or an
array. Numbers live in stack slots that LLVM turns into registers. Floating-point operations carry no fast-math flag:
they are the IEEE operations that the other engines do, in the same order.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from llvmlite import ir

from leadscrew.util.errors import SubsetError

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


class Lowering:
    """Lowers one entry into an LLVM module of its own: the types of its locals, its values, its statements."""

    builder: Any
    entry_builder: Any

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

    # ---- arrays
    def array(self, node: ast.expr) -> Array:
        """An array or a view of one."""
        if isinstance(node, ast.Name):
            if node.id in self.arrays:
                return self.arrays[node.id]
            if node.id in self.constants:
                return self.tables.get(node.id) or self.constant_array(node.id)
        if isinstance(node, ast.Call):
            text = ast.unparse(node.func)
            if text.endswith(".reshape") and isinstance(node.func, ast.Attribute):
                inner = self.array(node.func.value)
                return Array(inner.base, [self.integer(a) for a in node.args], inner.element)
            if text in ("stack_array2", "np.empty", "np.zeros"):
                sizes = node.args[0].elts if isinstance(node.args[0], ast.Tuple) else node.args
                return self.room([self.integer(a) for a in sizes], node, text == "np.zeros")
        if isinstance(node, ast.Subscript):
            outer = self.array(node.value)
            if isinstance(node.slice, ast.Slice):
                assert node.slice.lower is not None and node.slice.upper is not None
                low, high = self.integer(node.slice.lower), self.integer(node.slice.upper)
                return Array(self.builder.gep(outer.base, [self.index(low)]), [high - low], outer.element)
            stride = math.prod(outer.shape[1:])
            offset = self.builder.mul(self.cast(self.value(node.slice), I64), ir.Constant(I64, stride))
            return Array(self.builder.gep(outer.base, [offset]), outer.shape[1:], outer.element)
        self.refuse(node, "an array that cannot be traced")

    def room(self, shape: list[int], node: ast.expr, cleared: bool) -> Array:
        """Stack memory for an array of known size."""
        if not all(isinstance(n, int) for n in shape):
            self.refuse(node, "a local array needs a constant size")
        size = max(1, math.prod(shape))
        memory = self.entry_builder.alloca(ir.ArrayType(F64, size))
        memory.align = 64
        base = self.entry_builder.bitcast(memory, F64.as_pointer())
        if cleared:
            # one instruction: a store for each element would take minutes to optimise where there are thousands
            i8, pointer = ir.IntType(8), ir.IntType(8).as_pointer()
            clear = self.module.declare_intrinsic("llvm.memset", [pointer, I64])
            at = self.builder.bitcast(base, pointer)
            self.builder.call(clear, [at, i8(0), I64(8 * size), ir.IntType(1)(0)])
        return Array(base, list(shape), F64)

    def constant_array(self, name: str) -> Array:
        """A frozen array of the module."""
        value = self.constants[name]
        kind = I64 if value.dtype.kind == "i" else F64
        holder = ir.ArrayType(kind, value.size)
        place = ir.GlobalVariable(self.module, holder, name=name)
        place.global_constant, place.linkage = True, "internal"
        place.initializer = ir.Constant(holder, [x.item() for x in value.ravel()])
        base = place.gep([ir.Constant(ir.IntType(32), 0), ir.Constant(ir.IntType(32), 0)])
        self.tables[name] = Array(base, list(value.shape), kind)
        return self.tables[name]

    def integer(self, node: ast.expr) -> int:
        """A constant integer."""
        if isinstance(node, ast.Constant) and isinstance(node.value, int):
            return node.value
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return -self.integer(node.operand)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
            return self.integer(node.left) * self.integer(node.right)
        self.refuse(node, "a size that is not constant")

    def index(self, n: Any) -> Any:
        return ir.Constant(I64, n) if isinstance(n, int) else n

    def element(self, node: ast.Subscript) -> tuple[Any, Any]:
        """The address of an array's element."""
        array = self.array(node.value)
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(indices) != len(array.shape):
            self.refuse(node, f"{len(indices)} indices into an array of {len(array.shape)} dimensions")
        offset = self.subscript(node, indices[0], array.shape[0])
        for i, extent in zip(indices[1:], array.shape[1:], strict=True):
            offset = self.builder.add(
                self.builder.mul(offset, self.index(extent), flags=("nsw",)),
                self.subscript(node, i, extent),
                flags=("nsw",),
            )
        return self.builder.gep(array.base, [offset], inbounds=True), array.element

    def subscript(self, node: ast.Subscript, index: ast.expr, extent: Any) -> Any:
        """One index; a constant one is checked here, counted from the end where it is negative."""
        sign = -1 if isinstance(index, ast.UnaryOp) and isinstance(index.op, ast.USub) else 1
        number = index.operand if sign < 0 and isinstance(index, ast.UnaryOp) else index
        if isinstance(number, ast.Constant) and isinstance(number.value, int) and isinstance(extent, int):
            place = sign * number.value + (extent if sign < 0 else 0)
            if not 0 <= place < extent:
                self.refuse(node, f"the index {sign * number.value} into an array of {extent}")
            return ir.Constant(I64, place)
        return self.cast(self.value(index), I64)

    # ---- expressions
    def cast(self, value: Any, kind: Any) -> Any:
        """A value as another type."""
        if value.type == kind:
            return value
        if kind == I1:
            return self.truth(value)
        if value.type == I1:
            value = self.builder.zext(value, I64)
            return value if kind == I64 else self.builder.sitofp(value, F64)
        return self.builder.sitofp(value, F64) if kind == F64 else self.builder.fptosi(value, I64)

    def truth(self, value: Any) -> Any:
        """Whether a value is not zero; NaN is true, as in Python."""
        if value.type == I1:
            return value
        if value.type == F64:
            return self.builder.fcmp_unordered("!=", value, ir.Constant(F64, 0.0))
        return self.builder.icmp_signed("!=", value, ir.Constant(I64, 0))

    def joined(self, a: Any, b: Any) -> tuple[Any, Any]:
        """Two values as the wider of their types, at least integers."""
        kind = max((a.type, b.type, I64), key=lambda k: RANK[k])
        return self.cast(a, kind), self.cast(b, kind)

    def value(self, node: ast.expr) -> Any:
        """A number."""
        method = getattr(self, f"on_{type(node).__name__.lower()}", None)
        if method is None:
            self.refuse(node, "an expression outside the subset")
        return method(node)

    def on_constant(self, node: ast.Constant) -> Any:
        v = node.value
        if isinstance(v, bool):
            return ir.Constant(I1, int(v))
        return ir.Constant(I64, v) if isinstance(v, int) else ir.Constant(F64, float(v))  # type: ignore[arg-type]

    def on_name(self, node: ast.Name) -> Any:
        if node.id not in self.slots:
            self.refuse(node, "an array where a number is needed, or a name that is not set")
        return self.builder.load(self.slots[node.id])

    def on_attribute(self, node: ast.Attribute) -> Any:
        known = {"np.nan": math.nan, "np.inf": math.inf}
        text = ast.unparse(node)
        if text not in known:
            self.refuse(node, "a field of something that was not taken apart")
        return ir.Constant(F64, known[text])

    def on_subscript(self, node: ast.Subscript) -> Any:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            return self.index(self.array(node.value.value).shape[self.integer(node.slice)])
        place, _ = self.element(node)
        return self.builder.load(place)

    def on_unaryop(self, node: ast.UnaryOp) -> Any:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return self.builder.not_(self.truth(value))
        if value.type == I1:
            value = self.cast(value, I64)
        if isinstance(node.op, ast.Invert):
            return self.builder.not_(value)
        if isinstance(node.op, ast.UAdd):
            return value
        return self.builder.fneg(value) if value.type == F64 else self.builder.neg(value)

    def on_boolop(self, node: ast.BoolOp) -> Any:
        made = self.truth(self.value(node.values[0]))
        for other in node.values[1:]:
            rest = self.truth(self.value(other))
            made = self.builder.and_(made, rest) if isinstance(node.op, ast.And) else self.builder.or_(made, rest)
        return made

    def on_compare(self, node: ast.Compare) -> Any:
        signs = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
        sign = signs[type(node.ops[0])]
        a, b = self.joined(self.value(node.left), self.value(node.comparators[0]))
        if a.type == I64:
            return self.builder.icmp_signed(sign, a, b)
        return self.builder.fcmp_unordered(sign, a, b) if sign == "!=" else self.builder.fcmp_ordered(sign, a, b)

    def on_binop(self, node: ast.BinOp) -> Any:
        left, right = self.value(node.left), self.value(node.right)
        op = type(node.op)
        if op in (ast.BitAnd, ast.BitOr, ast.BitXor):
            if not (left.type == I1 and right.type == I1):
                left, right = self.cast(left, I64), self.cast(right, I64)
            return {ast.BitAnd: self.builder.and_, ast.BitOr: self.builder.or_, ast.BitXor: self.builder.xor}[op](
                left, right
            )
        if op in (ast.LShift, ast.RShift):
            shift = self.builder.shl if op is ast.LShift else self.builder.ashr
            return shift(self.cast(left, I64), self.cast(right, I64))
        if op is ast.Div:
            return self.builder.fdiv(self.cast(left, F64), self.cast(right, F64))
        a, b = self.joined(left, right)
        floating = a.type == F64
        if op is ast.Add:
            return self.builder.fadd(a, b) if floating else self.builder.add(a, b)
        if op is ast.Sub:
            return self.builder.fsub(a, b) if floating else self.builder.sub(a, b)
        if op is ast.Mult:
            return self.builder.fmul(a, b) if floating else self.builder.mul(a, b)
        if op is ast.Mod:
            return self.float_modulo(a, b) if floating else self.int_divide(a, b)[1]
        if op is ast.FloorDiv:
            return self.float_floor_divide(a, b) if floating else self.int_divide(a, b)[0]
        self.refuse(node, "an operator outside the subset")

    def int_divide(self, a: Any, b: Any) -> tuple[Any, Any]:
        """Quotient and remainder as Python has them; 0 and 0 where ``b`` is 0 or the quotient has more than 64 bits."""
        build, zero, one = self.builder, ir.Constant(I64, 0), ir.Constant(I64, 1)
        beyond = build.and_(
            build.icmp_signed("==", b, ir.Constant(I64, -1)), build.icmp_signed("==", a, ir.Constant(I64, -(2**63)))
        )
        lost = build.or_(build.icmp_signed("==", b, zero), beyond)  # where the processor would trap
        divisor = build.select(lost, one, b)
        rest = build.srem(a, divisor)
        wrong = build.and_(build.icmp_signed("!=", rest, zero), build.icmp_signed("<", build.xor(rest, divisor), zero))
        quotient = build.sub(build.sdiv(a, divisor), build.zext(wrong, I64))
        rest = build.select(wrong, build.add(rest, divisor), rest)
        return build.select(lost, zero, quotient), build.select(lost, zero, rest)

    def float_modulo(self, a: Any, b: Any) -> Any:
        """``a % b`` as CPython computes it for floats; NaN where ``b`` is 0."""
        build, zero = self.builder, ir.Constant(F64, 0.0)
        rest = build.frem(a, b)
        other = build.xor(build.fcmp_ordered("<", rest, zero), build.fcmp_ordered("<", b, zero))
        moved = build.select(other, build.fadd(rest, b), rest)
        return build.select(build.fcmp_ordered("==", rest, zero), self.with_sign(zero, b), moved)

    def float_floor_divide(self, a: Any, b: Any) -> Any:
        """``a // b`` as CPython computes it for floats; the IEEE quotient where ``b`` is 0."""
        build, zero, one = self.builder, ir.Constant(F64, 0.0), ir.Constant(F64, 1.0)
        rest = build.frem(a, b)
        other = build.and_(
            build.fcmp_unordered("!=", rest, zero),
            build.xor(build.fcmp_ordered("<", rest, zero), build.fcmp_ordered("<", b, zero)),
        )
        whole = build.fdiv(build.fsub(a, rest), b)
        whole = build.select(other, build.fsub(whole, one), whole)
        down = build.call(self.intrinsic("llvm.floor"), [whole])
        down = build.select(
            build.fcmp_ordered(">", build.fsub(whole, down), ir.Constant(F64, 0.5)), build.fadd(down, one), down
        )
        plain = build.fdiv(a, b)
        down = build.select(build.fcmp_ordered("==", whole, zero), self.with_sign(zero, plain), down)
        return build.select(build.fcmp_ordered("==", b, zero), plain, down)

    def with_sign(self, size: Any, sign: Any) -> Any:
        return self.builder.call(self.intrinsic("llvm.copysign"), [size, sign])

    def intrinsic(self, name: str) -> Any:
        kinds = [F64, F64] if name == "llvm.copysign" else [F64]
        full = f"{name}.f64"
        return self.module.globals.get(full) or ir.Function(self.module, ir.FunctionType(F64, kinds), name=full)

    def on_call(self, node: ast.Call) -> Any:
        name = ast.unparse(node.func)
        if name == "len":
            return self.index(self.array(node.args[0]).shape[0])
        args = [self.value(a) for a in node.args]
        build = self.builder
        if name == "ieee_select":
            kind = max((args[1].type, args[2].type), key=lambda k: RANK[k])
            return build.select(self.truth(args[0]), self.cast(args[1], kind), self.cast(args[2], kind))
        if name == "abs":
            if args[0].type == F64:
                return build.call(self.intrinsic("llvm.fabs"), args)
            value = self.cast(args[0], I64)
            return build.select(build.icmp_signed("<", value, ir.Constant(I64, 0)), build.neg(value), value)
        if name == "float_to_bits":
            return build.bitcast(self.cast(args[0], F64), I64)
        if name == "bits_to_float":
            return build.bitcast(self.cast(args[0], I64), F64)
        if name in ("int", "bool", "float"):
            return self.cast(args[0], {"int": I64, "bool": I1, "float": F64}[name])
        if name == "math.sqrt":
            return build.call(self.intrinsic("llvm.sqrt"), [self.cast(args[0], F64)])
        self.refuse(node, f"a call of {name!r} that was not fused")

    # ---- the entry
    def run(self) -> ir.Module:
        """The LLVM module."""
        kinds: list[Any] = []
        for _, rank, element in self.arguments:
            kinds += [(F64 if element == "f" else I64).as_pointer(), *[I64] * rank]
        function = ir.Function(self.module, ir.FunctionType(I64, kinds), name=self.node.name)
        given = iter(function.args)
        for name, rank, element in self.arguments:
            base = next(given)
            base.add_attribute("noalias")
            self.arrays[name] = Array(base, [next(given) for _ in range(rank)], F64 if element == "f" else I64)
        self.entry = function.append_basic_block("entry")
        body = function.append_basic_block("body")
        self.builder = ir.IRBuilder(body)
        self.entry_builder = ir.IRBuilder(self.entry)
        self.infer()
        for name, kind in self.types.items():
            self.slots[name] = self.entry_builder.alloca(kind, name=name)
            self.entry_builder.store(ir.Constant(kind, 0.0 if kind is F64 else 0), self.slots[name])
        self.block(self.node.body)
        if not self.builder.block.is_terminated:
            self.builder.ret(ir.Constant(I64, 0))
        self.entry_builder.branch(body)
        return self.module

    # ---- statements
    def block(self, body: list[ast.stmt]) -> None:
        """Statements in order; what follows a jump is left out."""
        for node in body:
            if self.builder.block.is_terminated:
                return
            getattr(self, f"do_{type(node).__name__.lower()}", self.refuse_statement)(node)

    def refuse_statement(self, node: ast.stmt) -> None:
        self.refuse(node, "a statement outside the subset")

    def do_pass(self, node: ast.stmt) -> None:
        """Nothing."""

    def do_expr(self, node: ast.Expr) -> None:
        self.value(node.value)

    def do_return(self, node: ast.Return) -> None:
        self.builder.ret(ir.Constant(I64, 0))

    def do_break(self, node: ast.stmt) -> None:
        self.builder.branch(self.loops[-1][1])

    def do_continue(self, node: ast.stmt) -> None:
        self.builder.branch(self.loops[-1][0])

    def do_assign(self, node: ast.Assign) -> None:
        target = node.targets[0]
        if isinstance(target, ast.Subscript):
            place, element = self.element(target)
            self.builder.store(self.cast(self.value(node.value), element), place)
        elif isinstance(target, ast.Name) and target.id not in self.types:
            self.arrays[target.id] = self.array(node.value)
        elif isinstance(target, ast.Name):
            self.builder.store(self.cast(self.value(node.value), self.types[target.id]), self.slots[target.id])
        else:
            self.refuse(node, "a tuple that was not taken apart")

    def do_if(self, node: ast.If) -> None:
        test = self.truth(self.value(node.test))
        if isinstance(node.test, ast.Constant):
            self.block(node.body if node.test.value else node.orelse)
            return
        yes, no = self.builder.append_basic_block(), self.builder.append_basic_block()
        self.builder.cbranch(test, yes, no)
        before, ends = self.arrays, []
        for start, body in ((yes, node.body), (no, node.orelse)):
            self.builder.position_at_end(start)
            self.arrays = dict(before)
            self.block(body)
            if not self.builder.block.is_terminated:
                ends.append((self.builder.block, self.arrays))
        if not ends:
            return
        after = self.builder.append_basic_block()
        for end, _ in ends:
            self.builder.position_at_end(end)
            self.builder.branch(after)
        self.builder.position_at_end(after)
        self.arrays = self.met(ends)

    def met(self, ends: list[tuple[Any, dict[str, Array]]]) -> dict[str, Array]:
        """Which array each name means where branches meet: the one of the branch that was taken."""
        (one, mine), (other, theirs) = ends[0], ends[-1]
        found = {}
        for name, a in mine.items():
            b = theirs.get(name)
            if b is None:
                continue
            if a.base is not b.base and (a.shape, a.element) == (b.shape, b.element):
                base = self.builder.phi(a.base.type)
                base.add_incoming(a.base, one)
                base.add_incoming(b.base, other)
                a = Array(base, a.shape, a.element)
            elif a.base is not b.base:
                continue
            found[name] = a
        return found

    def do_while(self, node: ast.While) -> None:
        test, body, after = (self.builder.append_basic_block() for _ in range(3))
        self.builder.branch(test)
        self.builder.position_at_end(test)
        self.builder.cbranch(self.truth(self.value(node.test)), body, after)
        self.loop(node.body, body, test, test, after)

    def loop(self, statements: list[ast.stmt], body: Any, back: Any, on: Any, after: Any) -> None:
        """A loop's body; ``on`` is where ``continue`` goes."""
        self.builder.position_at_end(body)
        self.loops.append((on, after))
        before, self.arrays = self.arrays, dict(self.arrays)
        self.block(statements)
        self.arrays = before
        self.loops.pop()
        if not self.builder.block.is_terminated:
            self.builder.branch(back)
        self.builder.position_at_end(after)

    def in_range(self, now: Any, high: Any, by: Any) -> Any:
        """Whether a range goes on: up or down as its step says, nowhere where that is zero."""
        build, zero = self.builder, ir.Constant(I64, 0)
        up = build.and_(build.icmp_signed(">", by, zero), build.icmp_signed("<", now, high))
        down = build.and_(build.icmp_signed("<", by, zero), build.icmp_signed(">", now, high))
        return build.or_(up, down)

    def next_of(self, now: Any, by: Any, high: Any) -> Any:
        """What follows in a range: its end where the sum would have more than 64 bits."""
        build = self.builder
        if isinstance(by, ir.Constant) and abs(by.constant) == 1:
            return build.add(now, by, flags=("nsw",))
        up = build.icmp_signed(">", by, ir.Constant(I64, 0))
        left = build.select(up, build.sub(high, now), build.sub(now, high))
        size = build.select(up, by, build.neg(by))
        return build.select(build.icmp_unsigned(">", left, size), build.add(now, by), high)

    def do_for(self, node: ast.For) -> None:
        assert isinstance(node.iter, ast.Call) and isinstance(node.target, ast.Name)
        given = [self.cast(self.value(a), I64) for a in node.iter.args]
        low, high = (ir.Constant(I64, 0), given[0]) if len(given) == 1 else (given[0], given[1])
        by = given[2] if len(given) > 2 else ir.Constant(I64, 1)
        counter = self.entry_builder.alloca(I64)
        self.builder.store(low, counter)
        test, body, on, after = (self.builder.append_basic_block() for _ in range(4))
        self.builder.branch(test)
        self.builder.position_at_end(test)
        now = self.builder.load(counter)
        self.builder.cbranch(self.in_range(now, high, by), body, after)
        self.builder.position_at_end(on)
        self.builder.store(self.next_of(self.builder.load(counter), by, high), counter)
        self.builder.branch(test)
        self.builder.position_at_end(body)
        self.builder.store(self.cast(now, self.types[node.target.id]), self.slots[node.target.id])
        self.loop(node.body, body, on, on, after)
