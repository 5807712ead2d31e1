"""The tables of the VUD pages hold what the study measures now."""

import math
from pathlib import Path

import pytest

from leadscrew.studies.vud_lathe.runs import STEPS, Loops

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def loops():
    return Loops()


def rows(page):
    """Cells of the rows that begin with a name of a controller."""
    for line in (DOCS / page).read_text(encoding="utf-8").splitlines():
        cells = [c.strip() for c in line.strip("|").split("|")]
        if line.startswith("|") and cells[0].startswith(("`paper.", "`corrected.", "`ours.")):
            yield cells[0].strip("`"), cells[1:]


def metrics(loops, controller, machine=None):
    seconds = 32.0 if controller == "paper.vud" else 4.0
    return [loops.run(controller, s, seconds, machine=machine).metrics for s in STEPS]


@pytest.mark.slow
def test_every_variant_of_the_page_settles_when_the_table_says(loops):
    seen = 0
    for controller, cells in rows("vud.md"):
        digits = 1 if controller == "paper.vud" else 2
        found = [m["settling_2um"] for m in metrics(loops, controller)]
        said = " / ".join("–" if math.isnan(t) else f"{t:.{digits}f}" for t in found)
        assert cells[1] == said, controller
        seen += 1
    assert seen > 10


def test_the_errors_of_the_page_are_those_of_the_study(loops):
    for controller, cells in rows("vud.md"):
        if cells[3].endswith(" um"):
            worst = 1e3 * max(m["error_after_2s"] for m in metrics(loops, controller))
            assert cells[3] == f"{worst:.2f} um", controller


def test_the_fast_settings_do_what_their_page_says(loops):
    tried = [(c, cells) for c, cells in rows("vud_fast.md") if cells[0].startswith("0.")]
    assert len(tried) == 3
    for controller, cells in tried:
        machine = "limited" if controller.endswith("limited") else None
        found = metrics(loops, controller, machine)
        assert cells[:2] == [f"{m['settling_2um']:.3f}" for m in found], controller
        assert cells[2] == f"{1e3 * max(m['overshoot'] for m in found):.1f}", controller
        assert cells[3] == f"{1e3 * max(m['error_after_2s'] for m in found):.2f}", controller
