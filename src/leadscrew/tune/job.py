"""What runs somewhere: a loop told by plain data, and a chunk of its runs.

A job can be sent to another process or machine: it holds names and numbers only, and builds its loops where it runs. A
run has the same bits wherever, beside whatever other runs, and in whatever chunk it is done: run ``k`` of a scenario
is ``loop.using({key: values[k]}).run(duration, replicate=first + k)``.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.experiment import Experiment
from leadscrew.kernel.parameters import ParameterSpec, nearest
from leadscrew.util.errors import NameUnknown, ValueRefused, entry_point

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop

DIVERGED = "diverged_at"
"""The key under which a result says when a run diverged, NaN where it did not."""


class Chunk(NamedTuple):
    """Some runs of a job in one scenario."""

    scenario: str
    """Empty for a loop of one's own."""
    columns: dict[str, np.ndarray]
    """One value a run, by dotted key."""
    first: int
    """Number of the first run: its noise."""

    @property
    def runs(self) -> int:
        """How many runs."""
        return len(next(iter(self.columns.values())))


@entry_point
@dataclass(frozen=True, eq=False)
class Job:
    """A controller on a machine, in one or several scenarios."""

    experiment: Experiment
    """Study, controller, changes, seed, engine; its own scenario counts where ``scenarios`` is empty."""
    scenarios: tuple[str, ...] = ()
    duration_s: float | None = None
    """Seconds of every run; the scenario's own unless given."""

    def of(self, scenario: str) -> Experiment:
        """The experiment in one scenario."""
        changed = {"scenario": scenario} if scenario else {}
        given = {"duration_s": self.duration_s} if self.duration_s is not None else {}
        return replace(self.experiment, **changed, **given)  # type: ignore[arg-type]

    @cached_property
    def where(self) -> tuple[str, ...]:
        """The scenarios; one that is empty for a loop of one's own."""
        if self.scenarios:
            return self.scenarios
        return (self.experiment.with_first_scenario().scenario or "",)

    def loop(self, scenario: str) -> Loop:
        """The loop in one scenario, built once in a process.

        Raises:
            LeadscrewError: a name that does not exist, or a value that is refused.
        """
        return _loop(self, scenario)

    def compile(self, scenario: str) -> None:
        """Builds and compiles the loop: threads that begin together would do it at the same time."""
        loop = self.loop(scenario)
        engine = self.experiment.engine or loop.engine
        if engine != "python":
            loop.program.entry("lanes", engine)

    def sheet(self) -> dict[str, ParameterSpec]:
        """What may vary: the entries that the loops of all scenarios have."""
        first, *others = (self.loop(s).sheet for s in self.where)
        return {k: e for k, e in first.items() if all(k in sheet for sheet in others)}

    def metrics(self) -> tuple[str, ...]:
        """Metrics that the loops of all scenarios have."""
        first, *others = (self.loop(s).metrics for s in self.where)
        return tuple(m for m in first if all(m in names for names in others))

    def check_metric(self, name: str) -> None:
        """Refuses a metric that a loop does not have.

        Raises:
            NameUnknown: names the nearest.
        """
        if name not in self.metrics():
            raise NameUnknown(f"there is no metric {name!r}{nearest(name, list(self.metrics()))}")

    def seconds(self, scenario: str) -> float:
        """Seconds of a run."""
        return float(self.of(scenario).seconds())

    @property
    def integration(self) -> dict[str, dict[str, Any]]:
        """What integrates the plant in each scenario, see :attr:`leadscrew.Loop.integration`."""
        return {s: self.loop(s).integration for s in self.where}

    def run(self, chunk: Chunk, threads: int = 1) -> dict[str, np.ndarray]:
        """Metrics by name and ``diverged_at``, one value a run."""
        loop = self.loop(chunk.scenario)
        done = loop.batch(
            self.seconds(chunk.scenario), chunk.columns, runs=chunk.runs, threads=threads, first=chunk.first,
            engine=self.experiment.engine,
        )  # fmt: skip
        return {**done.metrics, DIVERGED: done.diverged_at}

    def reasons(self, scenario: str, values: Mapping[str, float], run: int) -> dict[str, str]:
        """Why metrics of one run have no value, by name; the run is done again, alone."""
        loop = self.loop(scenario)
        changes = typed(loop.sheet, values)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            alone = loop.using(changes).run(
                self.seconds(scenario), every=0, engine=self.experiment.engine, replicate=run
            )
        return alone.metrics_without_value

    @cached_property
    def mark(self) -> str:
        """What tells this job from others: a hash of its data, of the files that it names, and of its program."""
        loops = [self.loop(s) for s in self.where]
        said = {
            "origins": [self.of(s).origin for s in self.where],
            "seconds": [self.seconds(s) for s in self.where],
            "programs": [loop.program.name for loop in loops],
            "seeds": [loop.seed for loop in loops],
            "parameters": [{k: _number(e) for k, e in loop.sheet.items()} for loop in loops],
        }
        return hashlib.sha256(json.dumps(said, sort_keys=True, default=str).encode()).hexdigest()

    def __getstate__(self) -> dict[str, Any]:
        return {"experiment": self.experiment, "scenarios": self.scenarios, "duration_s": self.duration_s}

    @cached_property
    def _key(self) -> str:
        """What is asked, as text: arrays among the changes neither compare nor hash."""
        changes = [(k, np.asarray(v).tolist()) for k, v in self.experiment.changes.items()]
        asked = {**self.experiment.__dict__, "changes": changes}
        return repr((asked, self.scenarios, self.duration_s))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Job) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def typed(sheet: Mapping[str, ParameterSpec], values: Mapping[str, float]) -> dict[str, Any]:
    """Numbers as a file has them: whole numbers as such, choices by their names."""

    def of(entry: ParameterSpec, value: float) -> Any:
        return entry.check(value) if entry.choice is not None else int(value) if entry.type == "int" else float(value)

    return {k: of(sheet[k], v) for k, v in values.items()}


def _number(entry: ParameterSpec) -> Any:
    return entry.stored(entry.default) if entry.choice is not None else np.asarray(entry.default).tolist()


@lru_cache(maxsize=32)
def _loop(job: Job, scenario: str) -> Loop:
    loop = job.of(scenario).loop()
    if loop.continuous:
        raise ValueRefused("many runs need a control period; a continuous loop (period=None) runs one at a time")
    return loop


def chunks_of(job: Job, columns: Mapping[str, np.ndarray], first: int = 0) -> list[Chunk]:
    """Runs in all scenarios of a job as chunks; how they are cut depends on the job and the number of runs alone."""
    runs = len(next(iter(columns.values())))
    made = []
    for scenario in job.where:
        size = chunk_size(job, scenario, runs)
        for low in range(0, runs, size):
            part = {k: np.ascontiguousarray(v[low : low + size]) for k, v in columns.items()}
            made.append(Chunk(scenario, part, first + low))
    return made


PERIODS_A_CHUNK = 2_000_000
"""Control periods of a chunk, about: a tenth of a second of one core, long against what a message costs."""


def chunk_size(job: Job, scenario: str, runs: int) -> int:
    """Runs of a chunk: enough work to be worth a message, never so many that progress is coarse."""
    loop = job.loop(scenario)
    periods = max(1, loop.periods(job.seconds(scenario)))
    wanted = max(1, PERIODS_A_CHUNK // periods)
    size = max(64, -(-wanted // 64) * 64)
    return min(size, max(1, runs))


def held(job: Job, runs: int) -> dict[str, np.ndarray]:
    """A column that changes nothing, so that runs of the noise alone can be counted.

    Raises:
        ValueRefused: the loop has no number that is the same in all scenarios.
    """
    loops = [job.loop(s) for s in job.where]
    for key, entry in job.sheet().items():
        if entry.type == "float" and len({loop.sheet[key].default for loop in loops}) == 1:
            return {key: np.full(runs, entry.default)}
    raise ValueRefused("this loop has no parameter that could be held: name one that varies")
