"""The error since the last change, of the machine and of its ghost: root mean square and largest, kept as rows come."""

from __future__ import annotations

import math

import numpy as np


class ErrorSums:
    """Sums over the error column of the rows since ``restart``."""

    def __init__(self, column: int | None, factor: float, unit: str) -> None:
        self.column, self.factor, self.unit = column, factor, unit
        self.restart(0)

    def restart(self, period: int) -> None:
        """From this period on."""
        self.since = period
        self._sums = {False: (0, 0.0, 0.0), True: (0, 0.0, 0.0)}

    def feed(self, rows: np.ndarray, ghost: bool = False) -> None:
        """Rows of the machine, or of its ghost."""
        if self.column is None or not len(rows):
            return
        count, squares, worst = self._sums[ghost]
        with np.errstate(over="ignore", invalid="ignore"):
            error = rows[:, self.column] * self.factor
            squares += float(error @ error)
        self._sums[ghost] = count + len(error), squares, _worst(worst, float(abs(error).max()))

    def state(self, period_s: float) -> dict[str, float | str | None]:
        """For the ``state`` message; in the shown unit, None where nothing was seen."""
        found: dict[str, float | str | None] = {"unit": self.unit, "since_s": self.since * period_s}
        for ghost, tail in ((False, ""), (True, "_ghost")):
            count, squares, worst = self._sums[ghost]
            found[f"rms{tail}"] = math.sqrt(squares / count) if count else None
            found[f"worst{tail}"] = worst if count else None
        return found


def _worst(one: float, other: float) -> float:
    """The larger; no number where one is none, as of a ghost that was lost."""
    return one if math.isnan(one) or one >= other else other


__all__ = ["ErrorSums"]
