"""LuGre from a measured friction force: stiffness, damping, friction of each direction, Stribeck fall if there is one.

The start of the search is Coulomb friction of each direction and the best of several stiffnesses. Viscous friction
needs sliding speeds that differ, a Stribeck fall needs them to differ more; where they do not, the value is fixed and
said to be. A Stribeck fall is kept only where it lowers the error of strokes that the fit has not seen: the last third
of the training part judges it, and then all of the training part fits it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.identify.friction_force.models import lugre_force, one_sided
from leadscrew.identify.friction_force.result import LUGRE, ModelFit
from leadscrew.identify.friction_force.search import Found, search
from leadscrew.identify.friction_force.task import STRIBECK_RATIO, VISCOUS_RATIO, Task, judged, parameters, without_rise

SHARES = (1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Of the range of the position: relaxation lengths to start from."""
FALLS = (0.05, 0.2, 0.5)
"""Of the fastest sliding: Stribeck speeds to start from."""
KEEP = 0.98
"""A Stribeck fall must lower the error of unseen strokes to this share."""
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
            notes.append("a Stribeck fall does not lower the error of strokes that the fit has not seen")
    if not found.converged:
        notes.append("the search ended before it had converged")
    fast = task.speeds[1]
    f = friction_of(found.values, shape, fast)
    force = lugre_force(f, task.record, float(found.values[4]))
    given = _parameters(task, shape, found, f)
    return judged(task, LUGRE, f, task.weight * force, given, amplitude=amplitude, condition=found.condition,
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
    if _unseen(task, inner, best, shape) > KEEP * _unseen(task, inner, simple, plain):
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


def _unseen(task: Task, inner: int, found: Found, shape: Shape) -> float:
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
