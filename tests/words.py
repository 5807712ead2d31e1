"""Words that the field does not use: ``python -m tests.words`` lists where users would read them.

Checked are the texts of the source (messages, help, documentation of parameters), the pages, the names of files, and
the names of the public interface: what the packages list, with parameters, fields and methods. The exit code is 1 where
one is there.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PHRASES = {
    r"\b(un|fore)?told\b": "identifiable, predicted, known, distinguished",
    r"(^|[.;:] )Whose\b": "the thing itself: 'scenario of the run', not 'Whose run'",
    r"\bstand(s|ing)? still\b|\bstand-still\b": "is at rest, standstill",
    r"\bhangs? on\b": "depends on",
    r"\bdoors?\b": "validation, entry",
    r"\bundone\b": "reverted",
    r"\bunseen (half|part|data)\b": "validation data",
    r"\b(bent bristles|bend of the bristles)\b": "bristle deflection",
    r"(?<!give )\bway (of the carriage|along|/ mm)": "travel, distance",
    r"\bsureness\b": "uncertainty",
    r"\b[Mm]ade (test|log|example|measurement)\b": "synthetic",
    r"\b(acceptance|issue) \d": "what it says",
    r"\bstands? twice\b": "is repeated",
}
"""What no text says, and what it says instead."""
NAMES = frozenset(
    [
        "found",
        "made",
        "said",
        "told",
        "asked",
        "given",
        "held",
        "way",
        "late",
        "least",
        "most",
        "whose",
        "door",
        "undone",
        "keeping",
        "bent",
        "foretold",
        "untold",
    ]
)
"""Parts of names that do not say what a value is."""
ALLOWED = re.compile(r"held_out|at_least|at_most|least_squares|logged_made")


def texts(file: Path) -> Iterator[tuple[int, str]]:
    """The texts of a module that a user may read: its strings with a space, but for docstrings. Those of decorated
    functions are what ``list`` and ``run`` print: blocks, claims, experiments, commands.
    """
    tree = ast.parse(file.read_text())
    printed = {id(n.body[0]) for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and n.decorator_list}
    silent = {
        id(n.value)
        for n in ast.walk(tree)
        if isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant) and id(n) not in printed
    }
    for node in ast.walk(tree):
        text = node.value if isinstance(node, ast.Constant) and id(node) not in silent else None
        if isinstance(text, str) and " " in text.strip():
            yield node.lineno, text


def phrases() -> Iterator[str]:
    """Where a text has a phrase of the list."""
    for file in sorted((ROOT / "src").rglob("*.py")):
        for line, text in texts(file):
            yield from _in(text, f"{file.relative_to(ROOT)}:{line}")
    for file in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        if file.name != "changed_numbers.md" and file.parent.name != "generated":
            for line, text in enumerate(file.read_text().splitlines(), 1):
                yield from _in(text, f"{file.relative_to(ROOT)}:{line}")


def _in(text: str, place: str) -> Iterator[str]:
    for pattern, better in PHRASES.items():
        for match in re.finditer(pattern, text):
            yield f"{place}: {match.group().strip()!r}: write {better}"


def names() -> Iterator[str]:
    """Public names with a part of the list."""
    for stub in sorted((ROOT / "src" / "leadscrew").rglob("__init__.pyi")):
        package = ".".join(stub.parent.relative_to(ROOT / "src").parts)
        module = importlib.import_module(package)
        for name in module.__all__:
            for key in (name, *_keys(getattr(module, name))):
                if bad(key):
                    yield f"{package}.{name}: {key!r}: a name says what the value is"
    for file in sorted((ROOT / "src").rglob("*.py")):
        if bad(file.stem):
            yield f"{file.relative_to(ROOT)}: a name says what the file holds"


def bad(name: str) -> bool:
    """Whether a name has a part that says nothing."""
    return not ALLOWED.search(name) and bool(NAMES & set(re.split(r"[_.]", name.lower())))


def _keys(value: Any) -> Iterator[str]:
    """Names below a public one: parameters of blocks and functions, fields and methods of classes."""
    from leadscrew.kernel.block import Block
    from leadscrew.kernel.parameters import entries

    if isinstance(value, Block):
        yield from (entry.key for entry in (entries(value.params) if value.params is not None else ()))
    elif inspect.isclass(value):
        yield from (name for name in getattr(value, "__annotations__", ()) if not name.startswith("_"))
        for name, member in vars(value).items():
            if not name.startswith("_") and (callable(member) or isinstance(member, property)):
                yield name
                yield from _arguments(member)
    elif callable(value):
        yield from _arguments(value)


def _arguments(value: Any) -> Iterator[str]:
    try:
        yield from inspect.signature(value).parameters
    except (TypeError, ValueError):
        return


if __name__ == "__main__":
    rows = [*phrases(), *names()]
    print("\n".join(rows))
    print(f"{len(rows)} words to change")
    sys.exit(bool(rows))
