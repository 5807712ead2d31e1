"""A controller with its parameters in a file: a name wherever a controller is named."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from leadscrew import controller_file, experiment, names, resolve
from leadscrew.controller_file import ControllerFile
from leadscrew.experiment import Experiment
from leadscrew.replay import replay
from leadscrew.tune import tuned
from leadscrew.tune.job import Job
from leadscrew.tune.tuner import tune
from leadscrew.util.errors import DataError

PLAIN = f"{Path(__file__).parents[1] / 'cli' / 'plain_study.py'}:STUDY"
HEAD = 'schema_version = 1\nkind = "controller"\nstudy = "vud_lathe"\ncontroller = "corrected.vud_beta_e"\n'


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.toml"
    controller_file.write(
        path, ControllerFile(PLAIN, "p", {"kp": 4.5, "stages": 2, "inverted": False, "table": np.array([2.0, 0, 1])})
    )
    return path


def test_it_says_what_the_changes_say(file):
    changes = {"controller.kp": 4.5, "controller.stages": 2, "controller.table": [2.0, 0, 1]}
    a = Experiment(PLAIN, "p", "small", changes).loop().run(0.2)
    b = Experiment(PLAIN, str(file), "small").loop().run(0.2)
    assert a.metrics == b.metrics
    assert np.array_equal(a.signals["true_error"], b.signals["true_error"])


def test_changes_go_before_the_file_and_show_its_values_as_defaults(file):
    loop = Experiment(PLAIN, str(file), "small", {"controller.kp": 7.0}).loop()
    assert loop.parameters["controller.kp"] == 7.0 and loop.parameters["controller.stages"] == 2
    assert Experiment(PLAIN, str(file), "small").settable()["controller.kp"].default == 4.5


def test_a_run_of_it_is_replayed_and_a_changed_file_is_named(file, tmp_path):
    Experiment(PLAIN, str(file), "small").loop().run(0.2).save(tmp_path / "run")
    assert replay(tmp_path / "run").identical
    controller_file.write(file, ControllerFile(PLAIN, "p", {"kp": 1.0}))
    causes = replay(tmp_path / "run").causes
    assert any("mine.toml is not the file that it was" in c for c in causes)


def test_it_is_a_block_by_name_and_an_experiment_by_itself(file):
    assert resolve.block(str(file)).params.kp == 4.5
    found = experiment.read(file)
    assert (found.study, found.controller) == (PLAIN, str(file))
    assert names.stem(str(file)) == "mine"
    assert names.absolute("a.toml") == str(Path("a.toml").resolve())


def test_a_fuzzy_system_may_be_its_controller(tmp_path):
    (tmp_path / "f.fis").write_text("x")
    (tmp_path / "c.toml").write_text(HEAD.replace("corrected.vud_beta_e", "f.fis"))
    assert set(resolve.digests(str(tmp_path / "c.toml"))) == {str(tmp_path / "f.fis"), str(tmp_path / "c.toml")}


def test_what_is_written_is_read_again(tmp_path):
    said = ControllerFile(
        "vud_lathe", "corrected.vud_beta_e", {"tau": 0.1 + 0.2, "a.b": 1e-300, "rules": [[1.0, -2.0], [0.0, 3.0]]},
        {"worst:m<=1": {"x": float("inf")}, "text": 'a "b" \\ \n c', "list": ["p", "q"], "empty": {}, "none": None},
    )  # fmt: skip
    controller_file.write(tmp_path / "c.toml", said)
    found = controller_file.read(tmp_path / "c.toml")
    assert found.parameters == said.parameters
    assert found.tuning["text"] == said.tuning["text"] and found.tuning["worst:m<=1"]["x"] == float("inf")


def test_a_tuning_starts_from_it_and_writes_one(file, tmp_path):
    job = Job(Experiment(PLAIN, str(file), "small", {"controller.inverted": False, "scenario.target_mm": 2.0}))
    found = tune(job, {"controller.kp": (1.0, 9.0), "plant.lag_s": (0.01, 0.1)}, ["rms_error"], budget=8)
    assert found.present["controller.kp"] == 4.5
    made = tuned.save(job, found, tmp_path / "new.toml")
    assert [p.name for p in made] == ["new.toml", "new_experiment.toml"]
    text = tomllib.loads(made[0].read_text())
    assert text["controller"] == "p" and text["set"]["table"] == [2.0, 0.0, 1.0] and text["set"]["stages"] == 2
    assert text["set"]["kp"] == found.values["controller.kp"]
    assert text["tuning"]["budget"] == 8 and text["tuning"]["trained"]["worst:rms_error"] > 0
    whole = experiment.read(made[1])
    run = whole.loop().run(whole.seconds())
    assert run.metrics["rms_error"] == found.trained.values["worst:rms_error"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("kind = ", "cannot be read as TOML"),
        ('study = "vud_lathe"', "is not a controller file: it has no kind"),
        (HEAD.replace('"controller"\n', '"experiment"\n', 1), "its kind is 'experiment'"),
        (HEAD.replace("study", "studi"), "there is no key 'studi'; did you mean study"),
        (HEAD.replace('study = "vud_lathe"\n', ""), "the key 'study' is missing"),
        (HEAD.replace("= 1", "= 3"), "schema_version = 3: Input should be 1 or 2"),
        (HEAD.replace('"vud_lathe"', "3"), "study = 3: Input should be a valid string"),
        (HEAD.replace("corrected.vud_beta_e", "other.toml"), "names no other one"),
        (HEAD.replace("corrected.vud_beta_e", "corrected.vud"), "no controller 'corrected.vud'; did you mean"),
        (HEAD + "[set]\ntauu = 1.0", "no parameter 'tauu'; did you mean tau"),
        (HEAD + "[set]\ntau = 9.0", "tau = 9.0 ([set]): allowed range is [0, 2]"),
        (HEAD + '[set]\ntau = "fast"', "tau = 'fast' ([set]): expected a number"),
    ],
)  # fmt: skip
def test_faults_are_named_with_file_and_key(tmp_path, text, words):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(DataError) as caught:
        Experiment("vud_lathe", str(path), "fig11a_step_m50").loop()
    assert str(path) in str(caught.value) and words in str(caught.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match="there is no file"):
        Experiment("vud_lathe", str(tmp_path / "none.toml"), "fig11a_step_m50").loop()
