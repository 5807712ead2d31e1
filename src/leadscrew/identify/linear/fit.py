"""A transfer function with delay from one log: structure by simulation of the part held out, intervals, advice.

    Y(s) / U(s) = (b_m s^m + ... + b_0) / (s^n + ... + a_q s^q) * exp(-delay s)

The input is held from sample to sample and simulated exactly (:mod:`leadscrew.identify.linear.model`). Poles and
delay are searched from instrumental-variable starts and a grid, the rest is linear
(:mod:`leadscrew.identify.linear.model`); the criterion is the error of simulation (output error). With the command
of a closed loop the last step uses it as instrument (:func:`from_command`).

Inside a closed loop the input answers the output's noise; what the command alone made of it does not.

The controller turns noise of the output into input, so noise and input go together, and output error is biased where
the noise is not white. The refined estimate solves, instead of ``J' e = 0``,

    Z' e(theta) = 0,    e = y - y_simulated(u; theta),    Z = d y_simulated(u_r; theta) / d theta

``u_r`` is the part of the input that the command explains: least squares on means of the command over windows that
reach back ever further. It need not be exact: whatever is made of the command is free of the noise (Young, Garnier,
Gilson, *Systems and Control Letters*, 2008; Soderstrom and Stoica, *System Identification*, 1989, chapter 8).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from leadscrew.identify.estimation import coloured, condition, whiteness
from leadscrew.identify.linear import advice
from leadscrew.identify.linear.choose import Fitted, Task, alone, choose, fitted, held_out
from leadscrew.identify.linear.model import Model, Problem, Solved, Structure, candidates
from leadscrew.identify.linear.record import LEAST, LinearRecord
from leadscrew.identify.linear.result import Candidate, LinearFit, Stretch
from leadscrew.identify.linear.uncertainty import Quantities, quantities, within
from leadscrew.kernel.one_thread import one_thread
from leadscrew.kernel.validate import number, whole
from leadscrew.util.errors import DataError, ValueRefused

FINE = 16
"""Windows of one sample each; the later ones grow."""
GROWTH = 1.35
BACK = 0.25
"""Share of the record up to which the windows reach back."""
AGREES = 0.5
"""Correlation of the input and its part from the command below which the command is no instrument."""


def from_command(u: np.ndarray, command: np.ndarray) -> tuple[np.ndarray, float]:
    """The input as the command explains it, and its correlation with the input; 0 where it is no instrument."""
    r = command - command[0]
    edges = list(range(FINE + 1))
    while edges[-1] < BACK * len(u):
        edges.append(int(np.ceil(GROWTH * edges[-1])))
    summed = np.concatenate([np.zeros(edges[-1] + 1), np.cumsum(r)])
    at = np.arange(len(u)) + edges[-1] + 1
    columns = [(summed[at - a] - summed[at - b]) / (b - a) for a, b in pairwise(edges)]
    rows = np.stack([*columns, np.ones(len(u))], axis=1)
    made = rows @ np.linalg.lstsq(rows, u, rcond=1e-9)[0]
    together = float(np.corrcoef(made, u)[0, 1]) if np.ptp(made) > 0.0 else 0.0
    return (made, together) if together > AGREES else (np.zeros_like(u), 0.0)


BAND = 160
"""Frequencies of the Bode band."""


class Estimate(NamedTuple):
    """Unknowns, what they leave of the training part, and intervals."""

    theta: np.ndarray
    solved: Solved
    method: str
    closed: bool
    """Whether the command was the instrument."""
    condition: float
    found: Quantities
    excited_hz: tuple[float, float]

    @property
    def tells(self) -> bool:
        """Whether the log tells one of its numbers; a delay that was given is none."""
        return any(p.identifiable and p.low < p.high for p in self.found.parameters.values())


def estimate(task: Task, best: Fitted) -> Estimate:
    """The numbers of one candidate."""
    r, problem = task.record, task.problem(best.structure)
    model = Model(problem)
    phi, method = model.phi(best.theta, best.solved), "output error"
    tools, closed = None, False
    if r.command is not None:
        clean, together = from_command(problem.u, r.command[: task.train])
        if together > 0.0:
            refined, rests = model.refined(phi, clean)
            if rests:
                phi, closed = refined, True
                tools = model.jacobian(phi, clean)
                method = (
                    f"instruments from the command, which makes {100.0 * together**2:.0f} % of the input's variance"
                )
    residual = problem.y[problem.rows] - model.simulate(phi, problem.u)
    change = model.jacobian(phi, problem.u)
    hz = np.geomspace(0.5 / (r.period * len(r.time)), 0.499 / r.period, BAND)
    found = quantities(model, phi, coloured(change, residual, tools), (r.input_unit, r.output_unit), hz)
    spoken = advice.excited(problem.u[problem.rows], residual, r.period, (hz, found.bode.response))
    b, theta = model.split(phi)
    denominator, delay_s, _ = problem.system(theta)
    solved = Solved(denominator, delay_s, b[::-1].copy(), phi[model.kept : -1], float(phi[-1]), residual)
    size = condition(change[:, : model.kept])
    return Estimate(theta, solved, method, closed, size, within(found, spoken[1]), spoken)


LONGEST = 20.0
"""Sample periods up to which the delay is searched."""
MARGIN = 0.02
"""Share by which the hold-out error may exceed the least one, for fewer coefficients."""
MOST = 6


@one_thread()
def identify_linear(
    record: LinearRecord,
    *,
    structure: tuple[int, int, int] | None = None,
    max_order: int = 4,
    max_zeros: int = 2,
    integrators: Sequence[int] = (0, 1),
    delay: float | None = None,
    max_delay: float | None = None,
    holdout: float = 0.5,
    margin: float = MARGIN,
    progress: Callable[[str, float], None] = lambda what, done: None,
) -> LinearFit:
    """A transfer function with delay from a record.

    Args:
        record: of :func:`linear_record` or :func:`read_linear`; with a command, it is the instrument.
        structure: poles (those at zero included), zeros, poles at zero; chosen among candidates unless given.
        max_order: most poles of a candidate, 1 to 6.
        max_zeros: most zeros.
        integrators: numbers of poles at zero to be tried.
        delay: s; fitted unless given.
        max_delay: s, the longest that is tried; 20 sample periods unless given.
        holdout: share of the log, at its end, that the fit does not see: 0 to 0.8.
        margin: the simplest candidate within this share of the least hold-out error is taken.
        progress: gets what happens and the fraction done.

    Raises:
        ValueRefused: an option out of its range.
        DataError: a training part that is too short, or in which input or output do not move.
    """
    structures = _structures(structure, max_order, max_zeros, integrators)
    task = _task(record, delay, max_delay, holdout)
    _in_range("margin", margin, 0.0, 1.0)
    if len(structures) > 1:
        best, table = choose(task, structures, margin, progress, lambda f: estimate(task, f).tells)
    else:
        progress(f"fitting {structures[0].text}", 0.1)
        best = fitted(task, structures[0], [], thorough=True, start=alone(task, structures[0]).theta)
        table = [Candidate(best.structure, best.solved.delay_s, best.train_rms, best.holdout_rms, "chosen")]
    return _result(task, best, estimate(task, best), table, margin, asked=structure is not None)


def _result(task: Task, best: Fitted, its: Estimate, table: list[Candidate], margin: float, asked: bool) -> LinearFit:
    r, problem = task.record, task.problem(best.structure)
    solved, found = its.solved, its.found
    white, rho = whiteness(solved.residual)
    stretches = _stretches(task, problem, its.theta, solved)
    missed, feedback = advice.correlations(solved.residual, problem.u[problem.rows])
    fit = LinearFit(
        source=r.source, structure=best.structure, numerator=solved.numerator, denominator=solved.denominator,
        delay_s=solved.delay_s, offset=found.offset, input_name=r.input_name, output_name=r.output_name,
        input_unit=r.input_unit, output_unit=r.output_unit, period=r.period, coefficients=found.coefficients,
        parameters=found.parameters, covariance=found.covariance, condition=its.condition, stretches=stretches,
        candidates=table, margin=margin, method=its.method, closed_loop=its.closed, whiteness=white,
        autocorrelation=rho, missed=missed, feedback=feedback, excited_hz=its.excited_hz, bode=found.bode,
        limits=_limits(r, stretches), measured=advice.measured_response(r, best.structure.integrators),
        resolution=r.resolution, noise=min(r.noise, stretches[0].rms), notes=list(r.notes),
    )  # fmt: skip
    fit.notes.extend(advice.notes(fit, r, task, asked))
    fit.advice.extend(advice.next_steps(fit, r))
    return fit


def _stretches(task: Task, problem: Problem, theta: np.ndarray, solved: Solved) -> list[Stretch]:
    r, rows = task.record, problem.rows
    measured = r.output[rows]
    found = [_stretch("training", r.time[rows], measured, measured - solved.residual)]
    ahead = held_out(task, problem, theta, solved)
    if len(ahead):
        found.append(_stretch("hold-out", r.time[task.train :], r.output[task.train :], ahead))
    return found


def _stretch(what: str, time: np.ndarray, measured: np.ndarray, simulated: np.ndarray) -> Stretch:
    left = measured - simulated
    rms, spread = float(np.sqrt(np.mean(left**2))), float(np.std(measured)) or 1.0
    return Stretch(what, float(time[0]), float(time[-1]), rms, float(np.abs(left).max()),
                   100.0 * rms / (float(np.ptp(measured)) or 1.0), 100.0 * (1.0 - rms / spread), time, measured,
                   simulated)  # fmt: skip


def _limits(record: LinearRecord, stretches: list[Stretch]) -> dict[str, Any]:
    """Of a machine that does what the log shows; derivatives are those of the simulation, which has no noise."""
    speeds = [np.diff(s.simulated) / record.period for s in stretches]
    rates = [np.diff(v) / record.period for v in speeds]
    return {
        "drive": float(np.abs(record.input).max()),
        "speed": max(float(np.abs(v).max()) for v in speeds),
        "acceleration": max(float(np.quantile(np.abs(a), 0.999)) for a in rates),
        "travel": [float(record.output.min()), float(record.output.max())],
    }


def _structures(
    structure: tuple[int, int, int] | None, max_order: int, max_zeros: int, integrators: Sequence[int]
) -> list[Structure]:
    if structure is not None:
        n, m, q = structure
        whole("order", n, 1, MOST)
        whole("zeros", m, 0, n - 1)
        whole("integrators", q, 0, min(n, 2))
        return [Structure(n, m, q)]
    whole("max_order", max_order, 1, MOST)
    whole("max_zeros", max_zeros, 0, MOST - 1)
    for q in integrators:
        whole("integrators", q, 0, 2)
    found = candidates(max_order, max_zeros, tuple(dict.fromkeys(integrators)))
    if not found:
        raise ValueRefused(
            f"max_order = {max_order} with {min(integrators, default=0)} integrators leaves no candidate"
        )
    return found


def _task(record: LinearRecord, delay: float | None, max_delay: float | None, holdout: float) -> Task:
    _in_range("holdout", holdout, 0.0, 0.8)
    n = len(record.time)
    train = n - round(holdout * n)
    if train < LEAST or (holdout and n - train < LEAST // 3):
        raise DataError(f"{record.source}: of {n} samples {train} are left to fit; at least {LEAST} are needed")
    for name, values in ((record.input_name, record.input), (record.output_name, record.output)):
        if np.ptp(values[:train]) == 0.0:
            raise DataError(
                f"{record.source}: {name} does not change before {record.time[train]:g} s, the part that is fitted; "
                "give the part of the log that moves, or a smaller hold-out"
            )
    longest = LONGEST * record.period if max_delay is None else number("max_delay", max_delay, "s")
    limit = 0.2 * train * record.period
    for name, value in (("delay", delay), ("max_delay", longest)):
        if value is not None:
            _in_range(name, value, 0.0 if name == "delay" else record.period, limit, " s")
    return Task(record, train, delay, longest)


def _in_range(key: str, value: float, low: float, high: float, unit: str = "") -> None:
    if not low <= number(key, value, unit.strip()) <= high:
        raise ValueRefused(f"{key} = {value!r}: allowed range is [{low:g}, {high:g}]{unit}")
