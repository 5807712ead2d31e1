"""Rows of slower ways: plain Python, our Python engine, SciPy, python-control, PathSim."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from leadscrew.bench import entries, loops, peers, plain
from leadscrew.bench.row import row
from leadscrew.bench.servo import INTEGRATORS, MOVING
from leadscrew.bench.timing import interleaved
from leadscrew.bench.yardstick import Yardstick

TIGHT = "DOP853, rtol 1e-12, per control period"
LIMITS = {"python-control": 1000.0}
"""How many times faster than a peer ours has to be."""


def positions(loop: Any, periods: int) -> np.ndarray:
    """Positions of our loop at the start of each period."""
    found: np.ndarray = loop.run(periods * loop.period, record="actual.position")["actual.position"]
    return found


def accuracy(periods: int) -> tuple[np.ndarray, dict[str, float]]:
    """The tight reference and the largest distance of our two forms from it, in mm."""
    p = Yardstick.parameters(loops.lathe())
    reference = peers.solve_ivp(p, periods, "DOP853", 1e-12)
    return reference, {f: float(np.abs(positions(loops.lathe(f), periods) - reference).max()) for f in INTEGRATORS}


def rows(reference: np.ndarray, errors: dict[str, float], rounds: int) -> list[dict[str, Any]]:
    """All rows of this file; the ratio is theirs over ours in the form that is as accurate or more."""
    loop = loops.lathe()
    p = Yardstick.parameters(loop)
    fast = {form: entries.single(loops.lathe(form), MOVING) for form in INTEGRATORS}
    slow = loop.start(engine="python")

    def on_python() -> None:
        slow.__init__(loop, "python")  # type: ignore[misc]
        slow.advance(MOVING, every=0)

    seen = interleaved({**{f: lambda r=r: [r() for _ in range(20)] for f, r in fast.items()},
                        "plain": lambda: plain.hold(p, MOVING), "engine": on_python}, rounds)  # fmt: skip
    ours = {f: seen[f] / MOVING / 20 for f in INTEGRATORS}
    made = []
    for key, what, bound in (("plain", "plain Python, local floats, by hand", 30.0), ("engine", "our Python engine", None)):
        each = seen[key] / MOVING
        error = float(np.abs(np.array(plain.hold(p, len(reference))) - reference).max()) if key == "plain" else errors["hold"]
        made.append(row(what, "first 0.8 s, moving", each * 1e9, ratio=each / ours["hold"], at_least=bound,
                        integrator=INTEGRATORS["hold"], error=error))  # fmt: skip
    for name, (package, integrator, run) in peers.PEERS.items():
        if peers.missing(package):
            made.append(row(name, "the same loop", integrator=integrator, remark="not installed"))
            continue
        run(p, 3)
        began = time.process_time()
        found = run(p, len(reference))
        each = (time.process_time() - began) / len(reference)
        error = float(np.abs(found - reference[: len(found)]).max())
        form = "hold" if error >= errors["hold"] and error < errors["rk4"] else "rk4" if name != "python-control" else "hold"
        made.append(row(name, f"the same loop, first {len(reference)} periods", each * 1e9, ratio=each / ours[form],
                        at_least=LIMITS.get(name), integrator=integrator, error=error,
                        remark=f"against our {INTEGRATORS[form]}, error {errors[form]:.1e} mm"))  # fmt: skip
    return made
