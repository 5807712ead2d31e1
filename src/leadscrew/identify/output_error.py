"""Parameters of a closed loop from logs of its moves, by output-error least squares.

For a controller (or a plant inside its loop) of which only moves are known: the whole loop is simulated from the start
of every logged move, and the parameters are those whose simulated signal comes nearest to the logged one,

    minimise over theta:    sum_r sum_k ((y_r(t_k; theta) - m_r(t_k)) / s_r)^2

with ``y_r`` the loop's signal in move ``r``, ``m_r`` the log, and ``s_r`` the range of ``m_r`` (every move counts the
same) or one common scale (every sample counts the same). The simulation gets no logged input, so an error of the model
shows up in full; a fit of the controller's output to its logged input would hide it. The price: parameters of
controller and plant that only act together cannot be told apart, which is why every fit measures what its data can
tell (Ljung, *System Identification*, 2nd ed., 1999, chapters 4, 7 and 13).

All simulations of an iteration are one ``Loop.batch``. Searches are deterministic.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from leadscrew.identify.estimation import white
from leadscrew.kernel import validate
from leadscrew.util.errors import DataError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

Search = Literal["local", "global"]
"""From a start downhill (trust-region least squares), or first all over the bounds (differential evolution)."""

LOST = 1e3
"""Residual, in ranges of the signal, that stands for a run that diverged."""
DEAF = 1e-9
"""A parameter whose whole range changes the signal by less than this share of its range does not act."""


class Trajectory(NamedTuple):
    """One logged move, from the loop's start."""

    time_s: np.ndarray
    """Rising, from 0 or later; values between two control periods are interpolated."""
    value: np.ndarray
    """The logged signal, in the loop's unit."""
    changes: Mapping[str, float] = {}
    """What the loop has differently in this move, by dotted key: ``{"reference.target": -50.0}``."""


@dataclass(frozen=True)
class OutputErrorFit:
    """The best parameters, how well they fit, and what the logs can tell of them."""

    parameters: dict[str, float]
    """By dotted key; ``loop.using(fit.parameters)`` is the fitted loop."""
    nrmse_percent: dict[str, float]
    """Root mean square difference over the range of the logged signal, by move."""
    simulated: dict[str, np.ndarray]
    """The fitted loop's signal at the times of each log."""
    standard_error: dict[str, float]
    """Of each parameter, if the differences were independent from sample to sample; a lower bound if they are not."""
    singular_values: np.ndarray
    """Of the Jacobian at the fit, largest first: change of all the residuals for a parameter's whole bounds."""
    weakest: dict[str, float]
    """The direction, in shares of the bounds, in which the logs tell least: a combination of parameters."""
    at_bound: tuple[str, ...]
    """Parameters that ended on a bound: the best value may lie beyond."""
    converged: bool
    message: str
    """What the optimiser said when it stopped."""
    runs: int
    """Simulated moves."""
    signal: str = "feedback"
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def condition(self) -> float:
        """Largest over smallest singular value: how much better the best known direction is known than the worst."""
        return float(self.singular_values[0] / self.singular_values[-1])

    @property
    def total_percent(self) -> float:
        """Root mean square of :attr:`nrmse_percent`: every move counts the same."""
        return float(np.sqrt(np.mean(np.square(list(self.nrmse_percent.values())))))


def fit_output_error(
    loop: Loop,
    records: Mapping[str, Trajectory],
    bounds: Mapping[str, tuple[float, float]],
    *,
    signal: str = "feedback",
    start: Mapping[str, float] | None = None,
    equal_moves: bool = True,
    search: Search = "local",
    seed: int = 0,
    step: float = 3e-3,
    max_condition: float = 500.0,
    population: int = 15,
    generations: int = 60,
) -> OutputErrorFit:
    """The parameters within ``bounds`` with which ``loop`` comes nearest to all records.

    Args:
        loop: the closed loop; its other parameters stay as they are.
        records: logged moves by name, in the unit of ``signal``.
        bounds: lowest and highest value of each fitted parameter, by dotted key. They are also its scale: a range of
            one or two orders of magnitude serves best.
        signal: a recorded signal of the loop, such as ``feedback`` or ``actual.position``.
        start: where a local search starts; the loop's own values, moved into the bounds, unless given.
        equal_moves: weigh every move the same (by the range of its log), or else every sample.
        search: ``local`` or ``global``; a global search ends with a local one.
        seed: of the global search; the same seed gives the same fit.
        step: difference for the Jacobian, as a share of the bounds; it must move the signal by many counts of the
            sensor, or rounding makes parameters look independent that are not.
        max_condition: condition number above which the parameters cannot be told apart.
        population: of the global search, points for each parameter.
        generations: of the global search, at most.

    Raises:
        DataError: no records, a record with unequal lengths, too few samples, times that do not rise or no movement;
            records that cannot tell the parameters apart.
        ValueRefused: no parameters, bounds that are none, a start outside or at which the loop diverges, an unknown
            search, or a parameter that does not act on the signal.
        NameUnknown: no such parameter or signal.
    """
    from scipy.optimize import differential_evolution, least_squares

    validate.one_of("search", search, ["local", "global"])
    lows, highs = _limits(loop, bounds)
    problem = _Problem(loop, records, tuple(bounds), lows, highs, signal, equal_moves)
    origin = problem.origin(start or {})
    problem.refuse_deaf(origin)
    if search == "global":
        found = differential_evolution(
            lambda x: np.sum(np.square(problem.residuals(x.T)), axis=1), [(0.0, 1.0)] * len(lows), rng=seed, x0=origin,
            popsize=population, maxiter=generations, tol=1e-6, polish=False, updating="deferred", vectorized=True,
        )  # fmt: skip
        origin = found.x
    if np.max(np.abs(problem.residuals(origin[None]))) >= LOST:
        where = ", ".join(f"{k} = {v:g}" for k, v in zip(bounds, lows + origin * (highs - lows), strict=True))
        raise ValueRefused(f"start: the loop diverges at {where}; give another start, or search = 'global'")
    best = least_squares(
        lambda x: problem.residuals(x[None])[0], origin, lambda x: problem.jacobian(x, step), bounds=(0.0, 1.0),
        xtol=1e-9, ftol=1e-12, gtol=1e-12, max_nfev=200,
    )  # fmt: skip
    jacobian = problem.jacobian(best.x, step)
    effects = np.linalg.norm(jacobian, axis=0)
    for key, share in zip(bounds, effects, strict=True):
        if share < DEAF:
            raise ValueRefused(f"{key} does not act on {signal} at the best fit: these records say nothing about it")
    _, sizes, directions = np.linalg.svd(jacobian, full_matrices=False)
    weakest = {key: float(part) for key, part in zip(bounds, directions[-1], strict=True)}
    if sizes[0] > max_condition * sizes[-1]:
        parts = " ".join(f"{part:+.2f} {key}" for key, part in weakest.items())
        raise DataError(
            f"the records cannot tell the parameters apart: condition number {sizes[0] / max(sizes[-1], DEAF):.2g}, "
            f"allowed {max_condition:.2g}; hardly anything changes along {parts} (in shares of their bounds)"
        )
    spread = np.sqrt(np.diag(white(jacobian, best.fun).covariance)) * (highs - lows)
    values = lows + best.x * (highs - lows)
    simulated = dict(zip(records, problem.simulate(best.x[None]), strict=True))
    return OutputErrorFit(
        parameters=dict(zip(bounds, values.tolist(), strict=True)),
        nrmse_percent={
            name: float(100.0 * np.sqrt(np.mean((simulated[name][0] - r.value) ** 2)) / np.ptp(r.value))
            for name, r in records.items()
        },
        simulated={name: rows[0] for name, rows in simulated.items()},
        standard_error=dict(zip(bounds, spread.tolist(), strict=True)),
        singular_values=sizes,
        weakest=weakest,
        at_bound=tuple(key for key, x in zip(bounds, best.x, strict=True) if min(x, 1.0 - x) < 1e-4),
        converged=bool(best.status > 0),
        message=str(best.message),
        runs=problem.runs,
        signal=signal,
        bounds=dict(bounds),
    )


class _Problem:
    """The moves of one fit; points are shares of the bounds, ``[point, parameter]``."""

    def __init__(
        self, loop: Loop, records: Mapping[str, Trajectory], keys: tuple[str, ...], lows: np.ndarray,
        highs: np.ndarray, signal: str, equal_moves: bool,
    ) -> None:  # fmt: skip
        if not records:
            raise DataError("no records to fit a loop to")
        for name, record in records.items():
            _check(name, record, keys)
        if len(loop.columns([signal])) != 2:
            raise ValueRefused(
                f"signal = {signal!r} has several parts: name one of {', '.join(loop.columns([signal])[1:])}"
            )
        self.loop, self.keys, self.lows, self.highs, self.signal = loop, keys, lows, highs, signal
        self.values = [np.asarray(r.value, dtype=np.float64) for r in records.values()]
        ranges = [float(np.ptp(v)) for v in self.values]
        self.scales = ranges if equal_moves else [max(ranges)] * len(ranges)
        set_by_moves = {k for r in records.values() for k in r.changes}
        for key in sorted(set_by_moves):
            loop.split(key)
        own = {k: loop.parameters[k] for k in sorted(set_by_moves)}
        self.changes = {k: np.array([r.changes.get(k, own[k]) for r in records.values()]) for k in own}
        periods = [np.asarray(r.time_s) / loop.period for r in records.values()]
        last = max(float(p[-1]) for p in periods)
        on_samples = all(np.max(np.abs(p - np.rint(p))) < 1e-6 for p in periods)
        self.every = int(np.gcd.reduce(np.rint(np.concatenate(periods)).astype(np.int64))) if on_samples else 1
        self.every = max(1, self.every)
        self.rows = [p / self.every for p in periods]
        self.duration = (int(np.ceil(last - 1e-6)) + 1) * loop.period
        self.runs = 0

    def simulate(self, points: np.ndarray) -> list[np.ndarray]:
        """The signal of each move at the times of its log, ``[point, sample]``."""
        n, moves = len(points), len(self.values)
        values = self.lows + points * (self.highs - self.lows)
        varied = {key: np.repeat(values[:, i], moves) for i, key in enumerate(self.keys)}
        varied |= {key: np.tile(v, n) for key, v in self.changes.items()}
        runs = n * moves
        batch = self.loop.batch(self.duration, varied, runs=runs, record=(self.signal,), every=self.every)
        self.runs += runs
        table = batch[self.signal]
        table[np.isfinite(batch.diverged_at)] = np.nan
        at = np.arange(table.shape[1])
        return [
            np.array([np.interp(rows, at, row) for row in table[move::moves]])
            for move, rows in enumerate(self.rows)
        ]  # fmt: skip

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """All differences in shares of the scales, ``[point, sample]``."""
        parts = zip(self.simulate(points), self.values, self.scales, strict=True)
        return np.nan_to_num(np.concatenate([(y - m) / s for y, m, s in parts], axis=1), nan=LOST)

    def jacobian(self, point: np.ndarray, step: float) -> np.ndarray:
        """Central differences, one-sided on a bound, ``[sample, parameter]``."""
        ups, downs = (np.clip(point + sign * step * np.eye(len(point)), 0.0, 1.0) for sign in (1.0, -1.0))
        found = self.residuals(np.concatenate([ups, downs]))
        apart = np.diag(ups - downs)
        return ((found[: len(point)] - found[len(point) :]) / apart[:, None]).T

    def origin(self, start: Mapping[str, float]) -> np.ndarray:
        """The start in shares of the bounds."""
        for key in start:
            if key not in self.keys:
                raise ValueRefused(f"start: {key} is not fitted; fitted are {', '.join(self.keys)}")
        own = self.loop.parameters
        at = np.array(
            [
                start.get(k, min(max(own[k], low), high))
                for k, low, high in zip(self.keys, self.lows, self.highs, strict=True)
            ]
        )
        for key, value, low, high in zip(self.keys, at, self.lows, self.highs, strict=True):
            if not low <= value <= high:
                raise ValueRefused(f"start: {key} = {value:g} is outside its bounds {low:g} to {high:g}")
        return (at - self.lows) / (self.highs - self.lows)

    def refuse_deaf(self, origin: np.ndarray) -> None:
        """Refuses a parameter that changes nothing between its bounds, the others at the start."""
        probes = np.concatenate([np.where(np.eye(len(origin), dtype=bool), x, origin) for x in (0.0, 0.5, 1.0)])
        found = self.residuals(probes).reshape(3, len(origin), -1)
        for i, key in enumerate(self.keys):
            if np.max(np.ptp(found[:, i], axis=0)) < DEAF and np.max(np.abs(found[:, i])) < LOST:
                raise ValueRefused(
                    f"{key} does not act on {self.signal} between {self.lows[i]:g} and {self.highs[i]:g}: these "
                    "records say nothing about it"
                )


def _limits(loop: Loop, bounds: Mapping[str, tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    if not bounds:
        raise ValueRefused("bounds: no parameter to fit")
    for key, (low, high) in bounds.items():
        loop.split(key)
        entry = loop.sheet[key]
        if entry.type != "float":
            raise ValueRefused(f"bounds: {key} is of type {entry.type}; only numbers of type float can be fitted")
        for value in (low, high):
            entry.check(float(value), "bounds")
        if not low < high:
            raise ValueRefused(f"bounds: {key} from {low:g} to {high:g}; the first must be below the second")
    lows, highs = (np.array([b[i] for b in bounds.values()], dtype=np.float64) for i in (0, 1))
    return lows, highs


def _check(name: str, record: Trajectory, keys: tuple[str, ...]) -> None:
    time, value = (np.asarray(part, dtype=np.float64) for part in record[:2])
    if time.shape != value.shape or time.ndim != 1:
        raise DataError(f"record {name}: time has the shape {time.shape}, the signal {value.shape}")
    if len(time) < 3:
        raise DataError(f"record {name}: {len(time)} samples; a fit needs at least three")
    if not (np.isfinite(time).all() and np.isfinite(value).all()):
        raise DataError(f"record {name}: a time or a value is not a finite number")
    if time[0] < 0.0 or not (np.diff(time) > 0.0).all():
        raise DataError(f"record {name}: times must rise from 0 s or later")
    if np.ptp(value) == 0.0:
        raise DataError(f"record {name}: the signal never moves")
    for key in record.changes:
        if key in keys:
            raise ValueRefused(f"record {name}: {key} is fitted, so a record cannot set it")
