"""Brings a function to one exit, so that it can be fused into its caller: early returns become branches."""

from __future__ import annotations

import ast

from leadscrew.kernel.trees import copied, names


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
