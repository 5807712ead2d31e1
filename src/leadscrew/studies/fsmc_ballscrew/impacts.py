"""The modern backlash behind a screw whose place is imposed: after a reversal the table is hit, and bounces."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.plants.backlash import Play, followed
from leadscrew.plants.backlash_two_mass import backlash_two_mass
from leadscrew.report.backlash import imposed_loop

if TYPE_CHECKING:
    from leadscrew.kernel.run import Run
    from leadscrew.studies.fsmc_ballscrew.runs import Loops

SINES = {"sine_wide": (5e-3, 1.0), "sine_fast": (1e-3, 2.0 * math.pi)}
"""Amplitude in m and angular frequency in rad/s."""
SETTLED_UM = 0.05
GAP_M = 2e-6
FREE = {f"guide.{k}": v for k, v in (("coulomb", 1e-9), ("static", 1e-9), ("stiffness", 1e-3), ("damping", 0.0),
                                     ("viscous", 0.0))}  # fmt: skip
"""No guide friction to speak of."""


class Impact(NamedTuple):
    """What happens after the reversal of the screw."""

    since_s: np.ndarray
    twist_um: np.ndarray
    """Screw minus table."""
    beyond_um: np.ndarray
    """Table minus where the classic play would have it."""
    crossing_s: float
    """From the reversal until the other flank is met first."""
    swing_um: float
    """Peak to peak of the difference to the classic play, from then on."""
    settled_s: float
    """From the reversal until that difference stays within :data:`SETTLED_UM` of its end."""
    contacts: int
    """How often the other flank is met."""


def imposed(loops: Loops, name: str, restitution: float, seconds: float, **changes: float) -> Run:
    """The screw from its largest speed on, the table on the forward flank."""
    radius, rate = SINES[name]
    loop = imposed_loop(radius, rate, restitution, 1e-4, **changes)
    return loop.run(seconds, record=("plant",)).check()


def impact(loops: Loops, name: str, restitution: float) -> Impact:
    """The reversal of one of the sines under this restitution."""
    radius, rate = SINES[name]
    run = imposed(loops, name, restitution, 0.5 * math.pi / rate + 0.31)
    since = run.time - 0.5 * math.pi / rate
    twist = 1e6 * (run["plant.motor"] - run["plant.table"])
    place, classic = -0.5 * GAP_M, []
    for x in (radius * np.sin(rate * run.time)).tolist():
        place = followed(Play(), place, x)
        classic.append(place)
    beyond = 1e6 * (run["plant.table"] - np.array(classic))
    behind = twist <= -0.5e6 * GAP_M
    first = float(since[np.flatnonzero(behind & (since > 0.0))[0]])
    after = (since > first) & (since < 0.3)
    end = float(beyond[(since > 0.25) & (since < 0.3)].mean())
    off = since[after][np.abs(beyond[after] - end) > SETTLED_UM]
    met = int(np.count_nonzero(np.diff(behind[(since > 0.0) & (since < 0.3)].astype(int)) == 1))
    return Impact(since, twist, beyond, first, float(np.ptp(beyond[after])), float(off[-1]) if off.size else first, met)


def crossing_of_parabola(name: str, gap: float = GAP_M) -> float:
    """``sqrt(2 b / (R w^2))``."""
    radius, rate = SINES[name]
    return math.sqrt(2.0 * gap / (radius * rate * rate))


def pressed_m() -> float:
    """How far the guide presses the table into a flank before a slow reversal."""
    p = backlash_two_mass.params
    return float(p.guide.coulomb / p.joint.forward_stiffness)


def change_of_flank_without_friction(loops: Loops, name: str) -> tuple[float, float]:
    """Phase of the screw, degrees after its largest speed, at which a table without friction meets the other flank.

    And that of a table that flies on at the largest speed: ``R w t - R sin w t = b``, so ``w t = (6 b / R)^(1/3)``.
    """
    radius, rate = SINES[name]
    run = imposed(loops, name, 0.05, 0.5 / rate, **FREE)
    met = run.time[np.argmax(run["plant.motor"] - run["plant.table"] <= -0.5 * GAP_M)]
    return math.degrees(rate * float(met)), math.degrees((6.0 * GAP_M / radius) ** (1.0 / 3.0))
