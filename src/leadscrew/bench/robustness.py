"""Rows of a robustness box: every controller of the XY table on twelve plants at three spindle speeds."""

from __future__ import annotations

import time
from typing import Any

from leadscrew.bench import whole

LIMIT_S = 20.0


def boxed(most: int | None = None) -> dict[str, float]:
    """Seconds from the import of the study to every controller's errors in the box, and of the same once more.

    Each run: 20 s of a motion of 1 mm under cutting, sampled at 2 kHz with an encoder of 0.5 um and 0.1 um of noise,
    then the amplitudes at five lines by least squares. ``most``: only so many controllers.
    """
    began = time.perf_counter()
    from leadscrew.studies.lab import Lab
    from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
    from leadscrew.studies.npid_xytable.cutting import tried
    from leadscrew.studies.npid_xytable.scenarios import CUT_S
    from leadscrew.studies.npid_xytable.study import STUDY

    names, lab = list(CONTROLLERS)[:most], Lab(STUDY)
    runs: list[int] = []

    def work() -> float:
        runs.append(sum(len(tried(lab, name, draws=1, box=True).speeds) for name in names))
        return runs[-1] * CUT_S

    return whole.twice(began, work) | {"controllers": len(names), "runs": runs[-1]}


def said(found: dict[str, float]) -> str:
    """What was done."""
    return f"{found['controllers']:.0f} controllers, 12 plants, 3 spindle speeds: {found['runs']:.0f} runs of 20 s"


def rows(quick: bool = False) -> list[dict[str, Any]]:
    """The rows; ``quick`` takes two controllers and judges nothing."""
    return whole.rows("robustness box", f"robustness.boxed({2 if quick else None})", said, LIMIT_S, quick)
