"""Models of friction that know the travel only: Dahl, and Maxwell slip, which has a memory of every reversal.

Maxwell slip is found without a search: with elements that yield after fixed travels its force is linear in their
shares, and non-negative least squares (C. Lawson, R. Hanson, *Solving least squares problems*, 1974) gives the best of
all shares at once. Elements that get none drop out. It also says best what slides: where elements with 98 % of the
force slip.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from leadscrew.friction.asymmetric import TwoSidedLuGre
from leadscrew.friction.dahl import Dahl
from leadscrew.friction.maxwell_slip import MaxwellSlip
from leadscrew.identify.axis.result import Parameter
from leadscrew.identify.friction_force.models import dahl_force, stops
from leadscrew.identify.friction_force.result import DAHL, SLIP, ModelFit
from leadscrew.identify.friction_force.search import Found, clusters_of, robust, search
from leadscrew.identify.friction_force.task import VISCOUS_RATIO, Task, judged, parameters
from leadscrew.kernel.errors import DataError

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
                  offset=float(found.values[3]), condition=found.condition)  # fmt: skip


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
    covariance, condition, quantile = robust(
        matrix[:n][:, kept], simulated[:n] - record.force[:n], clusters_of(record.strokes[:n]), np.ones(len(kept), bool)
    )
    found = Found(weights[kept], covariance, condition, 0.0, quantile, True)
    unit = {int(k): row for k, row in zip(kept, np.eye(len(kept)), strict=True)}
    keys = {"friction.coulomb": ("force", np.sum([unit[int(k)] for k in used], axis=0))}
    keys |= {f"friction.share[{i}]": ("force", unit[int(k)]) for i, k in enumerate(used)}
    given = parameters(keys, found, task, {})
    for i, k in enumerate(used):
        given[f"friction.share[{i}]"] = _share(given[f"friction.share[{i}]"], level, float(yields[k]), record.unit)
    bent = matrix[:, :m] @ weights[:m] / (level * np.where(task.weight != 0.0, task.weight, 1.0))
    return judged(task, SLIP, slip, simulated, given, amplitude=amplitude, offset=offset, condition=condition), bent


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
    note = f"yields after {yields:.3g} {unit}" + ("" if p.told else "; its interval is too wide to be of use")
    return Parameter(p.value / level, "1", p.low / level, p.high / level, p.how, p.told, note)
