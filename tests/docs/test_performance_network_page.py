"""The numbers on the page of the performance network are the study's, and its command prints what is shown."""

import re

import pytest
from typer.testing import CliRunner

from leadscrew.neural.performance_shape import READINGS
from leadscrew.neural.safety import safety
from leadscrew.studies.sofnn_tangent.claims_performance import performance_claims
from leadscrew.studies.sofnn_tangent.performance_runs import nets, of, trainings
from tests.docs.snippets import ROOT

PAGE = (ROOT / "docs" / "performance_network.md").read_text(encoding="utf-8")
TEXT = " ".join(PAGE.split())


def test_what_the_page_says_of_the_table_is_counted():
    value = {c.id.removeprefix("sofnn_tangent."): c.measured for c in performance_claims()}
    assert f"({value['table_uneven_pairs']:.0f} of 84 mirrored pairs do not cancel)" in TEXT
    assert f"({value['table_rises_e'] + value['table_rises_ec']:.0f} steps go the wrong way)" in TEXT
    assert f"even part, {value['table_even_rms']:.3f} levels" in TEXT


def test_what_the_page_says_of_unsafe_trainings_is_counted():
    wrong = {m: sum(r.slope >= 0.0 for r in of("18", m)) for m in ("lm", "ga_80x600")}
    assert f"Of {len(of('18', 'lm'))} least-squares trainings from random starts {wrong['lm']} have" in TEXT
    assert f"of {len(of('18', 'ga_80x600'))} by the genetic algorithm alone {wrong['ga_80x600']};" in TEXT
    found = safety(nets()["min_rmse"])
    assert f"smallest RMSE of all ({found.rmse:.3f}) has a slope of {found.slope:.2f}" in TEXT
    biased = max(abs(r.origin) for r in trainings() if r.reading == "25" and r.method != "lm_free")
    assert f"up to {biased:.1f} levels" in TEXT


def test_what_the_page_says_to_expect_is_what_came():
    alone = [r.rmse for r in of("18", "ga_80x600")]
    assert f"ends at {min(alone):.2f} to {max(alone):.2f} levels" in TEXT
    assert all(r.exact == 1.0 for r in of("hidden_30", "lm") if r.rmse == min(x.rmse for x in of("hidden_30", "lm")))
    best = sorted((r for m in ("lm", "cma_48k") for r in of("18", m)), key=lambda r: r.rmse)[:12]
    low, high = re.search(r"RMSE of (0\.\d+) to (0\.\d+) levels, with", TEXT).groups()
    assert all(float(low) - 0.005 <= r.rmse <= float(high) + 0.005 for r in best)
    low, high = re.search(r"with (\d+) to (\d+) % of the cells exact", TEXT).groups()
    assert all(float(low) - 0.5 <= 100.0 * r.exact <= float(high) + 0.5 for r in best)
    assert [READINGS[n].weights for n in ("18", "19", "24", "25", "16_four_hidden", "16_five_hidden")] == [
        18, 19, 24, 25, 16, 16,
    ]  # fmt: skip


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
