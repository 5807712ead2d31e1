"""The page on the whole lathe: what its Python prints, and its table of removal rates."""

import subprocess
import sys

import pytest

from leadscrew.studies.grey_turning.removal import FUZZY, OURS, REGULATED, Removal, roughness_um
from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "turning_lathe.md"


@pytest.mark.slow
def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


@pytest.mark.slow
def test_the_table_is_that_of_the_study():
    removal = Removal()
    found, seen = removal.accounts("falling"), set()
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        name, *cells = [c.strip().strip("`") for c in line.strip("|").split("|")]
        if line.startswith("|") and name in (*FUZZY, OURS, REGULATED):
            a = found[name]
            assert cells == [
                f"{a.time_s:.1f} s", f"{a.rate:.0f} mm3/s", f"{a.peak_n:.0f} N", f"{a.feed_same_peak:.0f} mm/min",
                f"{a.time_same_peak_s:.0f} s", f"{a.gain:.2f}",
            ], name  # fmt: skip
            seen.add(name)
    assert seen == {*FUZZY, OURS, REGULATED}
    gains = [removal.accounts("mixed")[name].gain for name in (*FUZZY, OURS)]
    assert f"{min(gains):.2f} to\n  {max(gains):.2f}" in PAGE.read_text(encoding="utf-8")
    assert f"{roughness_um(35.5):.2f} um at 1 mm to {roughness_um(116.69):.2f} um" in PAGE.read_text(encoding="utf-8")
