"""The page on friction from one log: its record, its command and its table."""

import re
import runpy

import pytest

from leadscrew.identify.friction_file import identify_file
from leadscrew.plants._ballscrew_stage import INERTIA, ballscrew_stage
from tests.docs.snippets import ROOT, python_of

PAGE = ROOT / "docs" / "identify_friction.md"


@pytest.mark.slow
def test_the_table_shows_what_the_command_finds(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "page.py").write_text(python_of(PAGE), encoding="utf-8")
    runpy.run_path("page.py")
    fit = identify_file("test.csv", travel_per_rad=1.5923)
    true, found = ballscrew_stage.params.friction, fit.friction
    names = ("stiffness", "damping", "viscous", "coulomb", "static", "stribeck_speed")
    expected = [(getattr(true, n), getattr(found, n)) for n in names] + [(INERTIA, fit.inertia)]
    rows = re.findall(
        r"^\| [^|]+, [^|]+ \| ([\d.e-]+) \| ([\d.e-]+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE
    )
    assert len(rows) == len(expected)
    for shown, values in zip(rows, expected, strict=True):
        for text, value in zip(shown, values, strict=True):
            assert float(text) == pytest.approx(value, rel=2e-4)
    assert abs(found.damping - true.damping) < 1.96 * fit.standard_error["damping"] < 0.01 * true.damping
