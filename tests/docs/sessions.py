"""The console sessions of a page: what is typed, what is shown to come out, and whether it does."""

from __future__ import annotations

import re
import shlex
import sys
from pathlib import Path
from typing import NamedTuple

from tests.docs.snippets import blocks

MARK = "@@@ session step"
SAVED = re.compile(r"[Ss]ave as `([^`]+)`:$")
PROMPT = "halcmd: "
NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d+(?:e[-+]?\d+)?(?![\w.]*\.\w)")
"""A number with a decimal point; no version, no name of a file."""
ANY_NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
VARIES = (
    (r"^Note: Using POSIX non-realtime$", ""),
    (r"LinuxCNC 2\.9\S*?(?=:|$)", "LinuxCNC 2.9"),
    (r"\b(gcc|clang|fmpy|ecospy) \d[\d.]*", r"\1 N"),
    (r"─+", "─"),
    (r"\s+", " "),
)
"""What differs from one machine to the next and says nothing about the page."""


class Step(NamedTuple):
    """One command, the lines given to its prompt, and the lines that are shown to come out."""

    command: str
    given: list[str]
    shown: list[str]


def steps_of(page: Path) -> list[Step]:
    """The commands of the ``console`` blocks of a page, in order."""
    found: list[Step] = []
    for _, lines in blocks(page, ("console",)):
        for line in lines:
            if line.startswith("$ "):
                found.append(Step(line.removeprefix("$ "), [], []))
            elif line.startswith(PROMPT):
                found[-1].given.append(line.removeprefix(PROMPT))
            else:
                found[-1].shown.append(line)
    return found


def files_of(page: Path) -> dict[str, str]:
    """The files that a page tells its reader to save, by name."""
    text = page.read_text(encoding="utf-8").splitlines()
    found = {}
    for first, lines in blocks(page, ("text", "py", "c", "hal")):
        before = next((x for x in reversed(text[: first - 1]) if x.strip()), "")
        saved = SAVED.search(before)
        if saved:
            found[saved[1]] = "\n".join(lines) + "\n"
    return found


def apart(steps: list[Step]) -> tuple[list[Step], list[Step]]:
    """Commands that build on each other, and those that neither write nor read anything that the others write."""
    written = [w for s in steps for w in re.findall(r"(?:-o|--out|--report|--journal) (\S+)", s.command)]

    def alone(step: Step) -> bool:
        return step.command.startswith("leadscrew ") and not any(
            re.search(rf"(?<![\w.-]){re.escape(w)}(?![\w-])", step.command) for w in written
        )

    return [s for s in steps if not alone(s)], [s for s in steps if alone(s)]


def prepare(page: Path, folder: Path, tools: dict[str, str], steps: list[Step] | None = None, name: str = "") -> Path:
    """Writes the files of a page and its commands, or some of them, as a script ``session{name}.sh``.

    ``tools`` come before the machine's programs.
    """
    programs = folder / "programs"
    programs.mkdir(exist_ok=True)
    ours = f'exec {shlex.quote(sys.executable)} -c "from leadscrew.cli import main; main()" "$@"'
    for tool, text in {"leadscrew": ours, **tools}.items():
        (programs / tool).write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
        (programs / tool).chmod(0o755)
    for file, text in files_of(page).items():
        (folder / file).write_text(text, encoding="utf-8")
    lines = [f"export PATH={shlex.quote(str(programs))}:$PATH"]
    for step in steps_of(page) if steps is None else steps:
        given = "".join(f"{x}\n" for x in step.given)
        lines += [f"printf '\\n{MARK}\\n'", f"{step.command} <<'END'\n{given}END", f"printf '\\n{MARK} %s\\n' $?"]
    script = folder / f"session{name}.sh"
    script.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return script


def compare(page: Path, printed: str, steps: list[Step] | None = None, rel: float = 0.0, since: str = "") -> None:
    """Asserts that what is shown came out, ``...`` being any lines; only what shows a refusal may fail, and must.

    ``steps`` are the commands that were typed, where these are not all of the page. ``rel``: see :func:`assert_shown`;
    it holds from the first command on that begins with ``since``, those before it are exact.
    """
    said = re.findall(rf"{MARK}\n(.*?)\n{MARK} (\d+)$", printed, re.DOTALL | re.MULTILINE)
    steps = steps_of(page) if steps is None else steps
    assert len(said) == len(steps), printed
    searched = next((i for i, step in enumerate(steps) if step.command.startswith(since)), len(steps))
    for i, (step, (text, code)) in enumerate(zip(steps, said, strict=True)):
        refused = any(re.match("leadscrew: (?!note: )", x) for x in step.shown)
        assert (code != "0") == refused, f"{step.command} ended with {code}:\n{text}"
        assert_shown(step, text, rel if i >= searched else 0.0)


def assert_shown(step: Step, text: str, rel: float = 0.0) -> None:
    """Asserts that what a page shows of a command is what it printed, if the page shows anything.

    ``rel``: by which share numbers with a decimal point may differ, for pages whose numbers come out of a search that
    rounds in another way on another kind of processor, which the page has to say. Whole numbers and words are exact.
    """
    if not any(x.strip() for x in step.shown):
        return
    said = text.splitlines()
    absent = tuple(name_of(x) for x in (*step.shown, *said) if "  not run  " in x)
    shown, real = (plain([x for x in lines if not (absent and x.startswith(absent))]) for lines in (step.shown, said))
    pattern = "".join(r"(?:.*\n)*?" if x == "..." else _line(x, rel) for x in shown)
    told = f"{step.command} shows\n" + "\n".join(shown) + "\nbut printed\n" + "\n".join(real)
    found = re.fullmatch(pattern, "".join(f"{x}\n" for x in real))
    assert found, told
    numbers = [float(x) for line in shown for x in NUMBER.findall(line)] if rel else []
    for number, instead in zip(numbers, map(float, found.groups()), strict=True):
        assert abs(instead - number) <= rel * abs(number), f"{instead:g} where the page has {number:g}; {told}"


def _line(shown: str, rel: float) -> str:
    """What matches a line: itself, or with any numbers in the places of its numbers."""
    if not rel:
        return re.escape(f"{shown}\n")
    return f"({ANY_NUMBER})".join(map(re.escape, NUMBER.split(shown))) + "\n"


def name_of(line: str) -> str:
    """The first cell of a row of a table."""
    return re.split(r"\s\s+", line)[0]


def plain(lines: list[str]) -> list[str]:
    """Lines without what differs between machines, and without empty ones."""
    found = []
    for line in lines:
        for pattern, instead in VARIES:
            line = re.sub(pattern, instead, line)
        if line.strip():
            found.append(line.strip())
    return found
