"""The page on stability: what its Python prints, and the numbers in its text."""

import re
import subprocess
import sys

import pytest

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.switching import worst_switching
from leadscrew.controllers._npid import npid
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from tests.docs.snippets import ROOT, assert_printed, shown, with_marks

PAGE = ROOT / "docs" / "stability.md"


@pytest.mark.slow
def test_the_python_of_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert all(shown(PAGE))


def test_the_limits_in_the_text_are_those_of_the_loop():
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    loop = reference_loops()["L_star"]
    said = re.search(
        r"the circle reaches ([\d.]+), a constant gain ([\d.]+), and the worst switching .* ([\d.]+)\. The", text
    )
    assert said is not None
    found = (ask("circle", loop, 1.0).limit, loop.gain_limit(), worst_switching(loop).high)
    assert [float(x) for x in said.groups()] == [round(found[0], 3), round(found[1], 2), round(found[2], 3)]


def test_the_load_named_in_the_text_lies_where_the_slope_passes_the_gain_margin():
    """A load worth 3 um of phi: phi(e) = 3 um has its slope above the limit, one of 2.5 um does not."""
    from scipy.optimize import brentq

    from leadscrew.controllers._npid import scaled_error, slope

    limit = reference_loops()["L_star"].gain_limit()
    p = npid.params
    for um, above in ((3.0, True), (2.5, False)):
        e = brentq(lambda e, f=um: 1e3 * scaled_error(p, e) - f, 0.0, 0.01)
        assert (slope(p, e) > limit) is above
