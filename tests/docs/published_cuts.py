"""Published turning forces, of others: what the page on force laws is checked with.

Dry turning at about 1080 1/min, mati-paredes/Turning-Cutting-Forces: the cuts of ``examples/turning_forces.csv``. Feeds
as set at the lathe, and as its authors measured them (length over time and spindle speed). Their own fit is one of the
first four cuts with the measured feeds.
"""

from __future__ import annotations

import numpy as np

from leadscrew.analysis.cutting_force import Kienzle
from leadscrew.identify.cutting_force_table import ForceTable

FEED = (0.104, 0.187, 0.299, 0.416, 0.104, 0.104, 0.104, 0.104)
"""Feed as set, mm/rev."""
MEASURED_FEED = (0.098, 0.176, 0.303, 0.401, 0.102, 0.100, 0.098, 0.101)
"""Feed as measured, mm/rev."""
DEPTH = (1.0, 1.0, 1.0, 1.0, 0.25, 0.5, 1.0, 1.25)
"""Depth of cut, mm."""
FORCE = (212.6, 371.1, 569.0, 725.6, 65.5, 120.2, 212.6, 268.2)
"""Main cutting force, N."""
FEED_SERIES = (0, 1, 2, 3)
"""The four feeds at 1 mm."""
DISTINCT = (0, 1, 2, 3, 4, 5, 7)
"""Without the seventh, which is the first cut again."""
PUBLISHED = Kienzle(1609.5, 0.136)
"""Their own fit."""


def cuts(rows: tuple[int, ...], measured: bool = False) -> ForceTable:
    """Some of the eight cuts as a table, with the feeds as set or as measured."""
    feeds = MEASURED_FEED if measured else FEED
    feed, depth, force = (np.array([x[i] for i in rows]) for x in (feeds, DEPTH, FORCE))
    return ForceTable(feed, depth, force, tuple(i + 1 for i in rows), {})
