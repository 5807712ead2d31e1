"""The Kalman filter of the inference network on its own: covariances over thousands of updates.

The forms of the update are compared in NumPy and kept in ``data/covariance_forms.csv``; :func:`write_forms` makes it
again. The filter that the controllers use is run compiled, in :func:`learner_loop`.
"""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from leadscrew.fuzzy.partition import Axis
from leadscrew.kernel.block import controller, plant
from leadscrew.kernel.sheet import Doc
from leadscrew.neural.inference_net import AXIS, W0, fired, network_output
from leadscrew.neural.kalman import kalman_learn
from leadscrew.studies.sofnn_tangent.online import rules

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

FORMS_CSV = Path(__file__).parent / "data" / "covariance_forms.csv"
MARKS = (100, 200, 500, 1000, 2000, 5000, 10000, 20000)
"""Updates after which a covariance is looked at."""
P0, R, FORGETTING = 1e4, 1e-4, 0.98
"""The digest's test: variance of a consequent before, of a target, and what textbooks divide P by."""
INSIDE = 2.0
"""Only the nine rules around zero are excited: E and EC from -2 to 2 levels."""
UPDATES = 20000


class FormRow(NamedTuple):
    """A covariance after some updates."""

    form: str
    bits: int
    """Of a number: 32 or 64."""
    forgetting: float
    updates: int
    finite: bool
    positive: bool
    """Positive definite: its symmetric half has a Cholesky factor."""
    asymmetry: float
    """Largest difference of an element from its mirror image, levels squared."""
    trace: float
    """Levels squared."""


def covariance_forms() -> list[FormRow]:
    """Three forms in two precisions, with and without forgetting, over 20,000 updates: half a minute."""
    from leadscrew.neural.kalman_dense import FORMS, regressor, updated

    points = np.random.default_rng(1).uniform(-INSIDE, INSIDE, (UPDATES, 2))
    rows = [regressor(fired(AXIS, AXIS, e, ec)) for e, ec in points]
    found: list[FormRow] = []
    for form in FORMS:
        for kind in (np.float32, np.float64):
            for forgetting in (1.0, FORGETTING):
                p: Any = (P0 * np.eye(49)).astype(kind)
                with np.errstate(all="ignore"):
                    for k, h in enumerate(rows, start=1):
                        p = updated(p, h, R, form, forgetting)[1]
                        if k in MARKS:
                            found.append(FormRow(form, 8 * p.itemsize, forgetting, k, *judged(p)))
    return found


def judged(p: np.ndarray) -> tuple[bool, bool, float, float]:
    """Whether a covariance is finite and positive definite, its asymmetry and its trace."""
    full = p.astype(float)
    if not np.isfinite(full).all():
        return False, False, math.nan, math.nan
    try:
        np.linalg.cholesky(0.5 * (full + full.T))
    except np.linalg.LinAlgError:
        return True, False, float(np.abs(full - full.T).max()), float(np.trace(full))
    return True, True, float(np.abs(full - full.T).max()), float(np.trace(full))


def write_forms(path: Path = FORMS_CSV) -> None:
    """Makes the table again."""
    lines = [",".join(FormRow._fields)]
    for row in covariance_forms():
        lines.append(
            ",".join(f"{x:.4g}" if isinstance(x, float) else f"{x:d}" if isinstance(x, int) else x for x in row)
        )
    path.write_text("\n".join(lines) + "\n")


@cache
def forms_kept() -> tuple[FormRow, ...]:
    """The table as it is kept."""
    rows = [line.split(",") for line in FORMS_CSV.read_text().splitlines()[1:]]
    return tuple(
        FormRow(a, int(b), float(c), int(d), e == "1", f == "1", float(g), float(h)) for a, b, c, d, e, f, g, h in rows
    )


# ---- the filter of the controllers, on its own
class LearnerParams(NamedTuple):
    """A network that learns what another one says."""

    axis: Axis = AXIS
    teacher: Annotated[np.ndarray, Doc("consequents that are to be learned, levels")] = W0
    inside: Annotated[float, Doc("largest E and EC, levels")] = INSIDE
    error: Annotated[float, Doc("amplitude of what is wrong with the target, levels")] = 0.1
    r: float = R
    q: float = 0.0
    cap: float = 1e300
    learn: Annotated[int, Doc("1: a Kalman update a period; 0: the network's output alone")] = 1


class LearnerState(NamedTuple):
    """The network, and how often it has learned."""

    weights: np.ndarray = np.zeros(49)
    covariance: np.ndarray = P0 * np.eye(49)
    first: float = 0.0
    second: float = 0.0


@controller(LearnerParams(), LearnerState())
def learner(p, s, command, feedback):
    """One Kalman update a period, at points that fill the square evenly (multiples of two irrational numbers)."""
    first = s.first + 0.7548776662466927
    second = s.second + 0.5698402909980532
    first = first - math.floor(first)
    second = second - math.floor(second)
    at = fired(p.axis, p.axis, p.inside * (2.0 * first - 1.0), p.inside * (2.0 * second - 1.0))
    off = p.error * math.sin(50.0 * first)
    said = network_output(s.weights, at)
    if p.learn > 0:
        kalman_learn(s.weights, s.covariance, at, network_output(p.teacher, at) + off - said, p.r, p.q, p.cap, 6.0)
    return LearnerState(s.weights, s.covariance, first, second), said


class Nothing(NamedTuple):
    """A plant that stands still."""

    x: float = 0.0


@plant(None, Nothing())
def still(s, u, dt):
    """Nothing."""
    return Nothing(0.0 * u)


def learner_loop(**values: float) -> Loop:
    """The learner in a loop around nothing; a period is an update."""
    from leadscrew.kernel.loop import Loop
    from leadscrew.references.step import step

    return Loop(
        reference=step(target=0.0), controller=learner(**values), plant=still, metrics={}, period=0.01, name="learner"
    )


def learned(updates: int = UPDATES, **values: float) -> np.ndarray:
    """The covariance of the learner after some updates."""
    live = learner_loop(**values).start()
    live.advance(updates, every=0)
    return np.asarray(rules(live).covariance)


def trace_of_learner(updates: int = UPDATES, **values: float) -> tuple[np.ndarray, np.ndarray]:
    """Updates, and the trace of the learner's covariance after them, levels squared."""
    live = learner_loop(**values).start()
    marks = np.unique(np.geomspace(1, updates, 60).astype(int))
    found = []
    for steps in np.diff(marks, prepend=0).tolist():
        live.advance(steps, every=0)
        found.append(float(np.trace(rules(live).covariance)))
    return marks, np.array(found)


def apart_from_dense(updates: int = 1500) -> float:
    """Largest difference of consequents and covariance from those of the plain matrix formula, levels, levels squared.

    The same points and targets as the learner's, over the whole universe, with walk and cap.
    """
    from leadscrew.neural.kalman_dense import kalman_learn_dense, regressor

    loop = learner_loop(inside=6.0, q=0.05, cap=4.0, r=0.01)
    p: Any = loop.blocks["controller"].params  # type: ignore[union-attr]
    live = loop.start()
    live.advance(updates, every=0)
    ours = rules(live)
    weights, covariance, first, second = np.zeros(49), P0 * np.eye(49), 0.0, 0.0
    for _ in range(updates):
        first, second = first + 0.7548776662466927, second + 0.5698402909980532
        first, second = first - math.floor(first), second - math.floor(second)
        at = fired(p.axis, p.axis, p.inside * (2.0 * first - 1.0), p.inside * (2.0 * second - 1.0))
        h = regressor(at)
        innovation = float(h @ p.teacher + p.error * math.sin(50.0 * first) - h @ weights)
        kalman_learn_dense(weights, covariance, at, innovation, p.r, p.q, p.cap, 6.0)
    return max(float(np.abs(ours.weights - weights).max()), float(np.abs(ours.covariance - covariance).max()))


def update_cost(periods: int = 5000, times: int = 7) -> float:
    """Microseconds that an update adds to a period, the best of some runs with it and without."""
    import time

    loops = (learner_loop(q=0.05, cap=4.0, r=0.01), learner_loop(q=0.05, cap=4.0, r=0.01, learn=0))
    lives = [loop.start() for loop in loops]
    best = [math.inf, math.inf]
    for _ in range(times):
        for i, live in enumerate(lives):
            began = time.perf_counter()
            live.advance(periods, every=0)
            best[i] = min(best[i], time.perf_counter() - began)
    return 1e6 * (best[0] - best[1]) / periods
