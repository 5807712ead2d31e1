"""The page on following errors shows what the command prints for the mill's logs."""

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from tests.docs import sessions
from tests.docs.snippets import ROOT, blocks, python_of
from tests.fuzzy.formats_systems import shared

PAGE = ROOT / "docs" / "following_error.md"


@pytest.mark.slow
def test_the_sessions_of_the_page_print_what_it_shows(tmp_path, monkeypatch):
    (tmp_path / "cnc_mill_umich").symlink_to(shared("data/cnc_mill_umich"))
    monkeypatch.chdir(tmp_path)
    session, odd = (lines for _, lines in blocks(PAGE, ("text",))[:2])
    steps = []
    for line in session:
        if line.startswith("$ "):
            steps.append(sessions.Step(line.removeprefix("$ "), [], []))
        else:
            steps[-1].shown.append(line)
    refused, told = (CliRunner().invoke(app, s.command.split()[1:]) for s in steps)
    assert refused.exit_code == 2 and refused.stderr.strip() == steps[0].shown[0]
    assert told.exit_code == 0, told.output
    sessions.assert_shown(steps[1], told.stdout)
    assert all(line in told.stdout for line in odd)
    assert (tmp_path / "mill.png").exists()
    common = next(line for line in told.stdout.splitlines() if line.startswith("one lag of "))
    assert f"same {common.split()[3]} to {common.split()[5]} ms" in PAGE.read_text(encoding="utf-8")


def test_the_python_of_the_page_prints_what_it_shows(capsys):
    exec(compile(python_of(PAGE), str(PAGE), "exec"), {})
    shown = [lines for _, lines in blocks(PAGE, ("text",))][-1]
    assert capsys.readouterr().out.splitlines() == shown
