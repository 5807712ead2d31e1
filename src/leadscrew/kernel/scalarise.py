"""Takes NamedTuples apart inside a fused function: every leaf a local of its own, and no leaf that nobody reads.

A NamedTuple costs nothing at run time, but much when it is compiled. What cannot be seen through (what a function
that stayed a function returns) is left whole and read field by field.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from typing import Any

from leadscrew.kernel.trees import INNER, clone, each, rewritten

Fields = Mapping[str, Mapping[str, str]]
"""Classes by name: fields in order, each with its annotation's text."""
PENDING = "?"
"""The class of a local of which nothing is known yet: one that is set from itself on the way round a loop."""


def fields_of(classes: list[ast.ClassDef]) -> dict[str, dict[str, str]]:
    """The fields of the module's NamedTuple classes."""
    return {
        c.name: {s.target.id: ast.unparse(s.annotation) for s in c.body
                 if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name)}
        for c in classes
    }  # fmt: skip


class Scalariser:
    """Works on one function at a time."""

    def __init__(self, classes: Fields) -> None:
        self.classes = classes
        self.types: dict[str, str | None] = {}
        self.count = 0

    def function(self, node: ast.FunctionDef) -> ast.FunctionDef:
        """The function with its NamedTuples taken apart; ``node`` is changed."""
        setters = [n for n in each(node) if n.__class__ is ast.Assign or n.__class__ is ast.For]
        targets = (n.targets[0] if isinstance(n, ast.Assign) else n.target for n in setters)
        self.types = {t.id: PENDING for t in targets if isinstance(t, ast.Name)}
        before: dict[str, str | None] = {}
        while self.types != before:
            before = self.types
            self.infer(node, setters)
        self.types = {k: None if v == PENDING else v for k, v in self.types.items()}
        node.body = self.block(node.body)
        return node

    # ---- types
    def infer(self, node: ast.FunctionDef, setters: Sequence[ast.stmt]) -> None:
        """The class of each local that only ever holds one class."""
        found: dict[str, set[str | None]] = {a.arg: {None} for a in node.args.args}
        for n in setters:
            if isinstance(n, ast.Assign):
                for target in n.targets:
                    if isinstance(target, ast.Name):
                        found.setdefault(target.id, set()).add(self.type_of(n.value))
                    elif isinstance(target, ast.Tuple):
                        for e in target.elts:
                            if isinstance(e, ast.Name):
                                found.setdefault(e.id, set()).add(None)
            elif isinstance(n, ast.For) and isinstance(n.target, ast.Name):
                found.setdefault(n.target.id, set()).add(None)
        for v in found.values():
            if len(v) > 1:
                v.discard(PENDING)
        self.types = {k: next(iter(v)) if len(v) == 1 else None for k, v in found.items()}

    def type_of(self, node: ast.expr) -> str | None:
        """The class of an expression, where it can be seen."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in self.classes:
            return node.func.id
        if isinstance(node, ast.Name):
            return self.types.get(node.id)
        if isinstance(node, ast.Attribute):
            base = self.type_of(node.value)
            if base == PENDING:
                return PENDING
            inner = self.classes[base].get(node.attr) if base else None
            return inner if inner in self.classes else None
        if isinstance(node, ast.IfExp):
            a, b = self.type_of(node.body), self.type_of(node.orelse)
            return a if a == b or b == PENDING else b if a == PENDING else None
        return None

    # ---- leaves
    def paths(self, cls: str) -> list[tuple[str, ...]]:
        """The leaves of a class as paths of fields."""
        out: list[tuple[str, ...]] = []
        for field, kind in self.classes[cls].items():
            out += [(field, *rest) for rest in self.paths(kind)] if kind in self.classes else [(field,)]
        return out

    def leaf(self, node: ast.expr, path: tuple[str, ...]) -> ast.expr:
        """One leaf of an expression that holds a NamedTuple."""
        if not path:
            return node
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in self.classes:
            at = list(self.classes[node.func.id]).index(path[0])
            return self.leaf(node.args[at], path[1:])
        if isinstance(node, ast.IfExp):
            return ast.IfExp(clone(node.test), self.leaf(node.body, path), self.leaf(node.orelse, path))
        if isinstance(node, ast.Name) and self.types.get(node.id):
            return ast.Name("__".join((node.id, *path)), ast.Load())
        for field in path:
            node = ast.Attribute(clone(node), field, ast.Load())
        return node

    def whole(self, node: ast.expr, cls: str) -> ast.expr:
        """A NamedTuple put together again, where something needs it whole."""
        args = []
        for field, kind in self.classes[cls].items():
            if kind in self.classes:
                inner = self.leaf(node, (field,)) if not isinstance(node, ast.Name) else None
                args.append(self._nested(node, (field,), kind) if inner is None else self.expression(inner))
            else:
                args.append(self.leaf(node, (field,)))
        return ast.Call(ast.Name(cls, ast.Load()), args, [])

    def _nested(self, node: ast.expr, path: tuple[str, ...], cls: str) -> ast.expr:
        args = [
            self._nested(node, (*path, f), k) if k in self.classes else self.leaf(node, (*path, f))
            for f, k in self.classes[cls].items()
        ]
        return ast.Call(ast.Name(cls, ast.Load()), args, [])

    def expression(self, node: ast.expr) -> ast.expr:
        """An expression with every field of a NamedTuple read from its own local."""
        if isinstance(node, ast.Attribute):
            path: list[str] = []
            base: ast.expr = node
            while isinstance(base, ast.Attribute):
                path.insert(0, base.attr)
                base = base.value
            if isinstance(base, ast.Name) and self.types.get(base.id):
                cls, depth = str(self.types[base.id]), 0
                while depth < len(path) and self.classes[cls].get(path[depth]) in self.classes:
                    cls, depth = self.classes[cls][path[depth]], depth + 1
                if depth == len(path):
                    return self._nested(base, tuple(path), cls)
                node = self._attributes(self.leaf(base, tuple(path[: depth + 1])), path[depth + 1 :])
                return node
            if isinstance(base, ast.Call) and isinstance(base.func, ast.Name) and base.func.id in self.classes:
                at = list(self.classes[base.func.id]).index(path[0])
                return self.expression(self._attributes(base.args[at], path[1:]))
            if isinstance(base, ast.IfExp) and self.type_of(base):
                sides = (self._attributes(side, path) for side in (base.body, base.orelse))
                return self.expression(ast.IfExp(base.test, *sides))
        if isinstance(node, ast.Name) and self.types.get(node.id) and isinstance(node.ctx, ast.Load):
            return self.whole(node, str(self.types[node.id]))
        held = node.__dict__
        for name in INNER[node.__class__]:
            value = held.get(name)
            if value.__class__ is list:
                value[:] = [self.expression(v) if isinstance(v, ast.expr) else v for v in value]
            elif isinstance(value, ast.expr):
                held[name] = self.expression(value)
        return node

    @staticmethod
    def _attributes(node: ast.expr, path: list[str]) -> ast.expr:
        for field in path:
            node = ast.Attribute(node, field, ast.Load())
        return node

    # ---- statements
    def block(self, body: list[ast.stmt]) -> list[ast.stmt]:
        """Statements with their NamedTuples taken apart."""
        out: list[ast.stmt] = []
        for node in body:
            self.statement(node, out)
        return out or [ast.Pass()]

    def statement(self, node: ast.stmt, out: list[ast.stmt]) -> None:
        """One statement; the assignment of a NamedTuple becomes one of each leaf."""
        if isinstance(node, ast.If | ast.While):
            node.test = self.expression(node.test)
            node.body = self.block(node.body)
            node.orelse = self.block(node.orelse) if node.orelse else []
        elif isinstance(node, ast.For):
            node.iter = self.expression(node.iter)
            node.body = self.block(node.body)
        elif isinstance(node, ast.Assign):
            target = node.targets[0]
            if isinstance(target, ast.Name) and self.types.get(target.id):
                self.split(target.id, self.opaque_calls(node.value, out), out)
                return
            node.value = self.expression(node.value)
            if isinstance(target, ast.Subscript):
                node.targets = [self.expression(target)]
        elif isinstance(node, ast.Return | ast.Expr) and node.value is not None:
            node.value = self.expression(node.value)
        out.append(node)

    def opaque_calls(self, node: ast.expr, out: list[ast.stmt]) -> ast.expr:
        """Holds what a whole function returns in a local, where a NamedTuple is built of it."""
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in self.classes:
            kinds = list(self.classes[node.func.id].values())
            for i, arg in enumerate(node.args):
                if kinds[i] in self.classes:
                    node.args[i] = self.opaque_calls(arg, out)
        elif isinstance(node, ast.Call):
            self.count += 1
            held = f"whole_{self.count}"
            out.append(ast.Assign([ast.Name(held, ast.Store())], self.expression(node)))
            return ast.Name(held, ast.Load())
        return node

    def split(self, name: str, value: ast.expr, out: list[ast.stmt]) -> None:
        """``name = value`` leaf by leaf, through names of their own where one reads what another sets."""
        cls = str(self.types[name])
        made = [("__".join((name, *p)), self.expression(clone(self.leaf(value, p)))) for p in self.paths(cls)]
        made = [(t, v) for t, v in made if not (isinstance(v, ast.Name) and v.id == t)]
        targets = {t for t, _ in made}
        tangled = any(isinstance(n, ast.Name) and n.id in targets and n.id != t for t, v in made for n in each(v))
        if tangled:
            held = []
            for t, v in made:
                if isinstance(v, ast.Constant) or not any(isinstance(n, ast.Name) and n.id in targets for n in each(v)):
                    held.append((t, v))
                    continue
                self.count += 1
                kept = f"kept_{self.count}"
                out.append(ast.Assign([ast.Name(kept, ast.Store())], v))
                held.append((t, ast.Name(kept, ast.Load())))
            made = held
        out.extend(ast.Assign([ast.Name(t, ast.Store())], v) for t, v in made)


def without_dead(node: ast.FunctionDef, pure: set[str]) -> ast.FunctionDef:
    """The function without assignments that nobody reads; calls of names in ``pure`` may go too."""
    reads: dict[str, int] = {}
    writers: dict[str, list[ast.Assign]] = {}
    for n in each(node):
        if n.__class__ is ast.Name and isinstance(n.ctx, ast.Load):
            reads[n.id] = reads.get(n.id, 0) + 1
        elif n.__class__ is ast.Assign and isinstance(n.targets[0], ast.Name):
            writers.setdefault(n.targets[0].id, []).append(n)
    dead: set[int] = set()
    todo = [name for name in writers if not reads.get(name)]
    while todo:
        for statement in writers[todo.pop()]:
            inside = list(each(statement.value))
            if any(
                isinstance(n, ast.Call) and not (isinstance(n.func, ast.Name) and n.func.id in pure) for n in inside
            ):
                continue
            dead.add(id(statement))
            for n in inside:
                if n.__class__ is ast.Name:
                    reads[n.id] -= 1
                    if reads[n.id] == 0 and n.id in writers:
                        todo.append(n.id)
    if dead:
        _drop(node.body, dead)
    return node


def _drop(body: list[ast.stmt], dead: set[int]) -> None:
    """Takes dead statements out of a block and the blocks inside it."""
    body[:] = [s for s in body if id(s) not in dead]
    for s in body:
        if isinstance(s, ast.For | ast.If | ast.While):
            _drop(s.body, dead)
            _drop(s.orelse, dead)
            if not s.body:
                s.body.append(ast.Pass())


def without_copies(node: ast.FunctionDef) -> ast.FunctionDef:
    """The function with ``x = y`` left out where both are assigned once: ``y`` is read in place of ``x``."""
    order: dict[str, int] = {}
    stores: dict[str, int] = {a.arg: 1 for a in node.args.args}
    first_read: dict[str, int] = {}
    copies: dict[str, ast.expr] = {}
    for place, n in enumerate(_names_in_order(node)):
        if isinstance(n.ctx, ast.Store):
            stores[n.id] = stores.get(n.id, 0) + 1
            order.setdefault(n.id, place)
        else:
            first_read.setdefault(n.id, place)
    for n in each(node):
        if (
            isinstance(n, ast.Assign)
            and isinstance(n.targets[0], ast.Name)
            and isinstance(n.value, ast.Name | ast.Constant)
        ):
            x, y = n.targets[0].id, n.value
            late = first_read.get(x, 1 << 60) > order[x]
            steady = isinstance(y, ast.Constant) or (stores.get(y.id, 0) == 1 and order.get(y.id, -1) < order[x])
            if stores[x] == 1 and late and steady:
                copies[x] = y

    def original(name: ast.Name) -> ast.expr:
        if not isinstance(name.ctx, ast.Load):
            return name
        found: ast.expr = name
        while isinstance(found, ast.Name) and found.id in copies:
            found = copies[found.id]
        return found if found is name else clone(found)

    rewritten(node, {ast.Name: original})
    return node


def _names_in_order(node: ast.AST) -> list[ast.Name]:
    """Every name, those of an assignment's value before its target."""
    out: list[ast.Name] = []
    stack: list[Any] = [node]
    while stack:
        n = stack.pop()
        if n.__class__ is ast.Name:
            out.append(n)
            continue
        fields = _ORDER.get(n.__class__) or INNER[n.__class__]
        for field in reversed(fields):
            value = n.__dict__.get(field)
            if value.__class__ is list:
                stack.extend(v for v in reversed(value) if isinstance(v, ast.AST))
            elif isinstance(value, ast.AST):
                stack.append(value)
    return out


_ORDER: dict[type, tuple[str, ...]] = {ast.Assign: ("value", "targets"), ast.For: ("iter", "target", "body")}
