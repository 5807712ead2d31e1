"""Rows of a robustness box: every controller of the XY table on twelve plants at three spindle speeds."""

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
FRESH = """
import json
from leadscrew.bench import robustness
print(json.dumps(robustness.boxed({most})))
"""


def boxed(most: int | None = None) -> dict[str, float]:
    """Seconds from the import of the study to every controller's errors in the box, and of the same once more.

    Each run: 20 s of a motion of 1 mm under cutting, sampled at 2 kHz with an encoder of 0.5 um and 0.1 um of noise,
    then the amplitudes at five lines by least squares. ``most``: only so many controllers.
    """
    began = time.perf_counter()
    from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
    from leadscrew.studies.npid_xytable.runs import Loops
    from leadscrew.studies.npid_xytable.scenarios import CUT_S
    from leadscrew.studies.npid_xytable.trials import BOX, trial

    names = list(CONTROLLERS)[:most]
    loops, walls, runs = Loops(), {}, 0
    for which in ("first", "again"):
        runs = sum(len(trial(loops, name, draws=1, box=BOX)) for name in names)
        walls[which] = time.perf_counter() - began
        began = time.perf_counter()
    return walls | {"controllers": len(names), "runs": runs, "simulated": runs * CUT_S}


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows, measured in a process of its own; ``quick`` takes two controllers and judges nothing."""
    before = load()
    idle = before is not None and before < IDLE
    done = subprocess.run(
        [sys.executable, "-c", FRESH.format(most=2 if quick else None)], capture_output=True, text=True, check=True
    )
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    what = f"{found['controllers']:.0f} controllers, 12 plants, 3 spindle speeds: {found['runs']:.0f} runs of 20 s"
    said = f"load {before:.2f} before" if before is not None else "load unknown"
    made = []
    for name, which in (("in a fresh process", "first"), ("once more", "again")):
        wall = found[which]
        made.append(
            row("robustness box", f"{what}, {name}", wall, "s", at_most=None if quick else LIMIT_S,
                judged=idle or wall <= LIMIT_S, remark=f"{found['simulated'] / wall:,.0f} x real time, {said}")
        )  # fmt: skip
    return made
