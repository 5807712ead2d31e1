"""Random materials, depths, machines and noise: the draws of a Monte Carlo, and how its runs are judged.

Every quantity is uniform between its ends and independent of the others, ``Kf`` in its logarithm; a draw counts where
the feed that it needs for 150 N at 1,200 1/min, ``n (F / (Kf b))^(1/P)``, lies in 15 to 130 mm/min (rejection). Ends:
the digest of the paper of the study ``grey_turning``, section 6.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel.errors import NameUnknown
from leadscrew.kernel.sheet import nearest

FORCE_N = 150.0
RPM = 1200.0
KF = 2256.3
"""S45C, N/mm^(1+P)."""
SPREAD = 0.4
"""``Kf`` from ``exp(-0.4)`` to ``exp(0.4)`` times that of S45C."""
FEEDS = (15.0, 130.0)
"""Feeds that a draw may need, mm/min."""

COMMON: dict[str, tuple[float, float]] = {
    "plant.law.exponent": (0.65, 0.96),
    "plant.depth.start": (0.5, 1.5),
    "sensor.noise_n": (0.5, 5.0),
    "plant.runout": (0.0, 0.02),
    "plant.stiffness": (10_000.0, 40_000.0),
    "plant.servo.damping": (0.5, 1.0),
}
MACHINES: dict[str, dict[str, tuple[float, float]]] = {
    "plant_f": {"plant.servo.rate": (25.0, 60.0), "plant.servo.dead_time_s": (0.0, 0.020)},
    "plant_n": {"plant.servo.rate": (12.0, 30.0), "plant.servo.dead_time_s": (0.010, 0.040)},
}
"""Feed servos: rate in rad/s and dead time."""
COUNTS = {"plant_f": 300, "plant_n": 400}
"""Draws for each machine."""
SEED = 9

BAD_STEADY = 5.0
BAD_OVERSHOOT = 30.0
"""A run is bad where its steady error or its overshoot is larger, percent."""


def feed_needed(kf: Any, exponent: Any, depth: Any, force: float = FORCE_N, rpm: float = RPM) -> np.ndarray:
    """Feed in mm/min at which the steady cutting force is ``force``."""
    room = np.asarray(force / (np.asarray(kf) * np.asarray(depth)), dtype=float)
    return np.asarray(rpm * room ** (1.0 / np.asarray(exponent)))


def draws(plant: str, count: int | None = None, seed: int = SEED) -> dict[str, np.ndarray]:
    """``count`` draws by dotted key, one array each; of the same seed fewer draws are the first of more.

    ``plant``: ``plant_f`` or ``plant_n``.

    Raises:
        NameUnknown: another plant.
    """
    if plant not in MACHINES:
        raise NameUnknown(f"there is no Monte Carlo for {plant!r}{nearest(plant, list(MACHINES))}")
    wanted = COUNTS[plant] if count is None else count
    ends = {"plant.law.kf": (math.log(KF) - SPREAD, math.log(KF) + SPREAD)} | COMMON | MACHINES[plant]
    low, high = np.array(list(ends.values())).T
    rng = np.random.default_rng([seed, list(MACHINES).index(plant)])
    kept: list[np.ndarray] = []
    while len(kept) < wanted:
        one = low + (high - low) * rng.random(len(ends))
        one[0] = math.exp(one[0])
        if FEEDS[0] <= feed_needed(*one[:3]) <= FEEDS[1]:
            kept.append(one)
    return dict(zip(ends, np.array(kept).T, strict=True))


class Judged(NamedTuple):
    """Readings of many runs at a constant force, one value a run, of the filtered force."""

    overshoot: np.ndarray
    """Largest excess, percent of the command; never negative."""
    rise_s: np.ndarray
    """From 10 to 90 % of the command for the first time, between samples by straight lines; NaN where it never rose."""
    rise_samples: np.ndarray
    """The same in whole samples: from the first sample at 10 % or above to the first at 90 %."""
    steady: np.ndarray
    """Mean absolute error over the last second, percent of the command."""
    iae: np.ndarray
    """Integral of the absolute error over the run, N s."""
    bad: np.ndarray
    """Steady error above 5 % or overshoot above 30 %, or a run that diverged."""


def _passed(t: np.ndarray, y: np.ndarray, level: float) -> np.ndarray:
    """When each row passes a level upwards for the first time; NaN where it does not."""
    up = (y[:, :-1] < level) & (y[:, 1:] >= level)
    rows, k = np.arange(len(y)), np.argmax(up, axis=1)
    before, after = y[rows, k], y[rows, k + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        at = t[k] + (t[k + 1] - t[k]) * (level - before) / (after - before)
    return np.where(up.any(axis=1), at, np.nan)


def judged(t: np.ndarray, y: np.ndarray, command: float = FORCE_N) -> Judged:
    """Readings of filtered forces ``y``, ``(runs, samples)``, at the times ``t``."""
    y = np.atleast_2d(np.asarray(y, dtype=float))
    period = float(t[1] - t[0])
    off = np.abs(y - command) / command
    overshoot = 100.0 * np.maximum(y.max(axis=1) / command - 1.0, 0.0)
    steady = 100.0 * off[:, t > t[-1] - 1.0 + 0.5 * period].mean(axis=1)
    rise = _passed(t, y, 0.9 * command) - _passed(t, y, 0.1 * command)
    levels = [np.where((y >= part * command).any(axis=1), (y >= part * command).argmax(axis=1), np.nan)
              for part in (0.1, 0.9)]  # fmt: skip
    lost = ~np.isfinite(y).all(axis=1)
    bad = (steady > BAD_STEADY) | (overshoot > BAD_OVERSHOOT) | lost
    return Judged(overshoot, rise, levels[1] - levels[0], steady, command * off.sum(axis=1) * period, bad)


def judge(batch: Any, command: float = FORCE_N) -> Judged:
    """Readings of a batch that recorded ``feedback``: a number, or a reading whose first part is the force."""
    return judged(batch.time, batch["feedback"], command)
