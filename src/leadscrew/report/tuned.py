"""The folder of a tuning: page, ``tune.json``, pictures, held-out runs, a controller file for each of a front."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew import controller_file
from leadscrew.figures.formats import metric_unit
from leadscrew.figures.style import BLACK, BLUE, ORANGE, VERMILION
from leadscrew.figures.table import as_typed, number, unit
from leadscrew.report.report import File, Report, TextTable, head
from leadscrew.tune.job import Job
from leadscrew.tune.measure import Samples
from leadscrew.tune.objective import Constraint, Goal
from leadscrew.tune.tuned import Tuned, controller_of
from leadscrew.util import escape
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from leadscrew.figures.figure import Figure


def units(job: Job) -> dict[str, str]:
    """The unit of each metric."""
    loop = job.loop(job.where[0])
    return {name: metric_unit(loop, metric) for name, metric in loop.metrics.items()}


def score_table(tuned: Tuned, job: Job) -> TextTable:
    """Goals and constraints: before, on the plants of the search, held out, bound, met on both."""
    rows, of = [], units(job)
    for wanted in (*tuned.goals, *tuned.constraints):
        key = str(wanted)
        values = [m.values[key] for m in (tuned.before_held_out, tuned.trained, tuned.held_out)]
        bound, met = "", ""
        if isinstance(wanted, Constraint):
            bound = f"{'≤' if wanted.at_most else '≥'} {number(wanted.bound)}"
            met = "yes" if all(wanted.met(v) for v in values[1:]) else "NO"
        name = key.split("<=")[0].split(">=")[0]
        rows.append([name, unit(of[wanted.metric]), *map(number, values), bound, met])
    heads = ("goal, constraint", "unit", "before, held out", "tuned, trained", "tuned, held out", "bound", "met")
    return TextTable(heads, rows, [False, False, True, True, True, False, False], title="Scores")


def setting_table(tuned: Tuned) -> TextTable:
    """What varied: before, after, range."""
    rows = [[k, as_typed(tuned.present[k]), as_typed(v), tuned.vary[k]] for k, v in tuned.values.items()]
    return TextTable(("parameter", "before", "tuned", "range"), rows, [False, True, True, False], title="Setting")


def front_table(tuned: Tuned) -> TextTable:
    """The Pareto front."""
    goals = [str(g) for g in tuned.goals]
    heads = ["", *goals, *(f"{g}, held out" for g in goals), *tuned.vary]
    rows = [
        [f"{i}{' taken' if m.chosen else ''}", *(number(m.trained.values[g]) for g in goals),
         *(number(m.held_out.values[g]) for g in goals), *(as_typed(m.values[k]) for k in tuned.vary)]
        for i, m in enumerate(tuned.front, 1)
    ]  # fmt: skip
    return TextTable(heads, rows, [False, *[True] * (len(heads) - 1)], title="Pareto front")


def report_of(job: Job, tuned: Tuned, folder: Path | None, files: Sequence[Path]) -> Report:
    """The report of ``leadscrew tune``; ``folder`` and ``files`` are written."""
    name = tuned.controller or tuned.study
    setting = "the setting; a name wherever a controller is named"
    loop = "the whole loop, because more than the controller varied"
    written = [File("", path, what) for path, what in zip(files, (setting, loop), strict=False)]
    return Report(
        {**head("tune"), **tuned.as_dict(), "files": [str(f) for f in files]},
        parts=[
            f"{name}: {tuned.used} of {tuned.budget} evaluations by {tuned.optimiser}, seed {tuned.seed}; "
            f"{tuned.runs} runs in {tuned.wall_s:.3g} s, {tuned.crew}",
            setting_table(tuned),
            score_table(tuned, job),
            *([front_table(tuned)] if tuned.front else []),
        ],
        verdict=tuned.verdict(),
        notes=tuned.notes,
        files=[*written, File("report", folder, "the report: report.html, tune.json, figures, held-out runs")],
        code=0 if tuned.feasible and tuned.holds else 1,
    )


def write(job: Job, tuned: Tuned, folder: str | Path) -> None:
    """Writes the folder, complete or not at all.

    Raises:
        DataError: it exists already, or cannot be written.
    """
    with atomic_folder(folder) as beside:
        drawn = figures(tuned, units(job))
        save_figures(drawn, beside)
        (beside / "tune.json").write_text(
            json.dumps(strict(tuned.as_dict()), indent=1, allow_nan=False) + "\n", "utf-8"
        )
        for name, samples in tuned.samples.items():
            parquet(samples, beside / f"held_out_{name}.parquet")
        if job.experiment.controller is not None:
            for i, member in enumerate(tuned.front, 1):
                file = controller_of(job, tuned, member.values)
                controller_file.write(beside / f"front_{i}.toml", file)
        tables = [score_table(tuned, job), setting_table(tuned), *([front_table(tuned)] if tuned.front else [])]
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


def page(title: str, sentences: Sequence[str], tables: Sequence[TextTable], drawn: Mapping[str, Figure]) -> str:
    """A page that opens anywhere, offline."""
    from leadscrew.report import page as html

    parts = [*html.paragraphs(sentences), *map(html.table, tables)]
    parts += [html.picture(figure, name, name) for name, figure in drawn.items()]
    return html.page(title, parts, style="td { white-space: nowrap; }")


def figures(tuned: Tuned, units: dict[str, str] | None = None) -> dict[str, Figure]:
    """All of them, by name."""
    found = {"search": search(tuned, units or {}), "held_out": held_out(tuned, units or {})}
    return found | ({"front": front(tuned, units or {})} if tuned.front else {})


def _plain(ax: Axes) -> None:
    ax.grid(color="0.92", linewidth=0.6)
    ax.set_axisbelow(True)


def label(wanted: Goal, units: dict[str, str]) -> str:
    """What an axis is called."""
    of = unit(units.get(wanted.metric, ""))
    where = f"\n{wanted.scenario}" if wanted.scenario else ""
    return f"{wanted.statistic} {wanted.metric.replace('_', ' ')}{f' ({of})' if of else ''}{where}"


def search(tuned: Tuned, units: dict[str, str]) -> Figure:
    """The best goal after each population; a cross while it still missed a constraint."""
    from leadscrew.figures.figure import Figure

    count = len(tuned.goals)
    figure = Figure(figsize=(7.0, 1.0 + 2.4 * count), layout="constrained")
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    x = np.array([g.evaluations for g in tuned.history])
    missed = np.array([g.violation > 0.0 for g in tuned.history])
    for i, (ax, wanted) in enumerate(zip(axes, tuned.goals, strict=True)):
        y = np.array([g.best[i] for g in tuned.history])
        ax.plot(x[~missed], y[~missed], color=BLUE, linewidth=1.2, drawstyle="steps-post", marker="o", markersize=2.5,
                label="best so far")  # fmt: skip
        if missed.any():
            ax.plot(x[missed], y[missed], "x", color=VERMILION, markersize=5, label="misses a constraint")
        before = tuned.before.values[str(wanted)]
        if np.isfinite(before):
            ax.axhline(before, color=BLACK, linewidth=0.9, linestyle=":", label="before")
        ax.set_ylabel(label(wanted, units))
        _plain(ax)
    axes[0].legend(frameon=False, fontsize="small")
    axes[-1].set_xlabel("evaluations")
    axes[0].set_title(
        f"{escape.figure(str(tuned.controller))}: {tuned.optimiser}, seed {tuned.seed}", fontsize="medium"
    )
    return figure


def held_out(tuned: Tuned, units: dict[str, str]) -> Figure:
    """Every metric that counts, before and after, one dot a held-out plant; lines are bounds."""
    from leadscrew.figures.figure import Figure

    shown: list[tuple[str, str]] = []
    for wanted in (*tuned.goals, *tuned.constraints):
        for scenario in tuned.scenarios:
            if wanted.scenario in ("", scenario) and (wanted.metric, scenario) not in shown:
                shown.append((wanted.metric, scenario))
    rows = -(-len(shown) // 3)
    columns = -(-len(shown) // rows)  # as even as it goes: four are two and two, not three and one
    figure = Figure(figsize=(1.0 + 2.9 * columns, 0.6 + 2.9 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, (metric, scenario) in zip(axes, shown, strict=False):
        for at, (name, colour) in enumerate((("before", ORANGE), ("tuned", BLUE))):
            strip(ax, at, tuned.samples[name].metrics[scenario][metric], colour)
        for c in _bounds(tuned.constraints, metric, scenario):
            ax.axhline(c.bound, color=VERMILION, linewidth=1.0, linestyle="--")
            ax.annotate(f"{'≤' if c.at_most else '≥'} {c.bound:g}", (1.45, c.bound), color=VERMILION, fontsize="small",
                        ha="right", va="bottom" if c.at_most else "top")  # fmt: skip
        ax.margins(y=0.12)
        ax.set_xticks([0, 1], ["before", "tuned"])
        ax.set_xlim(-0.5, 1.5)
        of = unit(units.get(metric, ""))
        ax.set_ylabel(f"{metric.replace('_', ' ')}{f' ({of})' if of else ''}")
        ax.set_title(scenario, fontsize="small")
        _plain(ax)
    for ax in axes[len(shown) :]:
        ax.set_visible(False)
    figure.suptitle(f"{tuned.held_out_plants} held-out plant{'s' if tuned.held_out_plants > 1 else ''}; bar: median",
                    fontsize="medium")  # fmt: skip
    return figure


def _bounds(constraints: tuple[Constraint, ...], metric: str, scenario: str) -> list[Constraint]:
    return [c for c in constraints if c.metric == metric and c.scenario in ("", scenario)]


def strip(ax: Axes, at: float, values: np.ndarray, colour: Any, width: float = 0.28, flat: bool = False) -> None:
    """Dots side by side in the order of their number, a bar at the median; how many could not be judged in words.

    ``flat``: values lie along the x axis.
    """
    known = values[np.isfinite(values)]
    if len(known):
        across = at + width * (2.0 * (np.arange(len(known)) * 0.618034 % 1.0) - 1.0)
        middle, bar = [np.median(known)] * 2, [at - width, at + width]
        ax.plot(*((known, across) if flat else (across, known)), "o", color=colour, markersize=3.2, alpha=0.7,
                markeredgewidth=0.0)  # fmt: skip
        ax.plot(*((middle, bar) if flat else (bar, middle)), color=BLACK, linewidth=1.4)
    if len(known) < len(values):
        ax.annotate(
            f"{len(values) - len(known)} not judged", (0.98, at) if flat else (at, 0.02),
            xycoords=("axes fraction", "data") if flat else ("data", "axes fraction"), ha="right" if flat else "center",
            va="center" if flat else "bottom", fontsize="small", color=VERMILION,
        )  # fmt: skip


def front(tuned: Tuned, units: dict[str, str]) -> Figure:
    """Goals against each other: on the plants of the search and on held-out ones."""
    from leadscrew.figures.figure import Figure

    pairs = [(i, j) for i in range(len(tuned.goals)) for j in range(i + 1, len(tuned.goals))]
    figure = Figure(figsize=(0.6 + 5.4 * min(2, len(pairs)), 0.4 + 4.4 * -(-len(pairs) // 2)), layout="constrained")
    axes = figure.subplots(-(-len(pairs) // 2), min(2, len(pairs)), squeeze=False).ravel()
    trained, far = (
        np.array([[getattr(m, part).values[str(g)] for g in tuned.goals] for m in tuned.front])
        for part in ("trained", "held_out")
    )
    chosen = np.array([m.chosen for m in tuned.front])
    for ax, (i, j) in zip(axes, pairs, strict=False):
        for a, b in zip(trained, far, strict=True):
            ax.plot([a[i], b[i]], [a[j], b[j]], color="0.75", linewidth=0.7, zorder=1)
        ax.plot(trained[:, i], trained[:, j], "o", color=BLUE, markersize=4.5, label="plants of the search")
        ax.plot(
            far[:, i], far[:, j], "o", color=ORANGE, markersize=4.5, markerfacecolor="none", label="held-out plants"
        )
        ax.plot(trained[chosen, i], trained[chosen, j], "o", color=BLACK, markersize=10, markerfacecolor="none",
                label=f"taken: nearest to {'both' if len(tuned.goals) == 2 else 'all'} best")  # fmt: skip
        ax.set_xlabel(label(tuned.goals[i], units))
        ax.set_ylabel(label(tuned.goals[j], units))
        _plain(ax)
    for ax in axes[len(pairs) :]:
        ax.set_visible(False)
    axes[0].legend(frameon=False, fontsize="small")
    axes[0].set_title(f"{escape.figure(str(tuned.controller))}: Pareto front", fontsize="medium")
    return figure
