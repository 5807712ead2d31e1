"""Where the search for poles starts: a grid, poles of simpler candidates with one more, instrumental variables.

Refined instrumental variables for continuous time (Young, *Recursive Estimation and Time-Series Analysis*, 2nd ed.,
2011, chapter 8): filtered by ``1 / E(s)``, ``D(s) y = B(s) u`` is a linear equation in the coefficients. Its output is
noisy, so the instruments are what the model so far makes of the input; then ``E`` becomes the new ``D``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.identify.linear.projection import Problem
from leadscrew.identify.linear.response import Step, forced, free, step_of

GRID = 10
"""Poles of the grid, evenly over the logarithm."""
ROUNDS = 4


class Known(NamedTuple):
    """What another candidate ended with."""

    poles: np.ndarray
    """Those that are not at zero."""
    delay_s: float


def starts(problem: Problem, known: list[Known], delays_s: list[float], most: int = 2) -> list[np.ndarray]:
    """The best few of all starts, by their sum of squares; ``delays_s`` are tried where nothing is known."""
    structure = problem.structure
    low, high = problem.bounds()
    tried: list[tuple[float, np.ndarray]] = []
    for poles, late in _sets(problem, known, delays_s):
        theta = structure.theta(poles)
        full = np.append(theta, late / problem.period) if problem.delay is None else theta
        full = np.clip(full, low, high)
        tried.append((float(np.sum(problem.residual(full) ** 2)), full))
    tried.sort(key=lambda pair: pair[0])
    chosen: list[np.ndarray] = []
    for _, theta in tried:
        if all(np.max(np.abs(theta - other), initial=0.0) > 0.5 for other in chosen):
            chosen.append(theta)
        if len(chosen) == most:
            break
    return chosen


def _sets(problem: Problem, known: list[Known], delays_s: list[float]) -> list[Known]:
    r = problem.structure.free
    grid = np.geomspace(1.0 / problem.time[-1], 1.0 / problem.period, GRID)
    sets = [k for k in known if len(k.poles) == r]
    for poles, late in known:
        if len(poles) == r - 1:
            sets += [Known(np.append(poles, -w), late) for w in grid]
        if len(poles) == r - 2:
            pairs = [w * np.array([-z + 1j, -z - 1j]) for w in grid for z in (0.03, 0.5)]
            sets += [Known(np.append(poles, pair), late) for pair in pairs]
    if not sets:
        sets = [Known(-w * np.geomspace(1.0, 3.0, r), late) for w in grid for late in delays_s]
    best = min(sets, key=lambda k: _cost(problem, k.poles))
    return [
        *sets,
        *(Known(poles, late) for poles in _refined(problem, best.poles) for late in (*delays_s, best.delay_s)),
    ]


def _cost(problem: Problem, poles: np.ndarray) -> float:
    theta = problem.structure.theta(poles)
    if problem.delay is None:
        theta = np.append(theta, 0.0)
    low, high = problem.bounds()
    return float(np.sum(problem.residual(np.clip(theta, low, high)) ** 2))


def _refined(problem: Problem, poles: np.ndarray) -> list[np.ndarray]:
    """Poles after some rounds of instrumental variables; none where they fail."""
    s = problem.structure
    found: list[np.ndarray] = []
    for _ in range(ROUNDS):
        try:
            poles = _round(problem, poles)
        except (np.linalg.LinAlgError, ValueError):
            return found[-1:]
        if len(poles) != s.free or not np.all(np.isfinite(poles)) or np.any(poles == 0.0):
            return found[-1:]
        poles = _inside(problem, poles)
        found.append(poles)
    return found[-1:]


def _inside(problem: Problem, poles: np.ndarray) -> np.ndarray:
    """Stable, and neither slower than the record nor faster than the sampling."""
    size = np.clip(np.abs(poles), 0.1 / problem.time[-1], 3.0 / problem.period)
    turned = np.where(poles.real > 0.0, -poles.conj(), poles)
    return size * turned / np.abs(poles)


def _round(problem: Problem, poles: np.ndarray) -> np.ndarray:
    s = problem.structure
    theta = s.theta(poles)
    late = 0.0 if problem.delay is None else problem.delay
    full = np.append(theta, 0.0) if problem.delay is None else theta
    low, high = problem.bounds()
    columns = problem.columns(problem.system(np.clip(full, low, high))[2])
    model = np.interp(np.arange(len(problem.u)), problem.rows, problem.y[problem.rows] - problem.project(columns)[1])
    filter_ = np.real(np.poly([*poles, *([-np.exp(np.mean(np.log(np.abs(poles))))] * s.integrators)]))
    own = step_of(filter_, 0.0, problem.period)
    driven = forced(step_of(filter_, late, problem.period), problem.u, s.zeros + 1)
    common = np.concatenate([driven, free(own, len(problem.u)), np.ones((len(problem.u), 1))], axis=1)
    measured, clean = (_derivatives(own, filter_, _middle(v - v[0])) for v in (problem.y, model))
    regress, tools = (np.concatenate([-v[:, s.integrators : -1], common], axis=1) for v in (measured, clean))
    size = np.linalg.norm(tools, axis=0) + 1e-300
    solution = np.linalg.lstsq((tools / size).T @ (regress / size), (tools / size).T @ measured[:, -1], rcond=1e-13)[0]
    inner = (solution / size)[: s.free] * own.rate ** (s.order - np.arange(s.integrators, s.order))
    return np.roots(np.concatenate([[1.0], inner[::-1]]))


def _middle(values: np.ndarray) -> np.ndarray:
    """What is held in place of a signal that runs on between its samples."""
    return np.append(0.5 * (values[1:] + values[:-1]), values[-1])


def _derivatives(step: Step, filter_: np.ndarray, values: np.ndarray) -> np.ndarray:
    """``(s / rate)^k rate^n / E`` of a signal, k = 0 ... n."""
    states = forced(step, values)
    n = len(filter_) - 1
    scaled = filter_ / step.rate ** np.arange(n + 1.0)
    return np.concatenate([states, (values - states @ scaled[:0:-1])[:, None]], axis=1)
