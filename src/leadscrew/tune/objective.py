"""What a search wants: goals to minimise and constraints to keep, over all sampled plants and scenarios.

As text, as the command line has it:

==============================  ======================================================================================
``METRIC``                      the worst case over all plants and scenarios
``STATISTIC:METRIC``            ``worst``, ``mean``, ``median``, or ``p95`` (any percentile from p1 to p99)
``METRIC@SCENARIO``             in one scenario only
``[...]METRIC[...]<=VALUE``     a constraint from above; ``>=`` from below, where the worst case is the smallest value
==============================  ======================================================================================

A run **fails** if it diverged or if the metric could not judge it (NaN: it never settled). A goal or a constraint with
a failed run is worth infinity. So that a search still finds its way, it does not see infinity but the number of failed
runs: whoever has fewer is better, whatever else. Between equals the sum of the missed constraints decides, each
squashed to ``x / (1 + x)`` with ``x = (value - bound) / |bound|`` over the runs that did not fail; and only between
settings that miss nothing the goal. A value that exceeds its bound by less than a millionth of a millionth of it counts
as on it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.tune.job import Job
from leadscrew.tune.measure import Samples
from leadscrew.util.errors import NameUnknown, ValueRefused

STATISTICS = ("worst", "mean", "median")
SLACK = 1e-12
"""Relative amount by which a bound may be exceeded: the last bits of a time that is a multiple of the period."""
_GOAL = re.compile(r"(?:(?P<statistic>[^:@]*):)?(?P<metric>[^:@]+)(?:@(?P<scenario>[^:@]+))?")
_CONSTRAINT = re.compile(r"(?P<left>.*?)(?P<sense><=|>=)(?P<right>.*)", re.DOTALL)


@dataclass(frozen=True)
class Goal:
    """A metric to minimise."""

    metric: str
    statistic: str = "worst"
    """Over plants and scenarios: ``worst``, ``mean``, ``median``, ``p1`` to ``p99``."""
    scenario: str = ""
    """Empty for all."""

    def __post_init__(self) -> None:
        percentile = re.fullmatch(r"p([1-9]\d?)", self.statistic)
        if self.statistic not in STATISTICS and not percentile:
            raise NameUnknown(
                f"{self.metric}: there is no statistic {self.statistic!r}; known: {', '.join(STATISTICS)}, p1 to p99"
            )

    @property
    def upper(self) -> bool:
        """Whether small values are good."""
        return True

    def check(self, job: Job) -> None:
        """Refuses a metric or a scenario that the job does not have.

        Raises:
            NameUnknown: names the nearest.
        """
        job.check_metric(self.metric)
        if self.scenario and self.scenario not in job.where:
            raise NameUnknown(f"{self}: no run is in a scenario {self.scenario!r}{nearest(self.scenario, job.where)}")  # type: ignore[arg-type]

    def values(self, samples: Samples) -> np.ndarray:
        """The metric of its scenarios, ``[scenario, run]``; NaN where a run failed."""
        at = [i for i, s in enumerate(samples.scenarios) if self.scenario in ("", s)]
        lost = np.array([samples.diverged_at[samples.scenarios[i]] for i in at])
        return np.where(np.isfinite(lost), np.nan, samples.metric(self.metric)[at])

    def over(self, values: np.ndarray) -> np.ndarray:
        """The statistic over the last axis, failed runs left out; NaN where all failed."""
        judged = ~np.isnan(values)
        some = judged.any(axis=-1)
        filled = np.where(some[..., None], values, 0.0)
        if self.statistic == "worst":
            found = np.nanmax(filled, axis=-1) if self.upper else np.nanmin(filled, axis=-1)
        elif self.statistic == "mean":
            found = np.nanmean(filled, axis=-1)
        else:
            percent = 50.0 if self.statistic == "median" else float(self.statistic[1:])
            found = np.nanpercentile(filled, percent if self.upper else 100.0 - percent, axis=-1)
        return np.where(some, found, np.nan)

    def __str__(self) -> str:
        return f"{self.statistic}:{self.metric}{f'@{self.scenario}' if self.scenario else ''}"


@dataclass(frozen=True)
class Constraint(Goal):
    """A metric to keep on one side of a bound."""

    at_most: bool = True
    bound: float = math.nan

    def __post_init__(self) -> None:
        super().__post_init__()
        if not math.isfinite(self.bound):
            raise ValueRefused(f"{self}: the bound must be a finite number")

    @property
    def upper(self) -> bool:
        """Whether small values are good."""
        return self.at_most

    def met(self, value: np.ndarray | float) -> np.ndarray:
        """Whether values keep the bound; NaN does not."""
        return self.missed(value) <= 0.0

    def missed(self, value: np.ndarray | float) -> np.ndarray:
        """By how much values miss the bound; not above 0 where they keep it, NaN stays NaN."""
        by = np.asarray(value) - self.bound if self.at_most else self.bound - np.asarray(value)
        return np.asarray(by - SLACK * abs(self.bound))

    def __str__(self) -> str:
        return f"{super().__str__()}{'<=' if self.at_most else '>='}{self.bound:g}"


def goal(text: str | Goal) -> Goal:
    """A goal from its text.

    Raises:
        ValueRefused, NameUnknown: it is none; says what is expected.
    """
    if isinstance(text, Goal):
        return text
    found = _GOAL.fullmatch(text.strip())
    if found is None or "<" in text or ">" in text:
        raise ValueRefused(f"{text!r}: expected METRIC, STATISTIC:METRIC, or either with @SCENARIO")
    return Goal(*_parts(found))


def constraint(text: str | Constraint) -> Constraint:
    """A constraint from its text.

    Raises:
        ValueRefused, NameUnknown: it is none; says what is expected.
    """
    if isinstance(text, Constraint):
        return text
    split = _CONSTRAINT.fullmatch(text.strip())
    found = _GOAL.fullmatch(split["left"].strip()) if split else None
    if split is None or found is None:
        raise ValueRefused(f"{text!r}: expected METRIC<=VALUE or METRIC>=VALUE, with STATISTIC: before or @SCENARIO")
    try:
        bound = float(split["right"])
    except ValueError:
        raise ValueRefused(f"{text!r}: {split['right'].strip()!r} is not a number") from None
    return Constraint(*_parts(found), split["sense"] == "<=", bound)


def _parts(found: re.Match[str]) -> tuple[str, str, str]:
    statistic = "worst" if found["statistic"] is None else found["statistic"].strip()
    return found["metric"].strip(), statistic, (found["scenario"] or "").strip()


def contradiction(constraints: Sequence[Constraint]) -> str:
    """The first two constraints that no number can keep both, in words; empty where there are none."""
    for a in constraints:
        for b in constraints:
            same = (a.metric, a.statistic, a.scenario) == (b.metric, b.statistic, b.scenario)
            if same and a.at_most and not b.at_most and a.bound < b.bound:
                return f"{a} and {b} contradict each other: nothing can keep both"
    return ""


class Scores(NamedTuple):
    """What settings are worth, ``[setting, ...]``."""

    goals: np.ndarray
    """``[setting, goal]``; infinite where a run failed."""
    bounded: np.ndarray
    """``[setting, constraint]``: the values that the constraints are about; infinite, on the bad side, where a run
    failed."""
    failed: np.ndarray
    """Runs that diverged or that some goal or constraint could not judge."""
    objectives: np.ndarray
    """``[setting, goal]``, finite: what a search minimises."""
    violations: np.ndarray
    """``[setting, 1 + constraint]``, finite, 0 where nothing is missed: what a search brings to 0 first."""
    diverged: np.ndarray
    """Runs that diverged."""

    @property
    def violation(self) -> np.ndarray:
        """The sum of the violations of each setting."""
        return np.asarray(self.violations.sum(axis=1))


def score(samples: Samples, plants: int, goals: Sequence[Goal], constraints: Sequence[Constraint]) -> Scores:
    """What the settings of a population are worth; the runs are ``setting 0 on every plant, setting 1 ...``."""
    runs = len(samples)
    lost = np.isfinite(np.array(list(samples.diverged_at.values())))
    fails = lost.copy()
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for wanted in (*goals, *constraints):
        values = wanted.values(samples)
        at = [i for i, s in enumerate(samples.scenarios) if wanted.scenario in ("", s)]
        fails[at] |= np.isnan(values)
        shaped = _by_setting(values, plants)
        found.append((wanted.over(shaped), np.isnan(shaped).any(axis=1)))
    count = runs // plants
    failed = _by_setting(fails.astype(float), plants).sum(axis=1)
    g = len(goals)
    exact = [
        np.where(bad, math.inf if w.upper else -math.inf, value)
        for w, (value, bad) in zip((*goals, *constraints), found, strict=True)
    ]
    objectives = [np.nan_to_num(value, nan=0.0) for value, _ in found[:g]]
    missed = [
        _squashed(np.nan_to_num(w.missed(v), nan=0.0), w.bound)
        for w, (v, _) in zip(constraints, found[g:], strict=True)
    ]
    weight = len(constraints) + 1.0
    return Scores(
        _columns(exact[:g], count), _columns(exact[g:], count), failed.astype(int),
        _columns(objectives, count), _columns([weight * failed, *missed], count),
        _by_setting(lost.astype(float), plants).sum(axis=1).astype(int),
    )  # fmt: skip


def _squashed(missed: np.ndarray, bound: float) -> np.ndarray:
    x = np.maximum(missed, 0.0) / (abs(bound) or 1.0)
    return np.where(np.isinf(x), 1.0, x / (1.0 + np.where(np.isinf(x), 0.0, x)))


def _by_setting(values: np.ndarray, plants: int) -> np.ndarray:
    """``[scenario, run]`` as ``[setting, scenario and plant]``."""
    scenarios, runs = values.shape
    return values.reshape(scenarios, runs // plants, plants).transpose(1, 0, 2).reshape(runs // plants, -1)


def _columns(columns: Sequence[np.ndarray], rows: int) -> np.ndarray:
    return np.column_stack(columns) if columns else np.zeros((rows, 0))
