"""``pytest -p tests.changed --changed-since COMMIT``: the tests that a change can affect, and a quarter of the others.

A test file is kept where its closure (:mod:`tests.closure`) has a file that differs from COMMIT, uncommitted files
included. The closure is static and may miss an edge; so a quarter of the other files is kept too, drawn by the hash of
HEAD. A draw has no rhythm: a count of commits modulo 4 leaves a quarter out for ever where each landing has four
commits, and the day's number repeats itself for all landings of a day. A file waits four landings on average, one in a
hundred files 16. All tests are kept where ``LEADSCREW_SWEEPS`` is ``whole``, the history is shallow or COMMIT unknown.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any
from zlib import crc32

import pytest

from tests.closure import Tree, changes, git

QUARTER = 4
KERNEL, ITS_OWN = "src/leadscrew/kernel/", "tests/kernel/"
"""The kernel is below everything. Where it changes, its own tests are kept (every block of the catalogue in C, machine
code and Python) and, as ever, a quarter of the others; ``make test`` has run all mechanisms."""
EVALUATION = "tests/studies/test_every_study.py"
"""Whole evaluations of studies, a minute and more: kept where something of the study has changed, never drawn."""


def drawn(head: str, tests: list[str]) -> list[str]:
    """The quarter of the test files that this commit draws."""
    return [test for test in tests if crc32(f"{head} {test}".encode()) % QUARTER == 0]


def choice(root: Path, commit: str) -> tuple[list[str] | None, str]:
    """The test files to keep, or None for all, and what the terminal says about it."""
    if os.environ.get("LEADSCREW_SWEEPS") == "whole":
        return None, "all test files: LEADSCREW_SWEEPS is whole"
    try:
        if git(root, "rev-parse", "--is-shallow-repository") == ["true"]:
            return None, "all test files: the history is shallow"
        (head,) = git(root, "rev-parse", "--verify", "HEAD^{commit}")
        (base,) = git(root, "rev-parse", "--verify", f"{commit}^{{commit}}")
        changed = changes(root, base)
    except (OSError, ValueError, subprocess.CalledProcessError):
        return None, f"all test files: git does not know the commit {commit}"
    tree = Tree(root)
    affected = tree.affected(f for f in changed if not f.startswith(KERNEL))
    if any(f.startswith(KERNEL) for f in changed):
        affected = sorted({*affected, *(t for t in tree.tests if t.startswith(ITS_OWN))})
    others = sorted({*tree.tests} - {*affected})
    heavy = tree.affected([EVALUATION]) if (root / EVALUATION).exists() else []
    too = drawn(head, sorted({*others} - {*heavy}))
    return [*affected, *too], (
        f"changed since {commit}: {len(changed)} files; test files: {len(affected)} by the change, "
        f"{len(too)} by rotation, {len(others) - len(too)} left out"
    )


class Changed:
    """Leaves out the tests of files that are not to be kept."""

    def __init__(self, root: Path, kept: list[str] | None, line: str) -> None:
        self.root, self.kept, self.line = root, kept, line

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: Any) -> None:
        """The workers of xdist take over the choice of the process that started them."""
        node.workerinput["changed"] = (self.kept, self.line)

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Keeps the tests of the chosen files."""
        if self.kept is not None:
            kept = {self.root / test for test in self.kept}
            config.hook.pytest_deselected(items=[item for item in items if item.path not in kept])
            items[:] = [item for item in items if item.path in kept]

    def pytest_report_header(self) -> str:
        """Above the tests, without ``-q``."""
        return self.line

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Below the tests."""
        terminalreporter.write_line(self.line)


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option."""
    parser.addoption("--changed-since", metavar="COMMIT", help="run tests that changes since COMMIT can affect")


def pytest_configure(config: pytest.Config) -> None:
    """Chooses, once: a worker of xdist takes over the choice."""
    commit = config.getoption("--changed-since")
    if commit:
        shared = getattr(config, "workerinput", {}).get("changed")
        plugin = Changed(config.rootpath, *(shared or choice(config.rootpath, commit)))
        config.pluginmanager.register(plugin, "changed-since")
