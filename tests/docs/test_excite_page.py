"""The page on test moves: what its Python prints, and the files that it lists."""

import re

import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from tests.docs import sessions
from tests.docs.snippets import ROOT, blocks, python_of

PAGE = ROOT / "docs" / "excite.md"


def test_the_python_of_the_page_prints_what_it_shows(capsys):
    exec(compile(python_of(PAGE), str(PAGE), "exec"), {})
    shown = [lines for _, lines in blocks(PAGE, ("text",))][-1]
    assert capsys.readouterr().out.splitlines() == shown


@pytest.mark.slow
def test_the_commands_of_the_page_print_what_it_shows_and_write_the_files_it_lists(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for step in sessions.steps_of(PAGE):
        done = CliRunner().invoke(app, step.command.split()[1:])
        assert done.exit_code == 0, done.output
        sessions.assert_shown(step, done.stdout)
    part = PAGE.read_text(encoding="utf-8").split("## The folder")[1].split("`leadscrew identify axis")[0]
    listed = set(re.findall(r"`([\w.]+\.(?:md|csv|ngc|hal|sh|json))`", part))
    assert {p.name for p in (tmp_path / "mill").iterdir()} == listed
