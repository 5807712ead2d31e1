"""``leadscrew simulate`` and ``replay``."""

from __future__ import annotations

import json

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.cli.conftest import FILE, strict_json


def simulated(study, *more):
    return ("simulate", study, "--controller", "p", "--scenario", "small", *more)


def test_metrics_come_with_units(call, study):
    found = strict_json(call(*simulated(study, "--json")).stdout)
    assert found["units"] == {"rms_error": "mm", "max_error": "mm"}
    assert found["metrics"]["max_error"] == 1.0 and found["diverged"] is None
    assert found["duration_s"] == 0.2 and found["engine"] == "python"
    out = call(*simulated(study)).stdout
    assert "max_error" in out and "mm" in out


STIFF = """
from leadscrew import Loop, controller
from leadscrew.plants._mass_lugre import mass_lugre
from leadscrew.references._step import step

@controller()
def push(command, feedback):
    return command

LOOP = Loop(reference=step(target=5.0), controller=push, plant=mass_lugre, engine="python", name="pushed")
"""


def test_what_integrated_the_plant_and_why_a_metric_has_no_value_are_printed(call, tmp_path):
    (tmp_path / "stiff.py").write_text(STIFF, encoding="utf-8")
    asked = ("simulate", f"{tmp_path}/stiff.py:LOOP", "--duration", "0.01")
    found = strict_json(call(*asked, "--json").stdout)
    said = {k: found[k] for k in ("method", "substeps", "rtol", "atol")}
    assert said == {"method": "rodas", "substeps": 1, "rtol": 1e-6, "atol": 1e-9}
    reason = "after the last move the response does not pass 90 % of it from below"
    assert found["metrics"]["rise_time"] is None and found["metrics_without_value"]["rise_time"] == reason
    out = call(*asked).stdout
    assert out.startswith("pushed: 0.01 s on python by rodas (rtol 1e-06, atol 1e-09), ")
    assert f"no value: {reason}" in " ".join(out.split())


def test_set_changes_scenario_and_blocks(call, study):
    args = (
        "--set",
        "scenario.target_mm=3",
        "--set",
        "controller.table=[2, 0, 0]",
        "--set",
        "plant.lag_s=0.1",
        "--json",
    )
    found = strict_json(call(*simulated(study, *args)).stdout)
    assert found["metrics"]["max_error"] == 3.0
    assert found["changes"] == {"scenario.target_mm": 3.0, "controller.table": [2.0, 0.0, 0.0], "plant.lag_s": 0.1}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("plant.lag_s=-1", ("plant.lag_s", "-1", "(0, inf)")),
        ("plant.lag_s=nan", ("plant.lag_s", "NaN")),
        ("plant.lag_s=1e999", ("plant.lag_s", "a number")),
        ("plant.lag_s=fast", ("plant.lag_s", "'fast'", "a number", "s")),
        ("plant.lag=1", ("plant.lag", "did you mean plant.lag_s")),
        ("controller.stages=1.5", ("controller.stages", "whole number")),
        ("controller.stages=" + "9" * 400, ("controller.stages", "whole number")),
        ("controller.inverted=maybe", ("controller.inverted", "true or false")),
        ("controller.table=[1, 2]", ("controller.table", "(3,)", "(2,)")),
        ("controller.table=" + "[" * 5000, ("controller.table", "JSON list")),
        ('controller.table={"a": 1}', ("controller.table", "JSON list")),
        ("plant.lag_s", ("plant.lag_s", "KEY=VALUE")),
        ("=1", ("KEY=VALUE",)),
    ],
)  # fmt: skip
def test_a_bad_value_is_refused_with_key_and_what_is_expected(refused, study, change, words):
    said = refused(*simulated(study, "--set", change))
    assert all(word in said for word in words), said


def test_refusals_name_what_there_is(refused, study):
    assert "p_half" in refused("simulate", study, "--scenario", "small")
    assert "small" in refused("simulate", study, "--controller", "p")
    assert "did you mean small" in refused("simulate", study, "-c", "p", "-s", "smal")
    assert "did you mean p_half" in refused("simulate", study, "-c", "p_hal", "-s", "small")
    assert "given twice" in refused(*simulated(study, "--set", "plant.lag_s=1", "--set", "plant.lag_s=2"))
    assert "engine" in refused(*simulated(study, "--engine", "fortran"))
    assert "duration" in refused(*simulated(study, "--duration", "-1"))
    assert "--every" in refused(*simulated(study, "--every", "0"))
    assert "no_such" in refused(*simulated(study, "--record", "no_such"))


def test_a_controller_may_come_from_a_file_or_the_catalogue(call, refused, study):
    found = strict_json(call("simulate", study, "-c", f"{FILE}:half", "-s", "small", "--json").stdout)
    assert found["metrics"]["max_error"] == 1.0
    call("simulate", study, "-c", "duty_pd", "-s", "small")
    assert "is a plant, not a controller" in refused("simulate", study, "-c", "lathe_servo", "-s", "small")


def test_a_file_may_hold_a_loop_or_a_function_that_makes_one(call, refused):
    for name in ("LOOP", "make"):
        found = strict_json(call("simulate", f"{FILE}:{name}", "--duration", "0.1", "--json").stdout)
        assert found["scenario"] is None and found["metrics"]["max_error"] == 1.0
    assert "duration" in refused("simulate", f"{FILE}:LOOP")
    assert "takes no controller" in refused("simulate", f"{FILE}:LOOP", "-c", "p")
    assert "of type int" in refused("simulate", f"{FILE}:NUMBER", "--duration", "1")
    assert "KeyError" in refused("simulate", f"{FILE}:broken", "--duration", "1")


def test_a_diverging_loop_ends_with_code_3_and_keeps_its_signals(call, study, tmp_path):
    unstable = ("--set", "controller.inverted=yes", "--set", "controller.kp=100")
    result = call(*simulated(study, *unstable, "--json", "--out", tmp_path / "run"), code=3)
    found = strict_json(result.stdout)
    assert found["diverged"]["state"] == "actual" and "left its bound" in found["diverged"]["message"]
    assert found["metrics"]["rms_error"] is None
    assert result.stderr.count("\n") == 1 and "diverged at t" in result.stderr
    assert "identical" in call("replay", tmp_path / "run").stdout


def test_signals_are_kept_and_replayed_bit_for_bit(call, study, tmp_path):
    out = tmp_path / "run"
    call(*simulated(study, "--out", out, "--every", "2", "--set", "plant.lag_s=0.07", "--seed", "7"))
    assert sorted(p.name for p in out.iterdir()) == ["run.json", "signals.parquet"]
    origin = json.loads((out / "run.json").read_text())["origin"]
    assert origin == {"study": study, "controller": "p", "scenario": "small", "changes": {"plant.lag_s": 0.07}}
    assert "identical: 100 rows" in call("replay", out).stdout
    found = strict_json(call("replay", out / "run.json", "--json").stdout)
    assert found["identical"] and found["first_difference"] is None and found["changed_since"] == []


def test_finer_integration_steps_are_taken_told_and_replayed(call, refused, study, tmp_path):
    """A user checks whether a result is the plant's or the step's."""
    asked = [simulated(study, "--set", "plant.lag_s=0.002", "--json", *more) for more in ((), ("--substeps", "50"))]
    rough, fine = (strict_json(call(*words).stdout)["metrics"]["rms_error"] for words in asked)
    assert rough != fine and abs(rough / fine - 1.0) < 0.1
    out = tmp_path / "run"
    call(*simulated(study, "--out", out, "--substeps", "4"))
    assert json.loads((out / "run.json").read_text())["substeps"] == 4
    assert "identical" in call("replay", out).stdout
    assert "substeps = 0: allowed are whole numbers from 1" in refused(*simulated(study, "--substeps", "0"))


def test_replay_says_where_the_bits_part(call, study, tmp_path):
    out = tmp_path / "run"
    call(*simulated(study, "--out", out))
    table = pq.read_table(out / "signals.parquet")
    values = table.column("actual").to_numpy().copy()
    values[17] += 2.0**-50
    at = table.column_names.index("actual")
    pq.write_table(table.set_column(at, "actual", pa.array(values)), out / "signals.parquet")
    said = call("replay", out, code=1).stdout
    assert "actual at row 17, t = 0.017 s" in said
    assert not strict_json(call("replay", out, "--json", code=1).stdout)["identical"]


def test_replay_names_a_block_that_changed_since(call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mine = tmp_path / "mine.py"
    mine.write_text(FILE.read_text())
    out = tmp_path / "run"
    call("simulate", f"{mine}:STUDY", "-c", "paper.half", "-s", "small", "--out", out)
    mine.write_text(FILE.read_text().replace("return 0.5 * p.kp", "return 0.25 * p.kp"))
    said = call("replay", out, code=1).stdout
    assert "not identical" in said and "module" in said


def test_what_cannot_be_replayed_is_refused(refused, study, tmp_path, call):
    assert "not a run folder" in refused("replay", tmp_path)
    out = tmp_path / "run"
    call(*simulated(study, "--out", out))
    whole = json.loads((out / "run.json").read_text())
    for key, value, word in (
        ("origin", {}, "origin"),
        ("start_s", 1.0, "live loop"),
        ("schema_version", 99, "schema_version"),
        ("origin", {**whole["origin"], "controller": "gone"}, "gone"),
        ("duration_s", "long", "manifest"),
        ("record", ["nothing"], "nothing"),
    ):
        (out / "run.json").write_text(json.dumps({**whole, key: value}))
        assert word in refused("replay", out)
    (out / "run.json").write_text("{")
    assert "is not JSON" in refused("replay", out)


def test_a_folder_in_use_is_refused_before_anything_runs(refused, study, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    assert "exists already" in refused(*simulated(study, "--out", tmp_path))
    assert (tmp_path / "mine.txt").read_text() == "mine"


EXPERIMENT = """
schema_version = 1
study = "plain_study.py:STUDY"
controller = "p"
scenario = "small"
duration = 0.1
[set]
scenario.target_mm = 2
"plant.lag_s" = 0.04
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """The working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def experiment(tmp_path, text=EXPERIMENT):
    (tmp_path / "plain_study.py").write_text(FILE.read_text())
    path = tmp_path / "mine.toml"
    path.write_text(text)
    return path


def test_an_experiment_file_says_it_all(call, here):
    path = experiment(here)
    found = strict_json(call("simulate", path, "--json").stdout)
    assert found["changes"] == {"scenario.target_mm": 2, "plant.lag_s": 0.04} and found["duration_s"] == 0.1
    more = strict_json(call("simulate", path, "--set", "scenario.target_mm=4", "--duration", "0.05", "--json").stdout)
    assert more["metrics"]["max_error"] == 4.0 and more["duration_s"] == 0.05
    assert "one millimetre" in call("list", path).stdout
    assert "the same" in call("diff", path, "p", "p").stdout


REMOVED = "warning: engine = 'numba': this engine was removed; 'llvm' runs instead and gives the same bits\n"


def test_a_run_of_the_removed_engine_is_replayed_on_llvm(call, study, tmp_path):
    out = tmp_path / "run"
    call(*simulated(study, "--out", out))
    manifest = json.loads((out / "run.json").read_text())
    (out / "run.json").write_text(json.dumps({**manifest, "engine": "numba"}))
    result = call("replay", out)
    assert result.stdout.startswith("identical: 200 rows") and result.stderr == REMOVED


def test_an_experiment_file_that_names_the_removed_engine_runs_on_llvm(call, here):
    path = experiment(here, EXPERIMENT.replace("[set]", 'engine = "numba"\n[set]'))
    result = call("simulate", path, "--json")
    assert strict_json(result.stdout)["engine"] == "llvm" and result.stderr == REMOVED


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("schema_version = 1", "schema_version = 3", ("schema_version",)),
        ("schema_version = 1", "", ("schema_version", "missing")),
        ("duration = 0.1", "duration = -1", ("duration", "-1")),
        ("duration = 0.1", "duration = 'long'", ("duration", "long")),
        ("duration = 0.1", "engine = 'fortran'", ("engine = 'fortran'", "'llvm', 'c' or 'python'")),
        ("duration = 0.1", "durations = 1", ("durations", "did you mean duration")),
        ("scenario.target_mm = 2", "scenario.target = 2", ("scenario.target", "did you mean")),
        ("scenario.target_mm = 2", "scenario.target_mm = 'far'", ("target_mm", "far", "number")),
        ("scenario.target_mm = 2", "scenario.target_mm = -11", ("target_mm", "-11", "[-10, inf)")),
        ("[set]", "[set", ("TOML",)),
    ],
)  # fmt: skip
def test_a_bad_experiment_file_is_refused_with_file_and_key(refused, here, old, new, words):
    assert old in EXPERIMENT
    said = refused("simulate", experiment(here, EXPERIMENT.replace(old, new)))
    assert all(word in said for word in ("mine.toml", *words)), said


def test_a_missing_experiment_file_is_refused(refused, tmp_path):
    assert "there is no file" in refused("simulate", tmp_path / "none.toml")
    assert "leadscrew simulate" in refused("run", experiment(tmp_path))
