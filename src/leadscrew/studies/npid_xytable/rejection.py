"""What a loop lets through of a disturbance at the plant's input, its price in margin, and the best linear PID for it.

    H = P_d / (1 + L),      S = 1 / (1 + L)

``L`` is the sampled loop L* as it runs (:func:`leadscrew.analysis.stability.loop.sampled_loop`), ``P_d`` the table
from a held disturbance, without dead time. :func:`best_pid` minimises the mean of ``|H|`` over the five lines of Table
II subject to a peak of ``|S|``; nothing else is weighed, noise least of all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from leadscrew.controllers._response import plant_response
from leadscrew.kernel.block import Block
from leadscrew.plants._xy_table_cutting import hold, xy_table_cutting
from leadscrew.studies.npid_xytable.calibration import PERIOD_S
from leadscrew.studies.npid_xytable.table2 import LINES_HZ
from leadscrew.studies.npid_xytable.tunings import TUNINGS, XY_TABLE, table_pid

if TYPE_CHECKING:
    from leadscrew.analysis.stability.linear import LinearLoop

SEARCHED = np.concatenate([np.geomspace(1.0, 60.0, 60), np.geomspace(60.0, 6270.0, 500)])
"""Where the search looks at ``|S|``, rad/s."""

BEST: dict[float, Block] = {
    most: replace(table_pid, params=TUNINGS[name].params.inner)
    for most, name in ((1.6, "ours.pid_best_160_ff"), (1.85, "ours.pid_best_185_ff"))
}
"""What :func:`best_pid` found, rounded, by the peak of sensitivity that was allowed; without feed-forward."""


def opened(controller: Block, changes: Mapping[str, float] | None = None) -> LinearLoop:
    """The loop L* of a linear controller, cut at the error; its plant with ``changes`` by ``plant.*`` keys."""
    from leadscrew.analysis.stability.loop import sampled_loop
    from leadscrew.controllers._wrapping import takes_motion
    from leadscrew.kernel.loop import Loop
    from leadscrew.references._sine import sine, sine_motion

    command = sine_motion if takes_motion(controller) else sine
    plant = xy_table_cutting.using(**{key.removeprefix("plant."): value for key, value in (changes or {}).items()})
    loop = Loop(reference=command, controller=controller, plant=plant, period=PERIOD_S, metrics={})
    return sampled_loop(loop, name="L*")


def let_through(loop: LinearLoop, hz: Sequence[float] | np.ndarray = LINES_HZ) -> np.ndarray:
    """``|H|`` at these frequencies, um/mV."""
    w = 2.0 * np.pi * np.asarray(hz, dtype=float)
    return np.asarray(
        np.abs(plant_response(XY_TABLE._replace(dead_time_s=0.0), PERIOD_S, w) / (1.0 + loop.response(w)))
    )


def peak(loop: LinearLoop, points: int = 6000) -> float:
    """Largest ``|S|`` on a grid of frequencies from 10 rad/s to near half the sampling frequency."""
    return float((1.0 / np.abs(1.0 + loop.response(np.geomspace(10.0, 6270.0, points)))).max())


class Gains(NamedTuple):
    """Of a plain PID."""

    kp: float
    ki: float
    kd: float


class _Plain:
    """A plain PID around the sampled table, in closed form: fast enough for a search."""

    def __init__(self) -> None:
        self.hz = np.array(LINES_HZ)
        self.lines = 2.0 * np.pi * self.hz
        self.at_lines, self.at_grid = (plant_response(XY_TABLE, PERIOD_S, w) for w in (self.lines, SEARCHED))
        plan = hold(xy_table_cutting.params, PERIOD_S)
        self.transition = np.array([plan.from_position, plan.from_velocity]).T
        self.sent = (plan.now, plan.sent, plan.sent2, plan.sent3)

    @staticmethod
    def law(gains: Gains, w: np.ndarray) -> np.ndarray:
        late = np.exp(-1j * w * PERIOD_S)
        return np.asarray(gains.kp + gains.ki * PERIOD_S / (1.0 - late) + gains.kd * (1.0 - late) / PERIOD_S)

    def peak(self, gains: Gains) -> float:
        return float((1.0 / np.abs(1.0 + self.law(gains, SEARCHED) * self.at_grid)).max())

    def through(self, gains: Gains) -> np.ndarray:
        return np.asarray(np.abs(self.at_lines / (1.0 + self.law(gains, self.lines) * self.at_lines)))

    def radius(self, gains: Gains) -> float:
        """Largest pole of the closed loop: position, speed, three outputs sent, integral, last error."""
        a, u = np.zeros((7, 7)), np.zeros(7)
        u[0] = -(gains.kp + gains.ki * PERIOD_S + gains.kd / PERIOD_S)
        u[5], u[6] = gains.ki, -gains.kd / PERIOD_S
        a[:2, :2] = self.transition
        a[:2] += np.outer(self.sent[0], u)
        a[:2, 2:5] += np.array(self.sent[1:]).T
        a[2], a[3, 2], a[4, 3] = u, 1.0, 1.0
        a[5, 5], a[5, 0], a[6, 0] = 1.0, -PERIOD_S, -1.0
        return float(np.abs(np.linalg.eigvals(a)).max())

    def cost(self, logarithms: np.ndarray, most: float) -> float:
        """Logarithm of the mean ``|H|``, with walls where ``|S|`` or a pole is too large."""
        gains = Gains(*np.exp(logarithms))
        beyond = max(0.0, self.peak(gains) - most), max(0.0, self.radius(gains) - 0.999)
        return float(np.log(self.through(gains).mean()) + 200.0 * beyond[0] + 100.0 * beyond[1])


def best_pid(most: float, seed: int = 1) -> Gains:
    """The plain PID in L* with the least mean ``|H|`` at the five lines whose peak of sensitivity is ``most`` or less.

    Differential evolution over ``ln kp, ln ki, ln kd`` (0.3 to 5, 1 to 2000, 0.001 to 0.02), about 5 s.
    """
    from scipy.optimize import differential_evolution

    plain = _Plain()
    box = [(np.log(a), np.log(b)) for a, b in ((0.3, 5.0), (1.0, 2000.0), (0.001, 0.02))]
    found = differential_evolution(plain.cost, box, args=(most,), seed=seed, popsize=25, maxiter=250, tol=1e-9)
    return Gains(*np.exp(found.x).tolist())
