"""Tools that a machine may lack: their tests skip with a reason, or fail where ``LEADSCREW_REQUIRE`` names the tool."""

import os
import shutil
from typing import NoReturn

import pytest


def missing(tool: str, reason: str) -> NoReturn:
    """Skips the test, or fails it where the tool is required (as in CI: ``LEADSCREW_REQUIRE=gcc,control``)."""
    if tool in os.environ.get("LEADSCREW_REQUIRE", "").split(","):
        pytest.fail(f"{tool} is required here: {reason}")
    pytest.skip(reason)


def runnable(engine: str) -> str:
    """The engine; skips or fails where it is ``c`` and the machine has no compiler."""
    if engine == "c" and shutil.which("gcc") is None:
        missing("gcc", "gcc is not installed")
    return engine


def needed(module: str, extra: str = "bench") -> None:
    """Skips or fails where a Python package is not installed."""
    try:
        __import__(module)
    except ImportError:
        missing(module, f"{module} is not installed: pip install leadscrew[{extra}]")
