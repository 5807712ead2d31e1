"""What a user reads after a common mistake: one sentence, and no frames but those of the user's own code."""

import inspect
import re
import runpy
import subprocess
import sys
import traceback

import pytest
from typer.testing import CliRunner

import leadscrew
from leadscrew import catalogue
from leadscrew.cli import app
from leadscrew.util.frames import DEBUG
from tests.notebook import executed

HEAD = """\
import math
from typing import NamedTuple
import numpy as np
import leadscrew as ls
class P(NamedTuple):
    kp: float = 2.0
class S(NamedTuple):
    x: float = 0.0
class Other(NamedTuple):
    x: float = 0.0
@ls.plant(P(), S())
def mass(p, s, u):
    return S(u)
pid, step, LIMITS = ls.block("pid"), ls.block("step"), [1.0, 2.0]
def go(controller=pid, plant=mass, **more):
    return ls.Loop(reference=step, controller=controller, plant=plant, metrics={}, **more)
"""
LAW = "@ls.controller(P())\ndef law(p, command, feedback):\n    {}\ngo(law).run(0.01)"
WITH_STATE = "@ls.controller(P(), S())\ndef law(p, s, command):\n    {}\ngo(law).run(0.01)"
FIRST = "mine.py:19: in 'law': "  # the first line of the step
STEP = "mine.py:17: in 'law': "  # its decorator

MISTAKES = {
    "a text for a number": (
        'pid(kp="20")', "ValueRefused: kp = '20' (pid): expected a number; write 20 without quotes"),
    "a typing error in a parameter": ("pid(kpp=2)", "NameUnknown: pid has no parameter 'kpp'; did you mean kp?"),
    "a gain without its name": ("pid(20.0)", "BlockError: pid(20.0): parameters have names: pid(kp=20.0)"),
    "arguments without names": (
        "ls.Loop(step, pid, mass)",
        "TypeError: Loop.__init__() takes 1 positional argument but 4 were given; "
        "name them: reference=..., controller=..., plant=..."),
    "a gain of NaN": (
        "pid(kp=math.nan)", "ValueRefused: kp = nan (pid): not a number (NaN) is not allowed"),
    "a gain out of range": ("pid(kp=-1.0)", "ValueRefused: kp = -1.0 (pid): allowed range is [0, inf)"),
    "an unknown block": (
        'ls.block("servo_axs")', "NameUnknown: there is no block 'servo_axs'; did you mean servo_axis?"),
    "an unknown study": (
        'ls.study("vud_late")', "NameUnknown: there is no study 'vud_late'; did you mean vud_lathe?"),
    "an unknown scenario": (
        'ls.Experiment("vud_lathe", "paper.vud", "fig11a_step_m5").loop()',
        "NameUnknown: vud_lathe has no scenario 'fig11a_step_m5'; did you mean fig11a_step_m50?"),
    "an unknown controller of a study": (
        'ls.Experiment("vud_lathe", "paper.vudd", "fig11a_step_m50").loop()',
        "NameUnknown: vud_lathe has no controller 'paper.vudd'; did you mean paper.vud?"),
    "no such file": ('ls.block("no_such.py:law")', "DataError: there is no file 'no_such.py'"),
    "no such run": ('ls.load("no_such")', "DataError: no_such is not a run folder: run.json is missing"),
    "nothing returned": (
        LAW.format("u = p.kp * command"), f"BlockError: {STEP}it returned nothing: missing 'return'?"),
    "nothing returned on one path": (
        LAW.format("if command > 0.5: return p.kp"),
        f"SubsetError: {FIRST}returns nothing where this does not return: missing 'return'?"),
    "three values returned": (
        WITH_STATE.format("return s, p.kp, 1.0"),
        f"BlockError: {STEP}it returned 3 values; a step with state returns (next_state, signal)"),
    "the signal alone": (
        WITH_STATE.format("return p.kp"),
        f"BlockError: {STEP}it returned 2.0; a step with state returns (next_state, signal)"),
    "a state where there is none": (
        LAW.format("return p, command"),
        f"BlockError: {STEP}it returned 2 values; a step without state returns its signal alone"),
    "another state": (
        WITH_STATE.format("return Other(), p.kp"), f"BlockError: {STEP}its next state is Other, not S"),
    "another state of a plant": (
        "@ls.plant(P(), S())\ndef law(p, s, u):\n    return Other(u)\ngo(plant=law).run(0.01)",
        f"BlockError: {STEP}it returned Other; a plant returns its state S, or its derivative"),
    "a missing parameter": (
        LAW.format("return p.ki * command"), f"SubsetError: {FIRST}'p' has no field 'ki'; did you mean kp?"),
    "a parameter without its p": (
        LAW.format("return kp * command"), f"SubsetError: {FIRST}the name 'kp' is not defined; did you mean p.kp?"),
    "np.clip": (
        LAW.format("return np.clip(command, -1.0, 1.0)"),
        f"SubsetError: {FIRST}'np.clip' cannot be used in a step; write min(max(x, low), high)"),
    "np.array": (
        LAW.format("return np.array([command, feedback])[0]"),
        f"SubsetError: {FIRST}'np.array' cannot be used in a step; "
        "use a name for each number, or an array in the state"),
    "np.sin of a list": (
        LAW.format("return np.sin([command])"),
        f"SubsetError: {FIRST}a list is outside the step subset; use a name for each number, or an array in the state"),
    "np.random": (
        LAW.format("return command + np.random.normal()"),
        f"SubsetError: {FIRST}'np.random.normal' cannot be used in a step; write leadscrew.normal(noise, 0)"),
    "a function that has no portable counterpart": (
        LAW.format("return math.erf(command)"),
        f"SubsetError: {FIRST}'math.erf' cannot be used in a step; the page 'Blocks' lists the functions that can"),
    "a list from outside": (
        LAW.format("return LIMITS[0] * command"),
        f"SubsetError: {FIRST}'LIMITS' is a list; make it an array, outside the step: LIMITS = np.array(LIMITS)"),
    "an endless loop": (
        LAW.format("while True: command = command + 1.0"),
        f"SubsetError: {FIRST}this 'while' never ends; give it a condition, or a 'break'"),
    "an import in a step": (
        LAW.format("import math"),
        f"SubsetError: {FIRST}'import' is outside the step subset; write it at the top of the file"),
    "a print in a step": (
        LAW.format("print(f'{command:.2f}'); return command"),
        f"SubsetError: {FIRST}print() in a step runs with engine='python' only"),
    "a text in a step": (
        LAW.format("mode = 'fast'; return command"),
        f"SubsetError: {FIRST}the constant 'fast'; a step computes with numbers only"),
    "an error in a step": (
        LAW.format("a, b = command; return a"),
        "BlockError: mine.py:19: in 'law', in the first period: TypeError: cannot unpack non-iterable float object; "
        "it was given command as a number, feedback as a number"),
    "a text as a parameter": (
        "class Q(NamedTuple):\n    mode: str = 'fast'\n@ls.controller(Q())\ndef law(p, command):\n"
        "    return command\ngo(law)", "ValueRefused: controller.mode = 'fast' (law): expected a number"),
    "a parameter without a default": (
        "class Q(NamedTuple):\n    gain: float\n@ls.controller(Q)\ndef law(p, command):\n    return command",
        "BlockError: law: Q.gain has no default: give it one, or write an instance"),
    "a decorator without parentheses": (
        "@ls.controller\ndef law(command):\n    return command",
        "BlockError: law: write @controller() or @controller(Params(), State()), with parentheses"),
    "a controller as a plant": (
        "go(plant=pid)", "BlockError: plant = 'pid' is a controller, not a plant"),
    "a function as a controller": (
        "def law(command):\n    return command\ngo(law)",
        "BlockError: controller = law is a function, not a block; decorate it with @controller(Params(), State())"),
    "a name as a controller": (
        'go("pid")', "BlockError: controller = 'pid' is a text, not a block; write leadscrew.block('pid')"),
    "no plant": (
        "ls.Loop(reference=step, controller=pid)",
        "TypeError: Loop.__init__() missing 1 required keyword-only argument: 'plant'"),
    "a typing error in an argument": (
        "go(substep=2)",
        "TypeError: Loop.__init__() got an unexpected keyword argument 'substep'; did you mean substeps?"),
    "a period in words": ('go(period="1 ms")', "ValueRefused: period = '1 ms': expected a number in s"),
    "a negative duration": ("go().run(-1.0)", "ValueRefused: duration = -1.0: allowed range is (0, inf) s"),
    "an unknown dotted key": (
        'go().using({"controler.kp": 2.0})',
        "NameUnknown: there is no parameter 'controler.kp'; did you mean controller.kp, controller.ki, controller.kd?"),
    "an unknown engine": (
        'go(engine="gpu")', "ValueRefused: engine = 'gpu': allowed are llvm, c, python"),
    "an unknown signal": (
        'go().run(0.01)["outputt"]', "NameUnknown: 'outputt' was not recorded; did you mean output?"),
    "an unknown metric": (
        'go().run(0.01).metrics.iae', "AttributeError: there is no metric 'iae'"),
    "an unknown attribute": ("ls.Lop", "AttributeError: module 'leadscrew' has no attribute 'Lop'"),
}  # fmt: skip
"""The code, and what is answered."""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A working folder of one's own, and no frames of the library."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(DEBUG, raising=False)
    return tmp_path


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_script_answers_in_one_sentence_below_the_users_own_frames(here, mistake):
    code, answer = MISTAKES[mistake]
    (here / "mine.py").write_text(HEAD + code + "\n")
    with pytest.raises(Exception, match=r".") as caught:
        runpy.run_path("mine.py", run_name="__main__")
    error = caught.value
    assert f"{type(error).__name__}: {error}" == answer
    assert len(answer) <= 180 and "\n" not in answer  # at most two lines of a terminal
    printed = "".join(traceback.format_exception(error))
    assert "leadscrew/src" not in printed and "src/leadscrew" not in printed and "direct cause" not in printed
    own = [f for f in traceback.extract_tb(error.__traceback__) if "mine.py" in f.filename]
    assert own[-1] == traceback.extract_tb(error.__traceback__)[-1] and own[0].lineno > HEAD.count("\n")


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_file_answers_the_command_line_in_one_line(here, mistake):
    code, answer = MISTAKES[mistake]
    (here / "mine.py").write_text(HEAD + code + "\n")
    result = CliRunner().invoke(app, ["simulate", "mine.py:LOOP", "--duration", "0.01"])
    assert result.exit_code == 2 and result.stdout == ""
    assert re.fullmatch(r"leadscrew: mine\.py:\d+ does not load: " + re.escape(answer) + "\n", result.stderr)


def program(*arguments):
    """What the program prints on stderr."""
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=120).stderr


@pytest.mark.slow
def test_all_frames_are_shown_with_the_environment_variable_and_with_debug(here, monkeypatch):
    (here / "mine.py").write_text(HEAD + "pid(kpp=2)\n")
    lines = program("mine.py").splitlines()
    assert [x.strip() for x in lines if not set(x) <= set(" ~^")] == [
        "Traceback (most recent call last):", f'File "{here / "mine.py"}", line 17, in <module>', "pid(kpp=2)",
        "leadscrew.NameUnknown: pid has no parameter 'kpp'; did you mean kp?",
    ]  # fmt: skip
    for arguments in (("--debug", "simulate", "mine.py:LOOP"), ("simulate", "mine.py:LOOP", "--debug")):
        printed = program("-m", "leadscrew", *arguments)
        assert printed.startswith("Traceback") and "in checked_replace" in printed
    monkeypatch.setenv(DEBUG, "1")
    assert "in checked_replace" in program("mine.py")


def test_an_error_of_a_users_function_is_named_by_file_and_line(here):
    (here / "mine.py").write_text("def build():\n    gains = []\n    return gains[0]\n")
    result = CliRunner().invoke(app, ["simulate", "mine.py:build", "--duration", "0.01"])
    assert result.exit_code == 2
    assert result.stderr == ("leadscrew: mine.py:build() failed at mine.py:3: IndexError: list index out of range\n")


STUDY = """\
from pathlib import Path
import leadscrew as ls
from leadscrew.studies import Scenario, Study
def build(controller, scenario):
    return {}["mass"]
STUDY = Study(
    name="mine", title="", paper="", build=build, controllers={"pid": ls.block("pid")},
    scenarios={"step": Scenario("step", None, "a step", 0.5)}, folder=Path(),
)
"""


def test_an_error_of_a_users_study_is_named_by_file_and_line_unless_all_frames_are_shown(here, monkeypatch):
    (here / "mine.py").write_text(STUDY)
    arguments = ["simulate", "mine.py:STUDY", "-c", "pid", "-s", "step"]
    result = CliRunner().invoke(app, arguments)
    assert (result.exit_code, result.stderr) == (2, "leadscrew: mine.py:5: KeyError: 'mass'\n")
    monkeypatch.setenv(DEBUG, "1")
    assert CliRunner().invoke(app, arguments).stderr.startswith("Traceback")


def test_a_step_prints_once_a_period_on_the_python_engine(here, capsys):
    code = LAW.format("print('u', p.kp, f'{command + 1.0:.1f}'); return p.kp * command").replace(
        "go(law)", "go(law, engine='python')"
    )
    (here / "mine.py").write_text(HEAD + code + "\n")
    runpy.run_path("mine.py", run_name="__main__")
    assert capsys.readouterr().out == "u 2.0 2.0\n" * 10


def test_a_warning_names_the_line_of_the_user(here):
    (here / "mine.py").write_text(HEAD + "go(pid(kp=1e6), bound=1e-3).run(0.1)\n")
    with pytest.warns(match="diverged") as caught:
        runpy.run_path("mine.py", run_name="__main__")
    assert {(w.filename, w.lineno) for w in caught} == {("mine.py", 17)}


@pytest.mark.slow
def test_a_mistake_in_a_notebook_shows_the_cell_and_one_sentence(here):
    nbformat = pytest.importorskip("nbformat", reason="nbformat is missing: pip install leadscrew[dev]")
    cells = [nbformat.v4.new_code_cell(HEAD + code) for code, _ in MISTAKES.values()]
    notebook = nbformat.v4.new_notebook(cells=cells)
    executed(notebook, here, allow_errors=True)
    for n, (cell, (_, answer)) in enumerate(zip(notebook.cells, MISTAKES.values(), strict=True), 1):
        output = cell.outputs[-1]
        assert f"{output.ename}: {output.evalue}" == answer.replace("mine.py", f"Cell In[{n}]")
        printed = re.sub(r"\x1b\[[0-9;]*m", "", "\n".join(output.traceback))
        assert "src/leadscrew" not in printed and "ipykernel" not in printed and "File " not in printed
        assert printed.count("Traceback") == 1 and f"Cell In[{n}], line" in printed


def test_every_public_function_and_every_maker_of_blocks_trims_its_errors():
    public = {name: getattr(leadscrew, name) for name in leadscrew.__all__} | catalogue.factories()
    whole = {name for name, f in public.items() if inspect.isfunction(f) and not hasattr(f, "__wrapped__")}
    assert whole == {"normal", "uniform"}  # steps call these
