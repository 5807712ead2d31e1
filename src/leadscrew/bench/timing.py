"""Interleaved timing: every contender in turn, round after round, process CPU time, medians."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from statistics import median


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
