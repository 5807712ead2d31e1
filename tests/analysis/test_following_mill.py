"""Acceptance: all 18 logs of the UMich CNC mill in one command; following error and lag by axis and phase."""

import csv
import json

import numpy as np
import pytest
from typer.testing import CliRunner

from leadscrew.cli import app
from tests.fuzzy.formats_systems import shared

PHASES = {"all", "prep", "repositioning", "end", "starting", *(f"layer {k} {w}" for k in "123" for w in ("up", "down"))}


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mill")
    logs = str(shared("data/cnc_mill_umich") / "experiment_*.csv")
    done = CliRunner().invoke(
        app, ["following-error", logs, "--period", "0.1", "--by", "Machining_Process", "--json", "--out",
              str(folder / "report"), "--csv", str(folder / "all.csv")],
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout), folder


@pytest.mark.slow
def test_all_18_files_in_one_command_by_axis_and_phase(seen):
    found, folder = seen
    assert len(found["logs"]) == 18
    rows = {(r["axis"], r["phase"]): r for r in found["together"]}
    assert set(rows) == {(axis, phase) for axis in ("X1", "Y1", "Z1", "S1") for phase in PHASES}
    assert rows["Y1", "all"]["rows"] == 25286 and rows["X1", "all"]["rows"] == 25285
    for axis in ("X1", "Y1", "Z1", "S1"):
        parts = [r["rows"] for (a, p), r in rows.items() if a == axis and p != "all"]
        assert sum(parts) == rows[axis, "all"]["rows"]
    with (folder / "all.csv").open() as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(found["together"]) + len(found["each"])
    assert {p.name for p in (folder / "report").iterdir()} == {
        "report.html", "following_error.json", "following_error.csv", "following_error.png",
    }  # fmt: skip


@pytest.mark.slow
def test_lags_agree_with_a_plain_regression_of_rows_that_were_written_finely(seen):
    """NumPy alone, on Y below 100 mm, where positions have a step of 0.1 mm."""
    found, _ = seen
    error, speed = [], []
    for path in sorted(shared("data/cnc_mill_umich").glob("*.csv")):
        with path.open() as file:
            rows = [r for r in csv.DictReader(file) if float(r["Y1_CommandPosition"]) < 99.0]
        error += [float(r["Y1_CommandPosition"]) - float(r["Y1_ActualPosition"]) for r in rows]
        speed += [float(r["Y1_CommandVelocity"]) for r in rows]
    moving = np.abs(speed) > 0.5
    slope = np.polyfit(np.array(speed)[moving], np.array(error)[moving], 1)[0]
    row = next(r for r in found["together"] if (r["axis"], r["phase"]) == ("Y1", "all"))
    lag = row["lag_s"]
    assert lag["value"] == pytest.approx(slope, rel=0.02) and lag["low"] < slope < lag["high"]
    assert row["shift_s"]["low"] < slope < row["shift_s"]["high"]
    assert lag["high"] - lag["low"] < 0.4e-3


@pytest.mark.slow
def test_what_is_odd_is_named_and_nothing_else_is(seen):
    found, _ = seen
    kinds = {name[-6:-4]: {f["kind"] for f in said} for name, said in found["findings"].items()}
    assert [k for k, v in kinds.items() if "order" not in v] == ["01"]
    assert [k for k, v in kinds.items() if "torn" in v] == ["02"]
    assert [k for k, v in kinds.items() if "frozen" in v] == ["02", "05", "11", "12"]
    assert all("rounding" in v and "period" not in v for v in kinds.values())
    assert [k for k, v in kinds.items() if "phase" in v] == ["05"]


@pytest.mark.slow
def test_a_wrong_period_of_the_mill_is_noticed():
    logs = str(shared("data/cnc_mill_umich") / "experiment_01.csv")
    done = CliRunner().invoke(app, ["following-error", logs, "--period", "0.01", "--json"])
    assert done.exit_code == 0
    (findings,) = json.loads(done.stdout)["findings"].values()
    assert any(f["kind"] == "period" for f in findings)
