"""Tolerances: what a run must keep to pass, as ``METRIC<=VALUE``, ``METRIC>=VALUE`` or ``METRIC@SCENARIO<=VALUE``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from leadscrew.kernel.errors import NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest
from leadscrew.tune.job import Job
from leadscrew.tune.measure import Samples

FORM = re.compile(r"\s*([^@<>=\s]+)\s*(?:@\s*([^<>=]+?)\s*)?([<>]=)\s*(\S+)\s*")


@dataclass(frozen=True)
class Tolerance:
    """A bound of a metric, in one scenario or in every one."""

    metric: str
    sense: str
    """``<=`` or ``>=``."""
    bound: float
    scenario: str = ""
    """Empty: in every scenario."""

    def __str__(self) -> str:
        return f"{self.metric}{f'@{self.scenario}' if self.scenario else ''}{self.sense}{self.bound:g}"

    @property
    def name(self) -> str:
        """What it bounds, without the bound."""
        return f"{self.metric}_{self.scenario}" if self.scenario else self.metric

    def scenarios(self, all_of_them: Sequence[str]) -> tuple[str, ...]:
        """Where it holds."""
        return (self.scenario,) if self.scenario else tuple(all_of_them)

    def kept(self, values: np.ndarray) -> np.ndarray:
        """Which values keep it; NaN does not."""
        with np.errstate(invalid="ignore"):
            return values <= self.bound if self.sense == "<=" else values >= self.bound

    def passes(self, samples: Samples) -> np.ndarray:
        """Which runs keep it wherever it holds."""
        where = self.scenarios(samples.scenarios)
        return np.all([self.kept(samples.metrics[s][self.metric]) for s in where], axis=0)


def tolerance(text: str) -> Tolerance:
    """A tolerance from its text.

    Raises:
        ValueRefused: it is none.
    """
    found = FORM.fullmatch(text)
    try:
        if found is None or not math.isfinite(bound := float(found[4])):
            raise ValueError
    except ValueError:
        raise ValueRefused(
            f"tolerance {text!r}: expected METRIC<=VALUE, METRIC>=VALUE or METRIC@SCENARIO<=VALUE"
        ) from None
    return Tolerance(found[1], found[3], bound, found[2] or "")


def tolerances(given: Iterable[str | Tolerance], job: Job) -> tuple[Tolerance, ...]:
    """Tolerances that a job can be judged by.

    Raises:
        NameUnknown: a metric or a scenario that the job does not have.
        ValueRefused: a text that is none; two tolerances that no run can keep together.
    """
    made = tuple(t if isinstance(t, Tolerance) else tolerance(t) for t in given)
    for t in made:
        job.check_metric(t.metric)
        if t.scenario and t.scenario not in job.where:
            raise NameUnknown(
                f"tolerance {t}: there is no scenario {t.scenario!r}{nearest(t.scenario, list(job.where))}"
            )
    for i, a in enumerate(made):
        for b in made[i + 1 :]:
            if a.metric != b.metric or a.sense == b.sense or not {*a.scenarios(job.where)} & {*b.scenarios(job.where)}:
                continue
            least, most = (a, b) if a.sense == ">=" else (b, a)
            if least.bound > most.bound:
                raise ValueRefused(f"the tolerances {a} and {b} contradict each other: no run can keep both")
    return made
