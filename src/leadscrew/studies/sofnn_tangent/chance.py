"""By how much two means of runs differ by chance alone, each run with a texture and noise of its own."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from leadscrew.studies.sofnn_tangent.runs import CELLS

WIDE = 3.0
"""Standard deviations of the difference of two means."""
HALF_DIGIT = 0.005
"""Half of the last digit of most numbers of the digest."""

Value = TypeVar("Value", float, np.ndarray)


def by_chance(deviation: Value, half_digit: float = HALF_DIGIT, others: int = CELLS) -> Value:
    """Of a mean of :data:`CELLS` runs and one of ``others``, whose runs have this standard deviation.

    ``WIDE deviation sqrt(1 / CELLS + 1 / others) + half_digit``, in the unit of the deviation.
    """
    return WIDE * math.sqrt(1.0 / CELLS + 1.0 / others) * deviation + half_digit
