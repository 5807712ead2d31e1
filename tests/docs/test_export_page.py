"""The page on export: its commands and what they show, the C that it quotes, its Python."""

import os
import re
import subprocess
import sys

import pytest

from leadscrew.export.folder import compiler_path
from tests.docs import sessions
from tests.docs.snippets import ROOT, blocks, python_of
from tests.tools import missing, needed

PAGE = ROOT / "docs" / "export.md"


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder in which every command of the page was typed."""
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    place = tmp_path_factory.mktemp("export")
    script = sessions.prepare(PAGE, place, {})
    done = subprocess.run(["bash", str(script)], cwd=place, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    (place / "printed.txt").write_text(done.stdout, encoding="utf-8")
    return place


def test_every_command_does_what_it_shows(folder):
    sessions.compare(PAGE, (folder / "printed.txt").read_text(encoding="utf-8"))


def without_lines(text):
    """C without the line numbers of the Python that it came from."""
    return re.sub(r"\.py:\d+", ".py", text)


def test_the_c_on_the_page_is_what_is_exported(folder):
    written = without_lines("\n".join(f.read_text(encoding="utf-8") for f in (folder / "lathe_c").glob("*.c")))
    quoted = ["\n".join(lines) for _, lines in blocks(PAGE, ("c",))]
    assert len(quoted) == 2
    for text in quoted:
        assert without_lines(text) in written


def test_the_manifest_s_table_names_every_field(folder):
    import json

    fields = set()
    for out in ("lathe_c", "lathe_float"):
        fields |= set(json.loads((folder / out / "manifest.json").read_text(encoding="utf-8")))
    rows = PAGE.read_text(encoding="utf-8").split("## The manifest")[1].split("\n## ")[0]
    assert fields == {x for row in re.findall(r"^\| (`.*?) \|", rows, re.MULTILINE) for x in re.findall("`(.*?)`", row)}


def test_the_python_of_the_page_runs(folder):
    needed("fmpy", "verify")
    (folder / "page.py").write_text(python_of(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=folder, env=os.environ, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
