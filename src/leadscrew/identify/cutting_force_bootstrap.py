"""Intervals of a force law from drawing its residuals again."""

from __future__ import annotations

import numpy as np

from leadscrew.identify.cutting_force import ForceFit
from leadscrew.identify.cutting_force_fit import CONFIDENCE, Interval, power_model
from leadscrew.kernel.errors import ValueRefused


def bootstrap(fit: ForceFit, draws: int = 2000, seed: int = 1) -> dict[str, Interval]:
    """Intervals of the log-log power law from drawing residuals again, as a check of the ``t`` intervals.

    Residuals are first widened by ``1 / sqrt(1 - leverage)``. With fewer than some ten rows such intervals are too
    narrow: there are few residuals to draw from.

    Raises:
        ValueRefused: fewer than 100 draws, or more than a million.
    """
    if not 100 <= draws <= 1_000_000:
        raise ValueRefused(f"bootstrap = {draws!r}: allowed range is 100 to 1000000 draws")
    table, exponent = fit.table, fit.law.exponent if fit.exponent_given else None
    model = power_model(exponent)
    design, given = model.columns(table.feed, table.depth), model.given(np.array([table.feed, table.depth]))
    solver = np.linalg.pinv(design)
    x = solver @ (np.log(table.force) - given)
    leverage = np.einsum("ij,ji->i", design, solver)
    left = (np.log(table.force) - given - design @ x) / np.sqrt(np.maximum(1.0 - leverage, 1e-12))
    picked = np.random.default_rng(seed).choice(left - left.mean(), size=(draws, len(left)))
    found = x + picked @ solver.T
    ends = np.quantile(found, [0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE], axis=0)
    as_shown: dict[str, Interval] = {}
    for i, name in enumerate(model.names):
        values = (x[i], ends[0, i], ends[1, i])
        as_shown[name] = Interval(*(float(np.exp(v)) if name == "kf" else float(v) for v in values))
    return as_shown
