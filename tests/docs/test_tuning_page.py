"""The page on tuning: what its commands show, and what its Python prints in the folder that they leave."""

import os
import re
import subprocess
import sys

import pytest

from leadscrew.export.folder import compiler_path
from tests.docs import sessions
from tests.docs.snippets import ROOT, assert_printed, shown, with_marks
from tests.tools import missing

PAGE = ROOT / "docs" / "tuning.md"
PARTS = sessions.apart(sessions.steps_of(PAGE))


def typed(place, part):
    """One of the two parts of the page's commands, under way."""
    script = sessions.prepare(PAGE, place, {}, PARTS[part], str(part))
    with (place / f"commands{part}.txt").open("wb") as out:
        return subprocess.Popen(["bash", str(script)], cwd=place, stdout=out, stderr=subprocess.STDOUT)


@pytest.mark.slow
def test_every_command_does_what_it_shows_and_so_does_the_python_in_the_folder_that_they_leave(tmp_path):
    """One test, so that workers of pytest-xdist do not type it all twice; what stands alone runs beside the rest."""
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    with typed(tmp_path, 0), typed(tmp_path, 1) as alone:
        alone.wait()
    for part, steps in enumerate(PARTS):
        sessions.compare(PAGE, (tmp_path / f"commands{part}.txt").read_text(encoding="utf-8"), steps)
    assert all(step.shown for step in sessions.steps_of(PAGE))
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, env=os.environ, capture_output=True, text=True)
    assert_printed(PAGE, done.stdout + done.stderr)
    assert sum(map(bool, shown(PAGE))) >= 3


def test_pictures_on_the_page_are_there():
    wanted = re.findall(r"\]\((images/[^)]+)\)", PAGE.read_text(encoding="utf-8"))
    assert len(wanted) == 2
    assert all((PAGE.parent / image).stat().st_size > 10_000 for image in wanted)
