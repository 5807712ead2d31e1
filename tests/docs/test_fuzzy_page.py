"""The page on fuzzy systems: what its Python prints, what its commands show, and the examples that belong to it."""

import os
import subprocess
import sys

import pytest

from leadscrew.export.folder import compiler_path
from tests.docs import sessions
from tests.docs.snippets import ROOT, assert_printed, shown, with_marks
from tests.tools import missing

PAGE = ROOT / "docs" / "fuzzy.md"
EXAMPLES = ROOT / "examples"


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder in which the Python of the page ran, and then every command was typed."""
    place = tmp_path_factory.mktemp("fuzzy")
    (place / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "page.py"], cwd=place, env={**os.environ, "MPLBACKEND": "Agg"}, capture_output=True, text=True
    )
    (place / "python.txt").write_text(done.stdout, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    script = sessions.prepare(PAGE, place, {})
    done = subprocess.run(["bash", str(script)], cwd=place, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    (place / "commands.txt").write_text(done.stdout, encoding="utf-8")
    return place


def test_the_python_of_the_page_prints_what_it_shows(folder):
    assert_printed(PAGE, (folder / "python.txt").read_text(encoding="utf-8"))
    assert sum(map(bool, shown(PAGE))) >= 9


def test_every_command_does_what_it_shows(folder):
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    sessions.compare(PAGE, (folder / "commands.txt").read_text(encoding="utf-8"))
    assert all(step.shown for step in sessions.steps_of(PAGE))


def test_the_example_is_the_system_of_the_page(folder):
    assert (EXAMPLES / "axis.fll").read_bytes() == (folder / "axis.fll").read_bytes()


def test_the_experiment_file_is_that_of_the_page_and_does_its_run(folder):
    import numpy as np

    from leadscrew import experiment, load

    example = EXAMPLES / "axis_on_the_lathe.toml"
    lines = [line for line in example.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert lines == (folder / example.name).read_text(encoding="utf-8").splitlines()
    found = experiment.read(example)
    _, signals = load(folder / "lathe_run")
    run = found.loop().run(found.seconds())
    assert np.array_equal(run["actual.position"], signals["actual.position"])


def test_pictures_on_the_page_are_there():
    import re

    wanted = re.findall(r"\]\((images/[^)]+)\)", PAGE.read_text(encoding="utf-8"))
    assert len(wanted) == 3
    assert all((PAGE.parent / image).stat().st_size > 10_000 for image in wanted)
