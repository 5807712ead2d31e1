"""Shared set-up: a compile cache of the tests' own, examples that are the same in CI, groups for xdist."""

import contextlib
import gc
import importlib
import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

from tests.budget import WHOLE

pytest_plugins = ["tests.groups", "tests.costs"]

# Kept from one session to the next: what is in it is named by its source and by that of the compiler.
os.environ.setdefault("LEADSCREW_CACHE_DIR", str(Path(__file__).parents[1] / "build" / "tests_cache"))

# What commands print is as wide as in a pipe, also in programs that tests start.
os.environ["COLUMNS"] = "100"

# Several workers share the cores: more threads of BLAS in each would only wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell that starts the tests in the background has Ctrl-C ignored, and so would every program that a test interrupts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# In CI the same examples every time: a search for new ones belongs to a developer's run, who can act on what it finds.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")


# Collecting makes no garbage worth the search for it.
gc.disable()


def pytest_sessionstart(session: pytest.Session) -> None:
    """Each worker begins its imports at another file, so that on a fresh clone none compiles what another has done."""
    worker = getattr(session.config, "workerinput", None)
    if worker is None or session.config.args != session.config.getini("testpaths"):
        return
    here = Path(__file__).parent
    names = [".".join(("tests", *f.relative_to(here).with_suffix("").parts)) for f in sorted(here.rglob("test_*.py"))]
    first = len(names) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
    for name in names[first:] + names[:first]:
        with contextlib.suppress(Exception, pytest.skip.Exception):  # collecting says what is wrong
            importlib.import_module(name)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Tests marked ``sweep`` run with ``LEADSCREW_SWEEPS=whole`` only: before a release."""
    if not WHOLE:
        left_out = [i for i in items if i.get_closest_marker("sweep")]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [i for i in items if not i.get_closest_marker("sweep")]


def pytest_collection_finish() -> None:
    """What was imported and collected stays to the end: no garbage collection need go through it again."""
    gc.collect()
    gc.freeze()
    gc.enable()
