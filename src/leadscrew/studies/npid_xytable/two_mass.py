"""What the first mode of the screw does to each controller: stability, sensitivity, error; and what a notch does.

The loop is exact at the samples: zero-order hold, dead time of 0.775 ms, the controller's own step as matrices. The
peak of sensitivity is taken on a grid that is dense around the mode.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from leadscrew.controllers.biquad import Notch, biquad
from leadscrew.controllers.npid import npid
from leadscrew.controllers.response import law_matrices
from leadscrew.controllers.wrapping import prepared, takes_motion
from leadscrew.kernel.block import Block
from leadscrew.kernel.metrics import rms_error
from leadscrew.plants.linear import hold_matrices
from leadscrew.plants.xy_table_two_mass import XYTableTwoMassParams, matrices, xy_table_two_mass
from leadscrew.studies.npid_xytable.calibration import DEAD_TIME_S, PERIOD_S
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.runs import Loops

TWO_PI = 2.0 * np.pi


class Judged(NamedTuple):
    """A linear loop around the axis with a mode."""

    radius: float
    """Largest pole of the closed loop, in size; stable below 1."""
    ms: float
    """Peak of sensitivity; infinite where the loop is unstable."""

    @property
    def stable(self) -> bool:
        """Whether all closed-loop poles lie inside the unit circle."""
        return self.radius < 1.0


@lru_cache(maxsize=256)
def _axis(params: XYTableTwoMassParams) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The axis with its dead time, one period: ``x+ = A x + B u``, ``y = C x``; the last states are voltages sent."""
    a, drive, _, shown = matrices(params)
    whole = int(DEAD_TIME_S / PERIOD_S)
    theta = DEAD_TIME_S - whole * PERIOD_S
    transition, _ = hold_matrices(a, drive, PERIOD_S)
    rest, first = hold_matrices(a, drive, PERIOD_S - theta)
    _, late = hold_matrices(a, drive, theta)
    n, m = len(a), len(a) + whole + 1
    big, enter, out = np.zeros((m, m)), np.zeros(m), np.zeros(m)
    big[:n, :n] = transition
    # States n, n + 1, ...: the voltage of the last period, of the one before, ...
    big[:n, n + whole] = rest @ late
    if whole:
        big[:n, n + whole - 1] = first
    else:
        enter[:n] = first
    for i in range(n + 1, m):
        big[i, i - 1] = 1.0
    enter[n] = 1.0
    out[:n] = shown
    return big, enter, out


@lru_cache(maxsize=256)
def _grid(mode_hz: float) -> np.ndarray:
    """Angular frequencies, rad/s: a wide grid, and a dense one around the mode and its zero."""
    wide = np.geomspace(2.0, np.pi / PERIOD_S, 600)
    near = TWO_PI * mode_hz * np.linspace(0.4, 1.6, 301)
    return np.unique(np.concatenate([wide, near[near < np.pi / PERIOD_S]]))


def _reached(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """States that the error reaches: the others (a level kept from an align) stay at rest."""
    reached = b != 0.0
    for _ in range(len(a)):
        reached = reached | ((a != 0.0) @ reached)
    return np.flatnonzero(reached)


@lru_cache(maxsize=256)
def _axis_response(params: XYTableTwoMassParams) -> np.ndarray:
    """Position over voltage on the grid of its mode."""
    big, enter, out = _axis(params)
    return _through(big, enter, params.mode_hz) @ out


def _through(a: np.ndarray, b: np.ndarray, mode_hz: float) -> np.ndarray:
    """``(z - A)^-1 b`` on the grid."""
    z = np.exp(1j * PERIOD_S * _grid(mode_hz))
    return np.asarray(np.linalg.solve(z[:, None, None] * np.eye(len(a)) - a, b[:, None])[..., 0])


def judged(controller: Block, params: XYTableTwoMassParams) -> Judged:
    """Closed-loop poles and peak of sensitivity of a linear controller of numbers."""
    ready = prepared(controller, PERIOD_S)
    a, b, c, d = law_matrices(controller.step, ready, controller.state, takes_motion(controller), PERIOD_S)
    used = _reached(a, b)
    a, b, c = a[np.ix_(used, used)], b[used], c[used]
    big, enter, out = _axis(params)
    closed = np.block([[a, -np.outer(b, out)], [np.outer(enter, c), big - np.outer(d * enter, out)]])
    radius = float(np.abs(np.linalg.eigvals(closed)).max())
    if radius >= 1.0:
        return Judged(radius, np.inf)
    law = _through(a, b, params.mode_hz) @ c + d
    return Judged(radius, float(np.abs(1.0 / (1.0 + law * _axis_response(params))).max()))


SPEEDS = np.geomspace(1.0, 0.05, 41)
"""Shares of a controller's speed that are tried."""


def slowed(controller: Block, speed: float) -> Block:
    """A PID with its zeros and, above the table's corner, its crossover at ``speed`` times what they were."""
    p = controller.params
    return controller(kp=speed**2 * p.kp, ki=speed**3 * p.ki, kd=speed * p.kd)


def speed_within(controller: Block, params: XYTableTwoMassParams, notch: bool, ms: float = 2.0) -> float:
    """The largest share of a PID's speed with a stable loop and a peak of sensitivity of at most ``ms``; else 0."""
    for speed in SPEEDS:
        slow = slowed(controller, float(speed))
        if judged(notched(slow, params.mode_hz) if notch else slow, params).ms <= ms:
            return float(speed)
    return 0.0


MODES_HZ = (40.0, 60.0, 80.0, 100.0, 120.0, 150.0, 200.0, 300.0)
"""The first six are what ball-screw axes have; the rest shows where the trouble ends."""
USUAL = 6
LINEAR = ("paper.pid", "ours.pid_scaled", "ours.pid_ms_159", "ours.pid_ms_185")
WIDTH, DEPTH = 0.5, 0.1
"""Of the notch: band over centre, and gain at the centre, which is the mode."""
_SATURATED = npid.params.alpha * npid.params.e_max
NPID_SLOPE = math.cosh(_SATURATED) + _SATURATED * math.sinh(_SATURATED)
"""Largest local gain of the NPID of Table I, 5.546."""


def notched(controller: Block, mode_hz: float) -> Block:
    """The controller behind a notch at the mode."""
    return biquad(controller, Notch(centre_hz=mode_hz, width_hz=WIDTH * mode_hz, depth=DEPTH))


class Cell(NamedTuple):
    """One controller on one axis, without and with the notch."""

    plain: Judged
    notch: Judged


class TwoMassMap:
    """Everything that claims and pictures need, each made once."""

    def __init__(self, loops: Loops) -> None:
        self.loops = loops

    @cached_property
    def cells(self) -> dict[tuple[str, bool, float], Cell]:
        """By controller, feedback from the table (True) or the motor, and mode in Hz."""
        found = {}
        for name, at_table, hz in product(LINEAR, (True, False), MODES_HZ):
            axis = XYTableTwoMassParams(mode_hz=hz, at_table=at_table)
            block = CONTROLLERS[name]
            found[name, at_table, hz] = Cell(judged(block, axis), judged(notched(block, hz), axis))
        return found

    @cached_property
    def speeds(self) -> dict[tuple[bool, float], tuple[float, float]]:
        """Share of the speed of ours.pid_ms_159 within Ms 2, without and with the notch."""
        block, found = CONTROLLERS["ours.pid_ms_159"], {}
        for at_table, hz in product((True, False), MODES_HZ):
            axis = XYTableTwoMassParams(mode_hz=hz, at_table=at_table)
            found[at_table, hz] = speed_within(block, axis, False), speed_within(block, axis, True)
        return found

    @cached_property
    def simulated(self) -> dict[tuple[str, bool, float], float]:
        """Rms error in um under the lines of 1,000 1/min, by simulation without a notch; NaN where the run diverged."""
        order = list(product(LINEAR, (True, False), MODES_HZ))
        loop = self.loops.get(
            "paper.pid", "spindle_1000", plant=xy_table_two_mass, substeps=20, computation_delay=DEAD_TIME_S,
            metrics={"rms": rms_error(from_time=0.5 * SIMULATED_S)}, bound=BOUND_MM,
        )  # fmt: skip
        gains = [CONTROLLERS[name].params for name, _, _ in order]
        varied = {f"controller.{key}": np.array([getattr(p, key) for p in gains]) for key in ("kp", "ki", "kd")}
        varied |= {"plant.at_table": np.array([x[1] for x in order]), "plant.mode_hz": np.array([x[2] for x in order])}
        done = loop.batch(SIMULATED_S, varied)
        return dict(zip(order, (1e3 * done.metrics["rms"]).tolist(), strict=True))


SIMULATED_S, BOUND_MM = 10.0, 100.0
