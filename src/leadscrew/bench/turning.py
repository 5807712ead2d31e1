"""Rows of a Monte Carlo in turning: every force controller of the study on random materials, depths and machines."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from leadscrew.bench import whole

LIMIT_S = 20.0
DRAWS = 300


def drawn(most: int | None = None) -> dict[str, float]:
    """Seconds from the import of the study to every controller's readings with their intervals, and once more.

    Each run: 3 s of a cut at 150 N, the lathe stepped by the millisecond, the controller every 20 ms. ``most``: only so
    many controllers.
    """
    began = time.perf_counter()
    from leadscrew.studies.grey_turning.random_plants import SECONDS, share
    from leadscrew.studies.grey_turning.random_plants import drawn as drawn_on
    from leadscrew.studies.grey_turning.study import STUDY
    from leadscrew.studies.lab import Lab
    from leadscrew.tune.statistics import quantiles

    names = list(STUDY.controllers)[:most]
    runs = DRAWS * len(names)

    def work() -> float:
        lab = Lab(STUDY)
        for name in names:
            reading = drawn_on(lab, name, "plant_f", DRAWS)
            share(reading.bad)
            quantiles(reading.overshoot, (50.0, 90.0))
            quantiles(reading.rise_s[np.isfinite(reading.rise_s)], (50.0,))
        return runs * SECONDS

    return whole.twice(began, work) | {"controllers": len(names), "runs": runs}


def said(found: dict[str, float]) -> str:
    """What was done."""
    return f"{found['controllers']:.0f} controllers, {DRAWS} draws each, intervals: {found['runs']:.0f} cuts of 3 s"


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows; ``quick`` takes two controllers and judges nothing."""
    return whole.rows("turning Monte Carlo", f"turning.drawn({2 if quick else None})", said, LIMIT_S, quick)
