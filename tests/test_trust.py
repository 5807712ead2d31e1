"""Python that a file names runs from the working folder only, or with ``--trust``; what the user names runs anyway."""

from __future__ import annotations

import copy
import hashlib
import json
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import leadscrew
from leadscrew import experiment, names, resolve, userfile
from leadscrew.cli import COMMANDS, _command, app
from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.executors import work
from leadscrew.tune.job import Chunk, Job, chunks_of
from leadscrew.util.errors import CodeNotTrusted, DataError, ValueRefused
from tests.cli import plain_study

PLAIN = f"{plain_study.__file__}:STUDY"
ROOT = str(Path(__file__).parents[1])
FINDING_TESTS = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, (ROOT, os.environ.get("PYTHONPATH"))))}
PYTHON = "from pathlib import Path\nfrom tests.cli.plain_study import *\nPath(__file__).with_name('ran').touch()\n"
EXPERIMENT = 'schema_version = 1\nstudy = "{}:STUDY"\ncontroller = "p"\nscenario = "small"\n'
CONTROLLER = 'schema_version = 1\nkind = "controller"\nstudy = "{}"\ncontroller = "{}"\n'
SESSION = """schema_version = 1
kind = "session"
periods = 0
digest = "{digest}"
[start]
study = "{study}"
controller = "p"
scenario = "small"
"""
SWITCH = '[[event]]\nperiod = 0\ndo = "switch"\nhow = "not bumpless"\ncontroller = "code.py:half"\n'
FOREIGN = "work_of_others"
NO_ROWS = hashlib.sha256().hexdigest()


class Places:
    """A working folder, and beside it one of somebody else, with Python that leaves a mark where it runs."""

    def __init__(self, root: Path) -> None:
        self.work, self.foreign = root / "work", root / FOREIGN
        for folder in (self.work, self.foreign):
            folder.mkdir()
            (folder / "code.py").write_text(PYTHON)
        self.python = self.foreign / "code.py"

    def put(self, text: str, name: str = f"{FOREIGN}/file.toml") -> Path:
        """A file, in the foreign folder unless named otherwise."""
        path = self.work.parent / name
        path.write_text(text)
        return path

    def ran(self) -> list[str]:
        """The folders whose Python has run since the last call."""
        marks = [p for folder in (self.work, self.foreign) if (p := folder / "ran").exists()]
        for mark in marks:
            mark.unlink()
        return [mark.parent.name for mark in marks]

    def refused(self, by: Path, *args: object) -> None:
        """The command is refused in one sentence with both files and what to do; nothing runs."""
        said = call(*args, code=2)
        assert said.startswith(f"leadscrew: {by}: names the Python file {self.python}, "), said
        assert f"outside the working folder {self.work}; read it, then add --trust" in said and said.count("\n") == 1
        assert self.ran() == []


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Places:
    """Both folders, the working folder the current one."""
    found = Places(tmp_path)
    monkeypatch.chdir(found.work)
    return found


def call(*args: object, code: int = 0) -> str:
    """The command line in this process: what it printed."""
    result = CliRunner().invoke(app, [str(a) for a in args])
    assert result.exit_code == code, result.output
    return result.output


# ---- one file of each kind
def test_an_experiment_file(places: Places) -> None:
    path = places.put(EXPERIMENT.format("code.py"))
    places.refused(path, "simulate", path)
    call("simulate", path, "--trust")
    assert places.ran() == [FOREIGN]
    places.refused(path, "simulate", path)  # it is loaded now, and the next command asks again all the same
    call("simulate", places.put(EXPERIMENT.format("../work/code.py")))
    assert places.ran() == ["work"], "Python of the working folder, named by a file from elsewhere"


def test_an_experiment_file_by_its_controller(places: Places) -> None:
    path = places.put(EXPERIMENT.format("../work/code.py").replace('"p"', '"code.py:half"'))
    said = call("simulate", path, code=2)
    assert f"{path}: names the Python file {places.python}, " in said and places.ran() == ["work"]
    call("simulate", path, "--trust")
    assert places.ran() == [FOREIGN]


def test_a_controller_file_by_its_controller(places: Places) -> None:
    path = places.put(CONTROLLER.format(PLAIN, "code.py:half"))
    places.refused(path, "simulate", PLAIN, "-c", path, "-s", "small")
    call("simulate", PLAIN, "-c", path, "-s", "small", "--trust")
    assert places.ran() == [FOREIGN]
    call("simulate", PLAIN, "-s", "small", "-c", places.put(CONTROLLER.format(PLAIN, "code.py:half"), "work/c.toml"))
    assert places.ran() == ["work"]


def test_a_controller_file_by_its_study(places: Places) -> None:
    path = places.put(CONTROLLER.format("code.py:STUDY", "p"))
    for command in ("list", "simulate"):
        places.refused(path, command, path)
    call("list", path, "--trust")
    assert places.ran() == [FOREIGN]
    call("list", places.put(CONTROLLER.format("code.py:STUDY", "p"), "work/c.toml"))
    assert places.ran() == ["work"]


def test_a_session_by_its_study(places: Places) -> None:
    text = SESSION.format(digest=NO_ROWS, study="code.py:STUDY")
    path = places.put(text)
    places.refused(path, "replay", path)
    assert call("replay", path, "--trust").startswith("identical") and places.ran() == [FOREIGN]
    assert call("replay", places.put(text, "work/s.toml")).startswith("identical") and places.ran() == ["work"]


@pytest.mark.parametrize("later", [False, True])
def test_a_session_by_its_controller_and_by_one_that_took_over(places: Places, later: bool) -> None:
    text = SESSION.format(digest=NO_ROWS, study=places.work / "code.py:STUDY")
    path = places.put(text + SWITCH if later else text.replace('"p"', '"code.py:half"'))
    said = call("replay", path, code=2)
    assert f"{path}: names the Python file {places.python}, " in said and places.ran() == ["work"]
    assert call("replay", path, "--trust").startswith("identical") and places.ran() == [FOREIGN]


@pytest.mark.parametrize(
    "origin",
    [
        {"study": f"../{FOREIGN}/code.py:STUDY"},
        {"study": "{foreign}/code.py:STUDY"},
        {"study": "code.py:STUDY", "controller": "{foreign}/code.py:half"},
    ],
)
def test_the_manifest_of_a_run(places: Places, origin: dict[str, str]) -> None:
    run = places.foreign / "run"
    call("simulate", PLAIN, "-c", "paper.half", "-s", "small", "--out", run)
    path = run / "run.json"
    manifest = json.loads(path.read_text())
    manifest["origin"] |= {key: name.format(foreign=places.foreign) for key, name in origin.items()}
    path.write_text(json.dumps(manifest))
    said = call("replay", run, code=2)
    assert said.startswith(f"leadscrew: {path}: names the Python file {places.python}, ") and "--trust" in said
    assert FOREIGN not in places.ran()
    assert call("replay", run, "--trust").startswith("identical") and places.ran() == [FOREIGN]


def test_a_machine_file_names_no_code(places: Places) -> None:
    path = places.put('schema_version = 1\nkind = "machine"\nname = "m"\nmodel = "code.py:STUDY"\n'
                      'position_unit = "mm"\ndrive_unit = "V"\n')  # fmt: skip
    assert "model = 'code.py:STUDY': Input should be 'servo_axis'" in call("list", path, "--trust", code=2)
    assert places.ran() == []


def test_a_journal_names_no_code(places: Places) -> None:
    folder = places.foreign / "journal"
    Journal(folder, {"study": f"{places.python}:STUDY"}).put(0, {})
    with pytest.raises(ValueRefused, match="another question"):
        Journal(folder, {"study": "plain"}, resume=True)
    assert places.ran() == []


# ---- every command
OF_A_LOOP = (
    ("list",), ("run",), ("simulate",), ("certify",), ("ballbar",), ("export", "-t", "c99", "--out", "c"),
    ("tune", "--vary", "controller.kp=1:2", "--minimise", "rms_error"), ("montecarlo", "--over", "plant.lag_s=1:2"),
    ("compare", "-c", "p", "-c", "p_half", "--minimise", "rms_error"), ("diff", "p", "p_half"),
)  # fmt: skip


@pytest.mark.parametrize("words", OF_A_LOOP, ids=lambda words: words[0])
def test_a_command_on_a_foreign_file(places: Places, words: tuple[str, ...]) -> None:
    path = places.put('schema_version = 1\nstudy = "code.py:STUDY"\n')
    places.refused(path, words[0], path, *words[1:])


def leaves(command: Any, name: str) -> Iterator[tuple[str, Any]]:
    """The commands of a command, groups entered."""
    for below, found in getattr(command, "commands", {}).items():
        yield from leaves(found, f"{name} {below}")
    if not getattr(command, "commands", {}):
        yield name, {option for p in command.params for option in (*p.opts, *p.secondary_opts)}


def test_every_command_that_takes_a_controller_or_a_study_has_the_option() -> None:
    options = dict(found for name in COMMANDS for found in leaves(_command(name), name))
    for name, has in options.items():
        assert ("--trust" in has) == (name in ("list", "run", "replay", "diff") or "--controller" in has), name
    assert sum("--trust" in has for has in options.values()) == 13


# ---- where the Python lies
@pytest.mark.parametrize("name", ["link.py", "sub/code.py", f"../{FOREIGN}/code.py", "{foreign}/code.py"])
def test_a_way_out_of_the_working_folder_is_no_way_in(places: Places, name: str) -> None:
    (places.work / "link.py").symlink_to(places.python)
    (places.work / "sub").symlink_to(places.foreign)
    path = places.put(EXPERIMENT.format(name.format(foreign=places.foreign)), "work/e.toml")
    places.refused(path, "simulate", path)


def test_a_chain_of_files_is_judged_by_its_end(places: Places) -> None:
    last = places.put(CONTROLLER.format(PLAIN, "code.py:half"), f"{FOREIGN}/c.toml")
    first = places.put(EXPERIMENT.format("code.py").replace('"p"', f'"../{FOREIGN}/c.toml"'), "work/e.toml")
    said = call("simulate", first, code=2)
    assert (
        said.startswith(f"leadscrew: {last}: names the Python file {places.python}, ") and FOREIGN not in places.ran()
    )
    call("simulate", first, "--trust")
    assert places.ran() == [FOREIGN]


def test_a_working_folder_behind_a_link_is_one(places: Places, monkeypatch: pytest.MonkeyPatch) -> None:
    (places.foreign / "link").symlink_to(places.work)
    (places.work / "below").mkdir()
    monkeypatch.chdir(places.foreign / "link")
    path = places.put(EXPERIMENT.format("../code.py"), "work/below/e.toml")
    call("simulate", path)
    assert places.ran() == ["work"]


@pytest.mark.parametrize("name", ["a\\u0000b.py", "~nobody-of-this-name/b.py", "loop.py"])
def test_a_path_that_is_none_is_one_sentence(places: Places, name: str) -> None:
    (places.work / "loop.py").symlink_to("loop.py")
    said = call("simulate", places.put(EXPERIMENT.format(name), "work/e.toml"), code=2)
    assert "there is no file" in said and said.count("\n") == 1


# ---- what the user names
@pytest.mark.parametrize("words", [("{}:STUDY", "-c", "p"), (PLAIN, "-c", "{}:half")])
def test_python_named_on_the_command_line_runs(places: Places, words: tuple[str, ...]) -> None:
    call("simulate", *(w.format(f"../{FOREIGN}/code.py") for w in words), "-s", "small")
    assert places.ran() == [FOREIGN]


def test_the_library_has_the_same_rule(places: Places) -> None:
    path = places.put(EXPERIMENT.format("code.py"))
    found = experiment.read(path)
    assert places.ran() == [], "reading runs nothing"
    with pytest.raises(leadscrew.CodeNotTrusted, match=r"with leadscrew\.trust\(\)"):
        found.loop()
    with leadscrew.trust():
        with leadscrew.trust():
            pass
        assert found.loop().name == "plain p small"
    assert places.ran() == [FOREIGN]
    with pytest.raises(CodeNotTrusted):
        found.settable()
    leadscrew.Experiment(str(found.study), "p", "small").loop()  # named by the program itself


def test_a_name_keeps_its_file_through_copies_pickles_and_paths(places: Places) -> None:
    name = names.from_file("code.py:STUDY", places.foreign / "e.toml")
    for same in (copy.deepcopy(name), pickle.loads(pickle.dumps(name)), names.absolute(name)):
        assert same == f"{places.python}:STUDY" and same.file == str(places.foreign / "e.toml")
        with pytest.raises(CodeNotTrusted):
            resolve.load(same)
    assert places.ran() == []
    with pytest.raises(DataError, match="there is no file"):
        resolve.load(names.from_file("none.py:STUDY", places.foreign / "e.toml"))


# ---- other processes
def test_a_worker_obeys_the_rule_of_who_sent_the_job(places: Places) -> None:
    job = Job(experiment.read(places.put(EXPERIMENT.format("code.py"))))
    columns = {"controller.kp": np.array([1.0])}
    with pytest.raises(CodeNotTrusted):
        chunks_of(job, columns)
    assert places.ran() == [], "no chunk leaves this process"
    number, result, error = work(pickle.loads(pickle.dumps(job)), 5, Chunk("small", columns, 0))
    assert (number, error) == (5, None) and result and places.ran() == [FOREIGN]
    assert not userfile.trusting()


LEADSCREW = (sys.executable, "-m", "leadscrew")


@pytest.mark.slow
def test_workers_on_this_machine(places: Places) -> None:
    path = places.put(EXPERIMENT.format("code.py"))
    asked = (
        "montecarlo",
        path,
        "--over",
        "plant.lag_s=0.04:0.06",
        "--runs",
        "4",
        "--no-figures",
        "--cluster",
        "local:1",
    )
    places.refused(path, *asked)
    call(*asked, "--trust")
    assert places.ran() == [FOREIGN]


@pytest.mark.slow
def test_the_panel(places: Places) -> None:
    path = places.put(EXPERIMENT.format("code.py"))
    command = (*LEADSCREW, "panel", str(path), "--no-open", "--port", "0", "--folder", str(places.work / "files"))
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=FINDING_TESTS)
    assert done.returncode == 2 and done.stderr.startswith(
        f"leadscrew: {path}: names the Python file {places.python}, "
    )
    assert places.ran() == []
    with subprocess.Popen(
        [*command, "--trust"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=FINDING_TESTS
    ) as panel:
        until = time.monotonic() + 60.0
        while not places.ran() and panel.poll() is None and time.monotonic() < until:
            time.sleep(0.1)
        assert panel.poll() is None, panel.stderr and panel.stderr.read()
        panel.terminate()


@pytest.mark.slow
def test_the_report_of_a_session_of_the_panel(places: Places) -> None:
    """The user has named the machine; the session that names it comes from the panel's own process."""
    text = SESSION.format(digest=NO_ROWS, study=f"{places.python}:STUDY")
    done = subprocess.run(
        (sys.executable, "-m", "leadscrew.panel.reporting"), input=text, capture_output=True, text=True, timeout=60,
        env=FINDING_TESTS,
    )  # fmt: skip
    assert done.returncode == 0 and "<html" in done.stdout, done.stderr
