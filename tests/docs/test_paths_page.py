"""The page on paths: its Python prints what the page shows."""

import subprocess
import sys

from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "paths.md"


def test_the_python_of_the_page_prints_what_the_page_shows(tmp_path):
    assert all(shown(PAGE))
    done = subprocess.run(
        [sys.executable, "-c", with_marks(PAGE)], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert_printed(PAGE, done.stdout)
