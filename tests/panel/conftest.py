"""A real panel with the lathe, and a page before it that has control."""

from __future__ import annotations

import psutil
import pytest

from tests.panel.served import Served


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    panel = Served(tmp_path_factory.mktemp("panel"), "vud_lathe", "--timeout", "2")
    yield panel
    worker = panel.worker()
    assert panel.end() == 0, "Ctrl-C is the way to end a panel"
    assert not psutil.pid_exists(worker), "the machine's process ends with it"


@pytest.fixture
def page(served):
    found = served.page(secret="secret-of-this-test")
    found.did("take")
    if not found.machine:
        found.wait(lambda m: m.get("kind") == "machine")
    found.did("machine", study="vud_lathe", controller="ours.pd", scenario="s_curve_m50")
    found.wait(lambda m: m.get("kind") == "state" and m["t"] == 0)
    yield found
    found.close()
