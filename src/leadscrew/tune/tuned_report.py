"""The folder of a tuning: ``report.html``, ``tune.json``, figures, held-out runs, a controller file for each member."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew import controller_file, escape
from leadscrew.newfolder import appearing
from leadscrew.report.strict import strict
from leadscrew.report.tables import metric_unit, number
from leadscrew.tune import tuned_files
from leadscrew.tune.job import Job
from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import Constraint
from leadscrew.tune.tuned import Tuned

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]
"""A title, names of columns, rows."""


def units(job: Job) -> dict[str, str]:
    """The unit of each metric."""
    loop = job.loop(job.where[0])
    return {name: metric_unit(loop, metric) for name, metric in loop.metrics.items()}


def rows(tuned: Tuned, job: Job) -> list[list[str]]:
    """Goals and constraints: before, on the plants of the search, held out, bound, met on both."""
    found = []
    of = units(job)
    for wanted in (*tuned.goals, *tuned.constraints):
        key = str(wanted)
        values = [m.values[key] for m in (tuned.before_held_out, tuned.trained, tuned.held_out)]
        bound, met = "", ""
        if isinstance(wanted, Constraint):
            bound = f"{'≤' if wanted.at_most else '≥'} {number(wanted.bound)}"
            met = "yes" if all(wanted.met(v) for v in values[1:]) else "NO"
        name = key.split("<=")[0].split(">=")[0]
        found.append([name, of[wanted.metric].replace("1", "") if of[wanted.metric] == "1" else of[wanted.metric],
                      *map(number, values), bound, met])  # fmt: skip
    return found


COLUMNS = ("goal, constraint", "unit", "before, held out", "tuned, trained", "tuned, held out", "bound", "met")


def settings(tuned: Tuned) -> list[list[str]]:
    """What varied: before, found, range."""
    return [[k, number(tuned.present[k]), number(v), tuned.vary[k]] for k, v in tuned.values.items()]


def front_table(tuned: Tuned) -> tuple[list[str], list[list[str]]]:
    """The Pareto front: columns and rows."""
    goals = [str(g) for g in tuned.goals]
    columns = ["", *goals, *(f"{g}, held out" for g in goals), *tuned.vary]
    found = [
        [f"{i}{' taken' if m.chosen else ''}", *(number(m.trained.values[g]) for g in goals),
         *(number(m.held_out.values[g]) for g in goals), *(number(m.values[k]) for k in tuned.vary)]
        for i, m in enumerate(tuned.front, 1)
    ]  # fmt: skip
    return columns, found


def write(job: Job, tuned: Tuned, folder: str | Path) -> None:
    """Writes the folder, complete or not at all.

    Raises:
        DataError: it exists already, or cannot be written.
    """
    from leadscrew.tune.tuned_figures import figures

    with appearing(folder) as beside:
        drawn = figures(tuned, units(job))
        save_figures(drawn, beside)
        (beside / "tune.json").write_text(
            json.dumps(strict(tuned.as_dict()), indent=1, allow_nan=False) + "\n", "utf-8"
        )
        for name, samples in tuned.samples.items():
            parquet(samples, beside / f"held_out_{name}.parquet")
        if job.experiment.controller is not None:
            for i, member in enumerate(tuned.front, 1):
                file = tuned_files.controller_of(job, tuned, member.values)
                controller_file.write(beside / f"front_{i}.toml", file)
        tables: list[Table] = [
            ("Scores", COLUMNS, rows(tuned, job)),
            ("Setting", ("parameter", "before", "tuned", "range"), settings(tuned)),
        ]
        if tuned.front:
            tables.append(("Pareto front", *front_table(tuned)))
        said = (
            f"{tuned.used} of {tuned.budget} evaluations by {tuned.optimiser}, seed {tuned.seed}; "
            f"{', '.join(s for s in tuned.scenarios if s)}"
        )
        noted = [f"note: {n}" for n in tuned.notes]
        text = page(f"{tuned.controller or tuned.study}: tuning", [tuned.verdict(), *noted, said], tables, drawn)
        (beside / "report.html").write_text(text, "utf-8")


def save_figures(drawn: Mapping[str, Figure], folder: Path) -> None:
    """Figures as PNG."""
    for name, figure in drawn.items():
        figure.savefig(folder / f"{name}.png", dpi=130, metadata={"Software": None})


def parquet(samples: Samples, path: Path, more: Mapping[str, Any] | None = None) -> None:
    """Runs as a table."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({**samples.as_columns(), **(more or {})}), path)


def page(title: str, sentences: Sequence[str], tables: Sequence[Table], drawn: Mapping[str, Figure]) -> str:
    """A page that opens anywhere, offline."""
    from leadscrew.report import page as html

    parts = html.paragraphs(sentences)
    for name, columns, lines in tables:
        numbers = [_numbers([line[i] for line in lines]) for i in range(len(columns))]
        head = "".join(_cell("th", c, right) for c, right in zip(columns, numbers, strict=True))
        body = "".join(
            f"<tr>{''.join(_cell('td', c, right) for c, right in zip(line, numbers, strict=True))}</tr>"
            for line in lines
        )
        parts.append(f'<h2>{escape.html(name)}</h2><div class="wide"><table><tr>{head}</tr>{body}</table></div>')
    parts += [html.picture(figure, name, name) for name, figure in drawn.items()]
    return html.page(title, parts, style="td { white-space: nowrap; }")


def _numbers(texts: Sequence[str]) -> bool:
    """Whether a column holds numbers; it stands to the right then, its title too."""
    try:
        return bool([float(t) for t in texts if t])
    except ValueError:
        return False


def _cell(tag: str, text: str, right: bool) -> str:
    kind = ' class="n"' if right else ""
    return f"<{tag}{kind}>{escape.html(text)}</{tag}>"
