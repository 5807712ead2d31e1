"""Which test files a change selects, in a small tree."""

import pytest

from tests.closure import Tree

LAZY = """
from leadscrew.exports import exports
__getattr__, __dir__, __all__ = exports(__name__, __file__)
"""
FILES = {
    "src/leadscrew/__init__.py": "",
    "src/leadscrew/__main__.py": "from leadscrew.cli import main",
    "src/leadscrew/exports.py": "",
    "src/leadscrew/catalogue.py": """
BLOCKS: dict[str, str] = {
    "sine": "leadscrew.references._sine:sine",
    "ramp": "leadscrew.references._ramp:ramp",
}
STUDIES = {"lathe": "leadscrew.studies.lathe.study:STUDY"}
def block(name): ...
def blocks(): return [block(name) for name in BLOCKS]
""",
    "src/leadscrew/references/__init__.py": "",
    "src/leadscrew/references/_sine.py": "",
    "src/leadscrew/references/_ramp.py": "",
    "src/leadscrew/tune/__init__.py": LAZY,
    "src/leadscrew/tune/__init__.pyi": "from .job import Job as Job\nfrom .slow import slow as slow",
    "src/leadscrew/tune/job.py": "def helper():\n    from leadscrew import helper",
    "src/leadscrew/tune/slow.py": "",
    "src/leadscrew/helper.py": "",
    "src/leadscrew/studies/lathe/__init__.py": "",
    "src/leadscrew/studies/lathe/data/moves.csv": "1,2",
    "src/leadscrew/studies/lathe/study.py": """
from leadscrew.studies.results import contents_of
CONTENTS = contents_of(*(f"leadscrew.studies.lathe.{part}" for part in ("claims",)))
""",
    "src/leadscrew/studies/__init__.py": "",
    "src/leadscrew/studies/results.py": "def evaluate(study): ...",
    "src/leadscrew/studies/lathe/claims.py": "",
    "src/leadscrew/cli/__init__.py": """
from importlib import import_module
from leadscrew.cli.output import show
COMMANDS = {"run": "leadscrew.cli.run:run", "tune": "leadscrew.cli.tune:app"}
app = [import_module(target.split(":")[0]) for target in COMMANDS.values()]
def main(): ...
""",
    "src/leadscrew/cli/output.py": "",
    "src/leadscrew/cli/run.py": "from leadscrew import catalogue\nfrom leadscrew.studies.results import evaluate",
    "src/leadscrew/cli/tune.py": """
import typer
from leadscrew.cli import tune_all, tune_one
app = typer.Typer()
app.command("all")(tune_all.run)
app.command("one")(tune_one.run)
""",
    "src/leadscrew/cli/tune_all.py": "def run(): from leadscrew.tune import slow",
    "src/leadscrew/cli/tune_one.py": "",
    "docs/first.md": "# One\n```python\nfrom leadscrew import tune\ntune.Job()\n```\n",
    "docs/second.md": "# Two\n```console\n$ leadscrew run lathe\n```\n",
    "tests/__init__.py": "",
    "tests/conftest.py": "pytest_plugins = ['tests.plugin']",
    "tests/plugin.py": "SAID = 'see second.md'",
    "tests/pages.py": "PAGES = ROOT.glob('*.md')\ndef read(page): ...",
    "tests/tune/conftest.py": "from leadscrew.references._ramp import ramp",
    "tests/tune/test_job.py": "from leadscrew.tune import Job",
    "tests/tune/test_slow.py": "import leadscrew.tune as t\nt.slow()",
    "tests/tune/cases/a.csv": "1",
    "tests/test_block.py": "from leadscrew.catalogue import block\ndef test(): block('sine')",
    "tests/test_blocks.py": "from leadscrew import catalogue\ndef test(): catalogue.blocks()",
    "tests/test_study.py": "from leadscrew import catalogue\ndef test(): catalogue.study('lathe')",
    "tests/test_judged.py": "from leadscrew import catalogue\nfrom leadscrew.studies import results\nSTUDY = 'lathe'",
    "tests/test_run.py": "from leadscrew.cli import app\ndef test(): call(app, ['run', 'x'])",
    "tests/test_tune.py": "from leadscrew.cli import app\ndef test(): call(app, 'tune one x'.split())",
    "tests/test_any_command.py": "from leadscrew.cli import app\ndef test(command): call(app, [command])",
    "tests/test_process.py": "CODE = 'from leadscrew.references.{x} import a'\nMORE = 'import leadscrew.helper'",
    "tests/test_first_page.py": "from tests.pages import read\ndef test(): read('first.md')",
    "tests/test_all_pages.py": "from tests.pages import PAGES",
    "tests/test_nothing.py": "",
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    root = tmp_path_factory.mktemp("tree")
    for name, text in FILES.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    return Tree(root)


def selected(tree, *changed):
    return {test.removeprefix("tests/").removesuffix(".py") for test in tree.affected(changed)}


def test_a_name_of_a_lazy_package_leads_to_its_own_file(tree):
    assert selected(tree, "src/leadscrew/tune/job.py") == {"tune/test_job", "test_first_page", "test_all_pages"}
    assert selected(tree, "src/leadscrew/tune/slow.py") == {"tune/test_slow", "test_any_command"}


def test_imports_in_functions_and_in_strings_of_code_count(tree):
    assert {"tune/test_job", "test_process"} <= selected(tree, "src/leadscrew/helper.py")
    assert "test_nothing" not in selected(tree, "src/leadscrew/helper.py")


def test_a_change_of_a_package_reaches_who_imports_anything_below_it(tree):
    assert {"tune/test_job", "tune/test_slow"} <= selected(tree, "src/leadscrew/tune/__init__.py")


def test_a_block_reaches_tests_that_name_it_or_go_through_the_catalogue(tree):
    assert selected(tree, "src/leadscrew/references/_sine.py") == {"test_block", "test_blocks"}
    assert selected(tree, "src/leadscrew/references/_ramp.py") == {"test_blocks", "tune/test_job", "tune/test_slow"}


def test_claims_reach_tests_that_evaluate_the_study(tree):
    assert selected(tree, "src/leadscrew/studies/lathe/claims.py") == {"test_judged", "test_all_pages"}
    assert "test_study" in selected(tree, "src/leadscrew/studies/lathe/study.py")


def test_data_and_what_is_gone_count_as_their_package(tree):
    want = {"test_study", "test_judged", "test_all_pages"}
    assert selected(tree, "src/leadscrew/studies/lathe/data/moves.csv") == want
    assert selected(tree, "src/leadscrew/studies/lathe/gone.py") == want
    assert selected(tree, "tests/tune/cases/a.csv") == {"tune/test_job", "tune/test_slow"}


def test_a_command_reaches_tests_that_name_it_or_name_none(tree):
    assert selected(tree, "src/leadscrew/cli/run.py") == {"test_run", "test_any_command", "test_all_pages"}
    assert selected(tree, "src/leadscrew/cli/tune.py") == {"test_tune", "test_any_command"}
    assert selected(tree, "src/leadscrew/cli/tune_one.py") == {"test_tune", "test_any_command"}
    assert selected(tree, "src/leadscrew/cli/tune_all.py") == {"test_any_command"}
    assert "test_run" in selected(tree, "src/leadscrew/cli/output.py")


def test_a_page_reaches_the_tests_that_read_it(tree):
    assert selected(tree, "docs/first.md") == {"test_first_page", "test_all_pages"}
    assert selected(tree, "docs/second.md") == {"test_all_pages"}


@pytest.mark.parametrize("file", ["pyproject.toml", "tests/conftest.py", "tests/plugin.py"])
def test_what_all_tests_depend_on_selects_all(tree, file):
    assert selected(tree, "docs/first.md", file) == {t[6:-3] for t in FILES if "test_" in t}


def test_a_test_selects_itself(tree):
    assert selected(tree, "tests/test_nothing.py") == {"test_nothing"}
