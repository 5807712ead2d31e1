"""All unknowns of a candidate in one vector: simulation and its change by each, for covariance and instruments."""

from __future__ import annotations

import numpy as np

from leadscrew.identify.linear.projection import Problem, Solved
from leadscrew.identify.linear.response import Step, forced, free

NUDGE = 1e-5
"""Step of the differences in ``theta``."""


class Model:
    """``phi``: ``b_0 ... b_m``, ``theta`` (as in :class:`Problem`), start of the scaled states, offset."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.m, self.n = problem.structure.zeros, problem.structure.order
        self.searched = problem.structure.free + (problem.delay is None)

    @property
    def kept(self) -> int:
        """Unknowns that belong to the system: numerator and ``theta``; start and offset belong to the record."""
        return self.m + 1 + self.searched

    def phi(self, theta: np.ndarray, solved: Solved) -> np.ndarray:
        """The vector of a solution."""
        return np.concatenate([solved.numerator[::-1], theta, solved.start, [solved.offset]])

    def split(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numerator by rising power, and ``theta``."""
        return phi[: self.m + 1], phi[self.m + 1 : self.kept]

    def weights(self, step: Step, b: np.ndarray) -> np.ndarray:
        """Of the scaled states, for a numerator by rising power."""
        return b / step.rate ** (self.n - np.arange(self.m + 1.0))

    def ramp(self, time: np.ndarray) -> np.ndarray:
        """What an offset of one adds."""
        return np.asarray(time**self.problem.structure.integrators)

    def simulate(self, phi: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The output at the rows used."""
        b, theta = self.split(phi)
        p, step = self.problem, self.problem.system(theta)[2]
        own = forced(step, u, self.m + 1)[p.rows] @ self.weights(step, b)
        begun = free(step, len(u))[p.rows] @ phi[self.kept : -1]
        return own + begun + phi[-1] * self.ramp(p.time[p.rows])

    def jacobian(self, phi: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Change of the output by each unknown, ``[row, unknown]``."""
        p = self.problem
        theta = self.split(phi)[1]
        step = p.system(theta)[2]
        size = step.rate ** (self.n - np.arange(self.m + 1.0))
        by_b = forced(step, u, self.m + 1)[p.rows] / size
        by_start, by_offset = free(step, len(u))[p.rows], self.ramp(p.time[p.rows])[:, None]
        by_theta = np.empty((len(p.rows), self.searched))
        for k in range(self.searched):
            ahead, back = phi.copy(), phi.copy()
            ahead[self.m + 1 + k] += NUDGE
            late = p.delay is None and k == self.searched - 1
            back[self.m + 1 + k] -= min(NUDGE, theta[k]) if late else NUDGE
            width = ahead[self.m + 1 + k] - back[self.m + 1 + k]
            by_theta[:, k] = (self.simulate(ahead, u) - self.simulate(back, u)) / width
        return np.concatenate([by_b, by_theta, by_start, by_offset], axis=1)

    def refined(self, phi: np.ndarray, clean: np.ndarray, rounds: int = 12) -> tuple[np.ndarray, bool]:
        """``Z' e = 0`` with instruments from the input ``clean``, by Gauss and Newton; and whether it came to rest."""
        p = self.problem
        low, high = p.bounds()
        at = slice(self.m + 1, self.kept)
        for _ in range(rounds):
            left = p.y[p.rows] - self.simulate(phi, p.u)
            z, j = self.jacobian(phi, clean), self.jacobian(phi, p.u)
            size = np.linalg.norm(j, axis=0) + 1e-300
            change = np.linalg.lstsq((z / size).T @ (j / size), (z / size).T @ left, rcond=1e-12)[0] / size
            if not np.all(np.isfinite(change)):
                return phi, False
            share = min(1.0, 0.5 / float(np.max(np.abs(change[at]), initial=1e-9)))
            moved = phi + share * change
            moved[at] = np.clip(moved[at], low, high)
            if share == 1.0 and np.max(np.abs(change[at]), initial=0.0) < 1e-7:
                return moved, True
            phi = moved
        return phi, False
