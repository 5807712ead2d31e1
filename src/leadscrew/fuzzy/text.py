"""Pieces of source text: names and comments that Python takes, sums and maxima as balanced trees."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Sequence


def identifiers(names: Sequence[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """A Python name for each name, alike where that can be; cut to 60 characters: LLVM has a limit."""
    used, found = set(taken), {}
    for name in names:
        stem = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:60] or "value"
        stem = f"v_{stem}" if stem[0].isdigit() or keyword.iskeyword(stem) else stem
        made, n = stem, 1
        while made in used:
            n += 1
            made = f"{stem}_{n}"
        used.add(made)
        found[name] = made
    return found


def tree(parts: Sequence[str], join: str) -> str:
    """Parts joined two by two, so that no chain is longer than it must be; ``join`` holds ``{0}`` and ``{1}``."""
    if len(parts) == 1:
        return parts[0]
    half = len(parts) // 2
    return join.format(tree(parts[:half], join), tree(parts[half:], join))


def total(parts: Sequence[str]) -> str:
    """The sum of the parts."""
    return tree(parts, "({0} + {1})").removeprefix("(").removesuffix(")") if len(parts) > 1 else parts[0]


class Lines:
    """Statements of a function."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.count = 0

    def put(self, line: str, depth: int = 1) -> None:
        """One line."""
        self.lines.append("    " * depth + line)

    def name(self, stem: str, value: str) -> str:
        """A new local that holds a value."""
        self.count += 1
        made = f"{stem}{self.count}"
        self.put(f"{made} = {value}")
        return made

    def largest(self, parts: Sequence[str], stem: str = "most") -> str:
        """The largest of the parts, as a local."""
        if len(parts) == 1:
            return parts[0]
        half = len(parts) // 2
        a, b = self.largest(parts[:half], stem), self.largest(parts[half:], stem)
        return self.name(stem, f"{a} if {a} > {b} else {b}")
