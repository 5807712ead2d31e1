"""Wear: parameters that drift over a life from 0 to 1 while the others stay distributed.

As text: ``KEY=START:END`` in the parameter's unit, ``KEY=xA:xB`` as factors of its own value in each run (the drawn one
where it is distributed, the loop's where not); with ``:log`` the drift is even in the logarithm.

The same samples and the same noise come at every step of the life: two steps differ by the wear alone.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.executors import Crew, Threads
from leadscrew.tune.job import Job
from leadscrew.tune.measure import Progress, identical, measure
from leadscrew.tune.montecarlo import MonteCarlo, asked_of, drawn, opened, passes, pieces, spreads
from leadscrew.tune.space import Space
from leadscrew.tune.statistics import Spread, Yield, without_intervals, yielded
from leadscrew.util.errors import NameUnknown, ValueRefused

Drifts = Mapping[str, "Wear | str | tuple[float, float]"] | Sequence["str | Wear"]
"""What drifts: ``{key: (start, end)}``, ``{key: "x1:x0.9"}``, or texts as on the command line."""
STEPS = 11
"""Steps of a life unless said otherwise."""
FORM = re.compile(r"\s*([^=\s]+)\s*=\s*(x?)([^:x]+):(x?)([^:x]+?)(:log)?\s*")


@dataclass(frozen=True)
class Wear:
    """How one parameter drifts."""

    key: str
    start: float
    end: float
    log: bool = False
    factor: bool = False
    """The ends are factors of the parameter's own value."""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start) and math.isfinite(self.end)) or self.start == self.end:
            raise ValueRefused(f"wear {self}: expected two different numbers")
        if (self.log or self.factor) and min(self.start, self.end) <= 0.0:
            raise ValueRefused(f"wear {self}: {'factors' if self.factor else 'a logarithm'} must be above 0")

    def __str__(self) -> str:
        x = "x" if self.factor else ""
        return f"{self.key}={x}{self.start:g}:{x}{self.end:g}{':log' if self.log else ''}"

    def at(self, life: float) -> float:
        """The value, or the factor, at a life from 0 to 1."""
        if life in (0.0, 1.0):
            return self.end if life else self.start
        if self.log:
            return self.start * (self.end / self.start) ** life
        return self.start + life * (self.end - self.start)


class Crossing(NamedTuple):
    """The life at which the yield falls below a level; NaN: not within this life."""

    level: float
    life: float
    low: float
    """Where the lower end of the yield's interval falls below."""
    high: float
    """Where the upper end does."""


@dataclass
class Envelope:
    """Metrics and yields over a life."""

    wears: tuple[Wear, ...]
    life: np.ndarray
    spreads: tuple[tuple[Spread, ...], ...]
    """By step."""
    yields: tuple[Yield, ...]
    """Against all tolerances together, by step."""

    def band(self, scenario: str, metric: str) -> np.ndarray:
        """A metric's percentiles ``[step, percentile]``."""
        rows = [next(s for s in step if (s.scenario, s.metric) == (scenario, metric)) for step in self.spreads]
        return np.array([[q.value for q in row.quantiles] for row in rows])

    def crossing(self, level: float) -> Crossing:
        """Where the yield falls below a level, interpolated linearly between steps."""
        ends = ([getattr(y, name) for y in self.yields] for name in ("value", "low", "high"))
        return Crossing(level, *(falls_below(self.life, np.array(y), level) for y in ends))


def falls_below(life: np.ndarray, values: np.ndarray, level: float) -> float:
    """Where a broken line first falls below a level; NaN where it does not."""
    below = np.flatnonzero(values < level)
    if not len(below):
        return math.nan
    k = int(below[0])
    if k == 0:
        return float(life[0])
    part = (values[k - 1] - level) / (values[k - 1] - values[k])
    return float(life[k - 1] + part * (life[k] - life[k - 1]))


def wear(text: str) -> Wear:
    """A drift from its text.

    Raises:
        ValueRefused: it is none.
    """
    found = FORM.fullmatch(text)
    try:
        if found is None or found[2] != found[4]:
            raise ValueError
        ends = float(found[3]), float(found[5])
    except ValueError:
        raise ValueRefused(f"wear {text!r}: expected KEY=START:END or KEY=xA:xB, either with :log") from None
    return Wear(found[1], *ends, log=bool(found[6]), factor=bool(found[2]))


def listed(given: Drifts) -> list[Wear]:
    """Drifts as they are given, read.

    Raises:
        ValueRefused: a text that is none.
    """
    if not isinstance(given, Mapping):
        return [w if isinstance(w, Wear) else wear(w) for w in given]
    made = []
    for key, value in given.items():
        if isinstance(value, Wear):
            made.append(value)
        else:
            made.append(wear(f"{key}={value}") if isinstance(value, str) else Wear(key, *value))
    return made


def wears(given: Drifts, job: Job, space: Space) -> tuple[Wear, ...]:
    """Drifts that a job can have.

    Raises:
        NameUnknown: no such parameter.
        ValueRefused: a text that is none, a value out of range, a parameter that drifts twice or is drawn as well.
    """
    made = tuple(listed(given))
    sheet, drawn_keys = job.sheet(), dict(space.items)
    for i, w in enumerate(made):
        if w.key not in sheet:
            raise NameUnknown(f"wear: there is no parameter {w.key!r}{nearest(w.key, list(sheet))}")
        if w.key in [other.key for other in made[:i]]:
            raise ValueRefused(f"wear {w.key}: given twice")
        if sheet[w.key].type != "float":
            raise ValueRefused(f"wear {w.key}: it is of type {sheet[w.key].type}; only numbers drift")
        if w.key in drawn_keys and not w.factor:
            raise ValueRefused(f"wear {w}: {w.key} is distributed as well; a factor (x1:x2) can be put on its values")
        ends: tuple[float, ...] = (1.0,)
        if w.factor:
            ends = drawn_keys[w.key].ends if w.key in drawn_keys else (own(job, w),)
        for value in (w.start, w.end):
            for end in ends:
                sheet[w.key].check(value * end, "wear")
    return made


def own(job: Job, wear: Wear) -> float:
    """The loop's own value of a parameter that drifts by factors.

    Raises:
        ValueRefused: it is another one in another scenario.
    """
    found = {float(job.loop(s).sheet[wear.key].default) for s in job.where}
    if len(found) > 1:
        raise ValueRefused(f"wear {wear}: its value differs between the scenarios; give START:END in its unit")
    return found.pop()


def worn(columns: Mapping[str, np.ndarray], drifts: Sequence[Wear], life: float, job: Job) -> dict[str, np.ndarray]:
    """The parameters at a life."""
    made = dict(columns)
    runs = len(next(iter(columns.values())))
    for w in drifts:
        base: np.ndarray | float = 1.0
        if w.factor:
            base = columns[w.key] if w.key in columns else own(job, w)
        made[w.key] = np.ascontiguousarray(np.broadcast_to(base * w.at(life), (runs,)))
    return made


def envelope(
    found: MonteCarlo,
    drifts: Drifts,
    *,
    steps: int = STEPS,
    crew: Crew | None = None,
    journal: Journal | str | Path | None = None,
    resume: bool = False,
    start: int = 0,
    progress: Progress | None = None,
) -> Envelope:
    """The samples of a Monte Carlo again at every step of a life.

    ``crew``, ``journal`` and ``resume`` are those of :func:`~leadscrew.tune.montecarlo.montecarlo`; ``start`` is the
    first number in a journal of several rounds.

    Raises:
        LeadscrewError: see :func:`wears`; fewer than two steps.
    """
    if steps < 2:
        raise ValueRefused(f"a life of {steps} steps: allowed are whole numbers from 2 on")
    job = found.job
    drifting = wears(drifts, job, found.space)
    workers = crew or Threads()
    kept = opened(journal, asked_of(found, wear=[repr(w) for w in drifting], life=steps), resume)
    columns = drawn(job, found.space, len(found), found.seed, found.method)
    life = np.linspace(0.0, 1.0, steps)
    total = steps * len(found) * len(job.where)
    rows, yields = [], []
    for k, at in enumerate(life):
        here = worn(columns, drifting, float(at), job)

        def report(done: int, of: int, k: int = k) -> None:
            if progress is not None:
                progress(k * of + done, total)

        samples = measure(job, here, workers, journal=kept, start=start + k * pieces(job, here), progress=report)
        alike = found.alike and identical(samples)
        step = spreads(samples, found.metrics)
        rows.append(tuple(map(without_intervals, step)) if alike else step)
        yields.append(yielded(passes(samples, found.tolerances), alike=alike))
    return Envelope(drifting, life, tuple(rows), tuple(yields))
