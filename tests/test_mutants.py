"""``make mutants`` on a small repository: who survives, and that nothing is left behind."""

import subprocess

import pytest

from tests import mutants
from tests.mutants import Mutant, differs, main, nearest_first
from tests.tools import needed

CODE = "def add(a: float, b: float) -> float:\n    return a + b\n\n\ndef unused(a):\n    return a > 0\n"
FILES = {
    ".gitignore": "__pycache__\nbuild\n",
    "src/leadscrew/__init__.py": "",
    "src/leadscrew/sums.py": CODE,
    "tests/__init__.py": "",
    "tests/test_sums.py": "from leadscrew.sums import add\ndef test_it(): assert add(1, 2) == 3\n",
    "tests/test_broken.py": "from leadscrew.sums import add\ndef test_it(): assert add(1, 2) == 4\n",
}


@pytest.fixture
def root(tmp_path, monkeypatch):
    root = tmp_path / "repository"
    for name, text in FILES.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    for command in (["init", "-q"], ["add", "-A"], ["-c", "user.name=x", "-c", "user.email=x@x", "commit", "-qm", "1"]):
        subprocess.run(["git", *command], cwd=root, check=True)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    return root


def three_mutants(file, code, seed):
    yield Mutant(file, 2, "Add_Sub", code, code.replace("a + b", "a - b"))
    yield Mutant(file, 6, "Gt_GtE", code, code.replace("a > 0", "a >= 0"))
    yield Mutant(file, 6, "Gt_Lt", code, code.replace("a > 0", "a < 0"))


@pytest.mark.slow
def test_a_change_that_no_test_notices_is_printed_and_the_tree_stays_as_it_is(root, monkeypatch, capsys):
    monkeypatch.setattr(mutants, "mutants_of", three_mutants)
    (root / "src/leadscrew/sums.py").write_text(CODE + "\n", encoding="utf-8")
    assert main(["--max", "2", "--base", "HEAD"], root) == 0
    printed = capsys.readouterr().out
    assert "src/leadscrew/sums.py: 2 mutants, 1 of 2 test files" in printed
    assert "survived src/leadscrew/sums.py:6 (Gt_GtE)\n    -    return a > 0\n    +    return a >= 0\n" in printed
    assert "1 killed, 0 timed out, 1 survived" in printed
    assert {n: (root / n).read_text(encoding="utf-8") for n in FILES} == {**FILES, "src/leadscrew/sums.py": CODE + "\n"}


def test_nothing_to_do_is_well_and_bad_input_is_not(root, capsys):
    assert main(["--base", "HEAD"], root) == 0
    for words in (["src/leadscrew/gone.py"], ["tests/test_sums.py"], ["--base", "gone"], ["--max", "0"]):
        with pytest.raises(SystemExit) as stop:
            main([*words], root)
        assert stop.value.code == 2
    assert "not a Python file of src" in capsys.readouterr().err


def test_annotations_of_functions_are_no_place_for_a_mutant():
    assert not differs("def f(a: int | None) -> int: return 1", "def f(a: int + None) -> str: return 1")
    assert differs("def f(a: int) -> int: return 1", "def f(a: int) -> int: return 2")
    assert not differs("a = 1", "a = = 1")


def test_the_nearest_tests_come_first():
    tests = ["tests/cli/test_tune.py", "tests/tune/test_job.py", "tests/tune/test_space.py", "tests/test_all.py"]
    want = ["tests/tune/test_space.py", "tests/tune/test_job.py", "tests/cli/test_tune.py", "tests/test_all.py"]
    assert nearest_first("src/leadscrew/tune/space.py", tests) == want


def test_the_mutants_of_a_file_are_python_and_take_each_place_once():
    needed("cosmic_ray", "mutants")
    generated = list(mutants.mutants_of("src/leadscrew/sums.py", CODE, 1))
    assert {m.line for m in generated} == {2, 6} and {m.line for m in generated[:2]} == {2, 6}
    assert [m.after for m in mutants.mutants_of("src/leadscrew/sums.py", CODE, 1)] == [m.after for m in generated]
    assert all(m.diff.count("\n") == 1 for m in generated)
