"""How well a system gives what was logged: errors on samples, in units of the output."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from leadscrew.fuzzy.system import System
from leadscrew.kernel.errors import ValueRefused


@dataclass(frozen=True)
class Score:
    """Errors of a system on samples, in units of the output."""

    samples: int
    silent: int
    """Samples at which no rule fires (and there is no default): in no error below."""
    rmse: float
    worst: float
    worst_sample: int
    """Number of the sample with the largest error in the data, from 0; -1 where there is none."""
    spread: float
    """Root mean square about the mean: the error of a constant."""

    def sentence(self, what: str) -> str:
        """One line of text; ``what`` says which samples."""
        silent = f"; no rule fires at {self.silent}" if self.silent else ""
        return (
            f"{what}: {self.samples} samples, error rms {self.rmse:.4g}, largest {self.worst:.4g} (sample "
            f"{self.worst_sample}, from 0); a constant would have {self.spread:.4g} rms{silent}"
        )


def score(system: System, rows: np.ndarray, numbers: np.ndarray | None = None) -> Score:
    """Errors of a system of one output on rows ``(inputs, output)``; ``numbers``: what the samples are called.

    Raises:
        ValueRefused: a system of several outputs, no rows, or rows of another length.
    """
    from leadscrew.fuzzy.evaluate import compiled

    if len(system.outputs) != 1 or rows.ndim != 2 or not len(rows) or rows.shape[1] != len(system.inputs) + 1:
        raise ValueRefused(
            f"rows of shape {rows.shape} for {len(system.inputs)} inputs and {len(system.outputs)} outputs"
        )
    error = compiled(system).many(rows[:, :-1]) - rows[:, -1]
    fires = np.isfinite(error)
    spread = float(np.std(rows[:, -1]))
    if not fires.any():
        return Score(len(rows), len(rows), math.nan, math.nan, -1, spread)
    at = int(np.argmax(np.where(fires, np.abs(error), -1.0)))
    rmse, worst = float(np.sqrt(np.mean(error[fires] ** 2))), float(abs(error[at]))
    return Score(len(rows), int((~fires).sum()), rmse, worst, at if numbers is None else int(numbers[at]), spread)
