"""The page on the design of a nonlinear PID: what it shows of its commands and Python is what comes out."""

import re
import subprocess
import sys

import pytest

from tests.docs.sessions import Step, assert_shown
from tests.docs.snippets import ROOT, assert_printed, blocks, shown, with_marks

PAGE = ROOT / "docs" / "design_npid.md"


def typed():
    """The commands in ``text`` blocks: slow ones, and such that end with 1."""
    found = []
    for _, lines in blocks(PAGE, ("text",)):
        for line in lines:
            if line.startswith("$ "):
                found.append(Step(line.removeprefix("$ "), [], []))
            elif found and lines[0].startswith("$ "):
                found[-1].shown.append(line)
    return found


def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert any(shown(PAGE))


@pytest.mark.slow
def test_the_commands_of_the_page_print_what_it_shows(tmp_path):
    steps = typed()
    assert [s.command.split()[1] for s in steps] == ["certify", "design", "certify", "simulate", "design"]
    said = ""
    for step in steps:
        program = [sys.executable, "-c", "from leadscrew.cli import main; main()", *step.command.split()[1:]]
        done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == ("NOT CERTIFIED" in done.stdout), done.stdout + done.stderr
        assert_shown(step, done.stdout)
        said += done.stdout
    assert (tmp_path / "map.png").stat().st_size > 20_000
    for row in re.findall(r"^\| ([^|]+?) \| ([\d.%a-z ]+) \| ([\d.%a-z ]+) \|$", PAGE.read_text(), re.MULTILINE):
        what = row[0].replace("the PID", "PID")
        printed = next(line for line in said.splitlines() if line.startswith(what[:20]))  # a long name is wrapped
        assert re.split(r"\s{2,}", printed.strip())[1:] == [row[1], row[2]]
