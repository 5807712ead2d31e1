"""Rows of a table of tangential cuts: every controller of the study on three lines in three materials."""

from __future__ import annotations

import time
from typing import Any

from leadscrew.bench import whole

LIMIT_S = 60.0


def cut(most: int | None = None) -> dict[str, float]:
    """Seconds from the import of the study to every controller's deviations in nine cells, and of the same once more.

    Each cell: five textures of the line to its end, 7.9 to 9.2 s at 100 Hz. ``most``: only so many controllers.
    """
    began = time.perf_counter()
    from leadscrew.studies.lab import Lab
    from leadscrew.studies.sofnn_tangent.cuts import RUNS, cells
    from leadscrew.studies.sofnn_tangent.scenarios import LINES
    from leadscrew.studies.sofnn_tangent.study import STUDY

    names = list(STUDY.controllers)[:most]
    seconds = 3 * RUNS * sum(STUDY.scenario(f"{line}_fabric").duration_s for line in LINES)

    def work() -> float:
        lab = Lab(STUDY)  # a new one, as a lab keeps what it measures
        for name in names:
            cells(lab, name)
        return seconds * len(names)

    return whole.twice(began, work) | {"controllers": len(names), "runs": 9 * RUNS * len(names)}


def said(found: dict[str, float]) -> str:
    """What was done."""
    return f"{found['controllers']:.0f} controllers, nine cells, five textures: {found['runs']:.0f} cuts"


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows; ``quick`` takes two controllers and judges nothing."""
    return whole.rows("tangential table", f"tangent.cut({2 if quick else None})", said, LIMIT_S, quick)
