"""The code in a Markdown file, as a Python file whose line numbers are those of the Markdown file."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")])
_FENCE = re.compile(r"^```(\S*)(?:\s.*)?$")


def blocks(page: Path, languages: tuple[str, ...]) -> list[tuple[int, list[str]]]:
    """The fenced blocks of a page in some languages: number of their first line, from 0, and their lines."""
    found: list[tuple[int, list[str]]] = []
    inside = False
    taken = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines()):
        fence = _FENCE.match(line)
        if fence and not inside:
            inside, taken = True, fence.group(1) in languages
            if taken:
                found.append((number + 1, []))
        elif inside and line.strip() == "```":
            inside = taken = False
        elif taken:
            found[-1][1].append(line)
    return found


def python_of(page: Path) -> str:
    """All ``python`` blocks of a page in order; every other line is left empty."""
    lines = [""] * len(page.read_text(encoding="utf-8").splitlines())
    for first, body in blocks(page, ("python",)):
        lines[first : first + len(body)] = body
    return "\n".join(lines) + "\n"


def commands_of(page: Path) -> list[str]:
    """The lines of ``console`` and ``sh`` blocks that call the command line."""
    lines = [line.strip().removeprefix("$ ") for _, body in blocks(page, ("console", "sh", "bash")) for line in body]
    return [line.split("  #")[0].strip() for line in lines if line.startswith("leadscrew ")]


MARK = "@@@ end of block"


def with_marks(page: Path) -> str:
    """The page's Python, with the same line numbers; a mark is printed where each block ends."""
    lines = python_of(page).splitlines()
    for first, body in blocks(page, ("python",)):
        lines[first + len(body)] = f"print({MARK!r})"
    return "\n".join(lines) + "\n"


def shown(page: Path) -> list[str]:
    """What the page shows of each Python block: the ``text`` block right behind it, or nothing."""
    lines = page.read_text(encoding="utf-8").splitlines()
    texts = dict(blocks(page, ("text",)))
    found = []
    for first, body in blocks(page, ("python",)):
        end = first + len(body) + 1
        after = next((i for i in range(end, len(lines)) if lines[i].strip()), end)
        found.append("\n".join(texts.get(after + 1, [])))
    return found


def assert_printed(page: Path, said: str) -> None:
    """Asserts that the Python with its marks printed what the page shows of each block."""
    printed = said.split(f"{MARK}\n")
    assert printed.pop() == "", said
    assert [text.rstrip("\n") for text in printed] == shown(page)
