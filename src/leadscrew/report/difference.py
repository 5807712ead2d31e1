"""How two controllers differ: the lines of their equations, and the values of their parameters."""

from __future__ import annotations

import ast
import difflib
import inspect
import textwrap
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from rich.text import Text

from leadscrew.figures.table import as_typed, unit
from leadscrew.kernel.parameters import entries
from leadscrew.report.report import Report, TextTable, head

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block


class ParameterDifference(NamedTuple):
    """One parameter that only one of the two has, or that differs; ``None`` where it is absent."""

    key: str
    a: Any
    b: Any
    unit: str


def equations(a: Block, b: Block, name_a: str, name_b: str) -> list[str]:
    """The unified diff of the two steps, with the helpers that only one of them reaches; docstrings left out."""
    reached_a, reached_b = list(_reached(a)), list(_reached(b))
    text_a = [line for f in reached_a if f is a.step or f not in reached_b for line in _source(f)]
    text_b = [line for f in reached_b if f is b.step or f not in reached_a for line in _source(f)]
    return list(difflib.unified_diff(text_a, text_b, name_a, name_b, lineterm="", n=50))


def parameters(a: Block, b: Block) -> list[ParameterDifference]:
    """The parameters in which two blocks differ."""
    sheet_a, sheet_b = ({e.key: e for e in entries(x.params)} for x in (a, b))
    rows = []
    for key in dict.fromkeys([*sheet_a, *sheet_b]):
        left, right = sheet_a.get(key), sheet_b.get(key)
        if left is not None and right is not None and np.array_equal(left.default, right.default):
            continue
        some = left or right
        assert some is not None
        rows.append(
            ParameterDifference(key, left.default if left else None, right.default if right else None, some.unit)
        )
    return rows


COLOURS = {"+": "green", "-": "red", "@": "cyan"}
"""Of the lines of a difference, by their first character."""


def report_of(study: str, first: Block, second: Block, a: str, b: str) -> Report:
    """The report of ``leadscrew diff``."""
    lines, rows = equations(first, second, a, b), parameters(first, second)
    cells = [(r.key, as_typed(r.a), as_typed(r.b), unit(r.unit)) for r in rows]
    table = TextTable(("parameter", a, b, "unit"), cells, [False, True, True, False])
    return Report(
        {**head("diff"), "study": study, "a": a, "b": b, "equations": lines, "parameters": [r._asdict() for r in rows]},
        parts=[
            (lambda _: [Text(x, COLOURS.get(x[:1], "")) for x in lines]) if lines else "The equations are the same.",
            table if rows else "The parameters are the same.",
        ],
    )


def _reached(block: Block) -> Iterator[Callable[..., Any]]:
    """What the equations consist of: ``prepare``, the step, and the plain functions that they call, kernel left out."""
    seen: list[Callable[..., Any]] = []
    waiting = [f for f in (block.step, block.prepare) if f is not None]
    while waiting:
        function = waiting.pop(0)
        if function in seen:
            continue
        seen.append(function)
        yield function
        names = function.__code__.co_names if hasattr(function, "__code__") else ()
        for name in names:
            found = getattr(function, "__globals__", {}).get(name)
            step = getattr(found, "step", found)
            if inspect.isfunction(step) and not step.__module__.startswith("leadscrew.kernel"):
                waiting.append(step)


def _source(function: Callable[..., Any]) -> list[str]:
    """The source of a function without decorator and docstring."""
    try:
        lines = textwrap.dedent(inspect.getsource(function)).splitlines()
        node = ast.parse("\n".join(lines)).body[0]
    except (OSError, TypeError, SyntaxError):
        return [f"# the source of {getattr(function, '__name__', function)!r} cannot be read", ""]
    if not isinstance(node, ast.FunctionDef):
        return [*lines, ""]
    first = node.body[0]
    dropped = range(first.lineno, (first.end_lineno or 0) + 1) if ast.get_docstring(node) is not None else range(0)
    kept = [line for at, line in enumerate(lines, 1) if at >= node.lineno and at not in dropped]
    return [*kept, ""]
