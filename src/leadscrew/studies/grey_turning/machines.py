"""The lathes of the study: the feed drives that its digest reconstructed, and the two materials of the paper.

The paper names neither servo nor sampling time. Plant F's servo (40 rad/s, no dead time) was fitted to Figures 9 and
10; plant N is slower (20 rad/s, one sample of dead time). Both are sampled every 20 ms and stepped every millisecond.
"""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.kernel.block import Block
from leadscrew.plants.turning import turning
from leadscrew.plants.turning.chip import IRON
from leadscrew.studies.study import Scenario

PERIOD_S = 0.02
"""Sampling period: 20 ms keep the runout of 20 Hz below half the sampling frequency."""

SUBSTEPS = 20
"""Steps of the plant a period: 1 ms."""


class Machine(NamedTuple):
    """A lathe in the cut."""

    doc: str
    plant: Block


SLOW = {"servo.rate": 20.0, "servo.dead_time_s": 0.02}
IRON_LAW = {f"law.{key}": value for key, value in IRON._asdict().items()}
FOLLOWING = {"radial.gain": 8.57}
"""A radial axis that takes 0.25 s from 10 to 90 % of a step, as the depth loop of the whole lathe does."""

MACHINES: dict[str, Machine] = {
    "plant_f": Machine("S45C, feed servo of 40 rad/s", turning),
    "plant_n": Machine("S45C, feed servo of 20 rad/s with 20 ms of dead time", turning(**SLOW)),
    "plant_f_iron": Machine("iron, feed servo of 40 rad/s", turning(**IRON_LAW)),
    "plant_f_radial": Machine("plant F; the depth follows its programme in 0.25 s", turning(**FOLLOWING)),
    "plant_n_radial": Machine("plant N; the depth follows its programme in 0.25 s", turning(**SLOW, **FOLLOWING)),
}
"""By name; see :func:`machine_of`."""


def machine_of(scenario: Scenario) -> str:
    """The machine that a scenario runs on.

    The one it ends in, ``..._on_NAME``; where the depth changes, plant F whose radial axis moves it; else plant F.
    """
    named = next((name for name in MACHINES if scenario.name.endswith(f"_on_{name}")), None)
    return named or ("plant_f_radial" if scenario.params.depth.steps else "plant_f")
