"""Measured points before they are believed: strays are taken out, points closer than a scan can tell are put together.

**Strays.** A point that lies further from the median of its seven neighbours (x and y each, itself among them) than
8 standard deviations of that distance, 0.2 mm, and the usual step. On a line that runs on, points *are* the median.
More than two in a row are no strays but a part of the line that lies elsewhere.

**Dense points.** ``k`` neighbours become their mean, for ``k`` steps as long as ``span``: white noise is then less by
``sqrt(k)`` on points ``k`` times as far apart, which leaves the cut-off of the smoothing as it is. The ends are those
of the line through the first two and the last two means.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from leadscrew.paths.curve import Array

NEIGHBOURS = 7
IN_A_ROW = 2
SIGMAS = 8.0
LEAST_STRAY_MM = 0.2
FEW = 0.01
"""Share of points up to which they are strays; more of them are how the scan is."""
HELD = 6.0
"""Means lie at most so many spans apart, or fewer points are put together."""


def strays(x: Array, y: Array) -> tuple[NDArray[np.int64], float]:
    """Indices of the points that lie off the line of their neighbours, and how far the furthest does, mm."""
    from scipy.ndimage import median_filter

    off = np.hypot(x - median_filter(x, NEIGHBOURS, mode="nearest"), y - median_filter(y, NEIGHBOURS, mode="nearest"))
    step = float(np.median(np.hypot(np.diff(x), np.diff(y))))
    far = off > max(SIGMAS * 1.4826 * float(np.median(off)), LEAST_STRAY_MM, step)
    rows = np.split(np.flatnonzero(far), np.flatnonzero(np.diff(np.flatnonzero(far)) > 1) + 1)
    found = np.concatenate([row for row in rows if row.size <= IN_A_ROW] or [np.empty(0, dtype=np.int64)])
    return found.astype(np.int64), float(off[found].max(initial=0.0))


def thinned(x: Array, y: Array, length: float, span: float) -> tuple[Array, Array, int]:
    """Means of points, and how many each is of; the points themselves where they are not closer than ``span``."""
    count = int(span * (x.size - 1) / length)
    while count > 1:
        edges = np.round(np.linspace(0.0, x.size, x.size // count + 1)).astype(np.int64)
        sizes = np.diff(edges)
        means = np.column_stack([np.add.reduceat(v, edges[:-1]) / sizes for v in (x, y)])
        if np.hypot(*np.diff(means, axis=0).T).max() <= HELD * span:
            # Half a mean's points, but for half a step, lie beyond it.
            share = 0.5 - 0.5 / count
            first = means[0] - share * (means[1] - means[0])
            last = means[-1] + share * (means[-1] - means[-2])
            u, v = np.vstack([first, means, last]).T
            return u, v, count
        count //= 2
    return x, y, 1
