"""Every example that a reader sees works: the Python blocks and the commands of README and docs, and the notebook."""

from __future__ import annotations

import importlib.util
import shlex
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest

from leadscrew.export.folder import compiler_path
from tests.docs.sessions import assert_shown, steps_of
from tests.docs.snippets import PAGES, ROOT, blocks, commands_of, python_of
from tests.notebook import executed
from tests.tools import missing

matplotlib.use("Agg")
LONG = ("leadscrew demo", "leadscrew run", "leadscrew bench", "leadscrew cache clear", "leadscrew panel")
"""Commands that other tests run, that never end, or that would disturb this machine."""
ELSEWHERE = ("export.md", "fuzzy.md", "identify_linear.md", "log_to_machine.md", "tuning.md")
"""Pages whose Python and commands need what the other wrote: tests of their own run both."""
QUICK = ("README.md", "first_steps.md", "blocks.md", "loops.md", "engines.md", "add_controller.md", "add_plant.md")
"""Pages that run in every `make test`; the others run with the slow sweep."""
COMMANDS = {
    page: [c for c in commands_of(page) if not c.startswith(LONG)] for page in PAGES if page.name not in ELSEWHERE
}


def each(pages):
    return [pytest.param(p, marks=() if p.name in QUICK else pytest.mark.slow, id=p.name) for p in pages]


@pytest.mark.slow
@pytest.mark.parametrize("page", each(p for p in PAGES if blocks(p, ("python",)) and p.name not in ELSEWHERE))
def test_python_of_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = f"page_{page.stem.lower()}"
    file = tmp_path / f"{name}.py"
    file.write_text(python_of(page), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, module)
    spec.loader.exec_module(module)


def test_first_loop_of_the_readme_is_short() -> None:
    _, first = blocks(ROOT / "README.md", ("python",))[0]
    assert len([line for line in first if line.strip()]) <= 25


@pytest.mark.slow
@pytest.mark.parametrize("page", each(p for p in COMMANDS if COMMANDS[p]))
def test_commands_of_a_page_run(page: Path, tmp_path: Path) -> None:
    shown = {step.command: step for step in steps_of(page)}
    for command in COMMANDS[page]:
        if command.startswith("leadscrew export") and compiler_path() is None:
            missing("gcc", "there is no C compiler on this machine")
        program = [sys.executable, "-c", "from leadscrew.cli import main; main()", *shlex.split(command)[1:]]
        done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stdout + done.stderr
        if command in shown:
            assert_shown(shown[command], done.stdout)


def test_links_between_pages_lead_somewhere() -> None:
    import re

    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#\s]+?\.(?:md|cff|png)|LICENSE|NOTICE)\)", text):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


@pytest.mark.slow
def test_notebook_runs(tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat", reason="nbformat is missing: pip install leadscrew[dev]")
    notebook = nbformat.read(ROOT / "docs" / "notebooks" / "first_loop.ipynb", as_version=4)
    executed(notebook, tmp_path)
    shown = [out for cell in notebook.cells if cell.cell_type == "code" for out in cell.outputs]
    assert sum("text/html" in out.get("data", {}) for out in shown) == 1, "a run shows a table"
    assert sum("image/png" in out.get("data", {}) for out in shown) == 2, "figures show themselves"
