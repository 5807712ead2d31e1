"""Whether every local of a step is set before it is read, and something is returned, on every path."""

from __future__ import annotations

import ast
from collections.abc import Callable

from leadscrew.kernel.trees import each, names


def check(node: ast.FunctionDef, locals_: set[str], refuse: Callable[[ast.AST, str], None]) -> None:
    """Calls ``refuse`` at the first read of a local that some path has not set, or at the end of a path that returns
    nothing where another one returns something.
    """
    end = _Paths(locals_, refuse).block(node.body, {a.arg for a in node.args.args})
    if end is not None and any(isinstance(n, ast.Return) for n in each(node)):
        refuse(node.body[-1], "returns nothing where this does not return: missing 'return'?")


def leaves(body: list[ast.stmt], returns: bool = True, breaks: bool = True) -> bool:
    """Whether the body of a loop holds a ``return``, or a ``break`` of this loop."""
    for node in body:
        if (returns and isinstance(node, ast.Return)) or (breaks and isinstance(node, ast.Break)):
            return True
        inner = breaks and not isinstance(node, ast.For | ast.While)
        if leaves([*getattr(node, "body", ()), *getattr(node, "orelse", ())], returns, inner):
            return True
    return False


class _Paths:
    def __init__(self, locals_: set[str], refuse: Callable[[ast.AST, str], None]) -> None:
        self.locals, self.refuse = locals_, refuse

    def reads(self, node: ast.AST | None, known: set[str]) -> None:
        """Refuses a read of what is not known to be set."""
        for n in names(node) if node is not None else ():
            if isinstance(n.ctx, ast.Load) and n.id in self.locals and n.id not in known:
                self.refuse(n, f"{n.id!r} may be read before it is set; set it on every path")

    def block(self, body: list[ast.stmt], known: set[str]) -> set[str] | None:
        """What is set after the statements; ``None`` where no path comes to their end."""
        now: set[str] | None = set(known)
        for node in body:
            if now is None:
                return None
            now = self.statement(node, now)
        return now

    def statement(self, node: ast.stmt, known: set[str]) -> set[str] | None:
        """What is set after one statement."""
        if isinstance(node, ast.Return | ast.Break | ast.Continue):
            self.reads(node.value if isinstance(node, ast.Return) else None, known)
            return None
        if isinstance(node, ast.Assign | ast.AnnAssign | ast.AugAssign):
            self.reads(node.value, known)
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name) and node.target.id not in known:
                self.refuse(node, f"{node.target.id!r} may be read before it is set; set it on every path")
            for target in targets:
                self.reads(target, known)
            if node.value is None:
                return known
            return known | {n.id for t in targets for n in names(t) if isinstance(n.ctx, ast.Store)}
        if isinstance(node, ast.If):
            self.reads(node.test, known)
            ends = [e for e in (self.block(node.body, known), self.block(node.orelse, known)) if e is not None]
            return set.intersection(*ends) if ends else None
        if isinstance(node, ast.For):
            self.reads(node.iter, known)
            counter = {node.target.id} if isinstance(node.target, ast.Name) else set()
            self.block(node.body, known | counter)
            return known
        if isinstance(node, ast.While):
            self.reads(node.test, known)
            self.block(node.body, known)
            endless = isinstance(node.test, ast.Constant) and node.test.value and not leaves(node.body, returns=False)
            return None if endless else known
        self.reads(node, known)
        return known
