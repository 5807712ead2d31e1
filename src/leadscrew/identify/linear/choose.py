"""Which structure: every candidate is fitted to the training part and judged by simulating the part held out.

The simulation of the hold-out runs from the logged input alone. Its start is free (the state in which a part of a log
begins is not measured); coefficients, delay and offset are those of the training. One-step prediction is not used: it
favours models that copy the last sample.

Two kinds of candidates are never chosen while there is another: one of which no number is identifiable, and one whose
delay ended at the longest that is tried. Both follow a move by what they are not.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from leadscrew.identify.linear.model import Known, Model, Problem, Solved, Structure, forced, free, starts
from leadscrew.identify.linear.record import LinearRecord
from leadscrew.identify.linear.result import Candidate

MOST_ROWS = 2000
"""Samples at which candidates are compared; all are simulated, and the chosen one is fitted to all."""
EQUAL = 1e-6
"""Share of the output's range below which errors count as equal: no sensor tells more."""
DELAYS = 5
"""Starts of the delay where no pole is searched."""
BESIDE = (-3.0, -1.0, 1.0, 3.0)
"""Sample periods."""
MOST_TRIED = 6
"""Candidates that are searched to the end."""
GIVE_UP = 4.0
"""A second start is searched only where its sum of squares is below this many times that of the first."""


class Fitted(NamedTuple):
    """One candidate with its numbers."""

    structure: Structure
    theta: np.ndarray
    solved: Solved
    train_rms: float
    holdout_rms: float

    @property
    def poles(self) -> np.ndarray:
        """Those that are not at zero."""
        return np.roots(self.solved.denominator[: self.structure.free + 1])


class Task(NamedTuple):
    """What all candidates share."""

    record: LinearRecord
    train: int
    """Samples of the training part, from the start."""
    delay: float | None
    longest: float

    @property
    def skipped(self) -> int:
        """Samples at the start that an input before the log may still move."""
        late = self.longest if self.delay is None else self.delay
        return min(int(np.ceil(late / self.record.period)) + 1, self.train // 4)

    def problem(self, structure: Structure, stride: int = 1) -> Problem:
        """The training part for one structure."""
        rows = np.arange(self.skipped, self.train, stride)
        r = self.record
        return Problem(
            r.input[: self.train], r.output[: self.train], r.period, structure, self.delay, self.longest, rows
        )


def held_out(task: Task, problem: Problem, theta: np.ndarray, solved: Solved) -> np.ndarray:
    """The output simulated over the part held out, its start fitted; empty where nothing is held out."""
    r, model = task.record, Model(problem)
    step = problem.system(theta)[2]
    after = slice(task.train, None)
    known = forced(step, r.input, model.m + 1)[after] @ model.weights(step, solved.numerator[::-1])
    known += solved.offset * model.ramp(r.period * np.arange(len(r.input)))[after]
    if not len(known):
        return known
    start = free(step, len(known))
    found = np.linalg.lstsq(start, r.output[after] - known, rcond=1e-11)[0]
    return known + start @ found


def fitted(task: Task, structure: Structure, known: list[Known], thorough: bool = False,
           start: np.ndarray | None = None) -> Fitted:  # fmt: skip
    """The best of a candidate; ``known`` are poles and delays of simpler ones, ``start`` where it was found before."""
    stride = 1 if thorough else max(1, task.train // MOST_ROWS)
    problem = task.problem(structure, stride)
    if start is not None:
        begins = [start, *_beside(problem, start)]
    elif structure.free:
        begins = starts(problem, known, [0.0, min(3.0 * task.record.period, task.longest)])
    else:
        late = np.linspace(0.0, 0.9 * task.longest / task.record.period, DELAYS)
        begins = [np.array([x]) for x in late] if task.delay is None else [np.zeros(0)]
    costs = [float(np.sum(problem.residual(x) ** 2)) for x in begins]
    found = [
        problem.search(x, 80 if thorough else 20, 1e-11 if thorough else 1e-6)
        for x, cost in zip(begins, costs, strict=True)
        if cost <= GIVE_UP * min(costs) or start is not None
    ]
    theta, cost = min(found, key=lambda pair: pair[1])
    solved = problem.solve(theta)
    ahead = held_out(task, problem, theta, solved)
    left = task.record.output[task.train :] - ahead
    return Fitted(structure, theta, solved, float(np.sqrt(cost / len(problem.rows))),
                  float(np.sqrt(np.mean(left**2))) if len(left) else float("nan"))  # fmt: skip


def _beside(problem: Problem, theta: np.ndarray) -> list[np.ndarray]:
    """The same poles with delays a few periods off: the error of simulation has a minimum in several."""
    if problem.delay is not None:
        return []
    steps = np.zeros((len(BESIDE), len(theta)))
    steps[:, -1] = BESIDE
    low, high = problem.bounds()
    return list(np.clip(theta + steps, low, high))


def alone(task: Task, structure: Structure) -> Fitted:
    """One structure that was asked for, from simpler ones with the same poles at zero."""
    known: list[Known] = []
    for order in range(structure.integrators + 1, structure.order):
        simpler = fitted(task, Structure(order, min(structure.zeros, order - 1), structure.integrators), known)
        known.append(Known(simpler.poles, simpler.solved.delay_s))
    return fitted(task, structure, known)


def choose(
    task: Task, structures: list[Structure], margin: float, progress: Callable[[str, float], None],
    tells: Callable[[Fitted], bool] = lambda found: True,
) -> tuple[Fitted, list[Candidate]]:  # fmt: skip
    """The simplest candidate within ``margin`` of the best that ``tells`` something, and the table of all."""
    found: list[Fitted] = []
    for k, structure in enumerate(sorted(structures, key=lambda s: (s.integrators, s.order, -s.zeros))):
        progress(f"trying {structure.text}", k / len(structures))
        same = [Known(f.poles, f.solved.delay_s) for f in found if f.structure.integrators == structure.integrators]
        found.append(fitted(task, structure, same))
    sure: set[Structure] = set()
    out = {f.structure: "its delay ended at the longest that is tried" for f in found if late(task, f)}
    out = out if len(out) < len(found) else {}
    while True:
        scores = {f.structure: _score(task, f) for f in found}
        best = min(score for structure, score in scores.items() if structure not in out)
        limit = (1.0 + margin) * max(best, EQUAL * float(np.ptp(task.record.output)))
        near = [f for f in found if f.structure not in out and scores[f.structure] <= limit]
        chosen = min(near, key=lambda f: (f.structure.free + f.structure.zeros, scores[f.structure]))
        if chosen.structure in sure:
            more = len(out) + 1 < len(found) and len(sure) < MOST_TRIED
            if not more or tells(chosen):
                break
            out[chosen.structure] = "none of its numbers is identifiable"
            continue
        # The table is of quick searches: what is to be chosen is searched to the end first.
        progress(f"fitting {chosen.structure.text}", 0.9)
        full = fitted(task, chosen.structure, [], thorough=True, start=chosen.theta)
        found = [full if f is chosen else f for f in found]
        sure.add(chosen.structure)
    order = sorted(found, key=lambda f: (f.structure.free + f.structure.zeros, f.structure))
    table = [
        Candidate(
            f.structure,
            f.solved.delay_s,
            f.train_rms,
            f.holdout_rms,
            out.get(f.structure) or _against(f, chosen, scores, best, limit),
        )
        for f in order
    ]
    return chosen, table


def late(task: Task, f: Fitted) -> bool:
    """Whether its delay ended at the longest that is tried."""
    return task.delay is None and f.solved.delay_s > 0.99 * task.longest


def _score(task: Task, f: Fitted) -> float:
    if np.isfinite(f.holdout_rms):
        return f.holdout_rms
    numbers = f.structure.free + f.structure.zeros + 2
    return f.train_rms * float(np.sqrt(1.0 + numbers * np.log(task.train) / task.train))


def _against(f: Fitted, chosen: Fitted, scores: dict[Structure, float], best: float, limit: float) -> str:
    if f is chosen:
        return "chosen"
    score = scores[f.structure]
    if score > limit:
        return f"{score / best:.3g} times the least error" if best > 0.0 else "larger error"
    own, simplest = (x.structure.free + x.structure.zeros for x in (f, chosen))
    return "as good, but more coefficients" if own > simplest else "as simple, but a larger error"
