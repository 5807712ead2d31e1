"""Rows of circular tests: three controllers of the ball-screw stage draw circles with two axes, at three feeds."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from leadscrew.bench import whole

STUDY = "fsmc_ballscrew"
CONTROLLERS = ("ours.smc_4khz", "ours.fsmc_4khz", "ours.pd_dob")
RADIUS_MM = 100.0
FEEDS_MM_MIN = (1000.0, 2000.0, 4000.0)
LIMIT_S = 10.0


def drawn(feeds: Sequence[float] = FEEDS_MM_MIN) -> dict[str, float]:
    """Seconds of all circles, from the import of the study to the quantities of ISO 230-4, and of the same once more.

    Each circle: X and Y with a loop each at 4 kHz and a scale of 10 nm, from rest, both directions, two turns, 1,800
    points of the second.
    """
    began = time.perf_counter()
    from leadscrew.analysis.circular.quantities import quantities
    from leadscrew.analysis.circular.simulation import Circle, Machine, draw
    from leadscrew.experiment import Experiment

    axes = {name: Experiment(STUDY, name, "sine_wide").loop() for name in CONTROLLERS}

    def work() -> float:
        simulated = 0.0
        for axis in axes.values():
            for feed in feeds:
                circle = Circle(RADIUS_MM, feed)
                quantities(draw(Machine(axis, axis), circle))
                simulated += 4.0 * 2.125 * 6.283185307179586 / circle.speed
        return simulated

    return whole.twice(began, work)


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows; ``quick`` takes the fastest feed alone and judges nothing."""
    feeds = FEEDS_MM_MIN[-1:] if quick else FEEDS_MM_MIN
    what = f"{len(CONTROLLERS)} controllers, both axes, both directions, {len(feeds)} feeds, R = {RADIUS_MM:g} mm"
    return whole.rows("circular test", f"circles.drawn({feeds!r})", lambda found: what, LIMIT_S, quick)
