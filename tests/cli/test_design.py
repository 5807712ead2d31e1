"""``leadscrew design vud``: what it prints, what it writes, and what it refuses with nothing written."""

import numpy as np
import pytest

from leadscrew import controller_file, resolve
from leadscrew.controllers._vud.universe import TABLE_2
from leadscrew.export.folder import compiler_path
from tests.cli.conftest import left, strict_json
from tests.design.moves import TABLE_1, rows, swapped, write
from tests.tools import missing


def test_each_step_is_printed_with_what_is_data_and_what_is_not(call):
    said = call("design", "vud", TABLE_1).stdout
    heads = [line for line in said.splitlines() if line[:1].isdigit()]
    assert heads == ["1. log", "2. universes", "3. curvature", "4. sets", "5. rules", "6. factors"]
    assert "the sign of ec is turned in r=50, r=190" in said
    assert "condition number 45.2, allowed is 30" in said and "condition number 488" in said
    assert "8 of 36 cells covered (22.2 %), 4 in conflict" in said
    assert "6 of 8 covered cells agree with the printed Table 2" in said
    assert "completion, which is not data:" in said and "36 of 36 cells are those of Table 2" in said
    assert "makes the axis creep" in said


def test_json_holds_every_step(call):
    found = strict_json(call("design", "vud", TABLE_1, "--curvature", "1.96,1.35", "--json").stdout)
    assert found["schema_version"] == 1 and found["out"] is None
    assert found["sets"]["count"] == {"half": 3, "full": 6, "intervals": 5} and found["sets"]["reading"] is None
    assert found["rules"]["learning"]["covered"] == 8 and found["rules"]["learning"]["conflicts"] == 4
    assert found["rules"]["compared_with_table_2"] == {
        "agree": 6, "other": [["NS", "PM"], ["PS", "NM"]], "equal_cells": 36,
    }  # fmt: skip
    assert found["log"]["turned"] == ["r=50", "r=190"]
    assert found["curvature"]["values"] == [1.96, 1.35] and len(found["curvature"]["attempts"]) == 2


def test_the_file_is_a_controller_that_says_where_it_comes_from(call, tmp_path):
    out = tmp_path / "table1.toml"
    args = ["--rate-scale", 25.87, "--levels", "0.333,0.677,1"]
    assert f"{out}: the controller" in call("design", "vud", TABLE_1, *args, "-o", out).stdout
    read = controller_file.read(out)
    assert (read.study, read.controller) == ("vud_lathe", "vud_beta_e")
    assert read.tuning["made_by"] == "leadscrew design vud"
    block = resolve.from_controller_file(out)
    assert np.array_equal(block.params.rules, TABLE_2) and block.params.rate_full_scale_mm == 25.87
    assert "made by leadscrew design vud" in call("list", out).stdout


def test_simulate_and_export_take_the_file(call, tmp_path):
    out = tmp_path / "designed.toml"
    call("design", "vud", TABLE_1, "--rate-scale", 25.87, "--levels", "0.333,0.677,1", "-o", out)
    args = ["--scenario", "fig11a_step_m50", "--duration", 2, "--json"]
    ours = strict_json(call("simulate", "vud_lathe", "-c", out, *args).stdout)["metrics"]
    corrected = strict_json(call("simulate", "vud_lathe", "-c", "corrected.vud_beta_e", *args).stdout)["metrics"]
    assert ours == corrected
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    folder = tmp_path / "machine"
    call("export", "vud_lathe", "-c", out, "--target", "c99", "--duration", 0.5, "--out", folder)
    assert (folder / "designed.c").exists()


@pytest.mark.slow
def test_a_log_of_simulate_out_becomes_a_controller_that_tune_takes(call, tmp_path):
    folders = []
    for scenario in ("fig11a_step_m50", "step_p50", "step_m190", "step_p190"):
        folders.append(tmp_path / scenario)
        call("simulate", "vud_lathe", "-c", "ours.original_fit", "-s", scenario, "--duration", 2, "--out", folders[-1])
    out, tuned = tmp_path / "own.toml", tmp_path / "tuned.toml"
    assert "4 moves" in call("design", "vud", *folders, "-o", out).stdout
    metrics = strict_json(call("simulate", "vud_lathe", "-c", out, "-s", "fig11b_step_m170", "--json").stdout)[
        "metrics"
    ]
    assert metrics["settling_2um"] < 1.7
    call("tune", "vud_lathe", "-c", out, "--vary", "controller.output_gain=1:3", "--minimise", "settling_2um",
         "--budget", 8, "-o", tuned)  # fmt: skip
    assert controller_file.read(tuned).parameters["output_gain"] >= 1.0


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (swapped("ec", "rho"), "columns look swapped: rho is the change of e"),
        (swapped("e", "ec"), "columns look swapped: e is the change of ec"),
        (rows()[:3], "a rule base needs 10 at least"),
        ([{**r, "rho": "0.5"} for r in rows()], "rho is always 0.5"),
        ([{**r, "e": "0.5"} for r in rows()], "e is always 0.5"),
        ([{**r, "e": "2"} for r in rows()], "row 2, column 'e': 2 is outside [-1, 1]"),
    ],
)
def test_logs_that_cannot_be_are_refused_and_nothing_is_written(refused, tmp_path, wanted, said):
    log = write(tmp_path / "log.csv", wanted)
    assert said in refused("design", "vud", log, "-o", tmp_path / "out.toml")
    assert left(tmp_path) == ["log.csv"]


@pytest.mark.parametrize(
    ("extra", "said"),
    [
        (["-o", "x.fis"], "ends in .toml"),
        (["--curvature", "1,x"], "expected numbers with commas"),
        (["--curvature", "1.96"], "expected u_ee and u_cc"),
        (["--reading", "full"], "the log carries none"),
        (["--curvature", "1.96,1.35", "--reading", "best"], "half, full, intervals"),
        (["--sets", "6", "--centres", "-1,1"], "one of them alone"),
        (["--law", "pid"], "vud_beta_e, vud"),
        (["--complete", "servo_grow"], "servo_growth"),
        (["--interval", "0"], "interval_s = 0"),
    ],
)
def test_options_that_cannot_be_are_refused(refused, extra, said):
    assert said in refused("design", "vud", TABLE_1, *extra)


def test_a_study_that_does_not_exist_is_refused_before_anything_is_written(refused, tmp_path):
    said = refused("design", "vud", TABLE_1, "--study", "vud_lath", "-o", tmp_path / "out.toml")
    assert "vud_lathe" in said and left(tmp_path) == []


def test_a_file_that_is_there_is_kept(refused, tmp_path):
    out = tmp_path / "mine.toml"
    out.write_text("mine")
    assert "exists already" in refused("design", "vud", TABLE_1, "-o", out)
    assert out.read_text() == "mine"
