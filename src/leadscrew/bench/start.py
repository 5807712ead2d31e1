"""Rows of fresh processes: cold, cached, the import alone; and what compiling a loop costs."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from statistics import median
from typing import Any

from leadscrew.bench.measuring import row

FIRST_RESULT = "from leadscrew.bench.loops import lathe; lathe({form!r}).run(4.0, engine={engine!r})"
COMPILES = """\
import time
from leadscrew.bench import loops, probes
probes.probe(probes.nothing).start().advance(1, every=0)
loop = loops.lathe()
loop.program.text
began = time.process_time()
loop.start().advance(1, every=0)
print(time.process_time() - began)
"""
"""A small loop first, so that imports and the compiler's own start do not count; then the text."""


def fresh(code: str, folder: str) -> str:
    """Runs a fresh process with its cache in ``folder``; what it printed."""
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, stdout=subprocess.PIPE, text=True,
        env={**clean, "LEADSCREW_CACHE_DIR": folder},
    )  # fmt: skip
    return done.stdout


def wall(folder: str, engine: str = "llvm", form: str = "hold") -> float:
    """Seconds from the start of a process to the end of its first run, its cache in ``folder``."""
    began = time.perf_counter()
    fresh(FIRST_RESULT.format(engine=engine, form=form), folder)
    return time.perf_counter() - began


def import_seconds() -> float:
    """What ``python -X importtime`` says of ``import leadscrew``."""
    said = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", "import leadscrew"], check=True, capture_output=True, text=True
    ).stderr
    line = next(x for x in reversed(said.splitlines()) if x.split("|")[-1].strip() == "leadscrew")
    return int(line.split("|")[1]) / 1e6


def compile_seconds() -> float:
    """Processor seconds from the lathe's generated text to the end of its first period, nothing cached."""
    with tempfile.TemporaryDirectory(prefix="leadscrew-bench-") as folder:
        return float(fresh(COMPILES, folder))


def compile_rows(rounds: int) -> list[dict[str, Any]]:
    """The lathe's entry to machine code."""
    seconds = median(compile_seconds() for _ in range(rounds))
    return [row("compilation, llvm", "the lathe's single-run entry, text to machine code", seconds, "CPU s")]


def c_rows(rounds: int) -> list[dict[str, Any]]:
    """Cold and cached starts of the engine ``c``, for a plant that is integrated and for one that SciPy prepares."""
    import shutil

    found = []
    for form, remark, bounds in (
        ("rk4", "with gcc", (0.6, 0.25)),
        ("hold", "with gcc, and SciPy imported for the plant's matrix exponential where it is not cached", (0.6, 0.25)),
    ):
        what = f"process start to first result, wall time, {form}"
        if shutil.which("gcc") is None:
            found.append(row("start, engine c", what, unit="s", remark="left out: no gcc"))
            continue
        colds, warms = [], []
        for _ in range(rounds):
            with tempfile.TemporaryDirectory(prefix="leadscrew-bench-") as folder:
                colds.append(wall(folder, "c", form))
                warms.append(wall(folder, "c", form))
        found.append(row("start, engine c, cold", what, median(colds), "s", at_most=bounds[0], remark=remark))
        found.append(row("start, engine c, cached", what, median(warms), "s", at_most=bounds[1]))
    return found


def rows(rounds: int) -> list[dict[str, Any]]:
    """Cold, cached, import."""
    with tempfile.TemporaryDirectory(prefix="leadscrew-bench-") as folder:
        cold = wall(folder)
        cached = median(wall(folder) for _ in range(rounds))
    what = "process start to first result, wall time"
    return [
        row("start, cold", what, cold, "s", at_most=3.0, remark="engine llvm, the default"),
        row("start, cached", what, cached, "s", at_most=0.9, remark="engine llvm, the default"),
        row("import leadscrew", "python -X importtime, in all", median(import_seconds() for _ in range(rounds)), "s",
            at_most=0.15),
        *c_rows(rounds),
    ]  # fmt: skip
