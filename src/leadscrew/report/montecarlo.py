"""The report of a Monte Carlo: ``report.html``, figures, every run, a summary, and the worst runs to run again."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.figures.formats import first_line, metric_unit
from leadscrew.figures.table import NOTHING, fixed, number, unit
from leadscrew.report.report import File, Part, Report, TextTable, Verbatim, head
from leadscrew.tune.montecarlo import MonteCarlo
from leadscrew.tune.parameter_drift import Crossing, Envelope
from leadscrew.tune.sensitivity import UNKNOWN, SobolIndex
from leadscrew.tune.statistics import Yield
from leadscrew.tune.worst import DIVERGED, Worst, write
from leadscrew.util import reading
from leadscrew.util.atomic import replace_folder, replaceable_folder
from leadscrew.util.errors import DataError
from leadscrew.util.escape import shell
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.report.montecarlo_figures import Bar, Picture
    from leadscrew.tune.montecarlo import MonteCarlo


EVEN = {"lhs": "a Latin hypercube is", "sobol": "Sobol points are"}
"""Samplings whose runs are not independent."""


def alike(found: MonteCarlo) -> str:
    """Says that all runs are the same run; nothing where they are not."""
    if not found.alike:
        return ""
    return (
        f"all {len(found)} runs are the same run, bit for bit: nothing is drawn and no noise reaches a metric, so "
        "there are no intervals; name what varies with --over"
    )


def independence(found: MonteCarlo) -> str:
    """On what the intervals rest; nothing where they rest on what was done."""
    if found.alike or not len(found.space) or found.method not in EVEN:
        return ""
    return (
        f"intervals are derived for independent runs; {EVEN[found.method]} more even than that, so they are as a rule "
        "too wide (--sampling random: independent runs)"
    )


def unknown(findings: Findings) -> str:
    """Which Sobol indices the runs do not tell; nothing where all are known."""
    rows = [s for s in findings.sobol if not (s.first_known and s.total_known)]
    if not rows:
        return ""
    names = ", ".join(dict.fromkeys(s.metric for s in rows))
    return (
        f"Sobol indices that are not known ({names}): their bootstrap interval is wider than ± {UNKNOWN:g}, as after a "
        f"few runs far from all others; take a larger N than {findings.points}"
    )


def missing(findings: Findings) -> str:
    """Which metrics have no Sobol indices because runs gave no value."""
    lost = {s.metric: s.without for s in findings.sobol if s.without}
    said = ", ".join(f"{metric} ({count})" for metric, count in lost.items())
    return f"no Sobol indices where runs gave no value: {said}" if lost else ""


def without_value(found: MonteCarlo) -> list[str]:
    """Why runs give no value of a metric, a sentence each; the reason is that of the first such run."""
    several = len(found.samples.scenarios) > 1
    return [
        f"{w.metric}{f' in {w.scenario}' if several else ''} has no value in {w.runs} of {len(found)} runs; "
        f"run {w.first}: {w.reason}"
        for w in found.without_value
    ]


def notes(findings: Findings) -> list[str]:
    """All of them."""
    said = (alike(findings.found), independence(findings.found), unknown(findings), missing(findings))
    return [s for s in said if s] + without_value(findings.found)


KIND = "leadscrew montecarlo"
"""By this, in its ``summary.json``, a folder is known to be ours to replace."""
SUMMARY = "summary.json"


def claimable(folder: str | Path) -> Path:
    """The folder, if a report may be written there: it does not exist, is empty, or holds an older report.

    Raises:
        DataError: it holds something else, or cannot be written.
    """
    return replaceable_folder(folder, _ours, "a Monte Carlo report")


def placed(folder: str | Path) -> AbstractContextManager[Path]:
    """A place to write to, which takes the place of ``folder`` at the end.

    Raises:
        DataError: see :func:`claimable`; or the disk refuses.
    """
    return replace_folder(folder, _ours, "a Monte Carlo report")


def _ours(folder: Path) -> bool:
    try:
        return reading.json_object(folder / SUMMARY).get("kind") == KIND
    except DataError:
        return False


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
        **head("montecarlo"),
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


# ---- on a terminal
SHOWN = (1, 5, 50, 95, 99)
"""Percents of the quantiles that a terminal shows."""
LOST = 3
"""Exit code where every run diverges."""


def report_of(findings: Findings, out: Path) -> Report:
    """The report of ``leadscrew montecarlo``, which is written to ``out``."""
    found, cost = findings.found, findings.cost
    several = len(found.samples.scenarios) > 1
    memory = "" if cost["peak_memory_mib"] is None else f", {cost['peak_memory_mib']:.0f} MiB at most"
    lost, verdict = bool(found.diverged.all()), ""
    if lost:
        first = min(float(at.min()) for at in (v[v == v] for v in found.samples.diverged_at.values()) if len(at))
        verdict = f"all {len(found)} runs diverged, the first at {first:g} s"
    return Report(
        {**summary(findings, out), "report": str(out / "report.html")},
        parts=[
            _spread_table(findings, several),
            *without_value(found),
            _yield_table(findings),
            *_sensitivity_parts(findings, several),
            *_life_parts(findings),
            *([Verbatim(_again(findings, out))] if findings.worst else []),
            f"{cost['runs']} runs in {cost['seconds']:.2f} s, {cost['runs_per_s']:,.0f} runs/s on {cost['crew']}"
            f"{memory}; {int(found.diverged.sum())} diverged",
        ],
        verdict=verdict,
        notes=[n for n in (alike(found),) if n],
        files=[File("", out / "report.html", "the report")],
        code=LOST if lost else 0,
    )


def _spread_table(findings: Findings, several: bool) -> TextTable:
    rows = []
    for s in findings.found.spreads:
        at = {q.percent: number(q.value) for q in s.quantiles}
        where = [s.scenario] if several else []
        without = str(s.diverged + s.without or "")
        rows.append([s.metric, *where, *(at[p] for p in SHOWN), unit(findings.unit(s.metric)), without])
    where = ["scenario"] if several else []
    heads = ["metric", *where, *(f"{p} %" for p in SHOWN), "unit", "without"]
    return TextTable(heads, rows, [False, *[False] * several, *[True] * len(SHOWN), False, True])


def _yield_table(findings: Findings) -> TextTable:
    found = findings.found
    rows = [[text, *_yield(y)] for text, y in found.yields.items()]
    rows.append(["all together" if rows else "did not diverge", *_yield(found.joint)])
    return TextTable(["tolerance", "passed", "yield", "95 % interval"], rows, [False, True, True, False])


def _yield(found: Yield) -> list[str]:
    part = [f"{number(100.0 * x)} %" for x in (found.value, found.low, found.high)]
    ends = f"{part[1]} to {part[2]}" if found.low == found.low else NOTHING
    return [f"{found.passed} of {found.runs}", part[0], ends]


def _sensitivity_parts(findings: Findings, several: bool) -> Iterator[Part]:
    """Which runs fail, rank correlations, Sobol indices; each where there are any."""
    where = ["scenario"] if several else []
    rows = [
        [f.tolerance, f.key, fixed(f.larger, 3), f"{fixed(f.larger_low, 3)} to {fixed(f.larger_high, 3)}",
         f"{number(f.low)} to {number(f.high)}", f"{f.failed} of {f.inside} fail"]
        for f in findings.found.failures
    ]  # fmt: skip
    if rows:
        heads = ["which runs fail", "parameter", "larger in failed", "95 % interval", "all failures within", "there"]
        yield TextTable(heads, rows, [False, False, True, False, False, False])
    rows = [
        [c.metric, *([c.scenario] if several else []), c.key, fixed(c.value, 3),
         f"{fixed(c.low, 3)} to {fixed(c.high, 3)}", fixed(c.partial, 3)]
        for c in findings.found.correlations
        if c.value == c.value
    ]  # fmt: skip
    if rows:
        heads = ["metric", *where, "parameter", "rank correlation", "95 % interval", "partial"]
        yield TextTable(heads, rows, [*[False] * (2 + several), True, False, True])
    rows = [
        [s.metric, *([s.scenario] if several else []), s.key,
         f"{s.first:.3f} ± {s.first_width:.3f}" if s.first_known else "not known",
         f"{s.total:.3f} ± {s.total_width:.3f}" if s.total_known else "not known"]
        for s in findings.sobol
        if s.first == s.first
    ]  # fmt: skip
    if rows:
        yield TextTable.words(["metric", *where, "parameter", "Sobol, first order", "total"], rows)
    yield from filter(None, (unknown(findings), missing(findings)))


def _life_parts(findings: Findings) -> Iterator[Part]:
    life, end = findings.envelope, findings.crossing
    if life is None or end is None:
        return
    rows = [[number(at, 3), *_yield(y)] for at, y in zip(life.life, life.yields, strict=True)]
    yield TextTable(["life", "passed", "yield", "95 % interval"], rows, [True, True, True, False])
    level = f"{100.0 * end.level:g} %"
    if end.life != end.life:
        yield f"the yield does not fall below {level} within this life"
    else:
        last = "beyond this life" if end.high != end.high else number(end.high)
        span = "" if end.low != end.low else f" (95 %: {number(end.low)} to {last})"
        yield f"the yield falls below {level} at {number(end.life)} of the life{span}"


def _again(findings: Findings, out: Path) -> Iterator[str]:
    """The commands that run the worst again."""
    yield "The worst runs, to run again:"
    for w in findings.worst:
        what = f"{w.of} at {number(w.value)} s" if w.of == DIVERGED else f"{w.of} {number(w.value)}"
        yield f"  {findings.replay(w, out)}   # run {w.run}, {what}"


# ---- the folder
def write_report(findings: Findings, folder: str | Path, figures: bool = True) -> Path:
    """Writes the folder beside its place, then puts it there; a report of ours that is there is replaced.

    Raises:
        DataError: the folder holds something else, or the disk refuses.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    target = Path(folder)
    with placed(target) as beside:
        write(findings.found, findings.worst, beside / "worst")
        pq.write_table(pa.table(findings.found.samples.as_columns()), beside / "samples.parquet")
        said = summary(findings, target)
        drawn = []
        for picture in pictures(findings) if figures else ():
            from leadscrew.report.html import embedded
            from leadscrew.report.montecarlo_figures import saved

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

    from leadscrew.report import montecarlo_figures as draw
    from leadscrew.report.montecarlo_figures import failure_pictures

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

    from leadscrew.report import montecarlo_figures as draw

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


def percent(part: float | None) -> str:
    """A part of one as percents."""
    return number(None if part is None else 100.0 * part)


def render(findings: Findings, data: Mapping[str, Any], folder: Path, drawn: Sequence[tuple[str, str, str]]) -> str:
    """The page, from what the summary says; ``drawn`` are name, caption and source of each figure."""
    from leadscrew.report.folder import manifest
    from leadscrew.report.html import template

    made = manifest(findings.found.wall_s)
    made.pop("wall time of the study")
    return template("montecarlo.html.j2", number=number, percent=percent).render(
        said=data,
        title=f"{Path(str(data['study'])).name} under {data['controller']}" if data["controller"] else data["study"],
        several=len(data["scenarios"]) > 1,
        groups=[
            ("Distributions", [d for d in drawn if d[0] in findings.shown]),
            ("Which runs fail", [d for d in drawn if d[0].startswith("fails_")]),
            ("Sensitivity", [d for d in drawn if d[0] in ("sensitivity", "sobol")]),
            ("Wear", [d for d in drawn if d[0].startswith("life_") and d[0] not in findings.shown]),
        ],
        independence=independence(findings.found),
        alike=alike(findings.found),
        without=without_value(findings.found),
        sobol_notes=[s for s in (unknown(findings), missing(findings)) if s],
        keys=list(findings.found.space.keys),
        folder=folder,
        command=findings.command,
        manifest={**findings.cost, **made},
        level=findings.level,
        shown=findings.shown,
    )
