"""``leadscrew design npid``: what it prints, what it writes, and what it refuses with nothing written."""

import pytest

from leadscrew import controller_file, resolve
from leadscrew.cli.design import runs_in
from leadscrew.util.errors import ValueRefused
from tests.cli.conftest import left, strict_json


@pytest.mark.slow
def test_the_file_is_a_controller_that_certify_and_simulate_take(call, tmp_path):
    out, plot = tmp_path / "designed.toml", tmp_path / "map.png"
    said = call("design", "npid", "-o", out, "--plot", plot).stdout
    heads = [line for line in said.splitlines() if line[:1].isdigit()]
    assert heads == ["1. axis", "2. PID", "3. limits", "4. search", "5. result"]
    assert "what binds: the slope stands at its limit of stability under command and load" in said
    assert f"{out}: the controller" in said and plot.stat().st_size > 20_000
    read = controller_file.read(out)
    assert (read.study, read.controller) == ("npid_xytable", "npid_slope")
    assert read.tuning["made_by"] == "leadscrew design npid"
    proved = call("certify", "npid_xytable", "-c", out, "--no-simulate", "--reserve", 1.09, "--proof").stdout
    assert "CERTIFIED: npid_slope is stable under every command and load" in proved
    run = strict_json(call("simulate", "npid_xytable", "-c", out, "-s", "measured_1000", "--json").stdout)
    assert run["metrics"]["rms_error"] < 3e-3


@pytest.mark.slow
def test_as_paper_puts_both_side_by_side_and_draws_them(call, tmp_path):
    plot = tmp_path / "both.png"
    said = call("design", "npid", "--as-paper", "--plot", plot).stdout
    for step in ("1. PID gains (Table I)", "3. limit of the gain, equation (3)", "alpha = acosh(2.35)/3 = 0.4996"):
        assert step in said
    assert said.index("THE PAPER'S PROCEDURE") < said.index("OURS") < said.index("largest slope")
    row = next(line for line in said.splitlines() if line.startswith("largest slope"))
    assert row.split() == ["largest", "slope", "5.546", "2.059"]
    assert plot.stat().st_size > 40_000


@pytest.mark.slow
def test_json_holds_the_limits_the_grid_and_what_binds(call):
    found = strict_json(call("design", "npid", "--law", "cosh", "--retune", 1.6, "--json").stdout)
    assert found["schema_version"] == 1 and found["controller"] == "npid" and found["paper"] is None
    assert found["retuned"]["ms"] == pytest.approx(1.6, rel=1e-3) and found["limits"]["driven"] > 2.9
    assert found["binding"] and len(found["grid"]) == 90
    assert found["parameters"]["alpha"] * found["parameters"]["e_max"] == pytest.approx(found["best"]["strength"])


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["-o", "x.json"], "ends in .toml"),
        (["--plot", "x.bmp"], ".png, .svg, .pdf"),
        (["--law", "cubic"], "there are slope"),
        (["--rate", "0"], "must be positive"),
        (["--m1", "0.5"], "a margin is a factor from 1 on"),
        (["--kd", "0.03"], "makes an unstable loop"),
        (["--dead-time", "9"], "at most 4 periods"),
        (["--study", "npid_xytabel", "-o", "x.toml"], "npid_xytable"),
        (["--study", "nosuch"], "nosuch"),
    ],
)
def test_options_that_cannot_be_are_refused_and_nothing_is_written(refused, tmp_path, monkeypatch, args, said):
    monkeypatch.chdir(tmp_path)
    assert said in refused("design", "npid", *args)
    assert left(tmp_path) == []


@pytest.mark.slow
def test_a_study_with_another_drive_gets_no_file(refused, tmp_path):
    said = refused(
        "design", "npid", "--study", "fsmc_ballscrew", "-o", tmp_path / "x.toml", "--plot", tmp_path / "x.png"
    )
    assert "--study fsmc_ballscrew: the designed controller cannot run in this study" in said
    assert "npid_slope commands a voltage, and ballscrew_stage takes a torque" in said and "nothing is written" in said
    assert left(tmp_path) == []


def test_a_controller_is_tried_in_the_study_that_its_file_names():
    blocks = (resolve.block("npid_slope"), resolve.block("npid"))
    for block in blocks:
        runs_in(resolve.study("npid_xytable"), block, "npid_xytable")
        with pytest.raises(
            ValueRefused,
            match=f"--study here: .* {block.name} commands a voltage, and ballscrew_stage takes a torque",
        ):
            runs_in(resolve.study("fsmc_ballscrew"), block, "here")
