"""Files of version 0.1.0 keep their meaning where defaults and the limit of an output have changed since.

A file that sets some gains of a general controller left the others at 0.1.0's defaults: read with today's, a tuned
loop would run with other gains and nobody would see it.
"""

import math
from dataclasses import replace

import pytest

from leadscrew import controller_file, experiment
from leadscrew.cli.values import parse
from leadscrew.experiment import Experiment
from leadscrew.kernel.parameters import renamed
from leadscrew.operate.settable import checked
from leadscrew.replay import rebuilt

GAINS = {"kp": 1.32, "ki": 5.0, "kd": 0.006805}
"""Table I, the defaults of ``pid`` in 0.1.0, with the integral gain of the files below."""


def controller_text(version):
    head = f'schema_version = {version}\nkind = "controller"\n'
    return head + 'study = "npid_xytable"\ncontroller = "pid"\n[set]\nki = 5.0\n'


def experiment_text(version):
    return (
        f'schema_version = {version}\nstudy = "npid_xytable"\ncontroller = "pid"\nscenario = "sine_1mm"\n'
        "[set]\ncontroller.ki = 5.0\n"
    )


@pytest.mark.parametrize("text", [controller_text, experiment_text])
def test_what_a_file_leaves_out_is_the_default_of_its_version(text, tmp_path):
    path = tmp_path / "mine.toml"
    found = {}
    for version in (1, 2):
        path.write_text(text(version))
        parameters = replace(experiment.read(path), scenario="sine_1mm").loop().parameters
        found[version] = {key: parameters[f"controller.{key}"] for key in GAINS}
    assert found == {1: GAINS, 2: {"kp": 1.0, "ki": 5.0, "kd": 0.0}}


def test_a_file_that_is_written_again_says_all_of_it(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(controller_text(1))
    controller_file.write(path, controller_file.read(path))
    assert controller_file.read(path).parameters == GAINS and "schema_version = 2" in path.read_text()


@pytest.mark.parametrize(("old", "ends"), [(3.0, (-3.0, 3.0)), (0.0, (-math.inf, math.inf))])
def test_the_symmetric_limit_becomes_two(old, ends):
    loop = Experiment("npid_xytable", "ours.pid_159_ff", "sine_1mm", {"controller.inner.max_output": old}).loop()
    assert tuple(loop.parameters[f"controller.inner.{end}"] for end in ("lower", "upper")) == ends
    assert checked({"controller.inner.max_output": old}, loop.sheet, {}) == {
        "controller.inner.lower": ends[0], "controller.inner.upper": ends[1]
    }  # fmt: skip
    assert parse([f"controller.inner.max_output={old}"], loop.sheet) == {
        "controller.inner.lower": ends[0], "controller.inner.upper": ends[1]
    }  # fmt: skip


def test_a_saved_run_with_a_limit_is_built_again():
    limits = {"controller.lower": -2.0, "controller.upper": 2.0}
    loop = Experiment("npid_xytable", "paper.pid", "sine_1mm", limits).loop()
    manifest = {**loop.manifest("llvm"), "origin": {**loop.origin, "changes": {"controller.max_output": 2.0}}}
    saved = {k: v for k, v in loop.parameters.items() if k not in limits}
    again = rebuilt({**manifest, "parameters": {**saved, "controller.max_output": 2.0}}, "run")
    assert again.parameters == loop.parameters


def test_a_limit_of_a_users_own_block_keeps_its_name():
    assert renamed({"controller.max_output": 3.0}, {"controller.max_output": 1.0}) == {"controller.max_output": 3.0}
    assert renamed({"controller.max_output": 3.0}, {"controller.gain": 1.0}) == {"controller.max_output": 3.0}


@pytest.mark.parametrize(
    ("study", "controller", "scenario", "old", "new"),
    [
        ("grey_turning", "ours.constant_force", "fig6_fixed_depth", "plant.servo.most", "plant.servo.max_feed"),
        ("sofnn_tangent", "ours.sofnn_tuned", "wave_fabric", "controller.most", "controller.max_offset"),
    ],
)
def test_a_key_of_010_is_the_one_of_today(study, controller, scenario, old, new):
    found = Experiment(study, controller, scenario, {old: 12.0}).loop()
    assert found.parameters[new] == 12.0 and parse([f"{old}=12"], found.sheet) == {new: 12.0}
