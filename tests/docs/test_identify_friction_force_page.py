"""The page on friction from a measured force: its commands, and its numbers of the tribometer where that is at hand."""

from __future__ import annotations

import re

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.figures.table import number
from leadscrew.identify.friction_force import identify_friction_force, read_force_record
from leadscrew.identify.friction_force.result import SLIP, STRIBECK
from leadscrew.report.friction_force import model_table
from tests.docs import sessions
from tests.docs.snippets import ROOT
from tests.fuzzy.formats_systems import shared

PAGE = ROOT / "docs" / "identify_friction_force.md"
TEXT = PAGE.read_text(encoding="utf-8")
pytestmark = pytest.mark.slow


PROSE = " ".join(TEXT.split())


def cells(line):
    return [x.strip() for x in line.strip("|").split("|")]


def test_the_commands_of_the_page_print_what_it_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    steps = [s for s in sessions.steps_of(PAGE) if " identify " in s.command]
    assert len(steps) == 2
    for step in steps:
        done = CliRunner().invoke(app, step.command.split()[1:])
        assert done.exit_code == 0, done.output
        sessions.assert_shown(step, done.stdout)
    head = (tmp_path / "contact.csv").read_text(encoding="utf-8").splitlines()[:4]
    assert "\n".join(head) in TEXT
    assert sorted(p.name for p in (tmp_path / "contact").iterdir()) == [
        "friction.toml", "friction_force.json", "friction_force.png", "report.html",
    ]  # fmt: skip


def test_the_table_of_the_tribometer_is_what_is_found():
    fit = identify_friction_force(read_force_record(shared("data/friction_tribometer/test_data_2.txt")))
    shown = {c[0]: c[1:] for line in TEXT.splitlines() if len(c := cells(line)) == 5}
    rows = model_table(fit).rows
    assert len(rows) == 7
    for name, fitted, held, percent, _, better, _ in rows:
        assert shown[name] == [fitted, held, percent, better]
    f = fit.chosen.friction
    assert f"of {f.forward.coulomb:.2f} and {f.backward.coulomb:.2f} where" in PROSE
    sliding = fit.models[STRIBECK].friction
    assert f"({sliding.forward.coulomb:.3f} forward, {sliding.backward.coulomb:.3f} backward)" in PROSE
    slip = fit.models[SLIP].friction
    assert len(slip.share) == 1
    yields = slip.coulomb / slip.stiffness[0]
    assert f"after {1e6 * yields:.0f} um" in PROSE
    assert f"spring of {5e-3 * slip.stiffness[0]:.0f} N/mm" in PROSE


def test_the_values_of_the_simulated_record_are_what_is_found():
    fit = identify_friction_force(read_force_record(shared("data/friction_tribometer/test_data_1.csv")))
    shown = {c[0]: c[1] for line in TEXT.splitlines() if len(c := cells(line)) == 3}
    for name, key in (
        ("Coulomb coefficient", "coulomb"), ("static coefficient", "static"), ("Stribeck speed, m/s", "stribeck_speed"),
    ):  # fmt: skip
        assert shown[name] == number(fit.chosen.parameters[f"friction.forward.{key}"].value)
    r = fit.record
    column = (r.speed > 0.0) * r.normal - (r.speed < 0.0) * r.normal
    assert re.search(rf"433 rows gives {column @ r.force / (column @ column):.4f}", PROSE)
