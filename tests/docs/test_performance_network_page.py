"""The command on the page of the performance network prints what is shown."""

import re

import pytest
from typer.testing import CliRunner

from tests.docs.snippets import ROOT

PAGE = (ROOT / "docs" / "performance_network.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_command_of_the_page_prints_what_is_shown(tmp_path, monkeypatch):
    import typer

    from leadscrew.cli.tangent_train import train

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


def test_the_best_errors_on_the_page_are_those_of_the_kept_trainings():
    """A network of a smaller error than the page's best, safe or not, would be missing on it."""
    from leadscrew.studies.sofnn_tangent.performance_runs import trainings

    text = " ".join(PAGE.split())
    rows = [r for r in trainings() if r.reading == "18"]

    def best(method, safe):
        return min(
            (r for r in rows if r.method == method and (not safe or -1.5 <= r.slope <= -0.4)), key=lambda r: r.rmse
        )

    assert f"has an RMSE of {best('lm', False).rmse:.3f} levels and the wrong slope" in text
    assert best("lm", False).slope > 0.0
    assert f"the best safe one {best('lm', True).rmse:.3f}" in text
    free = best("lm_free", True)
    assert free.rmse == min(r.rmse for r in rows)
    count = sum(r.rmse < free.rmse + 1e-3 for r in rows if r.method == "lm_free")
    assert f"{count} of 20 starts end at {free.rmse:.3f} with a safe slope of {free.slope:.2f}" in text
