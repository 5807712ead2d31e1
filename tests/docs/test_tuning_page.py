"""The page on tuning: what its commands show, and what its Python prints in the folder that they leave."""

import os
import re
import subprocess
import sys

import pytest

from leadscrew.export.folder import compiler_path
from tests.docs import sessions
from tests.docs.snippets import ROOT, blocks, python_of
from tests.tools import missing

PAGE = ROOT / "docs" / "tuning.md"
MARK = "@@@ end of block"


def with_marks():
    """The page's Python, with the same line numbers; a mark is printed where each block ends."""
    lines = python_of(PAGE).splitlines()
    for first, body in blocks(PAGE, ("python",)):
        lines[first + len(body)] = f"print({MARK!r})"
    return "\n".join(lines) + "\n"


def shown():
    """What the page shows of each Python block: the ``text`` block right behind it, or nothing."""
    page = PAGE.read_text(encoding="utf-8").splitlines()
    texts = dict(blocks(PAGE, ("text",)))
    found = []
    for first, body in blocks(PAGE, ("python",)):
        end = first + len(body) + 1
        after = next((i for i in range(end, len(page)) if page[i].strip()), end)
        found.append("\n".join(texts.get(after + 1, [])))
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder in which every command of the page was typed, and then its Python ran."""
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    place = tmp_path_factory.mktemp("tuning")
    script = sessions.prepare(PAGE, place, {})
    done = subprocess.run(["bash", str(script)], cwd=place, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    (place / "commands.txt").write_text(done.stdout, encoding="utf-8")
    (place / "page.py").write_text(with_marks(), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=place, env=os.environ, capture_output=True, text=True)
    (place / "python.txt").write_text(done.stdout + done.stderr, encoding="utf-8")
    return place


def test_every_command_does_what_it_shows(folder):
    sessions.compare(PAGE, (folder / "commands.txt").read_text(encoding="utf-8"))
    assert all(step.shown for step in sessions.steps_of(PAGE))


def test_the_python_of_the_page_prints_what_it_shows(folder):
    said = (folder / "python.txt").read_text(encoding="utf-8")
    printed = said.split(f"{MARK}\n")
    assert printed.pop() == "", said
    assert [text.rstrip("\n") for text in printed] == shown()
    assert sum(map(bool, shown())) >= 4


def test_pictures_on_the_page_are_there():
    wanted = re.findall(r"\]\((images/[^)]+)\)", PAGE.read_text(encoding="utf-8"))
    assert len(wanted) == 2
    assert all((PAGE.parent / image).stat().st_size > 10_000 for image in wanted)
