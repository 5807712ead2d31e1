"""The page on disturbance rejection: what its Python prints, and the numbers in its text."""

import subprocess
import sys

import numpy as np
import pytest

from leadscrew.studies.npid_xytable.rejection import BEST, let_through, opened
from leadscrew.studies.npid_xytable.tunings import TUNINGS
from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "disturbance_rejection.md"


@pytest.mark.slow
def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


def test_the_factors_in_the_text_are_those_of_the_loops():
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    table_i, retuned, best, cascade = (
        let_through(opened(block))
        for block in (TUNINGS["paper.pid"], TUNINGS["ours.pid_ms_159"], BEST[1.6], TUNINGS["ours.cascade"])
    )
    less = table_i / best
    assert f"lets {less[-1]:.1f} (7.7 Hz) to {less[0]:.0f} times (2.1 Hz) less through" in text
    assert f"lets {cascade.mean() / retuned.mean():.1f} times as much" in text
    assert f"let {table_i.mean():.2f} um through at every low frequency" in text and np.ptp(table_i) < 0.02
    shares = let_through(opened(TUNINGS["ours.pid_dob_60"])) / table_i
    assert f"{100 * (shares[-1] - 1):.0f} % more error at 7.7 Hz when slow" in text
