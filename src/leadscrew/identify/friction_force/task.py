"""One fit: a record, its load, and which samples may be looked at.

Least squares of a simulated friction force, with intervals that allow for residuals that are not white.

What a model misses comes again in every stroke and lasts for many samples, so neighbouring residuals are alike and the
usual intervals are far too narrow. The covariance is that of :func:`leadscrew.identify.estimation.clustered`, its
clusters being cycles of two strokes, or strokes where there are few; a sum of values has the fewest degrees of freedom
of its parts. Intervals say how well the parameters repeat from cycle to cycle; a shape that the model cannot take is
missed the same way in each of them and does not widen an interval, nor does the bias of samples that are far apart.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from leadscrew.friction.static_map import Sliding
from leadscrew.identify.estimation import Parameter, Spread, clustered, fitted, quantile, whiteness
from leadscrew.identify.estimation import fixed as fixed_parameter
from leadscrew.identify.friction_force.record import ForceRecord
from leadscrew.identify.friction_force.result import Load, ModelFit

CLUSTERS = 8
"""Fewest clusters for an interval."""
PIECES = 16
"""Clusters of equal length, where there are too few strokes."""
AT_BOUND = 1e-5
"""Of a parameter's usual size: nearer than this it lies on its bound."""


class Found(NamedTuple):
    """The best values."""

    values: np.ndarray
    spread: Spread
    """NaN where a parameter is on its bound, or without effect."""
    rms: float
    converged: bool


def clusters_of(strokes: np.ndarray) -> np.ndarray:
    """Number of the cluster of each sample."""
    strokes = strokes - strokes[0]
    for wide in (2, 1):
        if strokes[-1] // wide + 1 >= CLUSTERS:
            return strokes // wide
    return np.arange(len(strokes)) * PIECES // len(strokes)


def search(
    model: Callable[[np.ndarray], np.ndarray], target: np.ndarray, strokes: np.ndarray, start: np.ndarray,
    low: np.ndarray, high: np.ndarray, size: np.ndarray, most: int = 60,
) -> Found:  # fmt: skip
    """The values between ``low`` and ``high`` with which ``model`` comes nearest to ``target``.

    Args:
        model: force of some values at the samples of ``target``, N.
        target: measured force, N.
        strokes: number of the stroke of each sample.
        start: where to begin.
        low: least values.
        high: largest values.
        size: what is a usual size of each, which scales the search.
        most: evaluations of the Jacobian, at most.
    """
    from scipy.optimize import least_squares

    begin = np.clip(start, low + 1e-2 * size, high - 1e-2 * size)
    done = least_squares(
        lambda q: model(q) - target, begin, bounds=(low, high), x_scale=size, max_nfev=most, ftol=1e-9, xtol=1e-9
    )
    free = (done.x - low > AT_BOUND * size) & (high - done.x > AT_BOUND * size)
    spread = spread_of(done.jac, done.fun, clusters_of(strokes), free)
    rms = float(np.sqrt(np.mean(done.fun**2)))
    values = np.where(free, done.x, np.where(done.x - low < high - done.x, low, high))
    return Found(values, spread, rms, bool(done.status > 0))


def spread_of(jacobian: np.ndarray, residual: np.ndarray, clusters: np.ndarray, free: np.ndarray) -> Spread:
    """Covariance and degrees of freedom of the ``free`` values; NaN for the others, and for those without effect."""
    p = jacobian.shape[1]
    use = np.flatnonzero(free & (np.linalg.norm(jacobian, axis=0) > 0.0))
    covariance, degrees = np.full((p, p), np.nan), np.full(p, np.nan)
    if not len(use):
        return Spread(covariance, degrees, float("nan"))
    found = clustered(jacobian[:, use], residual, clusters)
    covariance[np.ix_(use, use)], degrees[use] = found.covariance, found.degrees
    return Spread(covariance, degrees, found.condition)


VISCOUS_RATIO = 2.0
"""Fast over slow sliding below which a viscous part cannot be told from Coulomb friction."""
STRIBECK_RATIO = 3.0
"""The same for a Stribeck fall."""


class Task(NamedTuple):
    """What is fitted to what."""

    record: ForceRecord
    load: Load
    weight: np.ndarray
    """Normal force, N; 1 for a model in newtons."""
    last: int
    """Samples that may be looked at."""
    speeds: tuple[float, float]
    """Slow and fast sliding in them."""

    @property
    def ratio(self) -> float:
        """Fast over slow sliding."""
        slow, fast = self.speeds
        return fast / slow if slow > 0.0 else np.inf

    def units(self) -> dict[str, str]:
        """Unit of each kind of parameter."""
        force, way = (
            ("", self.record.unit) if self.load == "coefficient" else (self.record.force_unit, self.record.unit)
        )
        per = f"{force} " if force else ""
        return {
            "force": force or "1", "stiffness": f"{force or '1'}/{way}", "damping": f"{per}s/{way}",
            "speed": f"{way}/s", "exponent": "1", "travel": way,
        }  # fmt: skip


def task_of(record: ForceRecord, load: Load, last: int) -> Task:
    """The task of the first ``last`` samples."""
    weight = record.normal if load == "coefficient" and record.normal is not None else np.ones(len(record.time))
    return Task(record, load, weight, last, sliding_speeds(record, last))


def sliding_speeds(record: ForceRecord, last: int) -> tuple[float, float]:
    """Speeds that 5 % and 95 % of the travel are slower than."""
    way, speed = np.abs(record.travel[:last]), np.abs(record.speed[:last])
    order = np.argsort(speed)
    share = np.cumsum(way[order])
    low, high = np.searchsorted(share, [0.05 * share[-1], 0.95 * share[-1]])
    return float(speed[order][low]), float(speed[order][high])


def without_rise(way: Sliding, side: str, why: str) -> dict[str, tuple[float, str, str]]:
    """Static friction and Stribeck speed of a direction, fixed because none was found."""
    return {
        f"friction.{side}.static": (way.static, "force", f"as Coulomb: {why}"),
        f"friction.{side}.stribeck_speed": (way.stribeck_speed, "speed", "without effect: static is Coulomb"),
    }


def parameters(
    keys: Mapping[str, tuple[str, np.ndarray]], found: Found, task: Task, fixed: Mapping[str, tuple[float, str, str]]
) -> dict[str, Parameter]:
    """Parameters with intervals: each key is a sum of fitted values (unit kind, weights); ``fixed`` have a reason."""
    units, out = task.units(), {}
    for key, (kind, weights) in keys.items():
        used = weights != 0.0
        value = float(weights @ found.values)
        variance = float(weights[used] @ found.spread.covariance[np.ix_(used, used)] @ weights[used])
        if not np.isfinite(variance):
            out[key] = Parameter(value, units[kind], np.nan, np.nan, "fitted", False, "on its bound, or without effect")
            continue
        reach = quantile(float(found.spread.degrees[used].min())) * float(np.sqrt(variance))
        coulomb = out.get(key.replace(".static", ".coulomb")) if key.endswith(".static") else None
        counted = value if coulomb is None else value - coulomb.value
        p = fitted(value, (value - reach, value + reach), units[kind], counted=counted)
        out[key] = p if p.identifiable else p._replace(note="its interval is too wide to be of use")
    for key, (value, kind, why) in fixed.items():
        out[key] = fixed_parameter(value, units[kind], why)
    return out


def judged(
    task: Task, name: str, friction: Any, simulated: np.ndarray, given: dict[str, Parameter], *, amplitude: float,
    offset: float = 0.0, condition: float = float("nan"), notes: tuple[str, ...] = (),
) -> ModelFit:  # fmt: skip
    """A model with its errors: ``simulated`` is its force over the whole record, N."""
    left = task.record.force - simulated
    seen, rest = left[: task.last], left[task.last :]
    rms = float(np.sqrt(np.mean(seen**2)))
    held = float(np.sqrt(np.mean(rest**2))) if len(rest) else float("nan")
    worst = float(np.abs(rest).max()) if len(rest) else float("nan")
    percent = 100.0 / amplitude
    return ModelFit(
        name, task.load, friction, given, offset, simulated, rms, held, worst, percent * rms, percent * held, condition,
        whiteness(seen).percent, notes,
    )  # fmt: skip
