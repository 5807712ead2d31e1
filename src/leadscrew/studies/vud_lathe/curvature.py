"""Curvature of a law from samples (step 3 of the paper), and what the circuit of Figure 5 reads in its place.

Trials use a cubic with ``sup |u_ee| = 1.96`` and ``sup |u_cc| = 1.35`` on [-1, 1], the paper's numbers:

    u = -(0.5 e + 0.1 ec + 1.96/6 e^3 + 1.35/6 ec^3)

Fits: a polynomial, odd because the samples' mirror images are added (:mod:`leadscrew.fuzzy.curvature`); or around each
sample a full quadratic, samples weighted by ``exp(-(d / h)^2 / 2)`` with their distance ``d`` and the bandwidth ``h``,
where 8 samples or more lie within two bandwidths. The largest size over the samples is taken.

The circuit has two stages, each a real differentiator ``s / (T s + 1)``, exact for straight lines between samples:

    y_k = a y_(k-1) + (1 - a) (x_k - x_(k-1)) / dt,    a = exp(-dt / T)

Two stages give ``d2e/dt2``, ``d2(ec)/dt2`` and ``d2u/dt2``, derivatives over *time*. The paper reads second derivatives
over *e* and *ec* off a scope, (8) and (9), and does not say how one comes from the other. For a law ``u(e, c)``

    d2u/dt2 = u_ee e'^2 + 2 u_ec e' c' + u_cc c'^2 + u_e e'' + u_c c''

so one signal holds five terms, and the quotient ``(d2u/dt2) / (d2e/dt2)`` is not ``u_ee``: for a straight law
``u = -k e`` it is ``-k`` where ``u_ee`` is 0, and it has a pole wherever ``e''`` passes zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from leadscrew.fuzzy.curvature import estimate_curvature
from leadscrew.studies.vud_lathe.laws import FULL_SCALE_MM, RATE_SCALE_MM, Move

TRUE = (1.96, 1.35)
"""(8) and (9): the paper's curvatures, and those of the cubic."""
SEED, POINTS = 6, 2000
LOCAL_AT = 200
"""At how many of the random samples a local fit is made."""
LEAST_NEAR = 8
SPEED_MM_S, AXIS_LAG_S = 289.0, 0.0193
"""Axis of the four steps: one lag in place of (2) and (3), their sum."""
STEPS_MM = (-190.0, -50.0, 50.0, 190.0)
STAGE_LAG_S = 0.01
"""Of each stage of the circuit; the paper gives no component. Ten periods of the controller."""
PERIOD_S = 0.001


class Samples(NamedTuple):
    """Points (e, ec) and the duty there."""

    points: np.ndarray
    duty: np.ndarray

    def noisy(self, size: float, seed: int = SEED) -> Samples:
        """With normal noise of this standard deviation on the duty."""
        noise = np.random.default_rng(seed).standard_normal(len(self.duty))
        return Samples(self.points, self.duty + size * noise)


def law(e, ec):
    """The cubic whose curvatures are :data:`TRUE`."""
    return -(0.5 * e + 0.1 * ec + TRUE[0] / 6.0 * e**3 + TRUE[1] / 6.0 * ec**3)


def scattered(seed: int = SEED) -> Samples:
    """Samples of the law anywhere in the plane of e and ec."""
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (POINTS, 2))
    return Samples(points, law(*points.T))


class StepRun(NamedTuple):
    """A step of the simulated axis under the law, a row a millisecond."""

    time: np.ndarray
    e: np.ndarray
    ec: np.ndarray
    duty: np.ndarray


def step_run(target_mm: float, seconds: float = 2.0) -> StepRun:
    """A step from 0 to a target by the law, on an axis with one lag and an ideal sensor."""
    dt = 0.001
    decay = math.exp(-dt / AXIS_LAG_S)
    x, w, before = 0.0, 0.0, target_mm
    rows = []
    for _ in range(round(seconds / dt)):
        error = target_mm - x
        e, ec = error / FULL_SCALE_MM, (error - before) * (0.1 / dt) / RATE_SCALE_MM
        rho = law(e, ec)
        rows.append((e, ec, rho))
        before = error
        w = decay * w + (1.0 - decay) * min(1.0, max(-1.0, rho))
        x -= SPEED_MM_S * dt * w
    e_, ec_, duty = np.array(rows).T
    return StepRun(dt * np.arange(len(rows)), e_, ec_, duty)


def stepped() -> Samples:
    """Samples of the law along four steps of a simulated axis, every 10 ms for 2 s."""
    runs = [step_run(target) for target in STEPS_MM]
    points = np.concatenate([np.column_stack([r.e, r.ec])[::10] for r in runs])
    return Samples(points, np.concatenate([r.duty[::10] for r in runs]))


def table_1(found: Mapping[str, Move], *names: str) -> Samples:
    """The samples k = 1 ... 20 of these moves, of all unless given; ec with its sign."""
    moves = [found[n] for n in names or tuple(found)]
    points = np.concatenate([np.column_stack([m.error[1:], m.rate[1:]]) for m in moves])
    return Samples(points, np.concatenate([m.duty[1:] for m in moves]))


def polynomial(samples: Samples, degree: int, odd: bool = True) -> tuple[tuple[float, float], float]:
    """u_ee and u_cc of a polynomial fit, largest over the samples, and its condition number."""
    points, duty = samples
    if odd:
        points, duty = np.concatenate([points, -points]), np.concatenate([duty, -duty])
    fit = estimate_curvature(
        points, duty, ((-1.0, 1.0),) * 2, method="polynomial", degree=degree, percentile=100.0, most_condition=math.inf
    )
    return (fit.values[0], fit.values[1]), fit.condition


def local(samples: Samples, bandwidth: float) -> tuple[float, float]:
    """u_ee and u_cc of local quadratics, largest over the points where they are made."""
    points, duty = samples
    found = []
    for centre in points[:: max(1, len(points) // LOCAL_AT)]:
        d = (points - centre) / bandwidth
        square = np.sum(d * d, axis=1)
        if np.count_nonzero(square < 4.0) < LEAST_NEAR:
            continue
        near = square < 32.0
        d, weight = d[near], np.exp(-0.25 * square[near])
        matrix = np.column_stack([np.ones(len(d)), d, 0.5 * d[:, 0] ** 2, d[:, 0] * d[:, 1], 0.5 * d[:, 1] ** 2])
        weighted = matrix * weight[:, None]
        fit = np.linalg.solve(weighted.T @ weighted, weighted.T @ (duty[near] * weight))
        found.append(np.abs(fit[[3, 5]]) / bandwidth**2)
    largest = np.max(found, axis=0)
    return float(largest[0]), float(largest[1])


def power_curvature(e, gain: float, exponent: float):
    """``|u_ee|`` of ``u = -sgn(e) gain |e|^exponent``; without bound towards e = 0."""
    return gain * exponent * (1.0 - exponent) * np.abs(e) ** (exponent - 2.0)


def differentiate(x: np.ndarray, lag_s: float = STAGE_LAG_S, stages: int = 2, dt: float = PERIOD_S) -> np.ndarray:
    """The output of cascaded stages; before the first sample the signal stood still."""
    a = math.exp(-dt / lag_s)
    y = np.asarray(x, dtype=float)
    for _ in range(stages):
        slopes = (1.0 - a) * np.diff(y, prepend=y[0]) / dt
        y = np.fromiter(accumulate(slopes, lambda before, slope: a * before + slope), float, len(slopes))
    return y


class Scope(NamedTuple):
    """What the circuit puts out along one move."""

    time: np.ndarray
    e: np.ndarray
    u2: np.ndarray
    e2: np.ndarray
    c2: np.ndarray

    @property
    def over_e(self) -> np.ndarray:
        """The quotient of the outputs of u and e."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.abs(self.u2 / self.e2)

    @property
    def over_c(self) -> np.ndarray:
        """The quotient of the outputs of u and ec."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.abs(self.u2 / self.c2)

    def at(self, error: float) -> int:
        """Row at which the size of e first is no more than this."""
        return int(np.argmax(np.abs(self.e) <= error))


def scope(time: np.ndarray, e: np.ndarray, c: np.ndarray, u: np.ndarray, lag_s: float = STAGE_LAG_S) -> Scope:
    """The circuit on the signals of one move."""
    return Scope(time, e, *(differentiate(x, lag_s) for x in (u, e, c)))


def signals(run: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time, e, ec and duty of a run of the loop, as its controller's terminals show them."""
    error = run["command"] - run["feedback"]
    change = np.diff(error, prepend=error[0]) * (0.1 / PERIOD_S)
    return run.time, error / FULL_SCALE_MM, change / RATE_SCALE_MM, run["output"]
