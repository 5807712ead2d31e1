"""What the tests cost and why they skip: CPU time by folder and file; a skip must name the tool that is missing.

``--record=FILE`` writes which tests passed and which skipped; ``--not-yet=FILE`` leaves out those that passed there.
"""

import json
import os
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from tests.tools import TOOLS

BUDGET_MIN = 9.0
"""CPU minutes of ``make test`` beyond which its last lines say so; machines differ, so it does not fail."""


def cpu_s() -> float:
    """CPU time of this process and of the ones that it has waited for."""
    t = os.times()
    return t.user + t.system + t.children_user + t.children_system


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options."""
    group = parser.getgroup("leadscrew")
    group.addoption("--costs", action="store_true", help="print CPU minutes by folder and the ten dearest files")
    group.addoption("--record", metavar="FILE", help="write which tests passed and which skipped, as JSON")
    group.addoption("--not-yet", metavar="FILE", help="leave out the tests that passed in this record")


def pytest_configure(config: pytest.Config) -> None:
    """One ledger a process."""
    config.pluginmanager.register(Ledger(config), "leadscrew-costs")


class Ledger:
    """Adds up the costs; on the process that xdist starts it only sends them on."""

    def __init__(self, config: pytest.Config) -> None:
        self.config = config
        self.worker = hasattr(config, "workerinput")
        self.last = 0.0
        self.files: Counter[str] = Counter()
        self.outcomes: dict[str, str] = {}
        self.unnamed: dict[str, str] = {}
        self.workers_s, self.collect_s = 0.0, 0.0

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """Leaves out what passed before."""
        record = config.getoption("--not-yet")
        if record:
            passed = {k for k, v in json.loads(Path(record).read_text(encoding="utf-8")).items() if v == "passed"}
            if config.pluginmanager.has_plugin("leadscrew-covered"):  # it traces these, whether they ran or not
                from tests.covered import UNTRACED

                passed = {k for k in passed if not k.startswith("tests/kernel/") or k.split("::")[0].endswith(UNTRACED)}
            config.hook.pytest_deselected(items=[i for i in items if i.nodeid in passed])
            items[:] = [i for i in items if i.nodeid not in passed]

    def pytest_collection_finish(self) -> None:
        """From here on time belongs to tests."""
        self.last = self.collect_s = cpu_s()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_makereport(self) -> Any:
        """The CPU time of each phase goes with its report."""
        outcome = yield
        now = cpu_s()
        outcome.get_result().cpu_s = now - self.last
        self.last = now

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Adds a phase; on a worker the process that started it does."""
        if self.worker:
            return
        file = report.nodeid.split("::")[0]
        self.files[file] += getattr(report, "cpu_s", 0.0)
        if report.when == "call" or report.outcome != "passed":
            self.outcomes[report.nodeid] = report.outcome
        if report.skipped and not hasattr(report, "wasxfail"):
            reason = str(report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr)
            reason = reason.removeprefix("Skipped: ")
            if reason.split(":")[0] not in TOOLS:
                self.unnamed[report.nodeid] = reason

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """What a worker says at its end."""
        sent = getattr(node, "workeroutput", {})
        self.workers_s += sent.get("cpu_s", 0.0)
        self.collect_s += sent.get("collect_s", 0.0)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        """Sends or writes the record; a skip without the name of a tool fails the session."""
        if self.worker:
            self.config.workeroutput.update(cpu_s=cpu_s(), collect_s=self.collect_s)  # type: ignore[attr-defined]
            return
        record = self.config.getoption("--record")
        if record:
            path = Path(record)
            path.parent.mkdir(parents=True, exist_ok=True)
            kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
            path.write_text(json.dumps(kept | self.outcomes, indent=0), encoding="utf-8")
        if self.unnamed and exitstatus == 0:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Unnamed skips, CPU time, load."""
        say = terminalreporter.write_line
        for test, reason in self.unnamed.items():
            say(f"FAILED {test}: skipped for {reason!r}, which names no tool of tests/tools.py", red=True)
        if not self.files:
            return
        own = os.times()
        total = (own.user + own.system + self.workers_s if self.workers_s else cpu_s()) / 60.0
        load = "".join(f", load {x:.1f}" for x in os.getloadavg()[:1]) if hasattr(os, "getloadavg") else ""
        if self.config.getoption("--costs"):
            say(f"CPU minutes: {total:.1f}, of them start and collection {self.collect_s / 60.0:.1f}{load}")
            folders: Counter[str] = Counter()
            for file, seconds in self.files.items():
                folders["/".join(Path(file).parts[:2])] += seconds
            say("by folder: " + ", ".join(f"{k} {v / 60.0:.2f}" for k, v in folders.most_common()))
            say("dearest files: " + ", ".join(f"{k} {v / 60.0:.2f}" for k, v in self.files.most_common(10)))
        if "not slow" in str(self.config.getoption("markexpr")) and total > BUDGET_MIN:
            say(f"these tests took {total:.1f} CPU minutes{load}; the budget is {BUDGET_MIN:g}: see CONTRIBUTING.md")
