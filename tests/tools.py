"""What a machine may lack: tests that need it skip and name it, or fail where ``LEADSCREW_REQUIRE`` names it."""

import os
import shutil
from typing import NoReturn

import pytest

TOOLS = {
    "gcc": "a C compiler",
    "g++": "a C++ compiler",
    "clang": "a second C compiler",
    "nm": "the symbols of a library, from binutils",
    "linuxcnc": "LinuxCNC and its HAL",
    "fmpy": "an FMU importer",
    "ecospy": "an FMU importer",
    "chromium": "a browser and Playwright",
    "node": "JavaScript outside a browser",
    "octave": "GNU Octave",
    "fuzzylite": "an independent fuzzy toolbox",
    "peers": "the other fuzzy toolboxes of 'make peers'",
    "pathsim": "a simulator to be measured against",
    "cosmic_ray": "what 'make mutants' changes code with",
    "shared": "measured data that is not in the repository",
    "posix": "signals, pipes and limits of POSIX",
    "x86-64": "the processor whose assembly a test reads",
    "fma": "a processor with fused multiply-add",
    "openblas": "a NumPy with several kernels of OpenBLAS",
}
"""The only reasons for a skip. A machine with Python alone has none but the last four."""


def missing(tool: str, reason: str) -> NoReturn:
    """Skips the test, or fails it where the tool is required (as in CI: ``LEADSCREW_REQUIRE=gcc,linuxcnc``)."""
    assert tool in TOOLS, f"{tool} is not in TOOLS"
    if tool in os.environ.get("LEADSCREW_REQUIRE", "").split(","):
        pytest.fail(f"{tool} is required here: {reason}")
    pytest.skip(f"{tool}: {reason}")


def runnable(engine: str) -> str:
    """The engine; skips or fails where it is ``c`` and the machine has no compiler."""
    if engine == "c" and shutil.which("gcc") is None:
        missing("gcc", "not installed")
    return engine


def needed(module: str, extra: str = "bench") -> None:
    """Skips or fails where a Python package is not installed."""
    try:
        __import__(module)
    except (ImportError, OSError):  # or a library of the system that it loads
        missing(module, f"pip install leadscrew[{extra}]")
