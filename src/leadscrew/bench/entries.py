"""A loop's compiled entries with their vectors ready, so that a timing holds nothing but the loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from leadscrew.kernel.live import Live
from leadscrew.kernel.loop import Loop


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
