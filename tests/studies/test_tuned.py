"""Gains in the folders ``tuned`` of the studies: each is what its own command finds."""

import shlex
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from leadscrew import catalogue, controller_file, resolve
from leadscrew.cli import app
from leadscrew.studies.tuned import FOLDER, tuned

FILES = [file for name in catalogue.STUDIES for file in sorted((resolve.study(name).folder / FOLDER).glob("*.toml"))]


def ids(file: Path) -> str:
    return f"{file.parts[-3]} {file.stem}"


@pytest.mark.parametrize("file", FILES, ids=ids)
def test_the_gains_are_those_of_a_controller_of_the_study_and_a_command_tells_where_from(file):
    found = controller_file.read(file)
    study = resolve.study(file.parts[-3])
    command = shlex.split(found.tuning["command"])
    assert command[:2] == ["leadscrew", "design"] or command[:3] == ["leadscrew", "tune", study.name]
    assert found.study == study.name
    assert found.tuning["holds"] is True, "the constraints are kept on plants that the search did not see"
    blocks = [b for b in study.controllers.values() if b.params is not None and not b.continuous]
    block = tuned(study.folder, file.stem, resolve.from_controller_file(file, study))
    assert repr(block.params) in map(repr, (b.params for b in blocks)), "with the names of all types in it"


@pytest.mark.sweep
@pytest.mark.parametrize("file", FILES, ids=ids)
def test_the_command_finds_as_good_a_setting_again(file, tmp_path):
    """The same search reaches the same goal; its last digits may hang on the processor."""
    before, out = controller_file.read(file).tuning, tmp_path / "again.toml"
    done = CliRunner().invoke(app, [*shlex.split(before["command"])[1:], "-o", str(out)])
    assert done.exit_code == 0, done.output
    after = tomllib.loads(out.read_text(encoding="utf-8"))["tuning"]
    for goal in before["minimise"]:
        assert after["held_out"][goal] == pytest.approx(before["held_out"][goal], rel=0.02)
