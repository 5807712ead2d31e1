"""The page on sliding mode: what its Python prints."""

import re
import subprocess
import sys

import pytest

from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "sliding_mode.md"


@pytest.mark.slow
def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pd_dob", "ours.pd_dob_aggressive", "super_twisting"])
def test_the_errors_of_the_table_are_those_of_the_runs_that_it_describes(name):
    """Two periods of the slow sines and 4 s of the fast one, the second half, to the printed digits."""
    from leadscrew.catalogue import study

    text = PAGE.read_text(encoding="utf-8")
    row = re.findall(rf"^\| `{name}`[^|]*\|(.*/.*)\| \d+ \|$", text, re.MULTILINE)[-1]
    of = study("fsmc_ballscrew")
    for cell, scenario in zip(row.split("|"), ("sine_slow", "sine_wide", "sine_fast"), strict=True):
        run = of.loop(f"ours.{name.removeprefix('ours.')}", scenario).run(of.scenarios[scenario].duration_s)
        error = 1e3 * run["true_error"][len(run.time) // 2 :]
        rms = float((error @ error / len(error)) ** 0.5)
        for digits, value in zip(cell.replace("*", "").split("/"), (abs(error).max(), rms), strict=True):
            last = 10.0 ** -len(digits.strip().partition(".")[2])
            assert float(digits) == pytest.approx(value, abs=0.51 * last), (scenario, cell)
