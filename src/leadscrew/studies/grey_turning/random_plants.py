"""Random materials, depths, machines and noise: the same draws and the same noise for every controller.

Every quantity is uniform between its ends and independent of the others, ``Kf`` in its logarithm; a draw counts where
the feed that it needs for 150 N at 1,200 1/min, ``n (F / (Kf b))^(1/P)``, lies in 15 to 130 mm/min (rejection). The
ends are ours. Draw ``k`` has the noise number ``k`` under every controller, so controllers are compared in pairs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.analysis.cutting_force import PowerLaw, feed_for
from leadscrew.kernel.parameters import nearest
from leadscrew.plants._turning.chip import S45C
from leadscrew.studies.grey_turning.readings import Reading, filtered, read
from leadscrew.studies.grey_turning.scenarios import FORCE_N, RPM
from leadscrew.studies.lab import Lab, measure
from leadscrew.util.errors import NameUnknown

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

KF = S45C.kf
"""N/mm^(1+P)."""
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
SEED = 9
SCENARIO, SECONDS = "fig6_fixed_depth", 3.0
FACTOR_SETS = ("s9_half", "stfc")
"""Scaling factors that TFC and GPFC are compared with."""


def draws(plant: str, count: int | None = None, seed: int = SEED) -> dict[str, np.ndarray]:
    """``count`` draws by dotted key, one array each; of the same seed fewer draws are the first of more.

    ``plant``: ``plant_f`` or ``plant_n``.

    Raises:
        NameUnknown: another plant.
    """
    if plant not in MACHINES:
        raise NameUnknown(f"there are no random plants {plant!r}{nearest(plant, list(MACHINES))}")
    wanted = COUNTS[plant] if count is None else count
    ends = {"plant.law.kf": (math.log(KF) - SPREAD, math.log(KF) + SPREAD)} | COMMON | MACHINES[plant]
    low, high = np.array(list(ends.values())).T
    rng = np.random.default_rng([seed, list(MACHINES).index(plant)])
    kept: list[np.ndarray] = []
    while len(kept) < wanted:
        one = low + (high - low) * rng.random(len(ends))
        one[0] = math.exp(one[0])
        if FEEDS[0] <= RPM * feed_for(PowerLaw(one[0], one[1]), FORCE_N, one[2]) <= FEEDS[1]:
            kept.append(one)
    return dict(zip(ends, np.array(kept).T, strict=True))


def known(loop: Loop, varied: Mapping[str, Any]) -> dict[str, Any]:
    """The draws of a loop; the programme of a controller that reads it has the depth that is cut."""
    depth = "reference.depth.start"
    return {**varied, depth: varied["plant.depth.start"]} if depth in loop.sheet else dict(varied)


def cut(loop: Loop, varied: Mapping[str, Any], depth_known: bool = True) -> Reading:
    """Cuts of 3 s; an overshoot is never negative."""
    done = loop.batch(SECONDS, known(loop, varied) if depth_known else varied, record=("feedback",))
    found = read(filtered(done))
    return found._replace(overshoot=np.maximum(found.overshoot, 0.0))


@measure
def drawn(
    lab: Lab,
    controller: str,
    plant: str = "plant_f",
    count: int | None = None,
    depth_known: bool = True,
    **changes: float,
) -> Reading:
    """A controller, some of its parameters changed, on the draws of a plant.

    ``depth_known``: whether the programme has the depth that is cut, else 1 mm.
    """
    block = lab.study.controller(controller)
    loop = lab.loop(block(**changes) if changes else block, SCENARIO, machine=plant)
    return cut(loop, draws(plant, count), depth_known)


class Share(NamedTuple):
    """How many of how many, and the 95 % interval (Wilson 1927) of the probability behind it."""

    hits: int
    of: int
    low: float
    high: float

    @property
    def percent(self) -> float:
        """The share itself."""
        return 100.0 * self.hits / self.of

    def __str__(self) -> str:
        return f"{self.hits} of {self.of} (95 %: {100.0 * self.low:.1f} to {100.0 * self.high:.1f} %)"


def share(holds: np.ndarray) -> Share:
    """Of draws in which something holds."""
    from scipy.stats import binomtest

    hits = int(np.count_nonzero(holds))
    ends = binomtest(hits, len(holds)).proportion_ci(0.95, method="wilson")
    return Share(hits, len(holds), float(ends.low), float(ends.high))


def high(found: Reading) -> float:
    """90th percentile of the overshoot, percent."""
    return float(np.percentile(found.overshoot, 90.0))


def better_in_all(one: Reading, other: Reading) -> Share:
    """Draws with less overshoot, less steady error and a rise in no more samples."""
    return share(
        (one.overshoot < other.overshoot) & (one.steady < other.steady) & (one.rise_samples <= other.rise_samples)
    )
