"""How printed C is laid out: long lines are broken where C does not mind."""

from __future__ import annotations

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
