"""The machine that the numbers hold for, and its load."""

from __future__ import annotations

import os
import platform
import shutil
from pathlib import Path
from typing import Any

from leadscrew.bench.row import row


def load() -> float | None:
    """The load average of the last minute, None where the system does not tell."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def processor() -> str:
    """What the processor calls itself."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = (x.split(":", 1)[1].strip() for x in lines if x.startswith("model name"))
    return next(named, platform.processor() or platform.machine())


def row_of_load(when: str) -> dict[str, Any]:
    """The load as a row, beside what the machine is."""
    gcc = "" if shutil.which("gcc") else ", no gcc"
    remark = f"{processor()}, {os.cpu_count()} cores seen, Python {platform.python_version()}{gcc}"
    return row("machine", f"load average of the last minute, {when} the bench", load(), "", remark=remark)
