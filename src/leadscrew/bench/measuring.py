"""What every row of the bench needs: its fields, interleaved timing, the machine's load, a loop's compiled entries."""

from __future__ import annotations

import os
import platform
import shutil
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from leadscrew.kernel.live import Live
from leadscrew.kernel.loop import Loop

FIELDS = ("name", "what", "value", "unit", "ratio", "target", "passed", "integrator", "error", "remark")


def row(
    name: str,
    what: str,
    value: float | None = None,
    unit: str = "ns/period",
    *,
    ratio: float | None = None,
    at_most: float | None = None,
    at_least: float | None = None,
    judged: bool = True,
    integrator: str = "",
    error: float | None = None,
    remark: str = "",
) -> dict[str, Any]:
    """A row; the target bounds the ratio where there is one, else the value.

    ``passed`` is True, False, or None where there is no target, nothing was measured, or ``judged`` is False.
    """
    seen = value if ratio is None else ratio
    sign = "x" if ratio is not None else unit
    target, passed = "", None
    if at_most is not None:
        target, passed = f"<= {at_most:g} {sign}", None if seen is None else bool(seen <= at_most)
    if at_least is not None:
        target, passed = f">= {at_least:g} {sign}", None if seen is None else bool(seen >= at_least)
    numbers = (None if x is None else float(x) for x in (value, ratio, error))
    value, ratio, error = numbers
    found = (name, what, value, unit, ratio, target, passed if judged else None, integrator, error, remark)
    return dict(zip(FIELDS, found, strict=True))


def interleaved(
    contenders: Mapping[str, Callable[[], object]], rounds: int, clock: Callable[[], float] = time.process_time
) -> dict[str, float]:
    """Median seconds of one call of each contender; each is called once before."""
    for call in contenders.values():
        call()
    seen: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(rounds):
        for name, call in contenders.items():
            began = clock()
            call()
            seen[name].append(clock() - began)
    return {name: median(times) for name, times in seen.items()}


def repeated(call: Callable[[], object], times: int) -> Callable[[], None]:
    """The call, a number of times."""

    def calls() -> None:
        for _ in range(times):
            call()

    return calls


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


def single(loop: Loop, periods: int, start: Live | None = None, engine: str = "llvm") -> Callable[[], Live]:
    """A call that moves the loop on by some periods, always from the same place, and records nothing."""
    live = start or loop.start()
    place = live.save()
    P, A = live.params
    S, B = live.state
    select, table, metrics = np.zeros(0, dtype=np.int64), np.zeros((1, 1)), np.zeros((1, max(1, len(loop.metrics))))
    counters = np.zeros(6, dtype=np.int64)
    run = loop.program.native("single", engine).bind(P, A, S, B, counters, select, table, metrics)

    def call() -> Live:
        S[:], B[:] = place.scalars, place.arrays
        counters[:] = (place.period, place.period + periods, 0, 0, 0, 0)
        run()
        return live

    return call


def batch(loop: Loop, periods: int, varied: Mapping[str, Any], threads: int = 1) -> Callable[[], Any]:
    """A call that runs a batch of metrics only."""
    return lambda: loop.batch(periods * loop.period, varied, threads=threads)
