"""Rows of a whole job: what a study does at once, by the clock, in a fresh process and once more."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

from leadscrew.bench.measuring import load, row
from leadscrew.bench.threads import IDLE


def twice(began: float, work: Callable[[], float]) -> dict[str, float]:
    """Seconds of ``work`` from ``began`` (of ``perf_counter``) on, and once more; by the clock, and of the processor.

    ``work`` gives the seconds that it has simulated.
    """
    found: dict[str, float] = {}
    used = 0.0  # imports included: of a fresh process
    for which in ("first", "again"):
        found["simulated"] = work()
        now = time.process_time()
        found |= {which: time.perf_counter() - began, f"{which}_cpu": now - used}
        began, used = time.perf_counter(), now
    return found


def rows(name: str, call: str, what: Callable[[dict[str, float]], str], limit_s: float, quick: bool) -> list[Any]:
    """Two rows named ``name`` of what ``call`` (``module.function(arguments)`` of the bench) gives in a process of its
    own; ``quick`` judges nothing, a busy machine only where the limit is met.
    """
    before = load()
    idle = before is not None and before < IDLE
    module = call.split(".", 1)[0]
    code = f"import json\nfrom leadscrew.bench import {module}\nprint(json.dumps({call}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    said = f"load {before:.2f} before" if before is not None else "load unknown"
    made = []
    for when, which in (("in a fresh process", "first"), ("once more", "again")):
        wall = found[which]
        remark = (
            f"{found[f'{which}_cpu']:.1f} s of processor time, {found['simulated'] / wall:,.0f} x real time, {said}"
        )
        made.append(
            row(name, f"{what(found)}, {when}", wall, "s", at_most=None if quick else limit_s,
                judged=idle or wall <= limit_s, remark=remark)
        )  # fmt: skip
    return made
