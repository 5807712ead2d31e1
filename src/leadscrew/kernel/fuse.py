"""Fuses what an entry calls into the entry itself, for the compiled engines.

A loop reaches fifty functions; fused, it is one. The arithmetic and its order stay what they are, so the bits do; the
Python engine runs the functions unfused, under the user's own lines.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping

from leadscrew.kernel.trees import INNER, Swap, clone, copied, each, names


def _has(node: ast.AST | list[ast.stmt], kind: type) -> bool:
    nodes = node if isinstance(node, list) else [node]
    return any(isinstance(n, kind) for top in nodes for n in ast.walk(top))


def _ends(body: list[ast.stmt]) -> bool:
    """Whether every path through the statements returns."""
    last = body[-1] if body else None
    if isinstance(last, ast.Return):
        return True
    return isinstance(last, ast.If) and _ends(last.body) and _ends(last.orelse)


class _Exit:
    def __init__(self, parts: int, taken: set[str]) -> None:
        self.taken = taken
        self.names = [self.free(f"ret{i}") for i in range(parts)] if parts else [self.free("ret")]
        self.parts = parts
        self.loops = 0

    def free(self, name: str) -> str:
        """A name that the function does not have."""
        while name in self.taken:
            name += "_"
        return name

    def result(self, value: ast.expr) -> list[ast.stmt]:
        """Writes what is returned into the locals that carry it to the exit."""
        targets: list[ast.expr] = [ast.Name(n, ast.Store()) for n in self.names]
        if not self.parts:
            return [ast.Assign(targets, value)]
        return [ast.Assign([ast.Tuple(targets, ast.Store())], value)]

    def convert(self, body: list[ast.stmt]) -> list[ast.stmt]:
        """Statements without a return; on every path the result is written."""
        out: list[ast.stmt] = []
        for i, node in enumerate(body):
            rest = body[i + 1 :]
            if isinstance(node, ast.Return):
                assert node.value is not None
                return out + self.result(node.value)
            if isinstance(node, ast.If) and _has(node, ast.Return):
                yes = node.body if _ends(node.body) else node.body + [copied(n) for n in rest]
                no = node.orelse if _ends(node.orelse) else node.orelse + rest
                out.append(ast.If(node.test, self.convert(yes) or [ast.Pass()], self.convert(no)))
                return out
            if isinstance(node, ast.For | ast.While) and _has(node, ast.Return):
                self.loops += 1
                flag = self.free(f"done{self.loops}")
                out.append(ast.Assign([ast.Name(flag, ast.Store())], ast.Constant(False)))
                node.body = self.inside(node.body, flag)
                out.append(node)
                out.append(ast.If(ast.Name(flag, ast.Load()), [ast.Pass()], self.convert(rest)))
                return out
            out.append(node)
        return out

    def inside(self, body: list[ast.stmt], flag: str) -> list[ast.stmt]:
        """The body of a loop: a return writes the result, raises the flag and leaves the loop."""
        out: list[ast.stmt] = []
        for node in body:
            if isinstance(node, ast.Return):
                assert node.value is not None
                out += [
                    *self.result(node.value),
                    ast.Assign([ast.Name(flag, ast.Store())], ast.Constant(True)),
                    ast.Break(),
                ]
                return out
            if isinstance(node, ast.If):
                node.body = self.inside(node.body, flag)
                node.orelse = self.inside(node.orelse, flag)
                out.append(node)
            elif isinstance(node, ast.For | ast.While) and _has(node, ast.Return):
                node.body = self.inside(node.body, flag)
                out += [node, ast.If(ast.Name(flag, ast.Load()), [ast.Break()], [])]
            else:
                out.append(node)
        return out


def single_exit(node: ast.FunctionDef) -> ast.FunctionDef:
    """The function with one return, at its end; itself where it already has that."""
    count = sum(isinstance(n, ast.Return) for n in ast.walk(node))
    if count == 0 or (count == 1 and isinstance(node.body[-1], ast.Return)):
        return node
    new = copied(node)
    sizes = {len(n.value.elts) for n in ast.walk(new) if isinstance(n, ast.Return) and isinstance(n.value, ast.Tuple)}
    taken = {n.id for n in names(new)} | {a.arg for a in new.args.args}
    exit_ = _Exit(sizes.pop() if sizes else 0, taken)
    new.body = exit_.convert(new.body)
    values: list[ast.expr] = [ast.Name(n, ast.Load()) for n in exit_.names]
    new.body.append(ast.Return(ast.Tuple(values, ast.Load()) if exit_.parts else values[0]))
    return ast.fix_missing_locations(new)


def _simple(node: ast.expr) -> bool:
    while isinstance(node, ast.Attribute):
        node = node.value
    return isinstance(node, ast.Name | ast.Constant)


def _returns(node: ast.FunctionDef) -> int:
    return sum(isinstance(n, ast.Return) for n in each(node))


def _substitution(given: Mapping[str, ast.expr], renamed: Mapping[str, str]) -> Swap:
    """Puts arguments in place of parameters and gives locals names of their own."""

    def swap(node: ast.Name) -> ast.expr:
        if node.id in renamed:
            return ast.Name(renamed[node.id], node.ctx)
        found = given.get(node.id)
        if found is not None and isinstance(node.ctx, ast.Load):
            copied: ast.expr = clone(found)
            return copied
        return ast.Name(node.id, node.ctx)

    return swap


def _matched(target: ast.Tuple, value: ast.Tuple) -> list[tuple[ast.expr, ast.expr]]:
    """Targets and values of a tuple assignment, tuples within tuples taken apart."""
    found: list[tuple[ast.expr, ast.expr]] = []
    for t, v in zip(target.elts, value.elts, strict=True):
        found += _matched(t, v) if isinstance(t, ast.Tuple) and isinstance(v, ast.Tuple) else [(t, v)]
    return found


class Fuser:
    """Fuses functions of one module; ``functions`` are the ones that may be fused, by name."""

    def __init__(self, functions: Mapping[str, ast.FunctionDef]) -> None:
        self.functions = {name: single_exit(node) for name, node in functions.items() if _returns(node)}
        self.uses: dict[str, tuple[set[str], dict[str, int]]] = {}
        self.done: dict[str, ast.FunctionDef] = {}
        self.count = 0

    def function(self, node: ast.FunctionDef) -> ast.FunctionDef:
        """A function with everything fused that can be."""
        fused: ast.FunctionDef = clone(node)
        fused.body = self.block(fused.body)
        return fused

    def usage(self, name: str) -> tuple[set[str], dict[str, int]]:
        """What a fused function assigns, and how often it reads each name."""
        if name not in self.uses:
            assigned: set[str] = set()
            read: dict[str, int] = {}
            for n in names(self.done[name]):
                if isinstance(n.ctx, ast.Store):
                    assigned.add(n.id)
                else:
                    read[n.id] = read.get(n.id, 0) + 1
            self.uses[name] = assigned, read
        return self.uses[name]

    def block(self, body: list[ast.stmt]) -> list[ast.stmt]:
        """Statements with their calls fused in."""
        out: list[ast.stmt] = []
        for node in body:
            self.statement(node, out)
        return out or [ast.Pass()]

    def statement(self, node: ast.stmt, out: list[ast.stmt]) -> None:
        """One statement, preceded by the bodies of what it calls."""
        if isinstance(node, ast.If):
            node.test = self.expression(node.test, out)
            node.body = self.block(node.body)
            node.orelse = self.block(node.orelse) if node.orelse else []
        elif isinstance(node, ast.For):
            node.iter = self.expression(node.iter, out)
            node.body = self.block(node.body)
        elif isinstance(node, ast.While):
            before: list[ast.stmt] = []
            test = self.expression(node.test, before)
            node.body = self.block(node.body)
            node.test = test
            if before:
                node.test = ast.Constant(True)
                node.body = [*before, ast.If(ast.UnaryOp(ast.Not(), test), [ast.Break()], []), *node.body]
        elif isinstance(node, ast.Assign):
            node.value = self.expression(node.value, out)
            node.targets = [self.expression(t, out) for t in node.targets]
            target = node.targets[0]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                self.unpack(target, node.value, out)
                return
        elif isinstance(node, ast.Return) and node.value is not None:
            node.value = self.expression(node.value, out)
        elif isinstance(node, ast.Expr):
            node.value = self.expression(node.value, out)
            if isinstance(node.value, ast.Constant | ast.Name):
                return  # what a function gave that was called for its writes
        out.append(node)

    def unpack(self, target: ast.Tuple, value: ast.Tuple, out: list[ast.stmt]) -> None:
        """``a, b = x, y`` without building a tuple, through names of their own where one reads what another sets."""
        pairs = [(t, v) for t, v in _matched(target, value)
                 if not (isinstance(v, ast.Name) and isinstance(t, ast.Name) and v.id == t.id)]  # fmt: skip
        targets = {t.id for t, _ in pairs if isinstance(t, ast.Name)}
        read = {n.id for _, v in pairs for n in names(v)}
        if targets & read:
            kept = []
            for t, v in pairs:
                held = self.fresh("v")
                out.append(ast.Assign([ast.Name(held, ast.Store())], v))
                kept.append((t, ast.Name(held, ast.Load())))
            pairs = kept  # type: ignore[assignment]
        out.extend(ast.Assign([t], v) for t, v in pairs)

    def fresh(self, stem: str) -> str:
        """A local name that nothing has yet."""
        self.count += 1
        return f"{stem}_{self.count}"

    def expression(self, node: ast.expr, out: list[ast.stmt]) -> ast.expr:
        """An expression with the functions that it calls fused; their statements go to ``out``."""
        held = node.__dict__
        for field in INNER[node.__class__]:
            value = held.get(field)
            if value.__class__ is list:
                value[:] = [self.expression(v, out) if isinstance(v, ast.expr) else v for v in value]
            elif isinstance(value, ast.expr):
                held[field] = self.expression(value, out)
        if isinstance(node, ast.IfExp) and isinstance(node.body, ast.Tuple) and isinstance(node.orelse, ast.Tuple):
            return self.chosen(node, node.body, node.orelse, out)
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in self.functions):
            return node
        return self.fused_call(node, node.func.id, out)

    def chosen(self, node: ast.IfExp, yes: ast.Tuple, no: ast.Tuple, out: list[ast.stmt]) -> ast.expr:
        """A choice between tuples as a tuple of choices."""
        test = ast.Name(self.fresh("test"), ast.Load())
        out.append(ast.Assign([ast.Name(test.id, ast.Store())], node.test))
        made = [ast.IfExp(clone(test), a, b) for a, b in zip(yes.elts, no.elts, strict=True)]
        return ast.Tuple([self.expression(x, out) for x in made], ast.Load())

    def fused_call(self, node: ast.Call, name: str, out: list[ast.stmt]) -> ast.expr:
        """The body of a called function into ``out``; gives the expression that it returns."""
        callee = self.functions[name]
        if name not in self.done:
            self.done[name] = self.function(callee)
        callee = self.done[name]
        params = [a.arg for a in callee.args.args]
        assigned, read = self.usage(name)
        renamed = {local: self.fresh(local.rstrip("0123456789").rstrip("_") or "v") for local in sorted(assigned)}
        given: dict[str, ast.expr] = {}
        for param, arg in zip(params, node.args, strict=True):
            if param in assigned:
                out.append(ast.Assign([ast.Name(renamed[param], ast.Store())], arg))
            elif _simple(arg) or param not in read:
                given[param] = arg
            else:
                held = self.fresh(param.rstrip("0123456789").rstrip("_") or "v")
                out.append(ast.Assign([ast.Name(held, ast.Store())], arg))
                given[param] = ast.Name(held, ast.Load())
        swap = _substitution(given, renamed)
        *body, last = callee.body
        out.extend(clone(s, swap) for s in body)
        assert isinstance(last, ast.Return) and last.value is not None
        value: ast.expr = clone(last.value, swap)
        return value
