"""Friction against speed: Coulomb and viscous friction of all samples, and the Stribeck map of sliding alone.

Coulomb and viscous friction is the yardstick of the others, so it gets every advantage: linear least squares over all
samples of the training part, a viscous part of any sign, and at rest the friction of the last motion held. The map is
fitted to sliding only, where the elements of Maxwell slip hold 98 % of their force: bins for looking at, and a robust
fit (soft L1) that single strokes do not pull.
"""

from __future__ import annotations

import numpy as np

from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.identify.friction_force.models import levels, map_force, one_sided
from leadscrew.identify.friction_force.result import MAP, STRIBECK, Bin, ModelFit
from leadscrew.identify.friction_force.search import Found, clusters_of, robust
from leadscrew.identify.friction_force.task import STRIBECK_RATIO, VISCOUS_RATIO, Task, judged, parameters, without_rise
from leadscrew.kernel.errors import DataError

STEADY = 0.98
"""Share of the elements' sliding force that is called sliding."""
BINS = 10
"""Each direction, at most, from the slowest to the fastest in equal ratios."""
SLOWEST = 0.02
"""Of the fastest: what is slower goes into the first bin."""
IN_A_BIN = 8
"""Samples, at least."""
MOST = 4000
"""Samples that the robust fit looks at."""


def fit_coulomb(task: Task, amplitude: float) -> ModelFit:
    """Coulomb friction of each direction and viscous friction."""
    r, n = task.record, task.last
    way = r.way
    matrix = np.column_stack([way > 0.0, -(way < 0.0).astype(float), r.speed]) * task.weight[:, None]
    values, *_ = np.linalg.lstsq(matrix[:n], r.force[:n], rcond=None)
    simulated = matrix @ values
    covariance, condition, quantile = robust(
        matrix[:n], simulated[:n] - r.force[:n], clusters_of(r.strokes[:n]), np.ones(3, bool)
    )
    found = Found(values, covariance, condition, 0.0, quantile, True)
    keys = {
        "friction.forward.coulomb": ("force", np.array([1.0, 0.0, 0.0])),
        "friction.backward.coulomb": ("force", np.array([0.0, 1.0, 0.0])),
        "friction.forward.viscous": ("damping", np.array([0.0, 0.0, 1.0])),
        "friction.backward.viscous": ("damping", np.array([0.0, 0.0, 1.0])),
    }
    ahead, back, viscous = values.tolist()
    f = TwoSided(Sliding(ahead, ahead, 1.0, viscous), Sliding(back, back, 1.0, viscous))
    return judged(task, MAP, f, simulated, parameters(keys, found, task, {}), amplitude=amplitude, condition=condition)


def sliding_rows(task: Task, share: np.ndarray) -> np.ndarray:
    """Samples of the training part that slide: under load, elements at 98 % of their sliding force, no stop beside."""
    r, n = task.record, task.last
    loaded = np.abs(task.weight[:n]) > 0.5 * np.median(np.abs(task.weight[:n]))
    moving = np.concatenate([[0.0], r.travel[:n], [0.0]]) * np.concatenate([[0.0], r.way[:n], [0.0]]) > 0.0
    steady = moving[:-2] & moving[1:-1] & moving[2:] & (r.way[:n] * r.speed[:n] > 0.0)
    return np.flatnonzero(steady & loaded & (r.way[:n] * share[:n] > STEADY))


def bins_of(task: Task, rows: np.ndarray) -> list[Bin]:
    """Force against speed in bins of equal ratios of speed, each direction."""
    from scipy.stats import t as student

    r, found = task.record, []
    y = r.force / np.where(task.weight != 0.0, task.weight, 1.0)
    for way in (-1.0, 1.0):
        mine = rows[r.way[rows] == way]
        if not len(mine):
            continue
        size = np.abs(r.speed[mine])
        place = np.clip(size / size.max(), SLOWEST, 1.0 - 1e-9)
        number = np.floor(BINS * (1.0 - np.log(place) / np.log(SLOWEST)))
        for part in (mine[number == k] for k in range(BINS)):
            if len(part) < IN_A_BIN:
                continue
            means = np.array([y[part[r.strokes[part] == k]].mean() for k in np.unique(r.strokes[part])])
            few = len(means) < 3
            reach = np.nan if few else float(student.ppf(0.975, len(means) - 1) * means.std(ddof=1) / len(means) ** 0.5)
            middle = float(means.mean())
            found.append(Bin(float(r.speed[part].mean()), middle, middle - reach, middle + reach, len(means)))
    return sorted(found)


def fit_map(task: Task, rows: np.ndarray, amplitude: float) -> ModelFit:
    """The Stribeck map of sliding, robust; without a fall or a viscous part where the speeds do not differ enough."""
    from scipy.optimize import least_squares

    r = task.record
    some = rows[np.unique(np.linspace(0, len(rows) - 1, min(MOST, len(rows))).astype(int))]
    v, way, weight, y = r.speed[some], r.way[some], task.weight[some], r.force[some]
    viscous, fall = task.ratio >= VISCOUS_RATIO, task.ratio >= STRIBECK_RATIO
    fast = task.speeds[1]
    start_sides = [float(np.median(way[way == s] * y[way == s] / weight[way == s])) for s in (1.0, -1.0)]
    if not max(start_sides) > 0.0:
        raise DataError(
            f"{r.source}: while it slides the force drives the motion (median {max(start_sides):.3g} against it): "
            "it is no friction; look whether the right columns were named"
        )
    # A direction without friction starts at its bound, not outside.
    start_sides = [max(side, 2e-3 * max(start_sides)) for side in start_sides]

    def friction_of(q: np.ndarray) -> TwoSided:
        drops = q[2 + viscous : 4 + viscous] if fall else (0.0, 0.0)
        speed = float(q[4 + viscous]) if fall else 1e3 * fast
        slope = float(q[2]) if viscous else 0.0
        return TwoSided(*(one_sided(float(q[i]), float(drops[i]), speed, slope) for i in (0, 1)))

    def model(q: np.ndarray) -> np.ndarray:
        f = friction_of(q)
        return weight * (way * levels(f, v, way) + (q[2] if viscous else 0.0) * v)

    level = max(start_sides)
    low = [1e-3 * level] * 2 + [0.0] * viscous + ([0.0, 0.0, 1e-3 * fast] if fall else [])
    high = [np.inf] * (2 + viscous) + ([np.inf, np.inf, 3.0 * fast] if fall else [])
    spread = 1.4826 * float(np.median(np.abs(y - weight * way * np.where(way > 0.0, *start_sides))))
    tried = []
    for share in (0.05, 0.2, 0.5) if fall else (0.0,):
        q0 = np.array(
            [*start_sides] + [0.02 * level / fast] * viscous + [0.2 * level] * 2 * fall + [share * fast] * fall
        )
        tried.append(least_squares(
            lambda q: model(q) - y, q0, bounds=(low, high), x_scale=q0, loss="soft_l1",
            f_scale=max(spread, 1e-6 * level * float(np.abs(weight).max())),
        ))  # fmt: skip
    done = min(tried, key=lambda x: x.cost)
    free = done.x - np.array(low) > 1e-6 * np.maximum(np.abs(done.x), 1e-3 * np.abs(q0))
    covariance, condition, quantile = robust(done.jac, done.fun, clusters_of(r.strokes[some]), free)
    values = np.where(free, done.x, np.array(low))
    found = Found(values, covariance, condition, 0.0, quantile, done.status > 0)
    f = friction_of(values)
    given = _parameters(task, found, f, viscous, fall)
    return judged(task, STRIBECK, f, task.weight * map_force(f, r), given, amplitude=amplitude, condition=condition)


def _parameters(task: Task, found: Found, f: TwoSided, viscous: bool, fall: bool) -> dict:
    unit = np.eye(len(found.values))
    keys, fixed = {}, {}
    why = f"sliding speeds differ by a factor of {task.ratio:.2g} only"
    for i, side in enumerate(("forward", "backward")):
        way = getattr(f, side)
        keys[f"friction.{side}.coulomb"] = ("force", unit[i])
        if viscous:
            keys[f"friction.{side}.viscous"] = ("damping", unit[2])
        else:
            fixed[f"friction.{side}.viscous"] = (0.0, "damping", why)
        if fall:
            keys[f"friction.{side}.static"] = ("force", unit[i] + unit[2 + viscous + i])
            keys[f"friction.{side}.stribeck_speed"] = ("speed", unit[4 + viscous])
        else:
            fixed |= without_rise(way, side, why)
    return parameters(keys, found, task, fixed)
