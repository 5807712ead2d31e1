"""Covariances of the Kalman filter of the inference network over 20,000 updates: forms, precisions, forgetting.

Only the nine rules around zero are excited. ``data/covariance_forms.csv`` keeps the result; :func:`write` makes it
again. The forms are those of :mod:`leadscrew.neural.kalman_dense`.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew.neural.inference_net import AXIS, fired

FILE = Path(__file__).parent / "data" / "covariance_forms.csv"
MARKS = (100, 200, 500, 1000, 2000, 5000, 10000, 20000)
"""Updates after which a covariance is looked at."""
P0, R, FORGETTING = 1e4, 1e-4, 0.98
"""Variance of a consequent before, of a target, and what textbooks divide P by."""
INSIDE = 2.0
"""Largest E and EC, levels."""
UPDATES = 20000


class Row(NamedTuple):
    """A covariance after some updates."""

    form: str
    bits: int
    """Of a number: 32 or 64."""
    forgetting: float
    updates: int
    finite: bool
    positive: bool
    """Positive definite: its symmetric half has a Cholesky factor."""
    asymmetry: float
    """Largest difference of an element from its mirror image, levels squared."""
    trace: float
    """Levels squared."""


def covariance_forms() -> list[Row]:
    """Three forms in two precisions, with and without forgetting: half a minute."""
    from leadscrew.neural.kalman_dense import FORMS, regressor, updated

    points = np.random.default_rng(1).uniform(-INSIDE, INSIDE, (UPDATES, 2))
    regressors = [regressor(fired(AXIS, AXIS, e, ec)) for e, ec in points]
    rows: list[Row] = []
    for form in FORMS:
        for kind in (np.float32, np.float64):
            for forgetting in (1.0, FORGETTING):
                p: Any = (P0 * np.eye(49)).astype(kind)
                with np.errstate(all="ignore"):
                    for k, h in enumerate(regressors, start=1):
                        p = updated(p, h, R, form, forgetting)[1]
                        if k in MARKS:
                            rows.append(Row(form, 8 * p.itemsize, forgetting, k, *judged(p)))
    return rows


def judged(p: np.ndarray) -> tuple[bool, bool, float, float]:
    """Whether a covariance is finite and positive definite, its asymmetry and its trace."""
    full = p.astype(float)
    if not np.isfinite(full).all():
        return False, False, math.nan, math.nan
    try:
        np.linalg.cholesky(0.5 * (full + full.T))
        positive = True
    except np.linalg.LinAlgError:
        positive = False
    return True, positive, float(np.abs(full - full.T).max()), float(np.trace(full))


def write(path: Path = FILE) -> None:
    """Makes the table again."""
    lines = [",".join(Row._fields)]
    for row in covariance_forms():
        lines.append(
            ",".join(f"{x:.4g}" if isinstance(x, float) else f"{x:d}" if isinstance(x, int) else x for x in row)
        )
    path.write_text("\n".join(lines) + "\n")


def kept() -> list[Row]:
    """The table as it is kept."""
    rows = [line.split(",") for line in FILE.read_text().splitlines()[1:]]
    return [Row(a, int(b), float(c), int(d), e == "1", f == "1", float(g), float(h)) for a, b, c, d, e, f, g, h in rows]
