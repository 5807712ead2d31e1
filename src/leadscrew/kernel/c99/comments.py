"""Comments of printed C, from docstrings, units and comments of the Python source; where long lines are broken."""

from __future__ import annotations

import ast
import inspect
import io
import itertools
import linecache
import textwrap
import tokenize
from pathlib import Path
from typing import Any

from leadscrew.kernel.module import Item
from leadscrew.kernel.parameters import SILENT, notes
from leadscrew.kernel.source import tree_of
from leadscrew.kernel.subset import is_named_tuple_type
from leadscrew.kernel.trees import parsed
from leadscrew.util.escape import c_comment


def block(lines: list[str], place: str = "") -> str:
    """Lines as a C comment."""
    if not lines:
        return f"/* {c_comment(place)} */\n" if place else ""
    if len(lines) == 1 and not place:
        return f"/* {c_comment(lines[0])} */\n"
    told = [*lines, *([place] if place else [])]
    return "/* " + "\n".join(f" * {c_comment(x)}".rstrip() for x in told).removeprefix(" * ") + " */\n"


def about(value: Any) -> list[str]:
    """The docstring of a function or class, line by line."""
    text = inspect.getdoc(value) if value is not None else None
    if text is None or (is_named_tuple_type(value) and text.startswith(f"{value.__name__}(")):
        return []
    return text.splitlines()


def place(item: Item) -> str:
    """Where a function was written: file and line, without folders."""
    code = getattr(item.value, "__code__", None)
    return "" if code is None or item.trusted else f"{Path(code.co_filename).name}:{code.co_firstlineno}"


def fields(cls: Any) -> dict[str, str]:
    """One note for each field of a NamedTuple: help and unit from its annotation, or the string below it."""
    found = {}
    sheet = notes(cls)
    below = _strings(cls)
    for name in cls._fields:
        said = sheet.get(name, SILENT).found
        parts = [said.get("doc") or below.get(name, ""), said.get("unit", "")]
        choice = f": {said['choice']}" if "choice" in said else ""
        found[name] = c_comment(", ".join(p for p in parts if p) + choice)
    return found


def _strings(cls: Any) -> dict[str, str]:
    try:
        tree = parsed(textwrap.dedent(inspect.getsource(cls)))
    except (OSError, TypeError, SyntaxError):
        return {}
    found: dict[str, str] = {}
    body = tree.body[0].body if isinstance(tree.body[0], ast.ClassDef) else []
    for a, b in itertools.pairwise(body):
        if isinstance(a, ast.AnnAssign) and isinstance(b, ast.Expr) and isinstance(b.value, ast.Constant):
            found[ast.unparse(a.target)] = " ".join(str(b.value.value).split())
    return found


def lines(function: Any) -> dict[int, list[str]]:
    """The comments of a function, by the line of the statement that they stand above or behind."""
    if function is None:
        return {}
    node, filename = tree_of(function)
    first, last = node.lineno, node.end_lineno or node.lineno
    text = "".join(linecache.getlines(filename)[first - 1 : last])
    starts = sorted({n.lineno for n in ast.walk(node) if isinstance(n, ast.stmt)})
    found: dict[int, list[str]] = {}
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(textwrap.dedent(text)).readline))
    except (tokenize.TokenError, IndentationError):
        return {}
    for token in tokens:
        if token.type != tokenize.COMMENT or token.string.startswith(("# noqa", "# fmt", "# type")):
            continue
        line = token.start[0] + first - 1
        after = [s for s in starts if s >= line] if not token.line[: token.start[1]].strip() else []
        before = [s for s in starts if s <= line]
        at = after[0] if after else before[-1] if before else None
        if at is not None:
            found.setdefault(at, []).append(c_comment(token.string.lstrip("# ").strip()))
    return found


WIDTH = 118
SIGNS = ("+", "-", "*", "/", "?", ":", "&&", "||")


def wrapped(line: str) -> list[str]:
    """A line, broken after a comma or before an operator where it is too long; its later parts are indented more."""
    if len(line) <= WIDTH or line.lstrip().startswith(("/*", "*", "#")):
        return [line.rstrip()]
    indent = len(line) - len(line.lstrip()) + 4
    found: list[str] = []
    while len(line) > WIDTH:
        cut = line.rfind(", ", indent + 20, WIDTH) + 1
        if not cut:
            cut = max(line.rfind(f" {sign} ", indent + 20, WIDTH) for sign in SIGNS)
        if cut <= 0:
            break
        found.append(line[:cut].rstrip())
        line = " " * indent + line[cut:].lstrip()
    return [*found, line.rstrip()]
