"""Frequency responses at the door: of any linear controller, and of a second-order plant with dead time, both sampled.

Controllers that are tuned by the loop around them (resonators, repetitive control) ask for them in ``prepare``. A
controller's response is found by trying the very step that runs and is exported, on states and errors of 1 nm, one by
one from rest: exact where it is linear, its linearisation at rest where it is not.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.kernel.layout import Layout, copied
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.plants._xy_table_cutting import XYTableCuttingParams, hold
from leadscrew.references._motion import Motion
from leadscrew.util.errors import ValueRefused

MOST_STATES = 200
"""Numbers in a state beyond which trying them one by one takes too long."""
SMALL = 1e-6
"""Size of what is tried."""


class PlantModel(NamedTuple):
    """What a controller believes of its plant: ``gain / (s^2 + damping s + stiffness)``, and a dead time."""

    gain: Annotated[float, Unit("mm/(V s^2)"), Gt(0), Doc("acceleration at 1 V from rest")]
    damping: Annotated[float, Unit("1/s"), Ge(0), Doc("coefficient of s")] = 0.0
    stiffness: Annotated[float, Unit("1/s^2"), Ge(0), Doc("constant coefficient")] = 0.0
    dead_time_s: Annotated[float, Unit("s"), Ge(0), Doc("from the sample to the voltage")] = 0.0


def plant_response(model: PlantModel, dt: float, w: Any) -> np.ndarray:
    """Position over voltage of the plant at the angular frequencies ``w`` (rad/s), sampled every ``dt``, mm/V."""
    rows = _held(model, dt)
    z = np.exp(1j * np.asarray(w, dtype=float) * dt)
    (a, c), (b, d) = rows[0], rows[1]
    position = sum(row[0] * z**-i for i, row in enumerate(rows[2:]))
    velocity = sum(row[1] * z**-i for i, row in enumerate(rows[2:]))
    return np.asarray(((z - d) * position + b * velocity) / ((z - a) * (z - d) - b * c))


@lru_cache(maxsize=256)
def _held(model: PlantModel, dt: float) -> tuple[tuple[float, float], ...]:
    plan = hold(XYTableCuttingParams(*model), dt)
    drive = (plan.now, plan.sent, plan.sent2, plan.sent3, plan.sent4, plan.sent5)
    return tuple((row.position, row.velocity) for row in (plan.from_position, plan.from_velocity, *drive))


def law_matrices(law: Any, params: Any, state: Any, motion: bool, dt: float) -> tuple[np.ndarray, ...]:
    """``x+ = A x + B e``, ``u = C x + D e`` of a controller's step, with ``e = command - feedback``.

    ``law``, ``params``: the step and what it gets as ``p``; ``motion``: whether its command is a motion.

    Raises:
        ValueRefused: a state of more than 200 numbers.
    """
    layout = Layout(state)
    scalars, n = len(layout.scalars), len(layout.scalars) + layout.array_size
    if n > MOST_STATES:
        raise ValueRefused(f"a controller with {n} numbers in its state: its response is found for up to {MOST_STATES}")
    rest_scalars, rest_arrays = layout.pack(state)
    rest = np.concatenate([rest_scalars[:scalars], rest_arrays[: layout.array_size]])
    at_rest = Motion() if motion else 0.0

    def tried(x: np.ndarray, error: float) -> np.ndarray:
        start = layout.unpack(np.append(x[:scalars], 0.0), np.append(x[scalars:], 0.0))
        after, u = law(params, copied(start), at_rest, -error, dt)
        found_scalars, found_arrays = layout.pack(after)
        return np.concatenate([found_scalars[:scalars], found_arrays[: layout.array_size], [u]])

    still = tried(rest, 0.0)
    columns = [tried(rest + SMALL * unit, 0.0) - still for unit in np.eye(n)]
    joined = np.array([*columns, tried(rest, SMALL) - still]).T / SMALL
    return joined[:n, :n], joined[:n, n], joined[n, :n], joined[n, n]


def law_response(law: Any, params: Any, state: Any, motion: bool, dt: float, w: Any) -> np.ndarray:
    """Output over error of a controller's step at the angular frequencies ``w`` (rad/s), in V/mm."""
    a, b, c, d = law_matrices(law, params, state, motion, dt)
    z = np.exp(1j * np.atleast_1d(np.asarray(w, dtype=float)) * dt)
    eye = np.eye(len(a))
    return np.array([c @ np.linalg.solve(x * eye - a, b) + d for x in z])
