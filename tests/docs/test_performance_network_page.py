"""The command on the page of the performance network prints what is shown."""

import re

import pytest
from typer.testing import CliRunner

from tests.docs.snippets import ROOT

PAGE = (ROOT / "docs" / "performance_network.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_command_of_the_page_prints_what_is_shown(tmp_path, monkeypatch):
    import typer

    from leadscrew.cli.tangent import train

    app = typer.Typer()
    app.command("train")(train)
    app.callback()(lambda: None)
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["train", "--seed", "2", "-o", "net.json"])
    assert done.exit_code == 0
    shown = re.search(r"\$ leadscrew tangent train --seed 2 -o net.json\n(.*?)```", PAGE, re.DOTALL)[1]

    def rows(text):
        lines = [re.sub(r"in [\d.]+ s$", "", line).split() for line in text.splitlines() if "─" not in line]
        return [line for line in lines if line]

    assert sorted(rows(shown)) == sorted(rows(done.output))
