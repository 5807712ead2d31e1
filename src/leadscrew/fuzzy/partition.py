"""Triangular partitions of unity: sets with their peaks at given centres, feet at the neighbouring centres.

    mu_i(x) = max(0, min((x - c_(i-1)) / (c_i - c_(i-1)), (c_(i+1) - x) / (c_(i+1) - c_i)))

The first and the last set are shouldered: outside the universe ``[c_1, c_n]`` an input counts as its nearest end.
At every ``x`` at most two sets have a membership above zero and the two sum to one, so an input is told by the
interval that it lies in and by its membership in the interval's upper set.

:class:`Partition` is for design and reports (labels, all memberships, ties). :class:`Axis` is the same partition as
a step reads it: its centres and, for speed, the reciprocals of the interval widths.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.sheet import Doc

TIE = 1e-12
"""Two memberships closer than this are a tie: far above rounding, far below three printed digits."""


class Axis(NamedTuple):
    """One input of a rule base, as a step reads it."""

    centres: Annotated[np.ndarray, Doc("peaks of the sets, increasing")]
    reciprocal_widths: Annotated[np.ndarray, Doc("one over the distance to the next centre")]


def axis(centres) -> Axis:
    """The partition with these centres, ready for a step.

    Raises:
        ValueRefused: fewer than two centres, or centres that do not increase.
    """
    c = np.array(centres, dtype=float)
    if c.ndim != 1 or c.size < 2:
        raise ValueRefused(f"centres = {c.tolist()}: a partition needs at least two centres in one row")
    width = np.diff(c)
    if not (np.isfinite(c).all() and (width > 0.0).all()):
        raise ValueRefused(f"centres = {c.tolist()}: centres must be finite and strictly increasing")
    return Axis(c, 1.0 / width)


def inside_universe(axis, x):
    """``x`` held between the first and the last centre."""
    return min(max(x, axis.centres[0]), axis.centres[axis.centres.shape[0] - 1])


def interval_index(axis, x):
    """Number of the interval that holds ``x``, from 0: how many inner centres lie at or below it."""
    index = 0
    for i in range(1, axis.centres.shape[0] - 1):
        index = index + (1 if x >= axis.centres[i] else 0)
    return index


def upper_membership(axis, index, x):
    """Membership of ``x`` in the upper set of its interval; the lower set has the rest to one."""
    return (x - axis.centres[index]) * axis.reciprocal_widths[index]


@dataclass(frozen=True)
class Winner:
    """The set to which a value belongs most."""

    index: int
    membership: float
    tied: bool
    """Another set has the same membership; ``index`` is then the lower of the two."""


@dataclass(frozen=True)
class Partition:
    """A triangular partition of unity with names for its sets."""

    centres: tuple[float, ...]
    labels: tuple[str, ...]

    def __post_init__(self) -> None:
        axis(self.centres)
        if len(self.labels) != len(self.centres):
            raise ValueRefused(f"{len(self.labels)} labels for {len(self.centres)} centres")

    def __len__(self) -> int:
        return len(self.centres)

    def memberships(self, x) -> np.ndarray:
        """Memberships of ``x`` in all sets; one row a value where ``x`` is an array."""
        peaks = np.eye(len(self.centres))
        values = np.asarray(x, dtype=float)
        columns = [np.interp(values, self.centres, peak) for peak in peaks]
        return np.stack(columns, axis=-1)

    def winner(self, x: float) -> Winner:
        """The set of largest membership, and whether it is tied."""
        mu = self.memberships(x)
        best = int(np.argmax(mu > mu.max() - TIE))
        return Winner(best, float(mu[best]), bool(np.sum(mu > mu.max() - TIE) > 1))

    def contracted(self, factor: float) -> Partition:
        """The same sets on a universe scaled by ``factor``."""
        return Partition(tuple(factor * c for c in self.centres), self.labels)

    @property
    def widths(self) -> tuple[float, ...]:
        """Distances between neighbouring centres."""
        return tuple(np.diff(self.centres).tolist())
