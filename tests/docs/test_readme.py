"""What the README says in a line of its text works when it is typed in a clone."""

import json
import re

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from tests.docs.snippets import ROOT


@pytest.mark.slow
def test_the_fuzzy_controller_of_the_readme_reaches_its_target(monkeypatch):
    """Within 1 % of -50 mm before the run ends, without a note."""
    monkeypatch.chdir(ROOT)
    recipes = re.findall(r"`leadscrew (simulate [^`]*)`", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert recipes
    for recipe in recipes:
        found = json.loads(CliRunner().invoke(app, [*recipe.split(), "--json"]).stdout)
        assert found["notes"] == []
        assert found["metrics"]["settling_1pct"] < found["duration_s"]


@pytest.mark.slow
def test_the_same_system_without_scales_says_what_is_wrong(monkeypatch):
    monkeypatch.chdir(ROOT)
    args = ["simulate", "vud_lathe", "-s", "fig11a_step_m50", "-c", "examples/axis.fll"]
    found = json.loads(CliRunner().invoke(app, [*args, "--json"]).stdout)
    assert [n["kind"] for n in found["notes"]] == ["moved_away", "outside_range"]
    text = CliRunner().invoke(app, args).stderr
    assert "controller.scale_output=-1" in text and "controller.scale_e=0.02" in text
