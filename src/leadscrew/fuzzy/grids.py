"""Partitions for data: universes, and sets evenly spaced, by the density of the data, or by curvature and accuracy.

``even``
    centres at equal distances;
``quantile``
    centres at equal parts of the data, ``c_i = Q((i - 1) / (n - 1))``: as many samples between any two centres, so the
    sets are narrow where the data is dense. Values that repeat may leave fewer sets than were asked for; that is said;
``grid_from_curvature``
    the number of sets from equation (10) of Long et al. (2014), :func:`partition_count`, under the reading that the
    caller names, from curvatures on universes scaled to [-1, 1] (:mod:`leadscrew.fuzzy.curvature`), evenly spaced; with
    the error that the sets guarantee, whatever the reading said.

How many sets an approximation asks for: equation (10) of Long et al. (2014), which can be read in three ways.

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
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from leadscrew.fuzzy.curvature import Curvature, Method, estimate_curvature
from leadscrew.fuzzy.partition import Partition
from leadscrew.util.errors import ValueRefused

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


SIGNED = {
    2: "N P", 3: "N ZE P", 4: "NB NS PS PB", 5: "NB NS ZE PS PB", 6: "NB NM NS PS PM PB", 7: "NB NM NS ZE PS PM PB",
    8: "NVB NB NM NS PS PM PB PVB", 9: "NVB NB NM NS ZE PS PM PB PVB",
}  # fmt: skip
"""Names of sets that lie symmetrically about zero: negative, zero, positive; (very) big, medium, small."""
MOST_SETS = 999


def labels(centres: Sequence[float]) -> tuple[str, ...]:
    """Names for sets: the usual ones where up to nine centres lie symmetrically about zero, else ``S1``, ``S2``, ..."""
    c = np.asarray(centres, dtype=float)
    if len(c) in SIGNED and np.abs(c + c[::-1]).max() <= 1e-9 * (c[-1] - c[0]):
        return tuple(SIGNED[len(c)].split())
    return tuple(f"S{k + 1}" for k in range(len(c)))


def partition(centres: Sequence[float]) -> Partition:
    """A partition with these centres and the usual names."""
    c = tuple(float(x) for x in centres)
    return Partition(c, labels(c))


def universe(
    values: Any, percentiles: tuple[float, float] = (0.0, 100.0), symmetric: bool = False, name: str = "values"
) -> tuple[float, float]:
    """The range of data between two percentiles; ``symmetric`` about zero, as far as the larger side.

    Raises:
        ValueRefused: no values, not finite, all the same, or percentiles out of order.
    """
    x = np.asarray(values, dtype=float)
    lower, upper = percentiles
    if not 0.0 <= lower < upper <= 100.0:
        raise ValueRefused(f"percentiles = {lower:g}, {upper:g}: expected two rising numbers from 0 to 100")
    if x.size == 0 or not np.isfinite(x).all():
        raise ValueRefused(f"{name}: a universe needs finite values")
    low, high = (float(v) for v in np.percentile(x, [lower, upper]))
    if symmetric:
        high = max(abs(low), abs(high))
        low = -high
    if not low < high:
        raise ValueRefused(f"{name}: is always {low:g}; no universe follows from that")
    return low, high


def even(low: float, high: float, sets: int) -> Partition:
    """``sets`` sets with centres at equal distances from ``low`` to ``high``.

    Raises:
        ValueRefused: fewer than 2 sets or more than 999, or an empty universe.
    """
    _sets(sets)
    c = np.linspace(low, high, sets)
    if low == -high:
        c = 0.5 * (c - c[::-1])
    return partition(c.tolist())


def quantile(values: Any, sets: int, low: float, high: float) -> Partition:
    """Up to ``sets`` sets with as many samples between any two centres; ``low`` and ``high`` are the outer centres.

    Raises:
        ValueRefused: fewer than 2 sets or more than 999, or values that are not finite.
    """
    _sets(sets)
    x = np.clip(np.asarray(values, dtype=float), low, high)
    if x.size == 0 or not np.isfinite(x).all():
        raise ValueRefused("quantiles need finite values")
    inner = np.quantile(x, np.linspace(0.0, 1.0, sets)[1:-1])
    c = np.unique([low, *inner.tolist(), high])
    apart = [float(c[0])]
    for value in c[1:].tolist():
        if value - apart[-1] > 1e-9 * (high - low):
            apart.append(value)
    apart[-1] = high
    return partition(apart)


def _sets(sets: int) -> None:
    if not 2 <= sets <= MOST_SETS:
        raise ValueRefused(f"sets = {sets}: allowed are 2 to {MOST_SETS}")


@dataclass(frozen=True)
class Grid:
    """Partitions of the inputs by curvature, and how they came about."""

    partitions: tuple[Partition, ...]
    curvature: Curvature
    count: PartitionCount
    reading: Reading
    accuracy: float
    """In units of the output."""

    @property
    def sets(self) -> int:
        """Sets of each input."""
        return len(self.partitions[0])

    @property
    def bound(self) -> float:
        """Error of the interpolation that these sets guarantee, if the curvatures are true, in units of the output."""
        return max(interpolation_bound(self.curvature.values, np.linspace(-1.0, 1.0, self.sets).tolist()))

    @property
    def needed(self) -> int | None:
        """The fewest even sets that guarantee the accuracy; None above 999."""
        if max(interpolation_bound(self.curvature.values, np.linspace(-1.0, 1.0, MOST_SETS).tolist())) > self.accuracy:
            return None
        return equal_sets_for(self.curvature.values, self.accuracy)

    def report(self) -> str:
        """The estimate, the three readings and the guarantee, as text."""
        c = self.count
        needed = self.needed
        asks = f"{needed} sets guarantee" if needed else f"more than {MOST_SETS} sets are needed to guarantee"
        return (
            f"{self.curvature}\n"
            f"equation (10) for an accuracy of {self.accuracy:g}: half {_said(c.half)}, full {_said(c.full)}, "
            f"intervals {_said(c.sets_of_intervals)}; read as {self.reading}: {self.sets} sets an input\n"
            f"they guarantee {self.bound:.3g} by these curvatures; {asks} {self.accuracy:g}"
        )

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return {
            "curvature": self.curvature.as_dict(), "count": self.count._asdict(), "reading": self.reading,
            "accuracy": self.accuracy, "sets": self.sets, "bound": self.bound, "needed": self.needed,
        }  # fmt: skip


def _said(sets: int) -> str:
    return f"{sets} set{'s' if sets != 1 else ''}"


def grid_from_curvature(
    points: Any,
    values: Any,
    universes: Sequence[tuple[float, float]],
    accuracy: float,
    reading: Reading,
    *,
    method: Method = "local",
    **options: Any,
) -> Grid:
    """Even partitions of all inputs, as many sets as equation (10) gives under ``reading``, at least 2.

    ``points``: one row a sample, one column an input; ``accuracy`` in units of the output; ``method`` and ``options``
    go to :func:`leadscrew.fuzzy.curvature.estimate_curvature`.

    Raises:
        ValueRefused: an unknown reading, an accuracy that is not positive or asks for more than 999 sets, or data that
            does not carry curvatures.
    """
    if reading not in PartitionCount._fields:
        raise ValueRefused(f"reading = {reading!r}: equation (10) can be read as {', '.join(PartitionCount._fields)}")
    found = estimate_curvature(points, values, universes, method=method, **options)
    count = partition_count(found.values, accuracy)
    sets = max(2, count.sets_of_intervals if reading == "intervals" else count.under(reading))
    if sets > MOST_SETS:
        raise ValueRefused(f"accuracy = {accuracy:g} asks for {sets} sets an input; allowed are up to {MOST_SETS}")
    return Grid(tuple(even(low, high, sets) for low, high in universes), found, count, reading, accuracy)
