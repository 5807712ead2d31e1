"""From where the fuzzy sliding mode brings the stage back: what can be proved, and what is measured.

Let the friction that the controller does not know, and any load, be at most D: ``abs(F_hat - F + load) <= D``. Then

    s' = -lam s + (U K(s / S, s_c / S_c) + d) / J,    abs(d) <= D

1. **Reaching.** If ``-K(x, y) >= D / U`` for all ``x >= a`` and all y in [-1, 1] (and the mirror image of it, which a
   symmetrical table has), then outside ``abs(s) <= a S`` the size of s falls at least at the rate ``lam``: from
   *every* start the state comes to that band and stays. Rules without the dead corner have such an a below 1 for every
   ``D < U / 2``, because ``K(1, y) <= -1/2`` for all y. The paper's rules and the corrected ones have none: each has a
   corner with ``K = 0``.
2. **Shrinking.** ``s_c = (p - lam) / (p + lam) s``, whose impulse response has the size 3, so that later
   ``abs(s_c) <= 3 a S``, and only ``abs(y) <= 3 a S / S_c`` matters. Used again and again this gives the ``a`` of
   :func:`ultimate_band`.
3. **The error** is ``e = p / (p + lam)^2 s``, so finally ``abs(e) <= 0.7358 a S / lam``.

What this does not cover: the damping of the true bristles, ``s1 dz/dt``, has no bound as long as the speed has none. It
is there in the measurements, which run the whole LuGre stage.

At rest on the target ``s = -s_c``. What the rules can hold there without a motion is ``U hold``, :func:`hold`: less
than load and static friction together, and the stage is left microns away with the integral running into the corner.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from leadscrew.controllers._sliding.continuous import fsmc_ideal, fsmc_printed_ideal, fuzzy_ideal
from leadscrew.controllers._sliding.fuzzy import RULES, sliding_system
from leadscrew.disturbances._step_load import step_load
from leadscrew.friction.lugre import HAT, LuGre
from leadscrew.kernel.block import Block
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.laws import LAM, SYSTEMS, tight_bounds
from leadscrew.studies.lab import Lab, measure

WITHOUT_DEAD_CORNER = fuzzy_ideal(
    sliding_system(
        RULES["without_dead_corner"], "fsmc_whole_ideal", "Fuzzy sliding mode, rules without a dead corner; a torque."
    ),
    "fsmc_whole_ideal",
)

BLOCKS: dict[str, Block] = {
    "printed": fsmc_printed_ideal,
    "corrected": fsmc_ideal,
    "without_dead_corner": WITHOUT_DEAD_CORNER,
}
"""Without sampling, by rule base."""

UNKNOWN = HAT.static + LuGre().static
"""Largest friction torque that may be missed at low speed, N m: believed one way, true the other way."""

STEPS_MM = tuple(float(x) for x in np.geomspace(1e-3, 100.0, 6))
"""Errors at the start, mm."""

LOADS = tuple(float(x) for x in range(0, 101, 5))
"""Loads that come on with it, N m; static friction is 9.36."""

SECONDS = 0.5
HOME_UM = 1.0
"""An end within this of the target is a return."""

SCALE, TORQUE, RATIO = 0.65, 120.0, 4.0
"""S in rad/s, U in N m, S_c over S."""


def hold(rules: str, ratio: float) -> float:
    """Largest K on the line ``s = -s_c``, where the stage rests on the target; ``ratio`` is ``S_c / S``."""
    x = np.linspace(0.0, 2.0 * max(1.0, ratio), 4001)
    return float(-SYSTEMS[rules].many(s=x, s_c=-x / ratio).min())


def surface_grid(rules: str, half: int = 400) -> tuple[np.ndarray, np.ndarray, float]:
    """Values of x from 0, ``-K(x, y)``, and how far K may be from the nearest value: half of what neighbours differ."""
    x, y = np.linspace(0.0, 1.0, half + 1), np.linspace(-1.0, 1.0, 2 * half + 1)
    k = -SYSTEMS[rules].many(s=x[:, None], s_c=y[None, :])
    margin = 0.5 * (np.abs(np.diff(k, axis=0)).max() + np.abs(np.diff(k, axis=1)).max())
    return x, k, float(margin)


def reach(rules: str, share: float, widest: float = 1.0) -> float:
    """Least a with ``-K(x, y) >= share`` for all ``x >= a``, ``abs(y) <= widest``; NaN where there is none."""
    x, k, margin = surface_grid(rules)
    y = np.linspace(-1.0, 1.0, k.shape[1])
    worst = np.minimum.accumulate(k[:, np.abs(y) <= widest + 1e-9].min(axis=1)[::-1])[::-1]
    enough = np.flatnonzero(worst - margin >= share)
    return float(x[enough[0]]) if len(enough) else float("nan")


def ultimate_band(rules: str, ratio: float, share: float) -> float:
    """The a of steps 1 and 2: finally ``abs(s) <= a S``, from every start; NaN where step 1 fails."""
    a = reach(rules, share)
    while a == a:
        smaller = reach(rules, share, min(1.0, 3.0 * a / ratio))
        if not smaller < a:
            return a
        a = smaller
    return a


def ultimate_error_um(band: float, scale: float = SCALE, lam: float = LAM) -> float:
    """Step 3, at the table."""
    return 1e3 * TRAVEL_MM_PER_RAD * tight_bounds()[0] * band * scale / lam


class Region(NamedTuple):
    """Where the stage ends, um: one row an initial error, one column a load."""

    rules: str
    ratio: float
    left_um: np.ndarray

    @property
    def returned(self) -> np.ndarray:
        """Which starts end on the target."""
        return np.asarray(self.left_um <= HOME_UM)


@measure
def region(lab: Lab, rules: str, ratio: float = RATIO) -> Region:
    """A step of each of :data:`STEPS_MM` under each of :data:`LOADS`, from rest."""
    loop = lab.loop(
        BLOCKS[rules](scale_sc=SCALE * ratio), "step_raw",
        disturbance=step_load(), metrics={}, sample=1e-2, rtol=1e-4, atol=1e-10, bound=1e6,
    )  # fmt: skip
    return Region(rules, ratio, np.array([[_left(loop, step, load) for load in LOADS] for step in STEPS_MM]))


def _left(loop: Any, step: float, load: float) -> float:
    run = loop.using({"reference.distance": step, "disturbance.size": load}).run(SECONDS, record="true_error")
    return 1e3 * float(np.abs(run["true_error"][-5:]).max()) if run.diverged is None else float("inf")


def largest_load(found: Region) -> float:
    """Largest load up to which every start returns, N m; NaN where none does."""
    lost = np.flatnonzero((~found.returned).any(axis=0))
    last = int(lost[0]) if len(lost) else len(LOADS)
    return LOADS[last - 1] if last else float("nan")
