"""What ``leadscrew montecarlo`` does after its options are read."""

from __future__ import annotations

import shlex
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.cli.checkpoint_policy import Keeping
from leadscrew.cli.progress import Report, Stage, counting
from leadscrew.cli.subject import experiment_of, spread
from leadscrew.cli.values import parse
from leadscrew.kernel import validate
from leadscrew.report.montecarlo import Findings, claimable, write_report
from leadscrew.tune import montecarlo, sensitivity
from leadscrew.tune.executors import Crew, crew
from leadscrew.tune.job import Job
from leadscrew.tune.montecarlo import sobol_indices
from leadscrew.tune.parameter_drift import Envelope, envelope, wears
from leadscrew.tune.space import Space, check_method
from leadscrew.tune.worst import worst
from leadscrew.util.errors import ValueRefused
from leadscrew.util.system import peak_memory

if TYPE_CHECKING:
    from leadscrew.experiment import Experiment


@dataclass(frozen=True)
class Asked:
    """The options as they were given."""

    study: str
    controller: str | None
    scenarios: tuple[str, ...]
    over: tuple[str, ...]
    runs: int
    tolerances: tuple[str, ...]
    sampling: str
    sobol: int
    wears: tuple[str, ...]
    life: int
    level: float
    worst: int
    duration: float | None
    changes: tuple[str, ...]
    seed: int | None
    threads: int | None
    cluster: str | None
    out: Path | None
    journal: Path | None
    resume: bool
    figures: bool

    def command(self, resume: bool = False) -> str:
        """The command line that asks for this again."""
        flags: list[tuple[str, Any]] = [("-c", self.controller), *(("-s", s) for s in self.scenarios)]
        flags += [("--over", x) for x in self.over] + [("--runs", self.runs)]
        flags += [("--tolerance", x) for x in self.tolerances]
        flags += [("--sampling", self.sampling if self.sampling != "lhs" else None), ("--sobol", self.sobol or None)]
        flags += [("--wear", x) for x in self.wears]
        if self.wears:
            flags += [("--life", self.life), ("--level", f"{self.level:g}")]
        flags += [("--worst", self.worst if self.worst != 3 else None), ("--duration", self.duration)]
        flags += [("--set", x) for x in self.changes] + [("--seed", self.seed), ("--threads", self.threads)]
        flags += [("--cluster", self.cluster), ("-o", self.out), ("--journal", self.journal)]
        words = ["leadscrew", "montecarlo", self.study]
        words += [str(word) for flag, value in flags if value is not None for word in (flag, value)]
        words += [] if self.figures else ["--no-figures"]
        return shlex.join([*words, "--resume"] if resume else words)


class Counted:
    """Counts runs over all stages."""

    def __init__(self) -> None:
        self.done = self.before = self.total = 0

    def through(self, report: Report) -> Report:
        """A report that counts as well."""
        last = -1

        def counted(done: int, total: int) -> None:
            nonlocal last
            if last < 0:
                self.before += done
                self.total += total
                last = 0
            self.done += done - last
            last = done
            report(done, total)

        return counted


class Work:
    """Everything that is asked for, checked before the first run."""

    def __init__(self, asked: Asked) -> None:
        self.asked = asked
        self.count = Counted()
        experiment = self._experiment()
        self.job = Job(experiment, asked.scenarios, asked.duration)
        self.space = Space.of(spread(asked.study, asked.over)).checked(self.job.sheet(), "--over")
        self.seed = experiment.seed or 0
        self.method = check_method(asked.sampling)
        self.tolerances = montecarlo.check(self.job, asked.runs, asked.tolerances)
        self.wears = wears(asked.wears, self.job, self.space)
        validate.whole("--life", asked.life, 2, 10_000)
        validate.whole("--worst", asked.worst, 0, 10_000)
        if not 0.0 < asked.level < 100.0:
            raise ValueRefused(f"--level {asked.level:g}: allowed are percents between 0 and 100")
        if asked.sobol:
            sensitivity.check(len(self.space), asked.sobol)
        name = Path(experiment.study.rpartition(":")[2] or experiment.study).name
        self.out = claimable(asked.out if asked.out is not None else Path("report") / f"{name}_montecarlo")
        self.keeping = Keeping(self.out, asked.journal, asked.resume, "-o", self._kept)

    def _experiment(self) -> Experiment:
        asked = self.asked
        experiment = experiment_of(asked.study)
        given = {"controller": asked.controller, "seed": asked.seed}
        experiment = replace(experiment, **{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]
        if asked.changes:
            there = replace(experiment, scenario=asked.scenarios[0]) if asked.scenarios else experiment
            parsed = parse(asked.changes, there.with_first_scenario().settable())
            experiment = replace(experiment, changes={**experiment.changes, **parsed})
        return experiment

    def question(self) -> dict[str, Any]:
        """What the journal is about."""
        return montecarlo.question(
            self.job, self.space, self.asked.runs, self.seed, self.method, sobol=self.asked.sobol,
            wear=[repr(w) for w in self.wears], life=self.asked.life if self.wears else 0,
        )  # fmt: skip

    def done(self) -> Findings:
        """Runs everything and writes the report."""
        asked = self.asked
        began = time.perf_counter()
        with self.keeping, crew(asked.cluster, asked.threads) as workers, counting() as stage:
            self.keeping.open(self.question())
            stage("compiling")
            findings = self._runs(workers, stage)
            seconds = time.perf_counter() - began
            stage("writing the report")
            fresh = self.count.done - self.count.before
            findings.cost = {
                "crew": workers.name,
                "runs": fresh,
                "seconds": round(seconds, 3),
                "runs_per_s": round(fresh / seconds, 1),
                "peak_memory_mib": peak_memory(),
            }
            write_report(findings, self.out, asked.figures)
        return findings

    def _runs(self, workers: Crew, stage: Stage) -> Findings:
        asked, journal = self.asked, self.keeping.journal
        found = montecarlo.montecarlo(
            self.job, self.space, asked.runs, seed=self.seed, method=self.method, tolerances=self.tolerances,
            crew=workers, journal=journal, progress=self.count.through(stage("Monte Carlo")),
        )  # fmt: skip
        columns = montecarlo.drawn(self.job, self.space, asked.runs, self.seed, self.method)
        start = montecarlo.pieces(self.job, columns)
        indices: tuple[sensitivity.SobolIndex, ...] = ()
        if asked.sobol:
            report = self.count.through(stage("Sobol indices"))
            indices = sobol_indices(found, asked.sobol, crew=workers, journal=journal, start=start, progress=report)
            unit = sensitivity.points(len(self.space), asked.sobol, self.seed)
            start += montecarlo.pieces(self.job, self.space.values(unit))
        life: Envelope | None = None
        if self.wears:
            report = self.count.through(stage("wear"))
            life = envelope(
                found, self.wears, steps=asked.life, crew=workers, journal=journal, start=start, progress=report
            )
        return Findings(
            found, worst(found, asked.worst), indices, asked.sobol, life, asked.level / 100.0, command=asked.command()
        )

    def _kept(self) -> str:
        return f"{self.count.done} runs are kept in {self.keeping.at}; go on with: {self.asked.command(resume=True)}"
