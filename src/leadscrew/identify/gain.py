"""The gain of an integrating plant from logs of its input and its position, by output-error least squares.

The input drives a chain of lags with unit dc gain and then an integrator, all known; the one unknown is the gain:

    position(t) = K * travel(t),    travel = 1 / (s (T_1 s + 1) (T_2 s + 1) ...) applied to the input

so the least-squares gain is the projection of the measured position on ``travel``. What the input did between the
samples is not in a log, and it matters when the samples are coarse: :data:`Hold` says what is assumed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.kernel.one_thread import one_thread
from leadscrew.plants._linear import hold_matrices

Hold = Literal["linear", "previous", "current"]
"""Between two samples the input runs in a straight line, keeps the earlier value, or has the later one already."""

HOLDS: tuple[Hold, ...] = ("linear", "previous", "current")


class Record(NamedTuple):
    """One logged move: time from its start, input, and position relative to its start."""

    time_s: np.ndarray
    input: np.ndarray
    position: np.ndarray


@dataclass(frozen=True)
class GainFit:
    """A gain for all records together, and how well it fits each."""

    gain: float
    """Position units per second and unit of input."""
    nrmse_percent: Mapping[str, float]
    """Root mean square error over the range of the measured position, by record, with the common gain."""
    gain_alone: Mapping[str, float]
    """The gain that each record would ask for by itself."""
    hold: Hold

    @property
    def spread_percent(self) -> float:
        """How far apart the records' own gains lie, in percent of the common one: large means not linear."""
        own = list(self.gain_alone.values())
        return 100.0 * (max(own) - min(own)) / abs(self.gain)


def unit_travel(record: Record, lags_s: Sequence[float], hold: Hold = "linear") -> np.ndarray:
    """Position that a plant of unit gain would reach under the record's input; exact for what ``hold`` assumes."""
    order = len(lags_s) + 2  # position, what each lag gives, input: each drives the one before
    chain, ramp = np.diag(np.ones(order - 1), 1), np.zeros(order)
    ramp[-1] = 1.0
    for i, lag in enumerate(lags_s, start=1):
        chain[i, i : i + 2] = -1.0 / lag, 1.0 / lag
    dt = float(record.time_s[1] - record.time_s[0])
    step, ramped = hold_matrices(chain, ramp, dt)
    u = record.input[1:] if hold == "current" else record.input[:-1]
    slopes = np.diff(record.input) / dt if hold == "linear" else np.zeros(len(u))
    state, travel = np.zeros(order), np.zeros(len(u) + 1)
    for k, (now, slope) in enumerate(zip(u, slopes, strict=True), start=1):
        state[-1] = now
        state = step @ state + ramped * slope
        travel[k] = state[0]
    return travel


@one_thread()
def fit_gain(records: Mapping[str, Record], lags_s: Sequence[float], hold: Hold = "linear") -> GainFit:
    """The gain that fits all records best in position.

    Raises:
        DataError: no records, a record of fewer than three samples or not evenly sampled, an input that never acts, or
            a position that never moves.
        ValueRefused: a lag that is not positive, or an unknown hold.
    """
    if hold not in HOLDS:
        raise ValueRefused(f"hold = {hold!r}: allowed are {', '.join(HOLDS)}")
    if any(not lag > 0.0 for lag in lags_s):
        raise ValueRefused(f"lags_s = {list(lags_s)}: every lag must be above 0 s")
    if not records:
        raise DataError("no records to fit a gain to")
    travel = {}
    for name, record in records.items():
        _check(name, record)
        travel[name] = unit_travel(record, lags_s, hold)
        if not np.any(travel[name]):
            raise DataError(f"record {name}: its input never acts, so it says nothing about the gain")
    own = {n: float(travel[n] @ r.position / (travel[n] @ travel[n])) for n, r in records.items()}
    gain = float(sum(travel[n] @ r.position for n, r in records.items()) / sum(travel[n] @ travel[n] for n in records))
    nrmse = {
        n: float(100.0 * np.sqrt(np.mean((gain * travel[n] - r.position) ** 2)) / np.ptp(r.position))
        for n, r in records.items()
    }
    return GainFit(gain, nrmse, own, hold)


def _check(name: str, record: Record) -> None:
    if len({len(part) for part in record}) != 1:
        lengths = ", ".join(str(len(part)) for part in record)
        raise DataError(f"record {name}: time, input and position have {lengths} samples")
    if len(record.time_s) < 3:
        raise DataError(f"record {name}: {len(record.time_s)} samples; a fit needs at least three")
    steps = np.diff(record.time_s)
    if not (steps > 0.0).all() or np.ptp(steps) > 1e-6 * steps.mean():
        raise DataError(f"record {name}: the samples are not evenly spaced in time")
    if np.ptp(record.position) == 0.0:
        raise DataError(f"record {name}: the position never moves")
