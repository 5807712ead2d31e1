"""Rows of fresh processes: cold, cached, and the import alone."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from typing import Any

from leadscrew.bench.row import row

FIRST_RESULT = "from leadscrew.bench.loops import lathe; lathe().run(4.0)"


def wall(folder: str) -> float:
    """Seconds from the start of a process to the end of its first run, its cache in ``folder``."""
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", FIRST_RESULT], check=True, env={**clean, "LEADSCREW_CACHE_DIR": folder})
    return time.perf_counter() - began


def import_seconds() -> float:
    """What ``python -X importtime`` says of ``import leadscrew``."""
    said = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", "import leadscrew"], check=True, capture_output=True, text=True
    ).stderr
    line = next(x for x in reversed(said.splitlines()) if x.split("|")[-1].strip() == "leadscrew")
    return int(line.split("|")[1]) / 1e6


def rows(rounds: int) -> list[dict[str, Any]]:
    """Cold, cached, import."""
    with tempfile.TemporaryDirectory(prefix="leadscrew-bench-") as folder:
        cold = wall(folder)
        cached = sorted(wall(folder) for _ in range(rounds))[rounds // 2]
    imported = sorted(import_seconds() for _ in range(rounds))[rounds // 2]
    what = "process start to first result, wall time"
    return [
        row("start, cold", what, cold, "s", at_most=3.0),
        row("start, cached", what, cached, "s", at_most=0.9),
        row("import leadscrew", "python -X importtime, in all", imported, "s", at_most=0.15),
    ]
