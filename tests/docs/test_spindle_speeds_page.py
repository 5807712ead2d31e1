"""The page on fast spindles: what its Python prints, and its numbers against the study."""

import re
import subprocess
import sys

import pytest

from tests.docs.snippets import ROOT, assert_printed, shown, with_marks
from tests.studies.whole import claims_of

PAGE = ROOT / "docs" / "spindle_speeds.md"
ROWS = {
    "PID, Table I": "pid",
    "NPID, um": "npid_um",
    "retuned PID, Ms 1.59": "pid_ms_159",
    "retuned PID, Ms 1.85": "pid_ms_185",
    "Ms 1.59 with resonators": "resonant",
}


@pytest.mark.slow
def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


@pytest.mark.slow
@pytest.mark.xdist_group("whole npid_xytable")
def test_the_numbers_of_the_page_are_those_of_the_study():
    from leadscrew.studies.npid_xytable.spindle_sweep import RPM

    claims = {n.removeprefix("sweep_"): c for n, c in claims_of("npid_xytable").items() if n.startswith("sweep_")}
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    for row, name in ROWS.items():
        cells = []
        for what in ("spindle", "tooth"):
            claim = claims[f"worst_{what}_{name}"]
            speed = re.search(r"at ([\d,]+) 1/min", claim.reason)[1]
            cells.append(f"{claim.measured:.3f} at {speed} 1/min")
        assert f"| {row} | {cells[0]} | {cells[1]} |" in text
    assert f"{claims['retuned_is_worse'].measured:.1f}-fold at the spindle line" in text
    speeds = re.search(r"1.1-fold from ([\d,]+) to ([\d,]+) 1/min", claims["retuned_is_worse"].reason)
    assert f"between {speeds[1]} and {speeds[2]} 1/min" in text
    assert f"{claims['npid_chatter'].measured:.1f} times the error of PID" in text
    assert f"{claims['ghost_motion'].measured:.1f} times the motion without it" in text
    assert f"at {len(RPM)} speeds from {RPM[0]:.0f} to {RPM[-1]:,.0f} 1/min" in text
    assert all(claims[f"closed_form_{n}"].passed for n in ("pid", "pid_ms_159", "pid_ms_185"))
    assert claims["resonators_take_the_lines"].measured < 0.01
