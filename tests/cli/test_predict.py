"""``leadscrew predict``: the scores of the library, sentences that follow from them, and what it refuses."""

import csv

import numpy as np
import pytest

from leadscrew.grey.score import compare
from leadscrew.grey.vectorised import predictions
from tests.cli.conftest import strict_json


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A rise to 150 N within 100 samples, then 1,900 of scatter about it."""
    k = np.arange(2000)
    y = 150.0 * (1.0 - np.exp(-k / 8.0)) + np.random.default_rng(4).normal(size=2000)
    path = tmp_path_factory.mktemp("log") / "cut.csv"
    path.write_text("time,force\n" + "".join(f"{0.02 * a:.2f},{b:.6f}\n" for a, b in zip(k, y, strict=True)))
    return path


def force_of(log):
    return np.loadtxt(log, delimiter=",", skiprows=1)[:, 1]


def test_json_has_the_scores_of_the_library(call, log):
    found = strict_json(call("predict", log, "--model", "dgm11", "--window", 6, "--horizon", 2, "--json").stdout)
    scores, _ = compare(force_of(log), ("dgm11", "last", "line", "two_point"), 6, 2)
    assert [s["model"] for s in found["scores"]] == [s.model for s in scores]
    assert [s["rmse"] for s in found["scores"]] == pytest.approx([s.rmse for s in scores], rel=1e-9)
    assert found["predictions"] == 2000 - 6 - 2 + 1 and found["kind"] == "leadscrew predict"


def test_about_a_set_point_it_says_that_grey_prediction_is_worse(call, log):
    shown = call("predict", log, "--from-row", 100).stdout
    assert "gm11 predicts this signal worse than its last value does (best of the others: last" in shown
    assert "1896 predictions one sample ahead, windows of 5." in shown
    heads, *rows = [line.split() for line in shown.splitlines() if line.startswith(("predictor", "gm11 ", "last"))]
    assert heads[:2] == ["predictor", "RMSE"]
    assert float(rows[0][2]) == pytest.approx(np.sqrt(2.5 / 2.0), abs=0.03)


def test_on_growth_it_says_that_it_is_better(call, tmp_path):
    y = 20.0 * np.exp(0.02 * np.arange(150)) + 0.01 * np.random.default_rng(1).normal(size=150)
    (tmp_path / "grown.csv").write_text("force\n" + "".join(f"{v:.8f}\n" for v in y))
    assert "gm11 predicts this signal better than its last value does" in call("predict", tmp_path / "grown.csv").stdout


def test_the_file_of_predictions_holds_what_was_said_of_each_row(call, log, tmp_path):
    to = tmp_path / "said.csv"
    options = ("--model", "gm11_shifted", "--shift", 150, "--horizon", 3, "--from-row", 11, "--to-row", 60)
    call("predict", log, *options, "--csv", to)
    rows = list(csv.DictReader(to.open()))
    y = force_of(log)
    said = predictions(y[10:60], "gm11_shifted", 5, 3, shift=150.0)
    assert [int(r["row"]) for r in rows] == list(range(18, 61))
    assert [float(r["force"]) for r in rows] == pytest.approx(y[17:60].tolist(), rel=1e-8)
    assert [float(r["gm11_shifted"]) for r in rows] == pytest.approx(said[4:47].tolist(), rel=1e-8)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--column", "forc"), "has no column 'forc'; did you mean force?"),
        (("--window", 3), "--window 3: expected 4 samples or more"),
        (("--horizon", 0), "--horizon 0: expected 1 sample or more"),
        (("--model", "gm1"), "--model 'gm1': there is no such predictor; did you mean gm11"),
        (("--model", "gm11_shifted"), "--shift is missing: --model gm11_shifted needs it, a finite number"),
        (("--model", "gm11_clamped", "--reference", "nan"), "--reference nan: --model gm11_clamped needs it"),
        (("--shift", 3), "--shift 3.0: is read by --model gm11_shifted only, not by gm11"),
        (("--from-row", 300, "--to-row", 200), "expected two rows in order, of 1 to 2000"),
        (("--to-row", 2001), "expected two rows in order, of 1 to 2000"),
        (("--to-row", 12), "12 samples: windows of 5 and a horizon of 1 need at least 15"),
        (("--csv", "out.txt"), "out.txt"),
    ],
)
def test_what_is_refused(refused, log, options, says):
    assert says in refused("predict", log, *options)


@pytest.mark.parametrize("cell", ["nan", "inf", "", "x"])
def test_a_value_that_is_no_number_is_named_with_its_row(refused, tmp_path, cell):
    (tmp_path / "bad.csv").write_text("force,t\n" + "1.0,0\n" * 20 + f"{cell},0\n" + "1.0,0\n" * 5)
    assert "row 22, column 'force'" in refused("predict", tmp_path / "bad.csv")


def test_a_constant_signal_has_no_error_and_no_ratio(call, tmp_path):
    (tmp_path / "flat.csv").write_text("force\n" + "150.0\n" * 40)
    shown = call("predict", tmp_path / "flat.csv").stdout
    assert "gm11 has the RMSE of the last value" in shown and "nan" not in shown


def test_a_log_with_semicolons_and_decimal_commas_is_read_like_any_other(call, tmp_path, log):
    y = force_of(log)[:40]
    plain, odd = tmp_path / "plain.csv", tmp_path / "odd.csv"
    plain.write_text("force,t\n" + "".join(f"{v},{k}\n" for k, v in enumerate(y)))
    odd.write_text("force;t\n" + "".join(f"{v};{k}\n".replace(".", ",") for k, v in enumerate(y)))
    assert call("predict", odd).stdout.replace("odd.csv", "plain.csv") == call("predict", plain).stdout
