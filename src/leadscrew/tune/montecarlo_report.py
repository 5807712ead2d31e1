"""The report of a Monte Carlo: ``report.html``, figures, every run, a summary, and the worst runs to run again."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.escape import shell
from leadscrew.report.strict import strict
from leadscrew.report.tables import first_line, metric_unit
from leadscrew.tune.montecarlo import MonteCarlo
from leadscrew.tune.montecarlo_folder import KIND, SUMMARY, placed
from leadscrew.tune.montecarlo_notes import notes, unknown
from leadscrew.tune.sensitivity import SobolIndex
from leadscrew.tune.wear import Crossing, Envelope
from leadscrew.tune.worst import Worst, write

if TYPE_CHECKING:
    from leadscrew.tune.montecarlo_figures import Bar, Picture

SCHEMA_VERSION = 1


@dataclass
class Findings:
    """All that a report says."""

    found: MonteCarlo
    worst: tuple[Worst, ...] = ()
    sobol: tuple[SobolIndex, ...] = ()
    points: int = 0
    """N of the Sobol indices."""
    envelope: Envelope | None = None
    level: float = 0.9
    """The yield below which a life ends."""
    cost: dict[str, Any] = field(default_factory=dict)
    """Who did it, how fast, how much memory."""
    command: str = ""

    def unit(self, metric: str) -> str:
        """A metric's unit."""
        loop = self.found.job.loop(self.found.job.where[0])
        return metric_unit(loop, loop.metrics[metric])

    def doc(self, metric: str) -> str:
        """What a metric is."""
        return first_line(self.found.job.loop(self.found.job.where[0]).metrics[metric].doc)

    @property
    def shown(self) -> tuple[str, ...]:
        """Metrics of which some run has a value."""
        return tuple(dict.fromkeys(s.metric for s in self.found.spreads if s.runs > s.diverged + s.without))

    @property
    def crossing(self) -> Crossing | None:
        """Where the yield falls below the level."""
        return None if self.envelope is None else self.envelope.crossing(self.level)

    def replay(self, row: Worst, folder: str | Path) -> str:
        """The command that runs one of the worst again."""
        return f"leadscrew simulate {shell(Path(folder) / 'worst' / row.file)}"


def summary(findings: Findings, folder: str | Path | None = None) -> dict[str, Any]:
    """The result as one JSON object; everything but ``cost`` is the same whoever did the runs."""
    found = findings.found
    origin = {k: v for k, v in found.job.of(found.job.where[0]).origin.items() if k != "scenario"}
    quantile = ("percent", "value", "low", "high")
    made = {
        "schema_version": SCHEMA_VERSION,
        "kind": KIND,
        "notes": notes(findings),
        **origin,
        "scenarios": list(found.job.where),
        "integration": found.job.integration,
        "duration_s": [found.job.seconds(s) for s in found.job.where],
        "runs": len(found),
        "sampling": found.method,
        "seed": found.seed,
        "over": {k: str(d) for k, d in found.space.items},
        "diverged": int(found.diverged.sum()),
        "metrics": [
            {**s._asdict(), "unit": findings.unit(s.metric),
             "quantiles": [dict(zip(quantile, q, strict=True)) for q in s.quantiles]}
            for s in found.spreads
        ],
        "metrics_without_value": [w._asdict() for w in found.without_value],
        "yields": [{"tolerance": t, **y._asdict()} for t, y in found.yields.items()],
        "joint": found.joint._asdict(),
        "correlations": [c._asdict() for c in found.correlations],
        "failures": [s._asdict() for s in found.failures],
        "sobol": [
            {**s._asdict(), "first_known": s.first_known, "total_known": s.total_known} for s in findings.sobol
        ],
        "wear": None if findings.envelope is None else _life(findings, findings.envelope),
        "worst": [
            {**w._asdict(), "file": f"worst/{w.file}", "command": folder and findings.replay(w, folder)}
            for w in findings.worst
        ],
        "cost": findings.cost,
    }  # fmt: skip
    said: dict[str, Any] = strict(made)
    return said


def _life(findings: Findings, envelope: Envelope) -> dict[str, Any]:
    return {
        "drifts": [str(w) for w in envelope.wears],
        "life": envelope.life,
        "yields": [y._asdict() for y in envelope.yields],
        "falls_below": envelope.crossing(findings.level)._asdict(),
        "metrics": [
            {
                "scenario": s.scenario,
                "metric": s.metric,
                "percents": [q.percent for q in s.quantiles],
                "values": envelope.band(s.scenario, s.metric),
                "low": [[q.low for q in step[i].quantiles] for step in envelope.spreads],
                "high": [[q.high for q in step[i].quantiles] for step in envelope.spreads],
                "diverged": [step[i].diverged for step in envelope.spreads],
                "without": [step[i].without for step in envelope.spreads],
            }
            for i, s in enumerate(envelope.spreads[0])
        ],
    }


def write_report(findings: Findings, folder: str | Path, figures: bool = True) -> Path:
    """Writes the folder beside its place, then puts it there; a report of ours that is there is replaced.

    Raises:
        DataError: the folder holds something else, or the disk refuses.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    from leadscrew.tune.montecarlo_page import render

    target = Path(folder)
    with placed(target) as beside:
        write(findings.found, findings.worst, beside / "worst")
        pq.write_table(pa.table(findings.found.samples.as_columns()), beside / "samples.parquet")
        said = summary(findings, target)
        drawn = []
        for picture in pictures(findings) if figures else ():
            from leadscrew.report.html import embedded
            from leadscrew.tune.montecarlo_figures import saved

            figure = picture.draw()
            saved(figure, beside / f"{picture.name}.png")
            drawn.append((picture.name, picture.caption, embedded(figure, picture.name)))
        page = render(findings, said, target, drawn)
        (beside / "report.html").write_text(page, encoding="utf-8", newline="\n")
        text = json.dumps(said, indent=1, allow_nan=False)
        (beside / SUMMARY).write_text(text, encoding="utf-8", newline="\n")
    return target


def pictures(findings: Findings) -> list[Picture]:
    """The figures of a report."""
    from functools import partial

    from leadscrew.tune import montecarlo_figures as draw
    from leadscrew.tune.failures_figure import failure_pictures

    found, made = findings.found, []
    for m in findings.shown:
        caption = f"{m}: {findings.doc(m)}"
        made.append(draw.Picture(m, caption, partial(draw.distribution, found, m, findings.unit(m))))
    if rows := _bars(findings, found.correlations, lambda c: (c.value, c.low, c.high, c.partial)):
        caption = "Rank correlation of each parameter with each metric, with 95 % intervals."
        arguments = (rows, "rank correlation", "partial", (-1.05, 1.05))
        made.append(draw.Picture("sensitivity", caption, partial(draw.bars, *arguments)))

    for name, caption, drawn in failure_pictures(found):
        made.append(draw.Picture(name, caption, drawn))

    def index(s: SobolIndex) -> Bar:
        total = (s.total, s.total - s.total_width, s.total + s.total_width) if s.total_known else (math.nan,) * 3
        return (*total, s.first if s.first_known else math.nan)

    if rows := _bars(findings, findings.sobol, index):
        left_out = " What is not known is not drawn." if unknown(findings) else ""
        caption = f"Sobol indices: the part of the variance that a parameter explains.{left_out}"
        ends = [b[2] for by_scenario in rows.values() for keys in by_scenario.values() for b in keys.values()]
        high = max(x for x in ends if x == x)
        arguments = (rows, "total index", "first order", (-0.08, min(1.5, max(1.1, 1.02 * high))))
        made.append(draw.Picture("sobol", caption, partial(draw.bars, *arguments)))
    if findings.envelope is not None:
        made += _life_pictures(findings, findings.envelope)
    return made


def _life_pictures(findings: Findings, envelope: Envelope) -> list[Picture]:
    from functools import partial

    from leadscrew.tune import montecarlo_figures as draw

    joined = ", ".join(str(w) for w in envelope.wears)
    values = {s.metric for step in envelope.spreads for s in step if s.runs > s.diverged + s.without}
    made = [
        draw.Picture(
            f"life_{m}",
            f"{m} over the life.",
            partial(
                draw.life_figure, envelope, m, findings.unit(m),
                [t for t in findings.found.tolerances if t.metric == m], joined,
            ),
        )
        for m in findings.found.metrics
        if m in values
    ]  # fmt: skip
    drawn = partial(draw.yield_figure, envelope, findings.level, joined)
    return [*made, draw.Picture("life_yield", "Yield against all tolerances over the life.", drawn)]


def _bars(findings: Findings, rows: Any, numbers: Any) -> dict[str, dict[str, dict[str, Bar]]]:
    """Rows by metric, scenario and parameter; metrics without any number are left out."""
    made: dict[str, dict[str, dict[str, Bar]]] = {}
    for row in rows:
        made.setdefault(row.metric, {}).setdefault(row.scenario, {})[row.key] = numbers(row)

    def any_number(by_scenario: Mapping[str, Mapping[str, Bar]]) -> bool:
        return any(not math.isnan(b[0]) for keys in by_scenario.values() for b in keys.values())

    return {m: found for m, found in made.items() if any_number(found)}
