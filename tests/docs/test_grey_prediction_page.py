"""The page on grey prediction: what its Python prints, its table of windows, its table of predictors."""

import subprocess
import sys

import pytest

from leadscrew.grey.predictors import KINDS
from leadscrew.grey.vectorised import gm11, line
from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "grey_prediction.md"


def rows():
    """Cells of all tables of the page."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    return [[c.strip() for c in x.strip("|").split("|")] for x in lines if x.startswith("| ")]


@pytest.mark.slow
def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


def test_the_windows_of_the_page_are_predicted_as_it_says():
    found = [r for r in rows() if r[0].count(",") == 4]
    assert len(found) == 5
    for window, grey, straight in found:
        y = [float(v) for v in window.split("(")[0].split(",")]
        assert f"{float(gm11(y)):.2f}" == grey and f"{float(line(y)):.2f}" == straight


def test_every_predictor_is_on_the_page_with_its_number():
    assert {r[1].strip("`"): int(r[0]) for r in rows() if r[0].isdigit()} == KINDS
