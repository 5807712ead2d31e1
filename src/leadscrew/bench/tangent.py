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
    from leadscrew.studies.sofnn_tangent.controllers import CONTROLLERS
    from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES
    from leadscrew.studies.sofnn_tangent.runs import CELLS, Loops
    from leadscrew.studies.sofnn_tangent.scenarios import SCENARIOS

    loops = Loops()
    seconds = CELLS * sum(SCENARIOS[f"{line}_{material}"].duration_s for line in LAPS for material in MATERIAL_NAMES)
    blocks = [CONTROLLERS[name] for name in list(CONTROLLERS)[:most]]

    def work() -> float:
        for block in blocks:  # blocks, not names: those are kept
            loops.cells(block)
        return seconds * len(blocks)

    return whole.twice(began, work) | {"controllers": len(blocks), "runs": 9 * CELLS * len(blocks)}


def said(found: dict[str, float]) -> str:
    """What was done."""
    return f"{found['controllers']:.0f} controllers, nine cells, five textures: {found['runs']:.0f} cuts"


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows; ``quick`` takes two controllers and judges nothing."""
    return whole.rows("tangential table", f"tangent.cut({2 if quick else None})", said, LIMIT_S, quick)
