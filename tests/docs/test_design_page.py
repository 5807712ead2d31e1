"""The page on the design of a VUD controller: what its Python prints. Its commands run in test_snippets."""

import subprocess
import sys

from tests.docs.sessions import steps_of
from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "design_vud.md"


def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


def test_the_design_is_shown_with_what_it_prints():
    command = next(step for step in steps_of(PAGE) if step.command.startswith("leadscrew design"))
    assert sum(line[:1].isdigit() for line in command.shown) == 6
