"""Residuals of a whole log in its known cascade."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.axis.cascade import closed_loop, play_closed
from leadscrew.identify.axis.refine_scales import Scales
from leadscrew.identify.axis.refine_windows import STEP
from leadscrew.identify.axis.simulation import start_state

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog

BLOCK_S = 0.5
"""Blocks of time that count as independent where there are no windows."""


class Closed:
    """The log's whole command played on the closed loop."""

    def __init__(self, log: AxisLog, scale: Scales, cascade: Cascade) -> None:
        self.log, self.scale, self.loop, self.runs = log, scale, closed_loop(log, cascade), 0
        self.start = start_state(log)

    def simulate(self, points: list[np.ndarray]) -> np.ndarray:
        """``[point, sample]``, model less measured."""
        self.runs += len(points)
        values, delays = [self.scale.point(x) for x in points], [self.scale.delay(x) for x in points]
        return play_closed(self.loop, values, self.start, len(self.log.time), delays) - self.log.position

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """All samples."""
        return self.simulate([x])[0]

    def jacobian(self, x: np.ndarray, central: bool = False) -> np.ndarray:
        """``[sample, variable]``; one-sided differences, or to both sides."""
        ups = [x + STEP * row for row in np.eye(len(x))]
        downs = [np.maximum(x - STEP * row, self.scale.low) for row in np.eye(len(x))] if central else [x]
        found = self.simulate([*ups, *downs])
        other = [len(ups) + (i if central else 0) for i in range(len(ups))]
        apart = [(up - downs[i if central else 0])[i] for i, up in enumerate(ups)]
        return np.column_stack([(found[i] - found[other[i]]) / apart[i] for i in range(len(ups))])

    @property
    def cluster(self) -> np.ndarray:
        """Block of time of each sample."""
        return np.arange(len(self.log.time)) // max(1, round(BLOCK_S / self.log.period))

    def begin(self, x: np.ndarray) -> tuple[float, float]:
        """As measured."""
        return self.start
