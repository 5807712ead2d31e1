"""The file of a fuzzy system as a controller: in simulate, export, list, replay, experiment files and Python."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew import names, resolve
from leadscrew.experiment import Experiment
from leadscrew.fuzzy import block, formats
from leadscrew.kernel.block import controller, reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import rms_error
from leadscrew.references._sine import sine_motion
from leadscrew.util.errors import BlockError, ValueRefused
from tests.budget import in_every_run
from tests.cli.conftest import strict_json
from tests.cli.plain_study import STUDY, slide
from tests.fuzzy.systems import mamdani, sugeno, with_block, with_output
from tests.tools import runnable

SCALES = ("--set", "controller.scale_e=0.5", "--set", "controller.scale_output=4")


@pytest.fixture
def made(tmp_path):
    """A function that writes a system to a file and gives its path."""

    def write(name="axis.fis", system=None):
        formats.write(system or with_output(mamdani(), integration="trapezoid"), tmp_path / name)
        return tmp_path / name

    return write


def simulated(study, path, *more):
    return ("simulate", study, "-c", path, "-s", "small", *more)


def test_a_file_drives_the_loop_as_its_block_does(call, study, made):
    found = strict_json(call(*simulated(study, made(), *SCALES, "--json")).stdout)
    by_hand = block.controller(mamdani(integration="trapezoid"), {"e": ("error", 0.5), "de": "change"}, output_scale=4)
    run = STUDY.loop(by_hand, "small").run(0.2)
    assert found["metrics"] == {k: float(v) for k, v in run.metrics.items()}
    assert found["metrics"]["rms_error"] < 0.9
    assert found["controller"].endswith("/axis.fis")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["axis.fis", "axis.fll", "axis.fcl", "AXIS.FLL"])
def test_every_format_gives_the_same_run(call, study, made, name):
    path = made("axis.fis")
    first = strict_json(call(*simulated(study, path, *SCALES, "--json")).stdout)["metrics"]
    formats.write(formats.read(path), path.with_name(name.casefold()))
    shutil.move(path.with_name(name.casefold()), path.with_name(name))
    assert strict_json(call(*simulated(study, path.with_name(name), *SCALES, "--json")).stdout)["metrics"] == first


MARKUP = """<fuzzySystem name="push"><knowledgeBase>
<fuzzyVariable name="e" domainleft="-2" domainright="2" type="input">
  <fuzzyTerm name="n"><triangularShape param1="-6" param2="-2" param3="2"/></fuzzyTerm>
  <fuzzyTerm name="p"><triangularShape param1="-2" param2="2" param3="6"/></fuzzyTerm></fuzzyVariable>
<fuzzyVariable name="u" domainleft="-3" domainright="3" type="output" defuzzifier="COG" defaultValue="0">
  <fuzzyTerm name="n"><triangularShape param1="-3" param2="-2" param3="-1"/></fuzzyTerm>
  <fuzzyTerm name="p"><triangularShape param1="1" param2="2" param3="3"/></fuzzyTerm></fuzzyVariable>
</knowledgeBase><mamdaniRuleBase name="r" activationMethod="MIN">
<rule name="1" connector="and" weight="1"><antecedent><clause><variable>e</variable><term>n</term></clause></antecedent>
  <consequent><then><clause><variable>u</variable><term>n</term></clause></then></consequent></rule>
<rule name="2" connector="and" weight="1"><antecedent><clause><variable>e</variable><term>p</term></clause></antecedent>
  <consequent><then><clause><variable>u</variable><term>p</term></clause></then></consequent></rule>
</mamdaniRuleBase></fuzzySystem>"""


def test_markup_with_one_input_takes_the_error(call, study, tmp_path):
    (tmp_path / "push.xml").write_text(MARKUP)
    found = strict_json(call(*simulated(study, tmp_path / "push.xml", "--json")).stdout)
    assert 0.0 < found["metrics"]["rms_error"] < 1.0


def test_list_shows_what_can_be_set_and_what_the_reader_says(call, made):
    path = made()
    out = call("list", path).stdout
    assert all(word in out for word in ("scale_e", "scale_de", "scale_output", "tables.weights", "mamdani49"))
    path.write_bytes(path.read_bytes().replace(b"mamdani49", "Gr\xf6\xdfe".encode("latin-1")))
    assert "The file is not UTF-8: read as Latin-1." in call("list", path).stdout


def test_the_output_that_drives_goes_by_name(call, refused, study, made):
    single = sugeno()
    other = replace(single.outputs[0], name="v", default=0.0)
    rules = [replace(r, consequents=(*r.consequents, replace(r.consequents[0], variable="v"))) for r in single.rules]
    both = replace(
        single, outputs=(replace(single.outputs[0], default=0.0), other),
        blocks=(replace(single.blocks[0], rules=tuple(rules)),),
    )  # fmt: skip
    path = made("two.fll", both)
    said = refused(*simulated(study, path))
    assert "say which output drives" in said
    assert "it has u, v" in said
    assert "no output 'w'" in refused(*simulated(study, f"{path}:w"))
    call(*simulated(study, f"{path}:v", *SCALES))


def test_what_is_wrong_with_a_file_is_said_with_its_place(refused, study, made, tmp_path):
    path = made()
    path.write_text(path.read_text().replace("'trimf'", "'trimm'", 1))
    said = refused(*simulated(study, path))
    assert "axis.fis:" in said
    assert "trimm" in said
    assert "cannot be read" in refused(*simulated(study, tmp_path / "no.fis"))
    three = replace(mamdani(), inputs=(*mamdani().inputs, replace(mamdani().inputs[0], name="third")))
    assert "has 3 inputs (e, de, third)" in refused(*simulated(study, made("three.fll", three)))


def test_a_file_is_no_study(refused, made):
    assert "expected a study" in refused("simulate", made(), "-c", "p", "-s", "small")


@pytest.mark.parametrize("scenario", in_every_run(["s_curve_m50", "trapezoid_m170"], ["s_curve_m50"]))
def test_it_follows_the_moves_of_the_lathe(made, scenario):
    scales = {"controller.scale_e": 0.02, "controller.scale_output": -1.0}
    experiment = Experiment("vud_lathe", str(made()), scenario, scales, record=("command", "actual.position"))
    run = experiment.loop().run(4.0)
    target = -50.0 if scenario == "s_curve_m50" else -170.0
    assert run["command"][-1] == target
    assert abs(run["actual.position"][-1] - target) < 0.01 * abs(target)


def commanded(monkeypatch, reference, path):
    """The experiment with a fuzzy system's file in a study whose controllers take a command of several numbers."""

    @controller()
    def first(command, feedback):
        return 2.0 * (command.position - feedback)

    @controller()
    def first_of_two(command, feedback):
        return 2.0 * (command.x - feedback)

    def build(found, scenario):
        return Loop(reference=reference, controller=found, plant=slide, metrics={"rms": rms_error}, engine="python")

    own = first if reference is sine_motion else first_of_two
    moving = replace(STUDY, name="moving", controllers={"p": own}, build=build)
    monkeypatch.setattr(resolve, "subject", lambda name: moving)
    return Experiment("moving", str(path), "small", {"controller.scale_output": 4.0})


def test_of_a_motion_it_takes_the_position(made, monkeypatch):
    experiment = commanded(monkeypatch, sine_motion, made())
    run = experiment.loop().run(0.1)
    by_hand = block.controller(mamdani(integration="trapezoid"), output_scale=4.0, command="position")
    plain = Loop(reference=sine_motion, controller=by_hand, plant=slide, metrics={"rms": rms_error}, engine="python")
    np.testing.assert_array_equal(run["output"], plain.run(0.1)["output"])
    assert run.loop.blocks["controller"].unit == "" and run.loop.name.startswith("moving ")
    assert run.loop.sheet.keys() < experiment.settable().keys()


def test_a_command_of_two_axes_is_refused_in_one_sentence(made, monkeypatch):
    class Both(NamedTuple):
        x: float = 0.0
        y: float = 0.0

    @reference()
    def circle(t):
        return Both(t, 1.0 - t)

    experiment = commanded(monkeypatch, circle, made())
    assert replace(experiment, controller="p", changes={}).loop().run(0.01).diverged is None
    with pytest.raises(BlockError, match=r"axis.fis does not fit moving: .*; here the command is x, y"):
        experiment.loop()


def test_unit_and_drive_are_those_of_the_studys_machine(made):
    loop = Experiment("vud_lathe", str(made()), "fig11a_step_m50").loop()
    found = loop.blocks["controller"]
    assert (found.unit, found.drive, found.full_scale, found.sense) == ("1", "duty", 1.0, -1)
    assert block.from_file(made()).drive == ""


@pytest.mark.slow
def test_a_run_is_replayed_and_a_changed_file_is_noticed(call, refused, study, made, tmp_path, monkeypatch):
    path = made()
    monkeypatch.chdir(tmp_path)
    call(*simulated(study, "axis.fis", *SCALES, "--out", "run"))
    origin = json.loads((tmp_path / "run/run.json").read_text())["origin"]
    assert origin["controller"] == str(path)
    monkeypatch.chdir("/")
    assert "identical: 200 rows" in call("replay", tmp_path / "run").stdout

    published = path.read_text()
    lines = published.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("4 4, 4"))
    lines[first] = lines[first].replace("4 4, 4", "4 4, 6")
    path.write_text("\n".join(lines))
    said = call("replay", tmp_path / "run", code=1).stdout
    assert "not identical" in said
    assert "axis.fis is not the file that it was" in said

    path.write_text(published.replace("(1) : 1", "(0.5) : 1", 1))
    said = refused("replay", tmp_path / "run")
    assert "axis.fis is not the file that it was" in said

    path.write_text(published)
    assert "identical: 200 rows" in call("replay", tmp_path / "run").stdout
    path.unlink()
    assert "cannot be read" in refused("replay", tmp_path / "run")


def test_an_experiment_file_names_it_beside_itself(call, study, made, tmp_path):
    made()
    (tmp_path / "e.toml").write_text(
        f'schema_version = 1\nstudy = "{study}"\ncontroller = "axis.fis"\nscenario = "small"\n'
        "[set]\ncontroller.scale_e = 0.5\ncontroller.scale_output = 4.0\n"
    )
    found = strict_json(call("simulate", tmp_path / "e.toml", "--json").stdout)
    direct = strict_json(call(*simulated(study, tmp_path / "axis.fis", *SCALES, "--json")).stdout)
    assert found["metrics"] == direct["metrics"]
    assert found["files"].keys() == {str(tmp_path / "axis.fis")}


def test_a_scale_that_does_not_exist_is_refused(refused, study, made):
    assert "did you mean controller.scale_e" in refused(*simulated(study, made(), "--set", "controller.scale=2"))


def test_it_is_exported_with_the_scales_as_knobs(call, study, made, tmp_path):
    runnable("c")
    args = ("export", study, "-c", made(), "-t", "c99", "--name", "axis", *SCALES)
    call(*args, "--out", tmp_path / "out", "--drive", "voltage")
    found = json.loads((tmp_path / "out/manifest.json").read_text())
    assert [k["key"] for k in found["knobs"]] == ["scale_e", "scale_de", "scale_output"]
    assert found["drive"] == "voltage"
    assert found["unit"] == "V"
    assert found["golden"]["verdict"] == "identical"
    assert found["origin"]["files"]


def test_an_export_is_called_as_the_file_or_the_object():
    named = {"a/my-axis.fis": "my_axis", "axis.fll:u": "axis", "a/b.py:half": "half", "paper.vud": "vud", "pid": "pid"}
    assert {name: names.stem(name) for name in named} == named


def test_a_file_that_changed_is_read_anew(made):
    path = made()
    before = resolve.block(str(path), "controller")
    assert resolve.block(str(path), "controller") is before
    made("axis.fis", with_output(mamdani(defuzzifier="bisector"), integration="trapezoid"))
    assert resolve.block(str(path), "controller") is not before


def test_numbers_of_the_system_are_tuned_by_name(study, made):
    path = made("axis.fll", sugeno())
    tables = np.array(resolve.block(str(path)).params.tables.terms)
    tables[14:, 0] *= 2.0
    twice = {"controller.tables.terms": tables}
    made_twice = Experiment(study, str(path), "small", twice).loop().run(0.1)
    scaled = Experiment(study, str(path), "small", {"controller.scale_output": 2.0}).loop().run(0.1)
    np.testing.assert_allclose(made_twice["output"], scaled["output"], rtol=1e-14)
    with pytest.raises(ValueRefused, match="change what its step is made of"):
        Experiment(
            study, str(made("w.fll", with_block(sugeno()))), "small", {"controller.tables.weights": np.full(49, 0.5)}
        ).loop().run(0.1)
