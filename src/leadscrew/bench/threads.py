"""Rows of a batch on one thread and on two."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from leadscrew.bench import loops, measuring
from leadscrew.bench.measuring import interleaved, load, row
from leadscrew.bench.servo import INTEGRATORS

PERIODS = 2000
"""Long enough that the door's work, about 10 us a run and on one thread, is under a tenth."""
IDLE = 0.7
"""Load average below which a machine counts as idle."""


def rows(rounds: int, runs: int, errors: dict[str, float]) -> list[dict[str, Any]]:
    """Wall time of the same batch with one thread and with two; judged on an idle machine only."""
    before = load()
    loop = loops.lathe()
    gains = {"plant.full_duty_speed_mm_s": np.linspace(259.0, 334.0, runs)}
    both = {str(k): measuring.batch(loop, PERIODS, gains, threads=k) for k in (1, 2)}
    walls = interleaved(both, rounds, time.perf_counter)
    idle = before is not None and before < IDLE
    said = "unknown" if before is None else f"{before:.2f}"
    remark = f"wall time; load {said} before" if idle else f"machine not idle: load {said}"
    facts: dict[str, Any] = {"integrator": INTEGRATORS["hold"], "error": errors.get("hold")}
    what = f"{runs} runs of {PERIODS} periods, validation included"
    return [
        row("batch, 1 thread", what, runs / walls["1"], "runs/s", **facts),
        row("batch, 2 threads", what, runs / walls["2"], "runs/s", ratio=walls["1"] / walls["2"], at_least=1.7,
            judged=idle, remark=remark, **facts),
    ]  # fmt: skip
