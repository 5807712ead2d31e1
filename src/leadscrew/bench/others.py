"""Rows of slower ways: plain Python, our Python engine, SciPy, python-control, PathSim."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import entries, loops, peers, plain
from leadscrew.bench.row import row
from leadscrew.bench.servo import INTEGRATORS, MOVING
from leadscrew.bench.timing import interleaved, repeated
from leadscrew.bench.yardstick import Yardstick

TIGHT = "DOP853, rtol 1e-12, per control period"
LIMITS = {"python-control, hold": 1000.0, "python-control, RK4": 1000.0}
"""How many times faster than a peer ours has to be."""
PLAIN = {
    "hold": "no target: the 30 x was measured on RK4; one exact step leaves little to do but pow, C in CPython",
    "rk4": "the form that the target was measured on",
}


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
    """All rows of this file; the ratio is theirs over ours with the same integrator, or one at least as accurate."""
    loop = loops.lathe()
    p = Yardstick.parameters(loop)
    slow = loop.start(engine="python")
    begin = slow.save()

    def on_python() -> None:
        slow.restore(begin)
        slow.advance(MOVING, every=0)

    contenders: dict[str, Callable[[], object]] = {"engine": on_python}
    for form in INTEGRATORS:
        call, by_hand = entries.single(loops.lathe(form), MOVING), getattr(plain, form)
        contenders[form] = repeated(call, 20)
        contenders[f"plain {form}"] = partial(by_hand, p, MOVING)
    seen = interleaved(contenders, rounds)
    ours = {f: seen[f] / MOVING / 20 for f in INTEGRATORS}
    made = []
    for form, integrator in INTEGRATORS.items():
        each = seen[f"plain {form}"] / MOVING
        error = float(np.abs(np.array(getattr(plain, form)(p, len(reference))) - reference).max())
        made.append(row(f"plain Python, {form}", "local floats, by hand", each * 1e9, ratio=each / ours[form],
                        at_least=30.0 if form == "rk4" else None, integrator=integrator, error=error,
                        remark=PLAIN[form]))  # fmt: skip
    each = seen["engine"] / MOVING
    made.append(row("our Python engine, hold", "first 0.8 s, moving", each * 1e9, ratio=each / ours["hold"],
                    integrator=INTEGRATORS["hold"], error=errors["hold"]))  # fmt: skip
    for name, (package, integrator, run) in peers.PEERS.items():
        if peers.missing(package):
            made.append(row(name, "the same loop", integrator=integrator, remark="not installed"))
            continue
        run(p, 3)
        began = time.process_time()
        found = run(p, len(reference))
        each = (time.process_time() - began) / len(reference)
        error = float(np.abs(found - reference[: len(found)]).max())
        form = "rk4" if errors["rk4"] <= 1.01 * error else "hold"
        note = peers.NOTES.get(name, "")
        made.append(row(name, f"the same loop, first {len(reference)} periods", each * 1e9, ratio=each / ours[form],
                        at_least=LIMITS.get(name), integrator=integrator, error=error,
                        remark=f"against our {INTEGRATORS[form]}, error {errors[form]:.1e} mm{note}"))  # fmt: skip
    return made
