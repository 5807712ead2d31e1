"""The page on constant cutting force: its table of convergence is what its Python prints, and has converged."""

import re
import subprocess
import sys

import pytest

from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "turning.md"


@pytest.mark.slow
def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


def test_steps_of_1_ms_give_each_figure_of_the_limit_to_a_tenth_of_a_percent():
    table = {
        row.split()[0]: [float(x) for x in re.findall(r"\d+\.\d+", row)[1:]] for row in shown(PAGE)[0].splitlines()[1:]
    }
    assert table["20"] == pytest.approx(table["1000"], rel=1e-3) and len(table["20"]) == 6
