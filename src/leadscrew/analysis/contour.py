"""Following error and contour error of a recorded XY path.

Following error is where the axes are behind their commands *at the same time*: ``command - actual``. Contour error is
how far the actual point lies from the commanded *curve*, whatever the time: the distance to the nearest point of the
polyline through the recorded commands. A machine that lags along the path has much of the first and none of the second;
the part shows the second.

The polyline stands for the curve: the chords of an arc of radius ``r`` sampled every ``h`` of length cut it by up to
``h^2 / (8 r)`` (1 nm for points 20 um apart on a radius of 50 mm), which bounds what the contour error can resolve.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
CHUNK = 2_000_000
"""Pairs of point and segment compared at once: some tens of megabytes."""


class FollowingError(NamedTuple):
    """Command minus actual at the same time."""

    x: Floats
    y: Floats
    distance: Floats
    """Length of the vector, never negative."""


class ContourError(NamedTuple):
    """Where each actual point lies with respect to the commanded curve."""

    signed: Floats
    """Distance to the nearest point of the curve: positive to the left of the direction of travel."""
    nearest_x: Floats
    nearest_y: Floats
    segment: NDArray[np.intp]
    """Index of the commanded sample at which the nearest segment starts."""

    @property
    def distance(self) -> Floats:
        """The distance without sign."""
        return np.abs(self.signed)

    @property
    def rms(self) -> float:
        """Root mean square of the distance."""
        return float(np.sqrt(np.mean(self.signed**2)))

    @property
    def largest(self) -> float:
        """Largest distance."""
        return float(np.abs(self.signed).max())


def following_error(command_x: Any, command_y: Any, actual_x: Any, actual_y: Any) -> FollowingError:
    """Following error of both axes and its length.

    Raises:
        ValueError: the arrays are empty or differ in length.
    """
    rx, ry, x, y = _columns(command_x, command_y, actual_x, actual_y)
    if rx.size != x.size:
        raise ValueError(f"{rx.size} commanded and {x.size} actual points: following error compares them one by one")
    return FollowingError(rx - x, ry - y, np.hypot(rx - x, ry - y))


def contour_error(
    command_x: Any, command_y: Any, actual_x: Any, actual_y: Any, window: int | None = None
) -> ContourError:
    """Contour error of each actual point against the polyline through the commanded points.

    ``window`` limits the search to the segments that start up to so many samples before or after the actual point's
    own: needed where the path crosses or comes near itself, and faster on long records. It must be longer than the
    lag in samples. Without it the whole polyline is searched.

    The sign is that of the cross product of the segment's direction and the vector from the nearest point; beyond
    the outside of a corner it is that of the first of the two segments. A point on the curve counts as left.

    Raises:
        ValueError: arrays that do not match, or a commanded path that does not move.
    """
    rx, ry, x, y = _columns(command_x, command_y, actual_x, actual_y)
    moves = np.flatnonzero((np.diff(rx) != 0.0) | (np.diff(ry) != 0.0))
    if moves.size == 0:
        raise ValueError("the commanded path does not move: it has no contour")
    # Segment i goes from its first commanded sample to the next place, past samples at rest.
    px, py = rx[moves], ry[moves]
    dx, dy = rx[moves + 1] - px, ry[moves + 1] - py
    curve = (px, py, dx, dy)
    if window is None:
        best = _search_all(curve, x, y)
    else:
        if rx.size != x.size:
            raise ValueError(f"{rx.size} commanded and {x.size} actual points: a window needs as many of each")
        best = _search_near(curve, moves, x, y, window)
    nx, ny = _nearest(tuple(column[best] for column in curve), x, y)
    left = dx[best] * (y - ny) - dy[best] * (x - nx) >= 0.0
    distance = np.hypot(x - nx, y - ny)
    return ContourError(np.where(left, distance, -distance), nx, ny, moves[best])


def _search_all(curve: tuple[Floats, ...], x: Floats, y: Floats) -> NDArray[np.intp]:
    """For each point the index of the nearest segment."""
    rows = max(1, CHUNK // curve[0].size)
    best = np.empty(x.size, dtype=np.intp)
    for k in range(0, x.size, rows):
        px, py = x[k : k + rows, None], y[k : k + rows, None]
        nx, ny = _nearest(curve, px, py)
        best[k : k + rows] = np.argmin((px - nx) ** 2 + (py - ny) ** 2, axis=1)
    return best


def _search_near(
    curve: tuple[Floats, ...], moves: NDArray[np.intp], x: Floats, y: Floats, window: int
) -> NDArray[np.intp]:
    """The same among segments that start within ``window`` samples, or the segment next to them at a long rest."""
    k = np.arange(x.size)
    low = np.clip(np.searchsorted(moves, k - window), 0, moves.size - 1)
    high = np.clip(np.searchsorted(moves, k + window, side="right") - 1, low, moves.size - 1)
    # At rest the last segment before it must stay in sight.
    low = np.minimum(low, np.clip(np.searchsorted(moves, k, side="right") - 1, 0, None))
    best = low.copy()
    least = np.full(x.size, np.inf)
    for offset in range(int((high - low).max()) + 1):
        i = np.minimum(low + offset, high)
        nx, ny = _nearest(tuple(column[i] for column in curve), x, y)
        square = (x - nx) ** 2 + (y - ny) ** 2
        better = square < least
        best[better], least[better] = i[better], square[better]
    return best


def _nearest(curve: tuple[Floats, ...], x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The nearest point of the segment from ``p`` along ``d``."""
    px, py, dx, dy = curve
    share = np.clip(((x - px) * dx + (y - py) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
    return px + share * dx, py + share * dy


def _columns(*values: Any) -> tuple[Floats, ...]:
    columns = tuple(np.asarray(v, dtype=np.float64) for v in values)
    if any(c.ndim != 1 for c in columns) or columns[0].size != columns[1].size or columns[2].size != columns[3].size:
        raise ValueError(f"expected arrays of x and y of one length, got shapes {[c.shape for c in columns]}")
    if columns[2].size == 0 or not all(np.isfinite(c).all() for c in columns):
        raise ValueError("the path is empty or holds a value that is not finite")
    return columns
