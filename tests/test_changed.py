"""``--changed-since``: which tests of a small repository run after a change."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.changed import EVALUATION, QUARTER, choice, drawn

HERE = Path(__file__).parent
FILES = {
    "src/leadscrew/__init__.py": "",
    "src/leadscrew/one.py": "",
    "src/leadscrew/two.py": "",
    ".gitignore": "__pycache__\n",
    "tests/__init__.py": "",
    "tests/conftest.py": "",
    "tests/test_one.py": "from leadscrew import one\ndef test_it(): pass\n",
    **{f"tests/test_two_{i}.py": "from leadscrew import two\ndef test_it(): pass\n" for i in range(40)},
}


def git(root, *args):
    who = ("-c", "user.name=x", "-c", "user.email=x@x")
    return subprocess.run(["git", *who, *args], cwd=root, check=True, capture_output=True, text=True).stdout.strip()


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A repository with one commit, and a change that is not committed."""
    monkeypatch.delenv("LEADSCREW_SWEEPS", raising=False)
    root = tmp_path / "repository"
    for name, text in FILES.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    git(tmp_path, "init", "-q", str(root))
    git(root, "add", "-A")
    git(root, "commit", "-q", "-m", "first")
    (root / "src/leadscrew/one.py").write_text("A = 1\n", encoding="utf-8")
    return root


def test_the_change_and_a_quarter_of_the_others_are_kept(root):
    kept, line = choice(root, "HEAD")
    assert "tests/test_one.py" in kept and 2 <= len(kept) - 1 <= 22
    assert line == (
        f"changed since HEAD: 1 files; test files: 1 by the change, {len(kept) - 1} by rotation, "
        f"{41 - len(kept)} left out"
    )


def test_the_rotation_draws_every_file_in_time():
    tests = [f"tests/test_{i}.py" for i in range(400)]
    draws = [drawn(f"{landing:040x}", tests) for landing in range(40)]
    assert {test for draw in draws for test in draw} == {*tests}
    assert sum(map(len, draws)) / 40 == pytest.approx(400 / QUARTER, rel=0.05)


def test_whole_evaluations_are_kept_by_a_change_of_theirs_alone(root):
    (root / "tests/studies").mkdir()
    whole = root / EVALUATION
    whole.write_text("def test_it():\n    pass\n", encoding="utf-8")
    git(root, "add", "-A")
    git(root, "commit", "-q", "-m", "studies")
    for landing in range(24):
        git(root, "commit", "-q", "--allow-empty", "-m", f"landing {landing}")
        assert EVALUATION not in choice(root, "HEAD")[0]
    whole.write_text("def test_it():\n    assert True\n", encoding="utf-8")
    assert EVALUATION in choice(root, "HEAD")[0]


def test_all_are_kept_where_nothing_can_be_said(root, tmp_path, monkeypatch):
    assert choice(root, "gone") == (None, "all test files: git does not know the commit gone")
    git(root, "commit", "-q", "-a", "-m", "second")
    git(tmp_path, "clone", "-q", "--depth", "1", f"file://{root}", "shallow")
    assert choice(tmp_path / "shallow", "HEAD") == (None, "all test files: the history is shallow")
    (tmp_path / "empty").mkdir()
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path))
    assert choice(tmp_path / "empty", "HEAD")[0] is None
    monkeypatch.setenv("LEADSCREW_SWEEPS", "whole")
    assert choice(root, "HEAD~1") == (None, "all test files: LEADSCREW_SWEEPS is whole")


@pytest.mark.parametrize(
    "workers", [(), pytest.param(("-p", "xdist", "-n", "2"), marks=pytest.mark.slow)], ids=["alone", "xdist"]
)
def test_pytest_runs_what_is_kept_and_says_so(root, workers):
    for name in ("links.py", "closure.py", "changed.py"):
        shutil.copy(HERE / name, root / "tests" / name)
    git(root, "add", "tests")
    git(root, "commit", "-q", "-m", "tools")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "tests.changed", "-p", "no:cacheprovider", *workers]
    env = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST_", "COV_"))}
    env |= {"PYTHONPATH": str(root / "src"), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(
        [*command, "--changed-since", "HEAD"], cwd=root, env=env, capture_output=True, text=True, timeout=60
    )
    kept, line = choice(root, "HEAD")
    assert done.returncode == 0, done.stdout + done.stderr
    assert line in done.stdout and f"{len(kept)} passed" in done.stdout
    assert "tests/test_one.py" in kept and len(kept) < 41
