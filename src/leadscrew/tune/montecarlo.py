"""Monte Carlo: many runs of a loop whose parameters are distributed; what its metrics then are.

Run ``k`` has the parameters of sample ``k`` and the noise of run ``k``: it is
``loop.using({key: columns[key][k]}).run(duration, replicate=k)``, wherever it was done.

Which runs fail: for every tolerance, how each parameter separates the runs that miss it from those that keep it.

A correlation is about all runs; a cliff in the tail of one parameter does not show in it. Here the failed runs are
set against the passed ones. ``larger`` is the probability that of one failed and one passed run the failed one has
the larger value (half of ties), the U of H. B. Mann and D. R. Whitney, Ann. Math. Statist. 18 (1947) 50, over the
number of pairs: 1/2 if the parameter says nothing, 1 or 0 if it decides alone. Its interval is R. G. Newcombe's
method 5, Statist. Med. 25 (2006) 559: the values whose own standard error (J. A. Hanley and B. J. McNeil, Radiology
143 (1982) 29, with the mean of both group sizes) puts them 1.96 of it away. It stays inside 0 to 1 and holds where
the groups do not overlap.

From ``low`` to ``high`` lie all failed runs: outside none failed. ``core_low`` to ``core_high`` is the range with the
fewest runs of all that holds 95 % of the failed ones.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel import validate
from leadscrew.kernel.parameters import nearest
from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.executors import Crew, Threads
from leadscrew.tune.job import Job, chunks_of, held
from leadscrew.tune.measure import Progress, Samples, measure, same_run
from leadscrew.tune.sensitivity import Z95, RankCorrelation, SobolIndex, rank_correlations, sobol
from leadscrew.tune.sensitivity import check as check_sobol
from leadscrew.tune.space import Given, Method, Space, check_method
from leadscrew.tune.statistics import Spread, Yield, clopper_pearson, spread, without_intervals, yielded
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

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


DIVERGED = "diverged"
"""Stands in the place of a tolerance for the runs that diverged in some scenario."""
CORE = 0.95
BINS = 10


class Separation(NamedTuple):
    """How one parameter separates failed from passed runs of one tolerance."""

    tolerance: str
    """Its text, or ``diverged``."""
    key: str
    failed: int
    passed: int
    larger: float
    """Probability that a failed run has the larger value."""
    larger_low: float
    larger_high: float
    low: float
    """Smallest value of a failed run."""
    high: float
    """Largest one."""
    inside: int
    """Runs from ``low`` to ``high``, failed or not."""
    core_low: float
    core_high: float
    core_inside: int
    core_failed: int


class Share(NamedTuple):
    """The part of failed runs among those of a parameter's values from ``start`` to ``end``."""

    start: float
    end: float
    failed: int
    runs: int
    value: float
    low: float
    high: float


def questions(found: MonteCarlo) -> dict[str, np.ndarray]:
    """Which runs fail, by tolerance; and which diverge. Only where some do and others do not."""
    asked = {str(t): ~t.passes(found.samples) for t in found.tolerances} | {DIVERGED: found.diverged}
    return {name: failed for name, failed in asked.items() if failed.any() and not failed.all()}


def separations(found: MonteCarlo) -> tuple[Separation, ...]:
    """Of every tolerance that some runs miss and others keep: each parameter, the one that separates best first."""
    rows: list[Separation] = []
    for name, failed in questions(found).items():
        made = [separation(x, failed, name, key) for key, x in found.samples.columns.items()]
        rows += sorted(made, key=lambda r: -abs(r.larger - 0.5))
    return tuple(rows)


def separation(values: np.ndarray, failed: np.ndarray, tolerance: str = "", key: str = "") -> Separation:
    """One parameter, one value a run, and which runs failed; some did and others did not."""
    theirs = np.sort(values[failed])
    m, n = len(theirs), int((~failed).sum())
    larger = larger_in(values, failed)
    ordered = np.sort(values)
    ends = float(theirs[0]), float(theirs[-1])
    core = core_of(theirs, ordered)
    held = int(np.count_nonzero((theirs >= core[0]) & (theirs <= core[1])))
    return Separation(
        tolerance, key, m, n, larger, *newcombe(larger, m, n), *ends, _between(ordered, *ends), *core,
        _between(ordered, *core), held,
    )  # fmt: skip


def larger_in(values: np.ndarray, failed: np.ndarray) -> float:
    """Probability that of one failed and one passed run the failed one has the larger value, half of ties."""
    from scipy.stats import rankdata

    m, n = int(failed.sum()), int((~failed).sum())
    pairs = float(rankdata(values)[failed].sum()) - 0.5 * m * (m + 1)
    return pairs / (m * n)


def newcombe(larger: float, m: int, n: int) -> tuple[float, float]:
    """The 95 % interval of such a probability from ``m`` and ``n`` runs."""
    from scipy.optimize import brentq

    if larger == 0.0:
        low, high = newcombe(1.0, n, m)
        return 1.0 - high, 1.0 - low
    more = 0.5 * (m + n) - 1.0

    def beyond(t: float) -> float:
        spread = t * (1.0 + more * ((1.0 - t) / (2.0 - t) + t / (1.0 + t))) / (m * n)
        # Where all pairs agree both sides have the factor 1 - t: without it one root is left.
        return 1.0 - t - Z95**2 * spread if larger == 1.0 else (t - larger) ** 2 - Z95**2 * (1.0 - t) * spread

    low = float(brentq(beyond, 0.0, larger, xtol=1e-12))
    return low, 1.0 if larger == 1.0 else float(brentq(beyond, larger, 1.0, xtol=1e-12))


def core_of(theirs: np.ndarray, ordered: np.ndarray) -> tuple[float, float]:
    """The range with the fewest runs that holds 95 % of the failed ones; both sorted, the narrowest of equals."""
    need = math.ceil(CORE * len(theirs) - 1e-9)
    starts, ends = theirs[: len(theirs) - need + 1], theirs[need - 1 :]
    inside = np.searchsorted(ordered, ends, "right") - np.searchsorted(ordered, starts, "left")
    at = np.lexsort((ends - starts, inside))[0]
    return float(starts[at]), float(ends[at])


def _between(ordered: np.ndarray, low: float, high: float) -> int:
    return int(np.searchsorted(ordered, high, "right") - np.searchsorted(ordered, low, "left"))


def shares(values: np.ndarray, failed: np.ndarray) -> list[Share]:
    """The part of failed runs in each tenth of a parameter's runs; by value where there are ten values or fewer."""
    different = np.unique(values)
    if len(different) <= BINS:
        return [_share(x, x, failed[values == x]) for x in different]
    # Ends are values that occur, so that equal values stay together and no part is empty.
    ends = np.unique(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1), method="inverted_cdf"))
    part = np.minimum(np.searchsorted(ends, values, "right") - 1, len(ends) - 2)
    return [_share(ends[i], ends[i + 1], failed[part == i]) for i in range(len(ends) - 1)]


def _share(start: float, end: float, failed: np.ndarray) -> Share:
    count, runs = int(failed.sum()), len(failed)
    return Share(float(start), float(end), count, runs, count / runs, *clopper_pearson(count, runs))


LARGEST = 2**31 - 1
"""Most runs: the noise has no more numbers."""


class WithoutValue(NamedTuple):
    """A metric that some runs of a scenario give no value for."""

    scenario: str
    metric: str
    runs: int
    """How many did not diverge and gave none."""
    first: int
    """Number of the first such run."""
    reason: str
    """Why it gave none in that run."""


@dataclass
class MonteCarlo:
    """The runs and what follows from them."""

    job: Job
    space: Space
    method: Method
    seed: int
    tolerances: tuple[Tolerance, ...]
    samples: Samples
    wall_s: float = 0.0
    """Seconds that the runs took, without those that a journal had already."""

    def __len__(self) -> int:
        return len(self.samples)

    @cached_property
    def spreads(self) -> tuple[Spread, ...]:
        """Percentiles of every metric in every scenario, metric by metric."""
        rows = spreads(self.samples, self.metrics)
        return tuple(map(without_intervals, rows)) if self.alike else rows

    @property
    def metrics(self) -> tuple[str, ...]:
        """The metrics that all scenarios have."""
        return self.job.metrics()

    @cached_property
    def yields(self) -> dict[str, Yield]:
        """The yield of each tolerance by its text."""
        return {str(t): yielded(t.passes(self.samples), alike=self.alike) for t in self.tolerances}

    @cached_property
    def passes(self) -> np.ndarray:
        """Which runs keep every tolerance and diverge nowhere."""
        return passes(self.samples, self.tolerances)

    @cached_property
    def joint(self) -> Yield:
        """The yield against all tolerances together; without any, of runs that did not diverge."""
        return yielded(self.passes, alike=self.alike)

    @cached_property
    def alike(self) -> bool:
        """Whether all runs are the same run: nothing drawn differs, and no noise made one bit of a difference."""
        return same_run(self.samples, self.space.keys)

    @cached_property
    def without_value(self) -> tuple[WithoutValue, ...]:
        """Metrics without a value in runs that did not diverge, each with the reason in the first such run."""
        found = []
        for scenario, metrics in self.samples.metrics.items():
            ran = np.isnan(self.samples.diverged_at[scenario])
            lost = {m: np.flatnonzero(np.isnan(v) & ran) for m, v in metrics.items()}
            firsts = {int(runs[0]) for runs in lost.values() if len(runs)}
            reasons = {
                k: self.job.reasons(scenario, {n: v[k] for n, v in self.samples.columns.items()}, k) for k in firsts
            }
            found += [
                WithoutValue(scenario, m, len(runs), int(runs[0]), reasons[int(runs[0])].get(m, ""))
                for m, runs in lost.items()
                if len(runs)
            ]
        return tuple(found)

    @cached_property
    def diverged(self) -> np.ndarray:
        """Which runs diverged in some scenario."""
        return ~kept_on(self.samples)

    @cached_property
    def correlations(self) -> tuple[RankCorrelation, ...]:
        """Of each parameter with each metric."""
        columns = self.samples.columns
        return tuple(
            row
            for m in self.metrics
            for s in self.samples.scenarios
            for row in rank_correlations(columns, self.samples.metrics[s][m], m, s)
        )

    @cached_property
    def failures(self) -> tuple[Separation, ...]:
        """How each parameter separates failed from passed runs, tolerance by tolerance."""
        return separations(self)


def spreads(samples: Samples, metrics: Sequence[str]) -> tuple[Spread, ...]:
    """Percentiles of metrics in every scenario, metric by metric."""
    found, lost = samples.metrics, samples.diverged_at
    return tuple(spread(s, m, found[s][m], lost[s]) for m in metrics for s in samples.scenarios)


def kept_on(samples: Samples) -> np.ndarray:
    """Which runs diverged in no scenario."""
    return np.all([np.isnan(at) for at in samples.diverged_at.values()], axis=0)


def passes(samples: Samples, wanted: Sequence[Tolerance]) -> np.ndarray:
    """Which runs keep every tolerance and diverge nowhere."""
    return np.all([kept_on(samples), *(t.passes(samples) for t in wanted)], axis=0)


@entry_point
def montecarlo(
    job: Job,
    over: Given | Space | None,
    runs: int,
    *,
    seed: int = 0,
    method: Method = "lhs",
    tolerances: Sequence[str | Tolerance] = (),
    crew: Crew | None = None,
    journal: Journal | str | Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> MonteCarlo:
    """Runs of a job with its parameters drawn from distributions; of the noise alone where none is given.

    Args:
        job: what runs.
        over: what varies: ``{key: (low, high)}``, distributions, or texts as on the command line.
        runs: how many, in every scenario.
        seed: of the samples; the noise has the seed of the job's experiment.
        method: ``lhs``, ``sobol`` or ``random``.
        tolerances: what a run must keep, see :func:`~leadscrew.tune.montecarlo.tolerance`.
        crew: who does the work; all cores unless given.
        journal: a folder for results as they come.
        resume: what the journal holds is not done again.
        progress: takes the runs that are done and all of them.

    Raises:
        LeadscrewError: a name that does not exist, a value that is refused, tolerances that contradict each other.
    """
    space = Space.of(over).checked(job.sheet(), "--over")
    wanted = check(job, runs, tolerances)
    check_method(method)
    kept = opened(journal, question(job, space, runs, seed, method), resume)
    began = time.perf_counter()
    columns = drawn(job, space, runs, seed, method)
    samples = measure(job, columns, crew or Threads(), journal=kept, progress=progress)
    samples.columns = {k: samples.columns[k] for k in space.keys}
    return MonteCarlo(job, space, method, seed, wanted, samples, time.perf_counter() - began)


def opened(journal: Journal | str | Path | None, asked: dict[str, Any], resume: bool) -> Journal | None:
    """The journal of a question, where a folder is given for it."""
    return Journal(journal, asked, resume) if isinstance(journal, str | Path) else journal


def check(job: Job, runs: int, given: Sequence[str | Tolerance] = ()) -> tuple[Tolerance, ...]:
    """The tolerances, after everything was looked at that can be refused before the first run."""
    validate.whole("runs", runs, 1, LARGEST)
    for scenario in job.where:
        job.loop(scenario).periods(job.seconds(scenario))
    return tolerances(given, job)


def drawn(job: Job, space: Space, runs: int, seed: int, method: Method) -> dict[str, np.ndarray]:
    """What varies, one value a run; where nothing does, a parameter that stays at its own value."""
    return space.sample(runs, seed, method) if len(space) else held(job, runs)


def question(job: Job, space: Space, runs: int, seed: int, method: Method, **more: Any) -> dict[str, Any]:
    """What a journal of a Monte Carlo is about."""
    asked = {"kind": "montecarlo", "job": job.mark, "runs": runs, "seed": seed, "sampling": method}
    return {**asked, "over": [f"{k}={d!r}" for k, d in space.items], **more}


def asked_of(found: MonteCarlo, **more: Any) -> dict[str, Any]:
    """What a journal of further runs of a Monte Carlo is about."""
    return question(found.job, found.space, len(found), found.seed, found.method, **more)


def pieces(job: Job, columns: dict[str, np.ndarray]) -> int:
    """How many numbers of a journal some runs take."""
    return len(chunks_of(job, columns))


def sobol_indices(
    found: MonteCarlo,
    count: int,
    *,
    crew: Crew | None = None,
    journal: Journal | str | Path | None = None,
    resume: bool = False,
    start: int = 0,
    progress: Progress | None = None,
) -> tuple[SobolIndex, ...]:
    """First-order and total indices of each varied parameter, from ``count (parameters + 2)`` runs in every scenario.

    ``crew``, ``journal`` and ``resume`` are those of :func:`~leadscrew.tune.montecarlo.montecarlo`; ``start`` is the
    first number in a journal of several rounds.

    Raises:
        ValueRefused: nothing varies, or ``count`` is no power of two.
        LeadscrewError: SALib is not installed.
    """
    check_sobol(len(found.space), count)
    kept = opened(journal, asked_of(found, sobol=count), resume)

    def evaluate(unit: np.ndarray) -> Mapping[tuple[str, str], np.ndarray]:
        columns = found.space.values(unit)
        samples = measure(found.job, columns, crew or Threads(), journal=kept, start=start, progress=progress)
        return {(m, s): samples.metrics[s][m] for m in found.metrics for s in samples.scenarios}

    return sobol(evaluate, found.space.keys, count, found.seed)
