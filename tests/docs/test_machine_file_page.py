"""The page on machine files: its file is one, and its commands run on it."""

import re
import shlex
from typing import get_args

import pytest
from typer.testing import CliRunner

from leadscrew import resolve
from leadscrew.cli import app
from leadscrew.machine.file import read
from leadscrew.machine.gains import PER_SI
from leadscrew.machine.table import Model
from tests.docs.snippets import ROOT, blocks

PAGE = ROOT / "docs" / "machine_file.md"
TEXT = PAGE.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("machine")
    (file,) = blocks(PAGE, ("toml",))
    (where / "table.toml").write_text("\n".join(file[1]), encoding="utf-8")
    return where


def test_the_page_names_every_model_unit_controller_and_scenario(folder):
    rows = dict(re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", TEXT, re.MULTILINE))
    assert re.findall(r"`(servo_\w+|linear)`", rows["`model`"]) == list(get_args(Model))
    units = rows["`position_unit`"].split(":")[1].replace(" or ", ", ")
    assert {u.strip() for u in units.split(",")} == set(PER_SI)
    study = resolve.study(str(folder / "table.toml"))
    named = set(re.findall(r"^\| (`[^|]+`) \|", TEXT, re.MULTILINE))
    assert {f"`{c}`" for c in study.controllers} | {"`ours.pid`"} <= named
    assert {s for row in named for s in re.findall(r"`(\w+)`", row)} >= set(study.scenarios)
    assert read(folder / "table.toml").cascade == {"kp": 160.18, "kv": 0.24345}


@pytest.mark.slow
def test_its_commands_run(folder, monkeypatch):
    monkeypatch.chdir(folder)
    typed = [line[2:] for _, body in blocks(PAGE, ("text",)) for line in body if line.startswith("$ ")]
    assert [shlex.split(t)[1] for t in typed] == ["simulate", "ballbar", "tune", "simulate"]
    for command in typed:
        done = CliRunner().invoke(app, shlex.split(command)[1:])
        assert done.exit_code == 0, (command, done.output)
