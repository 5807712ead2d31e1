"""Signatures with a shape to find: cyclic error (lead), stick motion (rise, decay), stick-slip (period, zone)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.analysis.circular import signatures
from leadscrew.analysis.circular.paths import Floats

if TYPE_CHECKING:
    from leadscrew.analysis.circular.search import Data

Shape = tuple[float, ...]
FEWEST_LEADS = 1.5
"""Fewer leads a radius look like scale and straightness."""


@dataclass(frozen=True)
class Kind:
    """One kind of signature with a shape."""

    name: str
    columns: Callable[[Data, int, Sequence[float]], Floats]
    grid: Callable[[float], list[Shape]]
    """The shapes to try; given the most leads a radius that the points resolve."""
    bounds: Callable[[float], list[tuple[float, float]]]
    parts: tuple[str, ...]
    """Names of the shape's values."""
    first: float
    """Factor of the first step of the search around the best of the grid."""
    jagged: bool = False
    """Whether the signature jumps, so that its slope says nothing."""


@dataclass(frozen=True)
class Member:
    """A signature of a kind, on one axis, with one shape."""

    kind: Kind
    which: int
    shape: Shape
    fixed: bool = False

    def columns(self, data: Data) -> Floats:
        """Its columns at the points."""
        return self.kind.columns(data, self.which, self.shape)

    def with_shape(self, shape: Sequence[float]) -> Member:
        """The same with another shape."""
        return replace(self, shape=tuple(float(v) for v in shape))


def columns_of(data: Data, members: Sequence[Member]) -> Floats:
    """All columns: the base, then each member's."""
    return np.column_stack((signatures.base(data.sign, *data.axes), *(m.columns(data) for m in members)))


@lru_cache(maxsize=8)
def _leads(most: float) -> list[Shape]:
    return [(float(k),) for k in np.arange(FEWEST_LEADS, max(most, FEWEST_LEADS + 0.1), 0.15)]


def _pairs(first: Sequence[float], second: Sequence[float]) -> list[Shape]:
    return [(a, b) for a in first for b in second]


KINDS = (
    Kind(
        "cyclic error",
        lambda d, which, shape: signatures.cyclic(d.axes[which], shape[0]),
        _leads,
        lambda most: [(1.0, max(most, FEWEST_LEADS + 0.2))],
        ("per_radius",),
        1.01,
    ),
    Kind(
        "stick motion",
        lambda d, which, shape: signatures.stick(d.axes[which], shape[0], shape[1]),
        lambda most: _pairs((0.2, 0.5, 1.0, 2.0, 4.0), (0.1, 0.3, 0.7, 1.5, 3.0, 6.0)),
        lambda most: [(0.01, 12.0), (0.02, 20.0)],
        ("rise_deg", "decay_deg"),
        1.3,
    ),
    Kind(
        "stick-slip",
        lambda d, which, shape: signatures.slip(d.axes[which], shape[0], shape[1]),
        lambda most: _pairs([float(v) for v in np.geomspace(0.6, 6.0, 80)], (4.0, 6.0, 9.0, 14.0, 20.0)),
        lambda most: [(0.4, 8.0), (2.0, 30.0)],
        ("period_deg", "zone_deg"),
        1.1,
        jagged=True,
    ),
)
