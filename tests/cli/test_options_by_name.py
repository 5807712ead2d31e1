"""Options by name on the command line and in files, those of 0.1.0 with numbers too."""

import json

import pytest
import typer
from click.testing import CliRunner

from leadscrew import controller_file, experiment
from leadscrew.cli import app
from leadscrew.tune import Job, tune
from leadscrew.tune.space import Space
from leadscrew.util.errors import DataError, ValueRefused

COMMAND = typer.main.get_command(app)
PID = ("simulate", "npid_xytable", "--controller", "paper.pid", "--scenario", "spindle_1000", "--duration", "0.1")


def called(*words, code=0):
    done = CliRunner().invoke(COMMAND, [*map(str, words)])
    assert done.exit_code == code, done.output
    return done.output


def test_list_shows_the_names_and_the_default():
    (row,) = (line for line in called("list", "tfc").splitlines() if line.startswith("inference"))
    assert row.split()[:4] == ["inference", "product", "product,", "minimum"]
    found = {p["key"]: p for p in json.loads(called("list", "tfc", "--json"))["parameters"]}
    assert (found["inference"]["type"], found["inference"]["choices"]) == ("choice", ["product", "minimum"])


@pytest.mark.parametrize("given", ["none", "0"])
def test_set_takes_a_name_or_the_number_of_before_and_the_run_is_saved_with_the_name(tmp_path, given):
    called(*PID, "--set", f"controller.anti_windup={given}", "--out", tmp_path / "run")
    saved = json.loads((tmp_path / "run" / "run.json").read_text())
    assert saved["parameters"]["controller.anti_windup"] == "none"
    assert saved["origin"]["changes"] == {"controller.anti_windup": "none"}
    assert "identical" in called("replay", tmp_path / "run")


def test_a_wrong_name_is_answered_with_the_names_and_the_nearest():
    said = called(*PID, "--set", "controller.anti_windup=clamp", code=2)
    assert (
        "controller.anti_windup = 'clamp' (--set): there are none, clamping, back-calculation; did you mean cl" in said
    )


@pytest.mark.parametrize("value", ['"minimum"', "1"])
def test_files_hold_names_and_those_of_before_numbers(tmp_path, value):
    whole = tmp_path / "experiment.toml"
    whole.write_text(
        'schema_version = 1\nstudy = "grey_turning"\ncontroller = "corrected.tfc_s6"\nscenario = "fig6_fixed_depth"\n'
        f"[set]\ncontroller.inference = {value}\n"
    )
    assert experiment.read(whole).loop().parameters["controller.inference"] == "minimum"
    own = tmp_path / "controller.toml"
    own.write_text(
        'schema_version = 1\nkind = "controller"\nstudy = "grey_turning"\ncontroller = "corrected.tfc_s6"\n'
        f"[set]\ninference = {value}\n"
    )
    tuned = experiment.Experiment("grey_turning", str(own), "fig6_fixed_depth")
    assert tuned.loop().parameters["controller.inference"] == "minimum"
    own.write_text(own.read_text().replace(f"inference = {value}", 'inference = "min"'))
    with pytest.raises(DataError, match=r"inference = 'min' \(\[set\]\): there are product, minimum; did you mean"):
        tuned.loop()


def job():
    return Job(experiment.Experiment("grey_turning", "corrected.gpfc_b_s9", "noise_free"), duration_s=0.2)


@pytest.mark.slow
def test_a_tuning_chooses_among_names_and_its_file_has_the_name(tmp_path):
    from leadscrew.tune.tuned import save

    axis = Job(experiment.Experiment("vud_lathe", "vud_family", "fig11a_step_m50"), duration_s=0.2)
    tuned = tune(axis, {"controller.output_from": "none|error|mean"}, ["rms_error"], budget=8, seed=1)
    assert tuned.vary == {"controller.output_from": "none|error|mean"}
    assert tuned.present == {"controller.output_from": "duty"}
    best = tuned.values["controller.output_from"]
    assert best in ("none", "error", "mean")
    save(axis, tuned, tmp_path / "tuned.toml")
    assert controller_file.read(tmp_path / "tuned.toml").parameters == {"output_from": best}


@pytest.mark.parametrize(
    ("text", "words"),
    [("predictor=two_point|gm12", "there are last, gm11"), ("predictor=0:14:int", r"write last\|gm11"),
     ("predictor=0|15", "there are last, gm11"), ("horizon=one|two", "expected numbers")],
)  # fmt: skip
def test_what_is_no_choice_among_the_names_is_refused_before_anything_runs(text, words):
    with pytest.raises(ValueRefused, match=rf"--vary.*controller.*{words}|controller.*--vary.*{words}"):
        Space.of([f"controller.{text}"]).checked(job().sheet(), "--vary")
    numbers = Space.of(["controller.predictor=6|8"]).checked(job().sheet(), "--vary")
    assert numbers == Space.of(["controller.predictor=two_point|gm11_printed"]).checked(job().sheet(), "--vary")
