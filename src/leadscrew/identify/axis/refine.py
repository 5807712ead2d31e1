"""Refinement of an axis model by simulation: the parameters with which the plant itself comes nearest to the log.

    minimise  sum_k (x_k(theta) - y_k)^2        x: leadscrew.plants.servo_axis under the logged drive

by trust-region least squares (SciPy) in scaled variables; all simulations of an iteration are one ``Loop.batch``.

- ``windows``: pieces of 0.7 s, each with a free start position and speed (:mod:`refine_windows`): multiple shooting.
  The logged drive acted exactly as it is in the log, so with noise of the sensor alone this is maximum likelihood, in
  closed loop too. A force that the model does not know is forgotten at the next window.
- ``open``: the whole log in one, its start speed free, and its start position too where nothing but the sensor's noise
  is left. Nothing is forgotten: what the model lacks adds up twice.
- ``closed``: the known cascade closes the loop on the model under the logged command. What is left is small, and tells
  of the parameters only as much as the controller lets them show.

Covariances hold where residuals are correlated, :mod:`refine_errors`; ``at_bound`` names a parameter on its bound.
H. G. Bock, *Recent advances in parameter identification techniques for ODE*, 1983, for multiple shooting; L. Ljung,
*System Identification* (2nd ed., 1999), section 7.4 for the output-error method.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from leadscrew.identify.axis.refine_closed import BLOCK_S, Closed
from leadscrew.identify.axis.refine_errors import Spread, by_force, clustered
from leadscrew.identify.axis.refine_replay import LOST
from leadscrew.identify.axis.refine_scales import Scales, scales
from leadscrew.identify.axis.refine_windows import Windows, cut, whole
from leadscrew.kernel import validate
from leadscrew.kernel.errors import DataError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog

Mode = Literal["open", "windows", "closed"]

DRIFTS = 0.9
"""Correlation of a residual from sample to sample above which it is a force integrated, not noise of the sensor."""
BEYOND = 20.0
"""An open-loop residual of more than so many times the sensor's noise is no noise; then the start position stays the
measured one, which a free one would leave to make up for what the model lacks."""
FLOOR = 5e-5
"""Standard error, as a share of the value, that is always there: simulations of the same axis in finer steps, and
drives that are logged rounded, give values that differ by so much."""
CLOCK = 2e-3
"""The same for a delay, in periods: a clock that samples is not better."""
ROUNDS = 3
"""How often windows are chosen anew, at most."""
MOST = 30
"""Evaluations of an optimisation, at most."""


@dataclass(frozen=True)
class Refined:
    """What a refinement found."""

    mode: Mode
    keys: tuple[str, ...]
    """Fitted keys, in the order of ``covariance``."""
    values: dict[str, float]
    """All values, both directions, the fitted ones and those that were kept."""
    covariance: np.ndarray
    """Of the fitted values, in their units."""
    standard_error: dict[str, float]
    degrees: dict[str, float]
    """Degrees of freedom of Student's t, by fitted key."""
    interval: dict[str, tuple[float, float]]
    """95 %."""
    condition: float
    """Columns of the Jacobian scaled to the same length."""
    correlation: dict[str, dict[str, float]]
    rms: float
    """Of what is left, m or rad."""
    residual: np.ndarray
    """Model less measured, window after window; free starts are taken out."""
    window: np.ndarray
    """Window of each entry of ``residual``; whiteness is judged within windows."""
    windows: int
    left_out: int
    """Windows that the model misses by far more than the others."""
    start_state: tuple[float, float]
    """Position and speed at the first sample; in ``open`` mode those that fit best."""
    at_bound: tuple[str, ...]
    runs: int
    converged: bool
    message: str


def refine(
    log: AxisLog,
    start: Mapping[str, float],
    fitted: Sequence[str],
    symmetric: bool = False,
    mode: Mode = "windows",
    delay_s: float = 0.0,
    cascade: Cascade | None = None,
    progress: Callable[[str, float], None] | None = None,
    *,
    window_s: float | None = None,
) -> Refined:
    """The values of ``fitted`` with which the simulated axis comes nearest to the log, from ``start`` downhill.

    Args:
        log: evenly sampled; is not changed.
        start: values by key of the plant; those that are not fitted stay. Static friction that equals Coulomb friction
            and is not fitted follows it.
        fitted: keys, ``delay_s`` among them where the delay is to be fitted.
        symmetric: friction alike both ways; ``friction.forward.*`` then speaks for both.
        mode: ``windows``, ``open`` or ``closed``.
        delay_s: from a logged drive to its act, where it is not fitted; where it is, its start.
        cascade: the loop that was active, for ``closed``.
        progress: is told what happens and the fraction done.
        window_s: length of a window, s; 0.7 unless given, less in a short log.

    Raises:
        NameUnknown, ValueRefused: an unknown key, mode or value; ``closed`` without a cascade.
        DataError: the simulation diverges at the start; the log is too short; no command for ``closed``.
    """
    validate.one_of("mode", mode, ["open", "windows", "closed"])
    scale = scales(log, start, fitted, symmetric, delay_s)
    problem = _problem(log, scale, mode, cascade, window_s)
    found = _descend(log, scale, problem, mode, progress)
    if isinstance(problem, Windows) and problem.held:
        left = problem.residuals(found[0])
        if float(np.sqrt(np.mean(left * left))) <= BEYOND * problem.noise:
            problem = Windows(log, scale, problem.pieces)
            found = _descend(log, scale, problem, mode, progress, found[0])
    if isinstance(problem, Windows) and mode == "windows":
        for _ in range(ROUNDS):
            if not problem.choose(found[0]):
                break
            found = _descend(log, scale, problem, mode, progress, found[0])
    return _result(log, scale, problem, mode, *found)


def _descend(
    log: AxisLog, scale: Scales, problem: Windows | Closed, mode: Mode, progress: Callable[[str, float], None] | None,
    begin: np.ndarray | None = None,
) -> tuple[np.ndarray, bool, str]:  # fmt: skip
    from scipy.optimize import least_squares

    say = progress or (lambda what, done: None)
    x = np.clip(scale.origin if begin is None else begin, scale.low, scale.high)
    first = problem.residuals(x)
    if np.max(np.abs(first)) >= 0.5 * LOST:
        raise DataError(f"{log.source}: the simulated axis diverges with the values that the refinement starts from")
    unit = max(float(np.sqrt(np.mean(first * first))), 1e-15)
    steps = 0

    def residuals(at: np.ndarray) -> np.ndarray:
        return problem.residuals(at) / unit

    def jacobian(at: np.ndarray) -> np.ndarray:
        nonlocal steps
        steps += 1
        say(f"refinement ({mode})", 1.0 - 0.8**steps)
        return problem.jacobian(at) / unit

    best = least_squares(
        residuals, x, jacobian, bounds=(scale.low, scale.high), x_scale="jac",
        ftol=1e-6 if mode == "open" else 1e-8, xtol=1e-6, gtol=1e-12,
        max_nfev=MOST,
    )  # fmt: skip
    return best.x, bool(best.status > 0), str(best.message)


def _problem(
    log: AxisLog, scale: Scales, mode: Mode, cascade: Cascade | None, window_s: float | None
) -> Windows | Closed:
    if mode == "closed":
        if cascade is None:
            raise ValueRefused("mode = 'closed': give the cascade that was active while the log was made")
        return Closed(log, scale, cascade)
    if window_s is not None:
        validate.positive("window_s", window_s, "s")
    if mode == "open":
        return Windows(log, scale, whole(log), held=True)
    return Windows(log, scale, cut(log, scale.point(scale.origin), window_s))


def _result(
    log: AxisLog, scale: Scales, problem: Windows | Closed, mode: Mode, x: np.ndarray, converged: bool, message: str
) -> Refined:
    left, jacobian = problem.residuals(x), problem.jacobian(x, central=True)
    spread = _spread(log, scale, problem, x, mode, left, jacobian)
    per = scale.per_variable(x)
    least = FLOOR * np.where(scale.logs, 1.0, np.abs(x))
    least = np.where([k == "delay_s" for k in scale.keys], CLOCK, least)
    spread = spread._replace(covariance=spread.covariance + np.diag(least * least))
    covariance = spread.covariance * np.outer(per, per)
    error = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    at_bound = tuple(k for k, v, low, high in zip(scale.keys, x, scale.low, scale.high, strict=True)
                     if v <= low + 1e-6 or v >= high - 1e-6)  # fmt: skip
    values = scale.values(x)
    full = scale.point(x) | {k: v for k, v in values.items() if k not in scale.point(x)}
    cluster = problem.cluster
    safe = np.where(error > 0.0, error, 1.0)
    related = covariance / np.outer(safe, safe)
    return Refined(
        mode=mode, keys=scale.keys, values=full | {"delay_s": scale.delay(x)}, covariance=covariance,
        standard_error=dict(zip(scale.keys, error.tolist(), strict=True)),
        degrees=dict(zip(scale.keys, spread.degrees.tolist(), strict=True)),
        interval=_intervals(scale, x, spread), condition=spread.condition,
        correlation={a: {b: float(related[i, j]) for j, b in enumerate(scale.keys)} for i, a in enumerate(scale.keys)},
        rms=float(np.sqrt(np.mean(left * left))), residual=left, window=cluster, windows=int(np.unique(cluster).size),
        left_out=int(np.sum(~problem.used)) if isinstance(problem, Windows) else 0,
        start_state=problem.begin(x), at_bound=at_bound, runs=problem.runs, converged=converged, message=message,
    )  # fmt: skip


def _spread(
    log: AxisLog, scale: Scales, problem: Windows | Closed, x: np.ndarray, mode: Mode, left: np.ndarray,
    jacobian: np.ndarray,
) -> Spread:  # fmt: skip
    if mode == "open":
        steady = float(left[1:] @ left[:-1]) / max(float(left @ left), 1e-300)
        if steady > DRIFTS:
            point = scale.point(x)
            rate = 0.5 * (point["friction.forward.viscous"] + point["friction.backward.viscous"]) / point["mass"]
            return by_force(jacobian, left, log.period, rate, BLOCK_S)
        return clustered(jacobian, left, np.arange(len(left)) // max(1, round(BLOCK_S / log.period)))
    return clustered(jacobian, left, problem.cluster)


def _intervals(scale: Scales, x: np.ndarray, spread: Spread) -> dict[str, tuple[float, float]]:
    """95 %, in the variable that was fitted: a logarithm's interval does not reach zero."""
    from scipy.stats import t

    reach = t.ppf(0.975, spread.degrees) * np.sqrt(np.maximum(np.diag(spread.covariance), 0.0))
    found = {}
    for i, key in enumerate(scale.keys):
        ends = [x[i] - reach[i], x[i] + reach[i]]
        low, high = (
            scale.size[i] * np.exp(np.clip(e, -700, 700)) if scale.logs[i] else scale.size[i] * e for e in ends
        )
        found[key] = (float(min(low, high)), float(max(low, high)))
    return found
