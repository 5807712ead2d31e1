"""The page on force laws: its commands, its notes, its table of the published fit, its refusal."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from leadscrew.identify.cutting_force import fit_forces
from tests.docs import published_cuts, sessions
from tests.docs.snippets import ROOT

PAGE = ROOT / "docs" / "identify_cutting_force.md"
TEXT = PAGE.read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_commands_of_the_page_print_what_it_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    steps = [s for s in sessions.steps_of(PAGE) if " identify " in s.command]
    assert len(steps) == 2
    for step in steps:
        done = CliRunner().invoke(app, step.command.split()[1:])
        assert done.exit_code == 0, done.output
        sessions.assert_shown(step, done.stdout)
    for note in done.stderr.splitlines():
        assert note in TEXT.splitlines()
    assert len(done.stderr.splitlines()) == 2
    assert sorted(p.name for p in (tmp_path / "cut").iterdir()) == [
        "cut.toml", "cutting_force.json", "cutting_force.png", "report.html",
    ]  # fmt: skip


def test_the_table_of_the_published_fit_is_what_is_found():
    rows = {c[0]: c[1:] for line in TEXT.splitlines() if len(c := [x.strip() for x in line.strip("|").split("|")]) == 4}
    for column, measured in ((1, True), (2, False)):
        fit = fit_forces(published_cuts.cuts(published_cuts.FEED_SERIES, measured))
        assert rows["specific force at 1 mm, N/mm2"][column] == f"{fit.law.kf:.1f}"
        assert rows["exponent mc"][column] == f"{1.0 - fit.law.exponent:.3f}"
        assert rows["R2 of ln kc"][column] == f"{fit.chosen.r2['log specific force']:.3f}"
        assert rows["R2 of ln F"][column] == f"{fit.chosen.r2['log force']:.3f}"
        if measured:
            p = fit.chosen.parameters["exponent"]
            assert f"known to {1.0 - p.high:.3f} to {1.0 - p.low:.3f}" in TEXT


def test_the_errors_on_eight_cuts_are_those_that_the_page_says():
    said = re.search(r"their law is off by ([\d.]+) % and ours\nby ([\d.]+) %", TEXT)
    ours = fit_forces(published_cuts.cuts(published_cuts.DISTINCT)).law
    for shown, law in zip(said.groups(), (published_cuts.PUBLISHED, ours), strict=True):
        off = np.array(published_cuts.FORCE) / law.force(published_cuts.FEED, published_cuts.DEPTH) - 1.0
        assert float(shown) == pytest.approx(100.0 * np.sqrt(np.mean(off**2)), abs=0.005)
    assert (150.0 / ours.kf) ** (1.0 / ours.exponent) == pytest.approx(0.06, abs=0.005)
    assert "about 0.06 mm/rev" in TEXT


def test_the_refusal_of_the_page_is_the_one_that_comes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "metres.csv").write_text("f,ap,Fc\n0.1,0.001,330\n0.2,0.001,560\n0.4,0.001,960\n", encoding="utf-8")
    done = CliRunner().invoke(app, ["identify", "cutting-force", "metres.csv"])
    assert done.exit_code == 2 and done.stderr.strip() in TEXT.splitlines()
