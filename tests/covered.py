"""``pytest -p tests.covered``: line coverage of the kernel by its own tests, traced while they run.

Tracing makes a test three times as slow, so no other pays for it. ``coverage combine`` and ``coverage report`` follow.
"""

import importlib
import pkgutil
from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

KERNEL = Path(__file__).parent / "kernel"
UNTRACED = ("test_c99.py",)
"""The pass over all blocks: minutes, and no line that the other tests of the kernel do not reach."""


class Covered:
    """Traces the tests of the kernel."""

    def __init__(self) -> None:
        self.coverage = Coverage(data_suffix=True, source=["leadscrew.kernel"])

    def imported(self) -> None:
        """What runs at import counts."""
        self.coverage.start()
        package = importlib.import_module("leadscrew.kernel")
        for module in pkgutil.walk_packages(package.__path__, "leadscrew.kernel."):
            importlib.import_module(module.name)
        self.coverage.stop()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Any:
        """Traces one test, its fixtures included."""
        own = KERNEL in item.path.parents and item.path.name not in UNTRACED
        if own:
            self.coverage.start()
        yield
        if own:
            self.coverage.stop()

    def pytest_sessionfinish(self) -> None:
        """Each worker of xdist writes a file of its own."""
        self.coverage.save()


def pytest_configure(config: pytest.Config) -> None:
    """Starts before any test module is imported."""
    plugin = Covered()
    plugin.imported()
    config.pluginmanager.register(plugin, "leadscrew-covered")
