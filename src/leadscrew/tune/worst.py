"""The worst runs as experiment files: ``leadscrew simulate FILE`` gives the very run again, bit for bit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew import names, toml_file
from leadscrew.experiment import SCHEMA_VERSION, Experiment
from leadscrew.figures.table import as_typed
from leadscrew.tune.job import typed
from leadscrew.tune.montecarlo import MonteCarlo
from leadscrew.util.atomic import atomic_write
from leadscrew.util.escape import file_name, one_line

DIVERGED = "diverged"


class Worst(NamedTuple):
    """One run among the worst."""

    of: str
    """The metric, ``METRIC_SCENARIO`` where a tolerance names one, or ``diverged``."""
    rank: int
    run: int
    scenario: str
    value: float
    """Of the metric, NaN where it has none; seconds at which it diverged."""

    @property
    def file(self) -> str:
        """Its file's name."""
        return file_name(f"{self.of}_{self.rank}") + ".toml"


def worst(found: MonteCarlo, count: int = 3) -> tuple[Worst, ...]:
    """The ``count`` worst runs against each tolerance (of each metric where there is none), and that diverged first.

    Worst is what lies furthest on the side of a tolerance that fails (the largest, without one); a run without a value
    is worse still, unless no run has one.
    """
    samples = found.samples
    rows: list[Worst] = []
    asked = [(t.name, t.metric, t.sense, t.scenarios(samples.scenarios)) for t in found.tolerances]
    for name, metric, sense, where in dict.fromkeys(asked or [(m, m, "<=", samples.scenarios) for m in found.metrics]):
        values = np.array([samples.metrics[s][metric] for s in where])
        lost = np.array([np.isfinite(samples.diverged_at[s]) for s in where])
        if np.isnan(values).all():
            continue
        badness = values if sense == "<=" else -values
        badness = np.where(lost, -np.inf, np.where(np.isnan(values), np.inf, badness))
        also = "_least" if sense == ">=" and (name, metric, "<=", where) in asked else ""
        for rank, (s, k) in enumerate(_largest(badness, min(count, int((~lost).sum())))):
            rows.append(Worst(f"{name}{also}", rank + 1, k, where[s], float(values[s, k])))
    at = np.array(list(samples.diverged_at.values()))
    for rank, (s, k) in enumerate(
        _largest(-np.where(np.isnan(at), np.inf, at), min(count, int((~np.isnan(at)).sum())))
    ):
        rows.append(Worst(DIVERGED, rank + 1, k, samples.scenarios[s], float(at[s, k])))
    return tuple(rows)


def _largest(values: np.ndarray, count: int) -> list[tuple[int, int]]:
    """Where the largest are, in order; the same on every machine."""
    flat = np.argsort(-values.ravel(), kind="stable")[:count]
    return [divmod(int(i), values.shape[1]) for i in flat]


def experiment(found: MonteCarlo, run: int, scenario: str) -> Experiment:
    """The experiment that is this very run; it knows controller files by their contents."""
    sheet = found.job.loop(scenario).sheet
    drawn = typed(sheet, {k: float(v[run]) for k, v in found.samples.columns.items()})
    asked = found.job.of(scenario)
    files = found.job.loop(scenario).origin.get("files", {})
    seconds = found.job.seconds(scenario)
    return replace(asked, changes={**asked.changes, **drawn}, duration_s=seconds, replicate=run, files=files)


def write(found: MonteCarlo, rows: tuple[Worst, ...], folder: str | Path) -> list[Path]:
    """Writes one experiment file a row.

    Raises:
        DataError: a file cannot be written.
    """
    made = []
    for row in rows:
        path = Path(folder) / row.file
        what = "diverged" if row.of == DIVERGED else row.of
        said = f"run {row.run} of {len(found)}: {what}{' at' if row.of == DIVERGED else ' ='} {as_typed(row.value)}"
        atomic_write(toml(experiment(found, row.run, row.scenario), said), path)
        made.append(path)
    return made


def toml(asked: Experiment, comment: str = "") -> str:
    """The experiment as the text of its file."""
    head: dict[str, Any] = {
        "schema_version": SCHEMA_VERSION,
        "study": names.absolute(asked.study),
        "controller": None if asked.controller is None else names.absolute(asked.controller),
        "scenario": asked.scenario or None,
        "duration": asked.duration_s,
        "engine": asked.engine,
        "seed": asked.seed,
        "replicate": asked.replicate,
    }
    table = {**head, "set": dict(asked.changes), "files": dict(asked.files)}
    return (f"# {one_line(comment)}\n" if comment else "") + toml_file.text(table)
