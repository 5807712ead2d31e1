"""From a fused entry to LLVM: floats, integers, truth values and arrays, nothing else.

An entry comes here with its calls fused and its NamedTuples taken apart, so that every local is a number or an
array. Numbers live in stack slots that LLVM turns into registers. Floating-point operations carry no fast-math flag:
they are the IEEE operations that the other engines do, in the same order.
"""

from __future__ import annotations

import ast
from typing import Any

from llvmlite import ir

from leadscrew.kernel.lower_locals import F64, I64, Array
from leadscrew.kernel.lower_values import Values


class Lowering(Values):
    """Lowers one entry into an LLVM module of its own."""

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
