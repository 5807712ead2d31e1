"""Tests with one ``xdist_group`` run in one worker, and so do the slow tests of a small file: they share much.

For ``--dist loadgroup``. xdist 3.8 hands groups over in the node ids, which pytest 9.2 does not let it write, and says
nothing (pytest-xdist issue 1386); here the first worker leaves them in a file that the scheduler reads.
"""

import json
import os
import tempfile
from collections import Counter
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling

SMALL = 12
"""Slow tests of a file that is not worth dividing."""
FILE = "LEADSCREW_TEST_GROUPS"


def group(item: pytest.Item, counts: Counter[Path]) -> str:
    """The group of a test; of one without any its own name."""
    mark = item.get_closest_marker("xdist_group")
    if mark is not None:
        return str(mark.args[0])
    small = item.get_closest_marker("slow") is not None and counts[item.path] <= SMALL
    return str(item.path) if small else item.nodeid


class Together(LoadScopeScheduling):
    """Sends a group as a whole, the largest first."""

    @cached_property
    def groups(self) -> dict[str, str]:
        """The group of each test; it is there when all workers have collected."""
        found: dict[str, str] = json.loads(Path(os.environ[FILE]).read_text(encoding="utf-8"))
        return found

    def _split_scope(self, nodeid: str) -> str:
        return self.groups[nodeid]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Together | None:
    """Ours, for ``--dist loadgroup``."""
    return Together(config, log) if config.getoption("dist") == "loadgroup" else None


def pytest_configure(config: pytest.Config) -> None:
    """The workers inherit the name of the file."""
    if config.getoption("dist", "no") == "loadgroup":
        os.environ[FILE] = str(Path(tempfile.mkdtemp(prefix="leadscrew-groups-")) / "groups.json")


def pytest_unconfigure(config: pytest.Config) -> None:
    """The file goes with the session that made it."""
    if config.getoption("dist", "no") == "loadgroup" and FILE in os.environ:
        file = Path(os.environ.pop(FILE))
        file.unlink(missing_ok=True)
        file.parent.rmdir()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_finish(session: pytest.Session) -> None:
    """Before xdist says that the worker has collected."""
    if FILE in os.environ and os.environ.get("PYTEST_XDIST_WORKER") == "gw0":
        counts = Counter(item.path for item in session.items if item.get_closest_marker("slow"))
        found = {item.nodeid: group(item, counts) for item in session.items}
        Path(os.environ[FILE]).write_text(json.dumps(found), encoding="utf-8")
