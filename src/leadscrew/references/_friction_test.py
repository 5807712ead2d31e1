"""The move for an identification of friction: one raised cosine after another, from rest and back to rest.

    command(t) = a (1 - cos(2 pi f (t - t_i)))     for n periods, then the next row (a, f, n)

Every row starts and ends at the same place with no speed, so the rows follow one another without a jump of position or
speed (the acceleration jumps by ``a (2 pi f)^2``). What each kind of row is for, with :data:`ROWS` on the stage of
Shams and Safdari (2010):

1. *wide and fast* rows slide in both directions at very different speeds: Coulomb and viscous friction, inertia;
2. *short and slow* rows under a controller without integral action: its torque ``kp (y_r - y)`` rises slowly while the
   bristles hold, up to a slip and back. The bend of torque against position before the slip is static friction, where
   it lets go at which rate is the Stribeck speed, the slope through zero torque is the stiffness of the bristles;
3. a *short and quick* row shakes the bristles without a slip: position lags the torque by damping over stiffness.

For rows of the second kind choose ``a`` so that ``2 a kp`` is about 2.7 times Coulomb friction (from sliding one way to
a third above it the other way), for the third kind about once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.block import Block, reference
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.references._motion import Motion, row_at
from leadscrew.util.errors import ValueRefused, entry_point

ROWS: tuple[tuple[float, float, float], ...] = (
    (2.5, 0.5, 1.0),
    (0.5, 4.0, 4.0),
    (0.05, 0.25, 1.0),
    (0.01, 10.0, 5.0),
)
"""Amplitude in mm, frequency in Hz, periods: 7.5 s for the stage with 1.5923 mm/rad under ``kp = 300 N m/rad``."""


class FrictionTestParams(NamedTuple):
    """One element a row, in the unit of the loop's command."""

    amplitude: Annotated[NDArray[np.float64], Doc("half of the travel of each row, either sign")]
    frequency: Annotated[NDArray[np.float64], Unit("Hz"), Gt(0), Doc("cycles per second of each row")]
    periods: Annotated[NDArray[np.float64], Gt(0), Doc("cycles of each row; whole numbers end at rest")]


class FrictionTestPlan(NamedTuple):
    """One row each: start time, amplitude, rate in rad/s, duration."""

    table: NDArray[np.float64]
    last: int


def plan_rows(params: FrictionTestParams, dt: float) -> FrictionTestPlan:
    """When each row starts, and how long it lasts."""
    lasts = params.periods / params.frequency
    starts = np.cumsum(lasts) - lasts
    table = np.column_stack([starts, params.amplitude, 2.0 * math.pi * params.frequency, lasts])
    return FrictionTestPlan(table, len(table) - 1)


def friction_test_step(p, t):
    """The row that ``t`` lies in, as a :class:`Motion`; at rest after the last."""
    row = row_at(p.table, p.last, t)
    since = min(t - p.table[row, 0], p.table[row, 3])
    moving = 1.0 if t - p.table[row, 0] < p.table[row, 3] else 0.0
    a = p.table[row, 1]
    w = p.table[row, 2]
    return Motion(
        a * (1.0 - math.cos(w * since)),
        moving * a * w * math.sin(w * since),
        moving * a * w * w * math.cos(w * since),
    )


@entry_point
def friction_test(rows: Sequence[Sequence[float]] = ROWS) -> Block:
    """A reference for an identification of friction; ``rows`` of amplitude, frequency in Hz, whole number of periods.

    Raises:
        ValueRefused: no rows, a row that is not three numbers, part of a period, or a value out of range.
    """
    try:
        table = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.ndim != 2 or table.shape[1] != 3 or not len(table):
        raise ValueRefused(f"rows = {rows!r} (friction_test): expected rows of amplitude, frequency, periods")
    for periods in table[:, 2]:
        if periods != math.floor(periods):
            raise ValueRefused(f"periods = {periods:g} (friction_test): a row that ends at rest has whole periods")
    amplitude, frequency, periods = (column.copy() for column in table.T)
    empty = FrictionTestParams(np.zeros(len(table)), np.ones(len(table)), np.ones(len(table)))
    block = reference(empty, prepare=plan_rows, name="friction_test")(friction_test_step)
    return block.using(amplitude=amplitude, frequency=frequency, periods=periods)


def friction_test_duration(rows: Sequence[Sequence[float]] = ROWS) -> float:
    """How long the rows last, in seconds."""
    return float(sum(periods / frequency for _, frequency, periods in rows))
