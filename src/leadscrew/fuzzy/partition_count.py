"""How many sets an approximation asks for: equation (10) of Long et al. (2014), which can be read in three ways.

    M = INT(U sqrt(sum_i ||d2u/dx_i2|| / (8 eps))) + 1

``half``
    as printed, with ``U`` the half width of the universe: ``M`` sets;
``full``
    with the full width ``2 U`` in place of ``U``;
``intervals``
    with the root over the sum alone, ``INT(U sqrt(sum) / (8 eps)) + 1``: a number of intervals, one more set.

The paper's numbers give 3, 6 and 5. It states 6 sets and then counts (5 + 1)^2 rules, so no reading is preferred here:
:func:`partition_count` returns all three, and :meth:`PartitionCount.under` wants a reading by name.

What a given partition guarantees does not depend on the reading: linear interpolation over intervals of width h is
off by at most ``h^2 / 8`` times the sum of the curvatures (:func:`interpolation_bound`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from leadscrew.kernel.errors import ValueRefused

Reading = Literal["half", "full", "intervals"]


class PartitionCount(NamedTuple):
    """The value of (10) under each reading."""

    half: int
    full: int
    intervals: int

    @property
    def sets_of_intervals(self) -> int:
        """Sets under the reading ``intervals``: one more than intervals."""
        return self.intervals + 1

    def under(self, reading: Reading) -> int:
        """The value under one reading, by name.

        Raises:
            ValueRefused: no such reading.
        """
        if reading not in self._fields:
            raise ValueRefused(f"reading = {reading!r}: equation (10) can be read as {', '.join(self._fields)}")
        return int(getattr(self, reading))


def partition_count(curvatures: Sequence[float], accuracy: float, half_width: float = 1.0) -> PartitionCount:
    """Equation (10) for the suprema of the second derivatives, the accuracy and the universe ``[-U, U]``.

    Raises:
        ValueRefused: a negative curvature, or an accuracy or half width that is not positive.
    """
    total = _total(curvatures)
    if not accuracy > 0.0:
        raise ValueRefused(f"accuracy = {accuracy!r}: must be above 0")
    if not half_width > 0.0:
        raise ValueRefused(f"half_width = {half_width!r}: must be above 0")
    per_half = half_width * math.sqrt(total / (8.0 * accuracy))
    return PartitionCount(
        half=math.floor(per_half) + 1,
        full=math.floor(2.0 * per_half) + 1,
        intervals=math.floor(half_width * math.sqrt(total) / (8.0 * accuracy)) + 1,
    )


def interpolation_bound(curvatures: Sequence[float], centres: Sequence[float]) -> list[float]:
    """Guaranteed error of the interpolation in each interval between ``centres``, the same on all inputs."""
    total = _total(curvatures)
    return [float(h * h / 8.0 * total) for h in np.diff(np.asarray(centres, dtype=float))]


def equal_sets_for(curvatures: Sequence[float], accuracy: float, half_width: float = 1.0) -> int:
    """The fewest equally spaced sets on ``[-U, U]`` whose guaranteed error is within ``accuracy``."""
    sets = 2
    while max(interpolation_bound(curvatures, np.linspace(-half_width, half_width, sets).tolist())) > accuracy:
        sets += 1
    return sets


def _total(curvatures: Sequence[float]) -> float:
    if any(not c >= 0.0 or math.isinf(c) for c in curvatures):
        raise ValueRefused(f"curvatures = {list(curvatures)}: suprema must be finite and not negative")
    return float(sum(curvatures))
