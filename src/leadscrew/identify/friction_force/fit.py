"""All friction models of a measured friction force, fitted to its first part and judged on the rest.

Friction against speed: Coulomb and viscous friction of all samples, and the Stribeck map of sliding alone.

Coulomb and viscous friction is the yardstick of the others, so it gets every advantage: linear least squares over all
samples of the training part, a viscous part of any sign, and at rest the friction of the last motion held. The map is
fitted to sliding only, where the elements of Maxwell slip hold 98 % of their force: bins for looking at, and a robust
fit (soft L1) that single strokes do not pull.

Models of friction that know the travel only: Dahl, and Maxwell slip, which has a memory of every reversal.

Maxwell slip is found without a search: with elements that yield after fixed travels its force is linear in their
shares, and non-negative least squares (C. Lawson, R. Hanson, *Solving least squares problems*, 1974) gives the best of
all shares at once. Elements that get none drop out. It also says best what slides: where elements with 98 % of the
force slip.

LuGre from a measured friction force: stiffness, damping, friction of each direction, Stribeck fall if there is one.

The start of the search is Coulomb friction of each direction and the best of several stiffnesses. Viscous friction
needs sliding speeds that differ, a Stribeck fall needs them to differ more; where they do not, the value is fixed and
said to be. A Stribeck fall is kept only where it lowers the error on validation strokes: the last third of the
training part judges it, and then all of the training part fits it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.dahl import Dahl
from leadscrew.friction.maxwell_slip import MaxwellSlip
from leadscrew.friction.static_map import Sliding, TwoSided
from leadscrew.identify.estimation import Parameter, quantile
from leadscrew.identify.friction_force.models import dahl_force, levels, lugre_force, map_force, one_sided, stops
from leadscrew.identify.friction_force.record import LEAST, ForceRecord
from leadscrew.identify.friction_force.result import (
    DAHL,
    LUGRE,
    MAP,
    SLIP,
    STRIBECK,
    Bin,
    FrictionForceFit,
    Load,
    ModelFit,
)
from leadscrew.identify.friction_force.task import (
    STRIBECK_RATIO,
    VISCOUS_RATIO,
    Found,
    Task,
    clusters_of,
    judged,
    parameters,
    search,
    spread_of,
    task_of,
    without_rise,
)
from leadscrew.kernel.one_thread import one_thread
from leadscrew.util.errors import DataError, ValueRefused

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
    spread = spread_of(matrix[:n], simulated[:n] - r.force[:n], clusters_of(r.strokes[:n]), np.ones(3, bool))
    found = Found(values, spread, 0.0, True)
    keys = {
        "friction.forward.coulomb": ("force", np.array([1.0, 0.0, 0.0])),
        "friction.backward.coulomb": ("force", np.array([0.0, 1.0, 0.0])),
        "friction.forward.viscous": ("damping", np.array([0.0, 0.0, 1.0])),
        "friction.backward.viscous": ("damping", np.array([0.0, 0.0, 1.0])),
    }
    ahead, back, viscous = values.tolist()
    f = TwoSided(Sliding(ahead, ahead, 1.0, viscous), Sliding(back, back, 1.0, viscous))
    return judged(
        task, MAP, f, simulated, parameters(keys, found, task, {}), amplitude=amplitude, condition=spread.condition
    )


def sliding_rows(task: Task, share: np.ndarray) -> np.ndarray:
    """Samples of the training part that slide: under load, elements at 98 % of their sliding force, no stop beside."""
    r, n = task.record, task.last
    loaded = np.abs(task.weight[:n]) > 0.5 * np.median(np.abs(task.weight[:n]))
    moving = np.concatenate([[0.0], r.travel[:n], [0.0]]) * np.concatenate([[0.0], r.way[:n], [0.0]]) > 0.0
    steady = moving[:-2] & moving[1:-1] & moving[2:] & (r.way[:n] * r.speed[:n] > 0.0)
    return np.flatnonzero(steady & loaded & (r.way[:n] * share[:n] > STEADY))


def bins_of(task: Task, rows: np.ndarray) -> list[Bin]:
    """Force against speed in bins of equal ratios of speed, each direction."""
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
            reach = np.nan if few else quantile(len(means) - 1) * float(means.std(ddof=1)) / len(means) ** 0.5
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
    doubt = spread_of(done.jac, done.fun, clusters_of(r.strokes[some]), free)
    values = np.where(free, done.x, np.array(low))
    found = Found(values, doubt, 0.0, done.status > 0)
    f = friction_of(values)
    given = _map_parameters(task, found, f, viscous, fall)
    return judged(
        task, STRIBECK, f, task.weight * map_force(f, r), given, amplitude=amplitude, condition=doubt.condition
    )


def _map_parameters(task: Task, found: Found, f: TwoSided, viscous: bool, fall: bool) -> dict:
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


ELEMENTS = 16
"""Yields that are tried first."""
NEAR = 7
"""Yields that are tried then, around each that was used."""
ALIKE = 1.2
"""Ratio of two yields below which their elements are one."""
LONGEST = 0.25
"""Of the range of the position: yields up to here, so that every element slips in a full stroke both ways."""
LEAST_SHARE = 1e-3
"""Of the largest: an element with less is none."""
NO_PATH = (
    "no part of the force follows the path as friction does, bending at a reversal and holding then; is it the force "
    "of a drive, with a mass in it? leadscrew identify axis takes those apart"
)
EXPONENTS = (0.3, 1.0)
"""Of Dahl, to start from."""


def fit_dahl(task: Task, like: ModelFit, amplitude: float) -> ModelFit:
    """Dahl with an offset; the search starts at the LuGre fit ``like``."""
    f, n = like.friction, task.last
    assert isinstance(f, TwoSidedLuGre)
    with_viscous = task.ratio >= VISCOUS_RATIO
    level = 0.5 * (f.forward.coulomb + f.backward.coulomb)
    record = dataclasses.replace(
        task.record, travel=task.record.travel[:n], speed=task.record.speed[:n], time=task.record.time[:n]
    )
    weight, target = task.weight[:n], task.record.force[:n]

    def friction_of(q: np.ndarray) -> Dahl:
        return Dahl(float(q[0]), float(q[1]), float(q[2]), float(q[4]) if with_viscous else 0.0)

    def model(q: np.ndarray) -> np.ndarray:
        return weight * (dahl_force(friction_of(q), record) + q[3])

    extra = [0.02 * level / task.speeds[1]] * with_viscous
    low = np.array([1e-9, 1e-3 * level, 0.05, -level] + [0.0] * with_viscous)
    high = np.array([np.inf, 10.0 * level, 20.0, level] + [np.inf] * with_viscous)
    size = np.array([f.stiffness, level, 0.3, level] + [0.1 * level / task.speeds[1]] * with_viscous)
    tried = []
    for exponent in EXPONENTS:
        start = np.array([f.stiffness, level, exponent, 0.0, *extra])
        tried.append(search(model, target, task.record.strokes[:n], start, low, high, size, most=40))
    found = min(tried, key=lambda x: x.rms)
    names = ["stiffness", "coulomb", "exponent", "offset"] + ["viscous"] * with_viscous
    kinds = {"stiffness": "stiffness", "coulomb": "force", "exponent": "exponent", "offset": "force",
             "viscous": "damping"}  # fmt: skip
    keys = {
        (name if name == "offset" else f"friction.{name}"): (kinds[name], np.eye(len(names))[i])
        for i, name in enumerate(names)
    }
    dahl = friction_of(found.values)
    force = task.weight * (dahl_force(dahl, task.record) + found.values[3])
    return judged(task, DAHL, dahl, force, parameters(keys, found, task, {}), amplitude=amplitude,
                  offset=float(found.values[3]), condition=found.spread.condition)  # fmt: skip


def fit_slip(task: Task, amplitude: float) -> tuple[ModelFit, np.ndarray]:
    """Maxwell slip with an offset and, where speeds differ, a viscous part; and its springs' share of sliding."""
    record, n = task.record, task.last
    reach = float(np.ptp(record.position[:n]))
    most = LONGEST * reach
    coarse = np.geomspace(max(record.encoder_step, 1e-3 * reach), most, ELEMENTS)
    forces = _weights(task, coarse)[1][: len(coarse)]
    width = (coarse[1] / coarse[0]) ** 0.75
    if not forces.any():
        raise DataError(f"{record.source}: {NO_PATH}")
    fine = np.unique([coarse[k] * width**p for k in _used(forces) for p in np.linspace(-1.0, 1.0, NEAR)])
    fine = fine[fine <= most]
    finer = _weights(task, fine)[1][: len(fine)] if len(fine) else np.zeros(0)
    yields = _merged(fine, finer) if finer.any() else coarse[_used(forces)]
    matrix, weights = _weights(task, yields)
    m = len(yields)
    used, level = _used(weights[:m]), float(weights[:m].sum())
    if not level > 0.0:
        raise DataError(f"{record.source}: {NO_PATH}")
    offset = float(weights[m] - weights[m + 1])
    viscous = float(weights[m + 2]) if len(weights) > m + 2 else 0.0
    slip = MaxwellSlip(
        share=weights[used] / level, stiffness=weights[used] / yields[used], damping=0.0, viscous=viscous,
        coulomb=level, static=level,
    )  # fmt: skip
    simulated = matrix @ weights
    kept = np.flatnonzero(weights > 0.0)
    spread = spread_of(
        matrix[:n][:, kept], simulated[:n] - record.force[:n], clusters_of(record.strokes[:n]), np.ones(len(kept), bool)
    )
    found = Found(weights[kept], spread, 0.0, True)
    unit = {int(k): row for k, row in zip(kept, np.eye(len(kept)), strict=True)}
    keys = {"friction.coulomb": ("force", np.sum([unit[int(k)] for k in used], axis=0))}
    keys |= {f"friction.share[{i}]": ("force", unit[int(k)]) for i, k in enumerate(used)}
    given = parameters(keys, found, task, {})
    for i, k in enumerate(used):
        given[f"friction.share[{i}]"] = _share(given[f"friction.share[{i}]"], level, float(yields[k]), record.unit)
    bent = matrix[:, :m] @ weights[:m] / (level * np.where(task.weight != 0.0, task.weight, 1.0))
    fit = judged(task, SLIP, slip, simulated, given, amplitude=amplitude, offset=offset, condition=spread.condition)
    return fit, bent


def _weights(task: Task, yields: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Columns (elements, offset up and down, speed) over the whole record, and their best weights."""
    from scipy.optimize import nnls

    ones = np.ones(len(task.record.time))
    columns = [*stops(task.record, yields).T, ones, -ones]
    if task.ratio >= VISCOUS_RATIO:
        columns.append(task.record.speed)
    matrix = np.column_stack(columns) * task.weight[:, None]
    # all columns of one length, or the solver's tolerance would drop small ones
    size = np.maximum(np.linalg.norm(matrix[: task.last], axis=0), 1e-300)
    # the triangle of QR has the same solution, and a few rows in place of thousands
    q, r = np.linalg.qr(matrix[: task.last] / size)
    return matrix, nnls(r, q.T @ task.record.force[: task.last])[0] / size


def _used(forces: np.ndarray) -> np.ndarray:
    return np.flatnonzero(forces > LEAST_SHARE * forces.max())


def _merged(yields: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Yields of the elements used, those nearer to one another than :data:`ALIKE` as one."""
    groups: list[list[int]] = []
    for k in _used(forces).tolist():
        if groups and yields[k] < ALIKE * yields[groups[-1][-1]]:
            groups[-1].append(k)
        else:
            groups.append([k])
    return np.array([np.average(yields[g], weights=forces[g]) for g in groups])


def _share(p: Parameter, level: float, yields: float, unit: str) -> Parameter:
    note = f"yields after {yields:.3g} {unit}" + ("" if p.identifiable else "; its interval is too wide to be of use")
    return Parameter(p.value / level, "1", p.low / level, p.high / level, p.how, p.identifiable, note)


SHARES = (1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Of the range of the position: relaxation lengths to start from."""
FALLS = (0.05, 0.2, 0.5)
"""Of the fastest sliding: Stribeck speeds to start from."""
KEEP = 0.98
"""A Stribeck fall must lower the error on validation strokes to this share."""
FAR_SPEED = 1e3
"""Times the fastest sliding: a Stribeck speed that does not matter because there is no fall."""


class Shape(NamedTuple):
    """Which values are searched for; the others are 0."""

    viscous: bool
    stribeck: bool

    def names(self) -> list[str]:
        """In the order of the search."""
        names = ["stiffness", "damping", "forward", "backward", "start"]
        return names + ["viscous"] * self.viscous + ["drop_forward", "drop_backward", "fall"] * self.stribeck


def friction_of(q: np.ndarray, shape: Shape, fast: float) -> TwoSidedLuGre:
    """The friction of the values searched for."""
    v = dict(zip(shape.names(), q.tolist(), strict=True))
    fall, viscous = v.get("fall", FAR_SPEED * fast), v.get("viscous", 0.0)
    return TwoSidedLuGre(
        v["stiffness"], v["damping"],
        one_sided(v["forward"], v.get("drop_forward", 0.0), fall, viscous),
        one_sided(v["backward"], v.get("drop_backward", 0.0), fall, viscous),
    )  # fmt: skip


def fit_lugre(task: Task, amplitude: float) -> ModelFit:
    """LuGre of the training part."""
    shape = Shape(task.ratio >= VISCOUS_RATIO, False)
    found = _search(task, shape, _start(task, shape))
    notes: list[str] = []
    if task.ratio >= STRIBECK_RATIO:
        fuller, with_fall = _with_stribeck(task, shape, found)
        if fuller is not None:
            shape, found = with_fall, fuller
        else:
            notes.append("a Stribeck fall does not lower the error on validation strokes")
    if not found.converged:
        notes.append("the search ended before it had converged")
    fast = task.speeds[1]
    f = friction_of(found.values, shape, fast)
    force = lugre_force(f, task.record, float(found.values[4]))
    given = _parameters(task, shape, found, f)
    return judged(task, LUGRE, f, task.weight * force, given, amplitude=amplitude, condition=found.spread.condition,
                  notes=tuple(notes))  # fmt: skip


def _part(task: Task, last: int) -> Task:
    return task._replace(last=last)


def _search(task: Task, shape: Shape, start: np.ndarray) -> Found:
    names, fast = shape.names(), task.speeds[1]
    record, n = _first(task)
    strokes = task.record.strokes[:n]
    weight, target = task.weight[:n], task.record.force[:n]
    low, high = np.zeros(len(names)), np.full(len(names), np.inf)
    level = max(start[2], start[3])
    low[2:4], low[4], high[4] = 1e-3 * level, -2.0 * level, 2.0 * level
    if shape.stribeck:
        low[-1], high[-1] = 1e-3 * fast, 3.0 * fast
    usual = {
        "stiffness": start[0], "damping": 0.1 * level / fast, "viscous": 0.1 * level / fast, "fall": 0.2 * fast,
        "drop_forward": 0.2 * level, "drop_backward": 0.2 * level,
    }  # fmt: skip
    size = np.array([usual.get(name, level) for name in names])

    def model(q: np.ndarray) -> np.ndarray:
        return weight * lugre_force(friction_of(q, shape, fast), record, float(q[4]))

    return search(model, target, strokes, start, low, high, size)


def _first(task: Task) -> tuple[_Cut, int]:
    r, n = task.record, task.last
    return _Cut(r.travel[:n], r.speed[:n], r.way[:n]), n


class _Cut(NamedTuple):
    """What :func:`lugre_force` needs of a part of a record."""

    travel: np.ndarray
    speed: np.ndarray
    way: np.ndarray


def _start(task: Task, shape: Shape) -> np.ndarray:
    record, n = _first(task)
    target, weight = task.record.force[:n], task.weight[:n]
    sides = []
    for way in (1.0, -1.0):
        rows = (record.way == way) & (record.travel != 0.0) & (weight > 0.1 * weight.max())
        ratio = way * target[rows] / weight[rows] if rows.any() else np.array([0.0])
        sides.append(max(float(np.quantile(ratio, 0.75)), 1e-9 + 1e-3 * float(np.abs(target / weight.max()).max())))
    reach, fast = float(np.ptp(task.record.position)), task.speeds[1]
    best, least = np.zeros(0), np.inf
    for share in SHARES:
        values = [max(sides) / (share * reach), 0.02 * max(sides) / fast, *sides, 0.0]
        q = np.array(values + [0.02 * max(sides) / fast] * shape.viscous)
        force = weight * lugre_force(friction_of(q, shape, fast), record)
        cost = float(np.sum((force - target) ** 2))
        if cost < least:
            best, least = q, cost
    return best


def _with_stribeck(task: Task, plain: Shape, found: Found) -> tuple[Found | None, Shape]:
    shape = Shape(plain.viscous, True)
    strokes = task.record.strokes[: task.last]
    inner = int(np.searchsorted(strokes, strokes[-1] * 2 // 3 + 1))
    if inner < 20 or task.last - inner < 20:
        inner = task.last * 2 // 3
    part = _part(task, inner)
    simple = _search(part, plain, found.values)
    tried = [_search(part, shape, _with_fall(found.values, shape, share, task.speeds[1])) for share in FALLS]
    best = min(tried, key=lambda x: x.rms)
    if _validation_error(task, inner, best, shape) > KEEP * _validation_error(task, inner, simple, plain):
        return None, plain
    return _search(task, shape, best.values), shape


def _with_fall(values: np.ndarray, shape: Shape, share: float, fast: float) -> np.ndarray:
    """A start that has a fall, and damping and viscous friction again where the plain search had none."""
    level = float(values[2:4].mean())
    least = 0.02 * level / fast
    start = np.concatenate([values, [0.2 * level, 0.2 * level, share * fast]])
    for name in ("damping", *(["viscous"] if shape.viscous else [])):
        at = shape.names().index(name)
        start[at] = max(start[at], least)
    return start


def _validation_error(task: Task, inner: int, found: Found, shape: Shape) -> float:
    record, n = _first(task)
    force = lugre_force(friction_of(found.values, shape, task.speeds[1]), record, float(found.values[4]))
    left = (task.weight[:n] * force - task.record.force[:n])[inner:]
    return float(np.sqrt(np.mean(left**2)))


def _parameters(task: Task, shape: Shape, found: Found, f: TwoSidedLuGre) -> dict:
    names = shape.names()

    def sum_of(*of: str) -> np.ndarray:
        return np.array([1.0 if name in of else 0.0 for name in names])

    keys = {
        "friction.stiffness": ("stiffness", sum_of("stiffness")),
        "friction.damping": ("damping", sum_of("damping")),
    }
    fixed: dict[str, tuple[float, str, str]] = {}
    slow, fast = task.speeds
    same = f"sliding speeds differ by a factor of {task.ratio:.2g} only ({slow:.3g} to {fast:.3g} {task.record.unit}/s)"
    for side in ("forward", "backward"):
        keys[f"friction.{side}.coulomb"] = ("force", sum_of(side))
        if shape.viscous:
            keys[f"friction.{side}.viscous"] = ("damping", sum_of("viscous"))
        else:
            fixed[f"friction.{side}.viscous"] = (0.0, "damping", same)
        way = getattr(f, side)
        if shape.stribeck:
            keys[f"friction.{side}.static"] = ("force", sum_of(side, f"drop_{side}"))
            keys[f"friction.{side}.stribeck_speed"] = ("speed", sum_of("fall"))
        else:
            why = "no fall was found" if task.ratio >= STRIBECK_RATIO else same
            fixed |= without_rise(way, side, why)
    return parameters(keys, found, task, fixed)


Progress = Callable[[str, float], None]
LOADS = ("auto", "force", "coefficient")
USUAL = (0.001, 3.0)
"""Coefficients of friction; outside of them a unit is likely to be wrong."""
SAMPLES_BEFORE_SLIDING = 3
"""Samples in the travel before sliding below which stiffness is told by hardly anything."""
NORMAL_CHANGES = 0.1
"""Change of the normal force while sliding, as a share of it, below which the log cannot say how friction scales."""


@one_thread()
def identify_friction_force(
    record: ForceRecord, *, holdout: float = 0.5, load: Literal["auto", "force", "coefficient"] = "auto",
    progress: Progress | None = None,
) -> FrictionForceFit:  # fmt: skip
    """Coulomb and viscous friction, Stribeck map, Dahl, LuGre and Maxwell slip of a measured friction force.

    Every model is fitted to the first samples and simulated over all of them, driven by the measured motion alone, so
    that no force of the hold-out is ever seen.

    Args:
        record: the log.
        holdout: share of the samples at the end that is not fitted, 0 to 0.8; 0 judges on the fitted samples.
        load: ``coefficient`` takes friction as a coefficient times the measured normal force, ``force`` does not;
            ``auto`` is the first where the normal force was logged, before anything is fitted. Both are reported.
        progress: gets what happens and the fraction done.

    Raises:
        ValueRefused: a hold-out or a load that is none, or a coefficient without a normal force.
        DataError: too little of the motion lies in the training part.
    """
    if not 0.0 <= holdout <= 0.8:
        raise ValueRefused(f"holdout = {holdout!r}: allowed range is [0, 0.8]")
    if load not in LOADS:
        raise ValueRefused(f"load = {load!r}: allowed are {', '.join(LOADS)}")
    if load == "coefficient" and record.normal is None:
        raise ValueRefused("load = 'coefficient': the record has no normal force; name its column, or fit the force")
    last = len(record.time) - int(holdout * len(record.time))
    _check_training(record, last)
    wanted: Load = "coefficient" if load == "coefficient" or (load == "auto" and record.normal is not None) else "force"
    judged_force = record.force[last:] if last < len(record.time) else record.force
    amplitude = 0.5 * float(np.ptp(judged_force))
    if amplitude == 0.0:
        raise DataError(
            f"{record.source}: the force does not change in the part that is judged; choose another hold-out"
        )
    report = progress or (lambda what, done: None)
    task = task_of(record, wanted, last)
    models, rows, bins = _all(task, amplitude, lambda what, done: report(what, 0.8 * done))
    others: dict[str, ModelFit] = {}
    if record.normal is not None:
        other = task_of(record, "force" if wanted == "coefficient" else "coefficient", last)
        report(f"LuGre, {other.load}", 0.8)
        others = {m.name: m for m in (fit_coulomb(other, amplitude), fit_lugre(other, amplitude))}
    normal = 1.0 if record.normal is None else float(record.normal[rows if len(rows) else slice(last)].mean())
    fit = FrictionForceFit(record, wanted, models, others, bins, last, amplitude, normal, task.speeds)
    fit.notes.extend([f.sentence for f in record.findings] + _notes(fit, task, rows))
    fit.advice.extend(_advice(fit, task))
    return fit


def _all(task: Task, amplitude: float, report: Progress) -> tuple[dict[str, ModelFit], np.ndarray, list[Bin]]:
    found = [fit_coulomb(task, amplitude)]
    report("Maxwell slip", 0.0)
    slip, share = fit_slip(task, amplitude)
    rows = sliding_rows(task, share)
    if all((task.record.way[rows] == way).sum() >= 10 for way in (1.0, -1.0)):
        report("Stribeck map", 0.1)
        found.append(fit_map(task, rows, amplitude))
    report("LuGre", 0.2)
    lugre = fit_lugre(task, amplitude)
    report("Dahl", 0.7)
    found += [fit_dahl(task, lugre, amplitude), lugre, slip]
    return {m.name: m for m in found}, rows, bins_of(task, rows)


def _check_training(record: ForceRecord, last: int) -> None:
    if last < LEAST:
        raise DataError(f"{record.source}: {last} samples to fit; expected at least {LEAST}: choose a smaller hold-out")
    travel = record.travel[:last]
    if not (travel > 0.0).any() or not (travel < 0.0).any():
        raise DataError(
            f"{record.source}: the first {last} samples, which are fitted, move one way only; choose a smaller "
            "hold-out or another start"
        )


def _notes(fit: FrictionForceFit, task: Task, rows: np.ndarray) -> list[str]:
    notes = [f"{m.name}: {note}" for m in fit.models.values() for note in m.notes]
    r, f = task.record, fit.chosen.friction
    assert isinstance(f, TwoSidedLuGre)
    length = max(f.forward.coulomb, f.backward.coulomb) / f.stiffness
    moved = np.abs(r.travel[: task.last])
    usual = float(np.median(moved[moved > 0.0]))
    if 3.0 * length < SAMPLES_BEFORE_SLIDING * usual:
        notes.append(
            f"sliding begins after {3.0 * length:.2g} {r.unit}, and samples are {usual:.2g} {r.unit} apart: stiffness "
            "and damping of the bristles rest on little"
        )
    level = 0.5 * (f.forward.coulomb + f.backward.coulomb)
    if task.load == "coefficient" and not USUAL[0] < level < USUAL[1]:
        notes.append(
            f"a coefficient of friction of {level:.3g} lies outside {USUAL[0]:g} to {USUAL[1]:g}: look at the units of "
            "force and normal force"
        )
    if r.normal is not None and len(rows):
        change = float(np.ptp(r.normal[rows])) / abs(fit.normal_mean)
        if change < NORMAL_CHANGES:
            notes.append(
                f"the normal force changes by {100.0 * change:.2g} % while sliding in the fitted part: that friction "
                "scales with it is assumed, not shown by what was fitted"
            )
    return notes


def _advice(fit: FrictionForceFit, task: Task) -> list[str]:
    said, unit = [], task.record.unit
    slow, fast = fit.speeds
    if task.ratio < VISCOUS_RATIO:
        said.append(f"strokes at other speeds (here {slow:.3g} to {fast:.3g} {unit}/s) tell viscous friction")
    if task.ratio < STRIBECK_RATIO:
        said.append("slow strokes, down to a hundredth of the fastest, tell static friction and Stribeck speed")
    damping = fit.chosen.parameters["friction.damping"]
    if not damping.identifiable:
        said.append("quick reversals inside the travel before sliding tell the damping of the bristles")
    return said
