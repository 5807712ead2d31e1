"""What the first mode of the screw does to each controller: stability and sensitivity; and what a notch does.

The loop is exact at the samples: zero-order hold, dead time of 0.775 ms, the controller's own step as matrices. The
peak of sensitivity is taken on a grid that is dense around the mode.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.controllers._biquad import Notch, biquad
from leadscrew.controllers._response import law_matrices
from leadscrew.controllers._wrapping import takes_motion
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.plants._linear import hold_matrices
from leadscrew.plants._xy_table_two_mass import XYTableTwoMassParams, matrices
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.calibration import DEAD_TIME_S, PERIOD_S
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS

MODES_HZ = (40.0, 60.0, 80.0, 100.0, 120.0, 150.0)
"""What ball-screw axes have."""
TRIED = ("paper.pid", "ours.pid_scaled", "ours.pid_ms_159", "ours.pid_ms_185")
WIDTH, DEPTH = 0.5, 0.1
"""Of the notch: band over centre, and gain at the centre, which is the mode."""
SPEEDS = np.geomspace(1.0, 0.05, 41)
"""Shares of a controller's speed that are tried."""


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


class Axis:
    """The axis with its dead time, one period: ``x+ = A x + B u``, ``y = C x``; the last states are voltages sent."""

    def __init__(self, params: XYTableTwoMassParams) -> None:
        a, drive, _, shown = matrices(params)
        whole = int(DEAD_TIME_S / PERIOD_S)
        theta = DEAD_TIME_S - whole * PERIOD_S
        transition, _ = hold_matrices(a, drive, PERIOD_S)
        rest, first = hold_matrices(a, drive, PERIOD_S - theta)
        _, late = hold_matrices(a, drive, theta)
        n, m = len(a), len(a) + whole + 1
        self.mode_hz = params.mode_hz
        self.a, self.b, self.c = np.zeros((m, m)), np.zeros(m), np.zeros(m)
        self.a[:n, :n] = transition
        # States n, n + 1, ...: the voltage of the last period, of the one before, ...
        self.a[:n, n + whole] = rest @ late
        self.a[:n, n + whole - 1] = first
        for i in range(n + 1, m):
            self.a[i, i - 1] = 1.0
        self.b[n] = 1.0
        self.c[:n] = shown
        near = 2.0 * np.pi * params.mode_hz * np.linspace(0.4, 1.6, 301)
        w = np.concatenate([np.geomspace(2.0, np.pi / PERIOD_S, 600), near[near < np.pi / PERIOD_S]])
        self.z = np.exp(1j * PERIOD_S * np.unique(w))
        self.response = self.through(self.a, self.b) @ self.c

    def through(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """``(z - A)^-1 b`` on the grid."""
        return np.asarray(np.linalg.solve(self.z[:, None, None] * np.eye(len(a)) - a, b[:, None])[..., 0])


def _reached(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """States that the error reaches: the others (a level kept from an align) stay at rest."""
    reached = b != 0.0
    for _ in range(len(a)):
        reached = reached | ((a != 0.0) @ reached)
    return np.flatnonzero(reached)


def judged(controller: Block, axis: Axis) -> Judged:
    """Closed-loop poles and peak of sensitivity of a linear controller of numbers."""
    ready = prepared(controller, PERIOD_S)
    a, b, c, d = law_matrices(controller.step, ready, controller.state, takes_motion(controller), PERIOD_S)
    used = _reached(a, b)
    a, b, c = a[np.ix_(used, used)], b[used], c[used]
    closed = np.block(
        [[a, -np.outer(b, axis.c)], [np.outer(axis.b, c), axis.a - np.outer(d * axis.b, axis.c)]],
    )
    radius = float(np.abs(np.linalg.eigvals(closed)).max())
    if radius >= 1.0:
        return Judged(radius, np.inf)
    law = axis.through(a, b) @ c + d
    return Judged(radius, float(np.abs(1.0 / (1.0 + law * axis.response)).max()))


def notched(controller: Block, mode_hz: float) -> Block:
    """The controller behind a notch at the mode."""
    return biquad(controller, Notch(centre_hz=mode_hz, width_hz=WIDTH * mode_hz, depth=DEPTH))


def slowed(controller: Block, speed: float) -> Block:
    """A PID with its zeros and, above the table's corner, its crossover at ``speed`` times what they were."""
    p = controller.params
    return controller(kp=speed**2 * p.kp, ki=speed**3 * p.ki, kd=speed * p.kd)


def speed_within(controller: Block, axis: Axis, notch: bool, ms: float = 2.0) -> float:
    """The largest share of a PID's speed with a stable loop and a peak of sensitivity of at most ``ms``; else 0."""
    for speed in SPEEDS:
        slow = slowed(controller, float(speed))
        if judged(notched(slow, axis.mode_hz) if notch else slow, axis).ms <= ms:
            return float(speed)
    return 0.0


@measure
def mode(lab: Lab, hz: float, at_table: bool) -> tuple[dict[str, Judged], tuple[float, float]]:
    """Each of :data:`TRIED` on an axis with a mode; share of its speed that ours.pid_ms_159 keeps, without and with
    the notch.
    """
    axis = Axis(XYTableTwoMassParams(mode_hz=hz, at_table=at_table))
    loops = {name: judged(CONTROLLERS[name], axis) for name in TRIED}
    retuned = CONTROLLERS["ours.pid_ms_159"]
    return loops, (speed_within(retuned, axis, False), speed_within(retuned, axis, True))
