"""Where the locals of a function are declared in C: as late and as far inside as the function allows."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from leadscrew.kernel.trees import each

Path = tuple[tuple[int, int], ...]
"""From the outside in: which block, and which statement in it."""


def _blocks(node: ast.stmt) -> list[list[ast.stmt]]:
    return [b for f in ("body", "orelse") if isinstance(b := getattr(node, f, None), list) and b]


class Places:
    """Knows for every local where it is set and read."""

    def __init__(self, node: ast.FunctionDef, arguments: set[str]) -> None:
        self.arguments = arguments
        self.seen: dict[str, list[Path]] = {}
        self.sets: dict[str, int] = {}
        self.statements: dict[Path, ast.stmt] = {}
        self.starts: dict[int, list[str]] = {}
        self.first: dict[str, int] = {}
        self.loops: dict[str, list[ast.For]] = {}
        self.counters: dict[str, bool] = {}
        self.walk(node.body, ())
        for name in self.seen:
            if name not in arguments:
                self.settle(name)

    def walk(self, body: list[ast.stmt], outer: Path) -> None:
        """Notes every use of a name, statement by statement."""
        for i, node in enumerate(body):
            path = (*outer, (id(body), i))
            self.statements[path] = node
            for n in self.own(node):
                self.seen.setdefault(n.id, []).append(path)
                if isinstance(n.ctx, ast.Store):
                    self.sets[n.id] = self.sets.get(n.id, 0) + 1
            if isinstance(node, ast.For) and isinstance(node.target, ast.Name):
                self.loops.setdefault(node.target.id, []).append(node)
            for block in _blocks(node):
                self.walk(block, path)

    @staticmethod
    def own(node: ast.stmt) -> Iterator[ast.Name]:
        """The names of a statement, without those in its blocks."""
        for field in node._fields:
            value = getattr(node, field, None)
            if field in ("body", "orelse") and isinstance(value, list):
                continue
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, ast.AST):
                    for n in each(part):
                        if isinstance(n, ast.Name):
                            yield n

    def settle(self, name: str) -> None:
        """Finds the innermost block with all uses of a local, and whether it begins by setting it."""
        paths = self.seen[name]
        depth = 0
        while all(len(p) > depth + 1 for p in paths) and len({p[depth] for p in paths}) == 1:
            # All uses are within one statement: go into the block of it that has them, if one block has them all.
            if len({p[depth + 1][0] for p in paths}) != 1:
                break
            depth += 1
        block = paths[0][depth][0]
        here = min((p for p in paths if p[depth][0] == block), key=lambda p: p[depth][1])
        node = self.statements[here[: depth + 1]]
        exact = [p for p in paths if p == here[: depth + 1]]
        named = [n for n in self.own(node) if n.id == name]
        if exact and isinstance(node, ast.Assign) and len(named) == 1:
            self.first[name] = id(node)
        elif not self.is_counter(name):
            self.starts.setdefault(block, []).append(name)

    def at_start(self, body: list[ast.stmt]) -> list[str]:
        """The locals to declare where a block begins."""
        return self.starts.get(id(body), [])

    def begins(self, name: str, node: ast.stmt) -> bool:
        """Whether a local begins with this statement."""
        return self.first.get(name) == id(node)

    def once(self, name: str) -> bool:
        """Whether a local is set in one place only."""
        return self.sets.get(name, 0) == 1

    def is_counter(self, name: str) -> bool:
        """Whether a local is only ever the counter of loops, set by them alone and used inside them alone."""
        if name not in self.counters:
            loops = self.loops.get(name, [])
            inside = [n for loop in loops for n in each(loop)]
            uses = sum(isinstance(n, ast.Name) and n.id == name for n in inside)
            ours = {id(loop) for loop in loops}
            nested = sum(id(n) in ours for n in inside) > len(loops)
            alone = bool(loops) and self.sets.get(name, 0) == len(loops) and uses == len(self.seen.get(name, []))
            self.counters[name] = alone and not nested
        return self.counters[name]
