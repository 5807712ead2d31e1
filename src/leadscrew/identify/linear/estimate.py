"""One candidate searched to the end: its unknowns refined by the command where there is one, and how sure they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.identify.linear import signs
from leadscrew.identify.linear.choose import Fitted, Task
from leadscrew.identify.linear.closed_loop import from_command
from leadscrew.identify.linear.intervals import condition, covariance
from leadscrew.identify.linear.model import Model
from leadscrew.identify.linear.projection import Solved
from leadscrew.identify.linear.sureness import Sure, sure, within

BAND = 160
"""Frequencies of the Bode band."""


class Estimate(NamedTuple):
    """Unknowns, what they leave of the training part, and intervals."""

    theta: np.ndarray
    solved: Solved
    method: str
    closed: bool
    """Whether the command was the instrument."""
    condition: float
    found: Sure
    excited_hz: tuple[float, float]

    @property
    def tells(self) -> bool:
        """Whether the log tells one of its numbers; a delay that was given is none."""
        return any(p.told and p.low < p.high for p in self.found.parameters.values())


def estimate(task: Task, best: Fitted) -> Estimate:
    """The numbers of one candidate."""
    r, problem = task.record, task.problem(best.structure)
    model = Model(problem)
    phi, method = model.phi(best.theta, best.solved), "output error"
    tools, closed = None, False
    if r.command is not None:
        clean, together = from_command(problem.u, r.command[: task.train])
        if together > 0.0:
            refined, rests = model.refined(phi, clean)
            if rests:
                phi, closed = refined, True
                tools = model.jacobian(phi, clean)
                method = (
                    f"instruments from the command, which makes {100.0 * together**2:.0f} % of the input's variance"
                )
    residual = problem.y[problem.rows] - model.simulate(phi, problem.u)
    change = model.jacobian(phi, problem.u)
    hz = np.geomspace(0.5 / (r.period * len(r.time)), 0.499 / r.period, BAND)
    found = sure(model, phi, covariance(change, residual, tools), (r.input_unit, r.output_unit), hz)
    spoken = signs.excited(problem.u[problem.rows], residual, r.period, (hz, found.bode.response))
    b, theta = model.split(phi)
    denominator, delay_s, _ = problem.system(theta)
    solved = Solved(denominator, delay_s, b[::-1].copy(), phi[model.kept : -1], float(phi[-1]), residual)
    size = condition(change[:, : model.kept])
    return Estimate(theta, solved, method, closed, size, within(found, spoken[1]), spoken)
