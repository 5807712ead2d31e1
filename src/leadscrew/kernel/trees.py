"""Copying and walking syntax trees, fast: a loop's tree is copied many times on its way to one function."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from typing import Any

Swap = Callable[[ast.Name], ast.expr]


def clone(node: Any, swap: Swap | None = None) -> Any:
    """A copy of a tree without its own line numbers; ``swap`` says what stands for each name."""
    cls = node.__class__
    if cls is ast.Name:
        return ast.Name(node.id, node.ctx) if swap is None else swap(node)
    new = cls.__new__(cls)
    for field in cls._fields:
        value = getattr(node, field, None)
        if value.__class__ is list:
            value = [clone(v, swap) if isinstance(v, ast.AST) else v for v in value]
        elif isinstance(value, ast.AST) and value._fields:
            value = clone(value, swap)
        setattr(new, field, value)
    if isinstance(new, ast.stmt):
        new.lineno = 1  # what ast.unparse asks of a statement
    return new


def copied(node: Any) -> Any:
    """A copy of a tree with its line numbers."""
    cls = node.__class__
    new = cls.__new__(cls)
    for field, value in node.__dict__.items():
        if value.__class__ is list:
            value = [copied(v) if isinstance(v, ast.AST) else v for v in value]
        elif isinstance(value, ast.AST) and value._fields:
            value = copied(value)
        setattr(new, field, value)
    return new


def each(node: ast.AST) -> Iterator[Any]:
    """Every node of a tree that has fields, in no order that matters."""
    stack: list[Any] = [node]
    pop, push = stack.pop, stack.append
    while stack:
        n = pop()
        yield n
        for value in n.__dict__.values():
            if value.__class__ is list:
                for v in value:
                    if isinstance(v, ast.AST):
                        push(v)
            elif isinstance(value, ast.AST) and value._fields:
                push(value)


def names(node: ast.AST) -> Iterator[ast.Name]:
    """Every name in a tree."""
    for n in each(node):
        if n.__class__ is ast.Name:
            yield n


def fingerprint(node: ast.AST) -> str:
    """A text that two trees share only if they are the same but for line numbers."""
    parts: list[str] = []

    def walk(n: Any) -> None:
        parts.append(n.__class__.__name__)
        for field in n._fields:
            value = getattr(n, field, None)
            if value.__class__ is list:
                parts.append("[")
                for v in value:
                    if isinstance(v, ast.AST):
                        walk(v)
                    else:
                        parts.append(repr(v))
                parts.append("]")
            elif isinstance(value, ast.AST):
                walk(value)
            else:
                parts.append(repr(value))

    walk(node)
    return " ".join(parts)
