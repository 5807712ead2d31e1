"""Does a predictor help on a recorded signal: errors of several predictors, sample by sample, beside the last value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadscrew.grey.vectorised import predictions
from leadscrew.util.errors import DataError

BESIDE = ("last", "line", "two_point")
"""What a grey model is always compared with: persistence and two straight lines."""
SPARE = 10
"""Predictions that a comparison needs at least."""
SURE = 2.0
"""Standard errors beyond which one predictor counts as better than another."""


@dataclass(frozen=True)
class Score:
    """One predictor on one signal; all errors are prediction minus value, in the unit of the signal."""

    model: str
    rmse: float
    worst: float
    """Largest error by size."""
    bias: float
    """Mean error."""
    better_share: float
    """Share of the samples whose prediction is nearer than the last value is."""
    against_last: float
    """Mean difference of squared errors to the last value, in its standard errors: negative is better."""

    @property
    def verdict(self) -> str:
        """``better``, ``worse`` or ``undecided`` against the last value."""
        if abs(self.against_last) <= SURE:
            return "undecided"
        return "better" if self.against_last < 0.0 else "worse"


def compare(
    signal, models: Sequence[str], length: int = 5, horizon: int = 1, **options: float
) -> tuple[list[Score], dict[str, np.ndarray]]:
    """Scores of the models, and their predictions, on the samples that all of them can predict.

    A prediction uses the ``length`` samples up to one and is compared with the sample ``horizon`` later. Whether a
    model differs from the last value is judged by the test of Diebold and Mariano: the mean difference of squared
    errors over its standard error, which counts correlation between neighbours (Newey and West, lag 2 n^(1/3)).

    Args:
        signal: samples at equal distance, one row.
        models: names of :data:`leadscrew.grey.predictors.KINDS`.
        length: samples of a window, four or more.
        horizon: samples ahead, one or more.
        options: ``reference`` and ``shift`` of the models that take them.

    Raises:
        DataError: fewer than ten samples left to judge by.
        NameUnknown: no such model.
        ValueRefused: a window below four samples.
    """
    y = np.asarray(signal, dtype=float)
    count = y.size - length - horizon + 1
    if count < SPARE:
        raise DataError(
            f"{y.size} samples: windows of {length} and a horizon of {horizon} need at least "
            f"{length + horizon - 1 + SPARE}"
        )
    given = {"gm11_clamped": "reference", "gm11_shifted": "shift"}
    made, scores = {}, []
    kept, true = slice(length - 1, y.size - horizon), y[length - 1 + horizon :]
    base = y[kept] - true
    for model in models:
        wanted = {k: v for k, v in options.items() if given.get(model) == k}
        made[model] = predictions(y, model, length, horizon, **wanted)
        error = made[model][kept] - true
        worst = float(error[np.abs(error).argmax()])
        nearer = float(np.mean(np.abs(error) < np.abs(base)))
        scores.append(
            Score(model, float(np.sqrt(np.mean(error**2))), worst, float(error.mean()), nearer,
                  standard_errors(error**2 - base**2))
        )  # fmt: skip
    return scores, made


def standard_errors(x: np.ndarray) -> float:
    """The mean of correlated numbers, in standard errors of it; 0 where all are equal to 0."""
    n, d = x.size, x - x.mean()
    lag = min(n - 1, round(2.0 * n ** (1.0 / 3.0)))
    spread = float(d @ d) + 2.0 * sum((1.0 - k / (lag + 1.0)) * float(d[k:] @ d[:-k]) for k in range(1, lag + 1))
    mean = float(x.mean())
    if mean == 0.0:
        return 0.0
    return mean / (math.sqrt(max(spread, 0.0)) / n) if spread > 0.0 else math.copysign(math.inf, mean)
