"""The page on tangential cutting: its table of pieces, the lines of G-code that it shows, what it says of lengths."""

import re

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.studies.sofnn_tangent import workflow
from tests.docs import sessions
from tests.docs.snippets import ROOT, blocks

PAGE = ROOT / "docs" / "tangent_cutting.md"
TEXT = PAGE.read_text(encoding="utf-8")
DRAWINGS = {
    "wave": "wave",
    "flower": "flower",
    "rounded rectangle": "rrect",
    "`leaf.svg`": "leaf.svg",
    "a DXF with a spline, in inches": "petal.dxf",
}


def test_the_table_has_the_ratios_of_the_study():
    rows = [[c.strip() for c in line.strip("|").split("|")] for line in TEXT.splitlines() if line.startswith("| ")]
    assert rows[0][1:4] == list(workflow.MATERIAL_NAMES) and [r[0] for r in rows[1:]] == list(DRAWINGS)
    for name, *cells in rows[1:]:
        both = [workflow.ratios([DRAWINGS[name]], workflow.MATERIAL_NAMES, scan)[0] for scan in ("exact", "scanner")]
        assert cells == [f"{v:.2f}" for part in both for v in part]


@pytest.mark.slow
def test_the_programs_have_the_lines_that_the_page_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for step in sessions.steps_of(PAGE)[:5]:
        assert CliRunner().invoke(app, step.command.split()[1:]).exit_code == 0
    shown = next("\n".join(lines) for _, lines in blocks(PAGE, ("text",)) if lines[0].startswith("G0"))
    assert shown in (tmp_path / "leaf.ngc").read_text(encoding="utf-8")
    for line in re.findall(r"`(C\S+ \(d [\d.-]+\))`", TEXT):
        assert line in (tmp_path / "leaf2.ngc").read_text(encoding="utf-8")
    arcs = re.search(r"(\d+) arcs at 3000 mm/min", TEXT)
    assert arcs is not None and len(re.findall(r"\nG[123] X", workflow.first_program("flower"))) == int(arcs[1])
