"""Rows of a machine that is operated: what its periods cost, and what a look at its reasons does; no browser needed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from leadscrew.bench.measuring import interleaved, row

PERIODS = 20
"""Of a loop at 1 kHz: those of one frame at 50 frames a second."""
TURN = 8000
"""Periods of the circle: 0.5 Hz at 4 kHz."""


def rows(quick: bool) -> list[dict[str, Any]]:
    """Milliseconds of 20 periods of the lathe's servo in operation, and of a look at rules and at a circle."""
    rounds = 20 if quick else 200
    contenders = {"periods": _periods(), "rules": _rules(), "circle": _circle()}
    took = {name: 1000.0 * seconds for name, seconds in interleaved(contenders, rounds).items()}
    said = f"processor time, median of {rounds}"

    def made(name: str, what: str, most: float) -> dict[str, Any]:
        return row("panel", what, took[name], "ms", at_most=None if quick else most, remark=said)

    return [
        made("periods", f"vud_lathe, operated: {PERIODS} periods", 1.0),
        made("rules", "a look at the rules of vud_lathe", 2.0),
        made("circle", f"a look at a circle of {TURN} periods", 10.0),
    ]


def _periods() -> Callable[[], object]:
    from leadscrew.operate.operated import Operated, Start

    operated = Operated(Start("vud_lathe", "corrected.vud_beta_e", "sequence"))
    operated.advance(100)
    operated.set({"plant.full_duty_speed_mm_s": 280.0})
    return lambda: operated.advance(PERIODS)


def _rules() -> Callable[[], object]:
    from leadscrew.experiment import Experiment
    from leadscrew.operate.why import explainer

    name = "corrected.vud_beta_e"
    loop = Experiment("vud_lathe", name, "sequence").loop()
    live = loop.start()
    why = explainer(loop, name)
    run = live.advance(50, record=[c for c in live.program.plan.columns if c != "time"])
    at = {k: float(v[-1]) for k, v in run.signals.items()}
    return lambda: why.look(live, at)


def _circle() -> Callable[[], object]:
    import math

    import numpy as np

    from leadscrew import resolve
    from leadscrew.analysis.circular.simulation import with_reference
    from leadscrew.operate.why import Circle
    from leadscrew.references._sine import sine_motion

    own = resolve.study("fsmc_ballscrew").loop("ours.smc_4khz", "sine_slow")
    pair = [with_reference(own, sine_motion(amplitude=0.5, frequency=0.5, phase=p)) for p in (0.5 * math.pi, 0.0)]
    circle = Circle(pair, ["actual", "y.actual"])
    turn = 2.0 * math.pi * np.arange(TURN + 1000) / TURN
    oval = 0.5 + 4e-3 * np.cos(2.0 * turn)
    circle.feed(np.column_stack((oval * np.cos(turn), oval * np.sin(turn))))
    return circle.look
