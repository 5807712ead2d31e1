"""Where a stretch of a log starts: position and speed with which the model itself follows its first samples best.

A parabola through the first samples takes the speed of their middle for that of the first one; a log that begins with
full drive from rest then starts a simulation in motion, which is off by metres later. The model knows the drive, so its
start speed is solved for by Gauss and Newton over the first :data:`START_S` (9 samples at least), the position with it;
both are two numbers of the stretch's first milliseconds, not of the rest that is judged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from leadscrew.identify.axis.refine_replay import LOST, Starts, play
from leadscrew.identify.axis.simulation import START_S, start_state

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop
    from leadscrew.logs import AxisLog

LEAST, ROUNDS = 9, 3
STEP = 1e-3
"""Change of a start speed for its derivative, as a share of the largest speed of the first samples or of the log."""


def by_model(
    log: AxisLog, loop: Loop, point: Mapping[str, float], firsts: Sequence[int], delay_s: float = 0.0
) -> list[tuple[float, float]]:
    """Position and speed at each of the samples ``firsts``; those of a parabola where the model comes no nearer.

    Args:
        log: what was measured.
        loop: that plays it, :func:`leadscrew.identify.axis.refine_replay.played`.
        point: all values of the plant.
        firsts: samples that stretches begin at.
        delay_s: of the drive.
    """
    count = min(max(LEAST, round(START_S / log.period)), len(log.position) - max(firsts))
    begins = [start_state(log, first) for first in firsts]
    if count < LEAST:
        return begins
    at = np.array(firsts)
    measured = log.position[at[:, None] + np.arange(count)]
    position, speed = (np.array(column) for column in zip(*begins, strict=True))
    step = STEP * float(np.max(np.abs(np.diff(log.position)))) / log.period
    n = len(at)
    best, kept, kept_speed = np.full(n, np.inf), position.copy(), speed.copy()

    def tried(v: np.ndarray) -> np.ndarray:
        runs = Starts(np.tile(at, 2), np.tile(position, 2), np.concatenate([v, v + step]))
        return play(loop, [point] * (2 * n), runs, count, [delay_s] * (2 * n)).reshape(2, n, count) - measured

    # from the parabola's speed, and from rest: where the model sticks one of them has no slope
    for begin in (speed, np.zeros(n)):
        v = begin.copy()
        for _ in range(ROUNDS + 1):
            left, more = tried(v)
            shift = left.mean(axis=1)
            left, slope = left - shift[:, None], (more - left) / step
            slope = slope - slope.mean(axis=1)[:, None]
            size = np.sum(left * left, axis=1)
            better = (size < best) & (np.abs(shift) < LOST)
            best = np.where(better, size, best)
            kept, kept_speed = np.where(better, position - shift, kept), np.where(better, v, kept_speed)
            weight = np.sum(slope * slope, axis=1)
            v = v - np.sum(left * slope, axis=1) / np.where(weight > 0.0, weight, np.inf)
    return list(zip(kept.tolist(), kept_speed.tolist(), strict=True))
