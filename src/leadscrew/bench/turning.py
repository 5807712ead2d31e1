"""Rows of a Monte Carlo in turning: every force controller of the study on random materials, depths and machines."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from typing import Any

from leadscrew.bench.machine import load
from leadscrew.bench.row import row
from leadscrew.bench.threads import IDLE

LIMIT_S = 20.0
DRAWS = 300
FRESH = """
import json
from leadscrew.bench import turning
print(json.dumps(turning.drawn({most})))
"""


def drawn(most: int | None = None) -> dict[str, float]:
    """Seconds from the import of the study to every controller's readings with their intervals, and once more: by the
    clock, and of the processor.

    Each run: 3 s of a cut at 150 N, the lathe stepped by the millisecond, the controller every 20 ms. ``most``: only so
    many controllers.
    """
    began, used = time.perf_counter(), time.process_time()
    from leadscrew.studies.grey_turning.montecarlo_runs import MonteCarlo, force_controllers, table
    from leadscrew.studies.grey_turning.runs import Loops

    loops = Loops()
    walls: dict[str, float] = {}
    names = force_controllers(loops)[:most]
    for which in ("first", "again"):
        made = MonteCarlo(loops)
        table({name: made.of(name, "plant_f", DRAWS) for name in names})
        walls |= {which: time.perf_counter() - began, f"{which}_cpu": time.process_time() - used}
        began, used = time.perf_counter(), time.process_time()
    runs = DRAWS * len(names)
    return walls | {"controllers": len(names), "runs": runs, "simulated": runs * 3.0}


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows, measured in a process of its own; ``quick`` takes two controllers and judges nothing."""
    before = load()
    idle = before is not None and before < IDLE
    done = subprocess.run(
        [sys.executable, "-c", FRESH.format(most=2 if quick else None)], capture_output=True, text=True, check=True
    )
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    what = f"{found['controllers']:.0f} controllers, {DRAWS} draws each, intervals: {found['runs']:.0f} cuts of 3 s"
    busy = f"load {before:.2f} before" if before is not None else "load unknown"
    made = []
    for name, which in (("in a fresh process", "first"), ("once more", "again")):
        wall = found[which]
        said = f"{found[f'{which}_cpu']:.1f} s of processor time, {found['simulated'] / wall:,.0f} x real time, {busy}"
        made.append(
            row("turning Monte Carlo", f"{what}, {name}", wall, "s", at_most=None if quick else LIMIT_S,
                judged=idle or wall <= LIMIT_S, remark=said)
        )  # fmt: skip
    return made
