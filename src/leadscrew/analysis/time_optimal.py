"""How fast a position step can be at all, on any linear axis under a sampled drive: a linear programme.

Where ``dz/dt = A z + B u`` with ``u`` held over a period, the state after every period is linear in the duties ``u_0,
u_1, ...``. Whether *any* sequence within ``|u| <= 1`` brings the position within ``+-band`` of ``D`` at period ``N``
and keeps it there is a linear programme, with limits of states (speed, current) as further bounds. "Keeps it
there" is: inside at every sample from ``N`` on, and at rest after ``hold`` further periods, so that no duty at all
keeps it inside for good. The least ``N`` is a bound for every controller, whatever it measures and computes, that holds
its duty over the same periods; noise, lag and rounding of sensors can only cost time.

A sequence that takes ``N`` periods also takes ``N + 1``, by waiting first, so that the search may stop at the first
``N`` that fails.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew.kernel import cache
from leadscrew.plants._linear import hold_matrices
from leadscrew.util.errors import DataError, ValueRefused

SOLVERS = (("highs-ds", True), ("highs-ipm", False), ("highs-ds", False))
"""Ways of HiGHS, the next where one gives up: an error of 0 is reached in many ways, which is hard on it."""


class StateLimit(NamedTuple):
    """One state of the plant, ``z[state]``, that has to stay within ``+-largest`` at every sample."""

    state: int
    largest: float


class FastestMove(NamedTuple):
    """The fewest periods of a step, and one sequence of duties that takes no more."""

    periods: int
    time_s: float
    duty: np.ndarray
    """One value a period, up to rest."""
    largest_error: float
    """The least that the largest error from ``periods`` on can be; at most the band."""
    one_less: float
    """The same one period earlier: beyond the band, which is what makes ``periods`` the fewest."""


def fastest_move(
    a: np.ndarray,
    b: np.ndarray,
    position: Sequence[float],
    distance: float,
    band: float,
    period: float = 1e-3,
    limits: Sequence[StateLimit] = (),
    near_s: float | None = None,
    hold: int = 40,
) -> FastestMove:
    """Fewest periods within which an axis at rest can be within ``band`` of ``distance``, and stay.

    Args:
        a: the axis, ``dz/dt = a z + b u``, with ``-1 <= u <= 1`` held over each period; order by order.
        b: its input column.
        position: row that gives the position, in the unit of ``distance`` and ``band``.
        distance: where to go from 0; its sign is that of a move under positive ``u``.
        band: largest error allowed from there on, positive.
        period: seconds.
        limits: states that have to stay within bounds at every sample.
        near_s: where to begin the search, for speed alone; see :func:`single_lag_time`.
        hold: periods after which the axis has to rest.

    Raises:
        ValueRefused: a distance, band or period that is not positive, or no solution within 10,000 periods.
    """
    for name, value in (("distance", distance), ("band", band), ("period", period)):
        if not value > 0.0:
            raise ValueRefused(f"{name} = {value!r} (fastest_move): must be positive")
    found: dict[int, tuple[float, np.ndarray]] = {}

    def error(periods: int) -> float:
        if periods not in found:
            found[periods] = least_error(a, b, position, distance, periods, period, limits, hold)
        return found[periods][0]

    fits = band * (1.0 + 1e-9)
    last = max(1, int(near_s / period if near_s else _full_duty_periods(a, b, position, distance, period)))
    first, step = 0, 1
    while error(last) > fits:
        first, last, step = last, last + step, 2 * step
        if last > 10_000:
            raise ValueRefused(f"distance = {distance!r} (fastest_move): not reached within 10,000 periods")
    step = 1
    while first < last - step and not first and error(last - step) <= fits:
        last, step = last - step, 2 * step
    first = max([first, *(k for k, (size, _) in found.items() if size > fits)])
    while last - first > 1:
        middle = (first + last) // 2
        first, last = (first, middle) if error(middle) <= fits else (middle, last)
    least, duty = found[last]
    return FastestMove(last, last * period, duty, least, error(last - 1) if last > 1 else math.inf)


def _full_duty_periods(a: np.ndarray, b: np.ndarray, position: Sequence[float], distance: float, period: float) -> int:
    """The periods that full duty needs to be there, at speed."""
    transition, drive = hold_matrices(a, b, period)
    z, row = np.zeros(len(drive)), np.asarray(position, dtype=float)
    for k in range(1, 10_000):
        z = transition @ z + drive
        if row @ z >= distance:
            return k
    return 10_000


def least_error(
    a: np.ndarray, b: np.ndarray, position: Sequence[float], distance: float, periods: int, period: float = 1e-3,
    limits: Sequence[StateLimit] = (), hold: int = 40,
) -> tuple[float, np.ndarray]:  # fmt: skip
    """The least possible largest error from ``periods`` on, and the duties of it; infinite where there is none.

    Arguments as for :func:`fastest_move`. Unknowns of the programme: the duties, the states after every period, the
    error. Its matrices are sparse: one block row a period. What was found is kept in the cache beside the compiled
    loops, by a hash of this file and of all arguments.

    Raises:
        DataError: the solver finds neither an answer nor that there is none.
    """
    asked = (np.asarray(a, dtype=float).tobytes(), np.asarray(b, dtype=float).tobytes(), tuple(map(float, position)),
             float(distance), periods, float(period), tuple(map(tuple, limits)), hold)  # fmt: skip
    mark = hashlib.sha256(Path(__file__).read_bytes() + repr(asked).encode()).hexdigest()
    kept = cache.read(f"programme_{mark[:24]}.npy")
    if kept is None:
        least, duty = _solve(a, b, position, distance, periods, period, limits, hold)
        kept = np.array([least, *duty]).tobytes()
        cache.write(f"programme_{mark[:24]}.npy", kept)
    found = np.frombuffer(kept)
    return float(found[0]), found[1:]


def _solve(
    a: np.ndarray, b: np.ndarray, position: Sequence[float], distance: float, periods: int, period: float,
    limits: Sequence[StateLimit], hold: int,
) -> tuple[float, np.ndarray]:  # fmt: skip
    from scipy import sparse
    from scipy.optimize import linprog

    transition, drive = hold_matrices(np.asarray(a, dtype=float), np.asarray(b, dtype=float), period)
    n, order = periods + hold, len(drive)
    unknowns = n + order * n + 1
    before = sparse.eye(n, k=-1)
    motion = sparse.hstack([
        -sparse.kron(sparse.identity(n), drive[:, None]),
        sparse.identity(order * n) - sparse.kron(before, transition),
        sparse.csr_matrix((order * n, 1)),
    ])  # fmt: skip
    after = np.arange(periods - 1, n)

    pick = sparse.csr_matrix((np.ones(len(after)), (np.arange(len(after)), after)), shape=(len(after), n))
    x = sparse.hstack([
        sparse.csr_matrix((len(after), n)), sparse.kron(pick, np.asarray(position, dtype=float)[None, :]),
        sparse.csr_matrix((len(after), 1)),
    ]).tocsr()  # fmt: skip
    size = sparse.csr_matrix((np.ones(len(after)), (np.arange(len(after)), np.full(len(after), unknowns - 1))), x.shape)
    above, below = np.full(len(after), distance), np.full(len(after), -distance)
    _, sizes, directions = np.linalg.svd(transition - np.identity(order))
    moving = directions[sizes > 1e-12 * sizes[0]]  # at rest all of these are zero
    still = sparse.hstack([
        sparse.csr_matrix((len(moving), unknowns - 1 - order)), sparse.csr_matrix(moving),
        sparse.csr_matrix((len(moving), 1)),
    ])  # fmt: skip
    low = np.full(unknowns, -np.inf)
    high = np.full(unknowns, np.inf)
    low[:n], high[:n], low[-1] = -1.0, 1.0, 0.0
    for limit in limits:
        low[n + limit.state : -1 : order], high[n + limit.state : -1 : order] = -limit.largest, limit.largest
    cost = np.zeros(unknowns)
    cost[-1] = 1.0
    inside, equal = sparse.vstack([x - size, -x - size]).tocsr(), sparse.vstack([motion, still]).tocsr()
    for method, presolve in SOLVERS:
        found = linprog(
            cost, inside, np.concatenate([above, below]), equal, np.zeros(equal.shape[0]),
            np.column_stack([low, high]), method=method, options={"presolve": presolve},
        )  # fmt: skip
        if found.status == 0:
            return float(found.fun), found.x[:n]
        if found.status == 2:
            return math.inf, np.zeros(n)
    raise DataError(f"the linear programme of {periods} periods has no answer: {found.message}")
