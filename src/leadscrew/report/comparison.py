"""A comparison: its tables, its picture, its folder."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path

from matplotlib.ticker import MaxNLocator

from leadscrew import controller_file
from leadscrew.figures import style
from leadscrew.figures.figure import Figure
from leadscrew.figures.formats import metric_unit
from leadscrew.figures.table import NOTHING, as_typed, number, unit
from leadscrew.report.report import Report, TextTable, head
from leadscrew.report.tuned import page, parquet, save_figures, strip
from leadscrew.tune import tuned
from leadscrew.tune.compare import Comparison, Contest, confidence
from leadscrew.tune.objective import Goal
from leadscrew.tune.statistics import Interval, per_plant
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.escape import file_name
from leadscrew.util.strict_json import strict


def colours(found: Comparison) -> dict[str, str]:
    """A colour for each contender: its own wherever it has one, none twice as far as they reach."""
    rest = [style.BLUE, style.ORANGE, style.GREEN, style.PURPLE, style.SKY, style.VERMILION]
    made: dict[str, str] = {}
    for r in found.results:
        wanted = style.colour(r.name)
        if wanted in made.values():
            wanted = next((c for c in rest if c not in made.values()), wanted)
        made[r.name] = wanted
    return made


def figure(found: Comparison, asked: Contest) -> Figure:
    """Every metric of every contender, one dot an unseen plant."""
    wanted: dict[str, Goal] = {}
    for w in (*found.goals, *found.constraints):
        wanted.setdefault(f"{w.metric}\n{w.scenario}", w)
    columns = min(2, len(wanted))
    count = -(-len(wanted) // columns)
    height = 0.9 + 0.42 * len(found.results)
    drawn = Figure(figsize=(2.0 + 4.0 * columns, 0.7 + (height + 0.4) * count), layout="constrained")
    axes = drawn.subplots(count, columns, squeeze=False)
    of = colours(found)
    loop = asked.contenders[0].job.loop(found.scenarios[0])
    for i, (ax, w) in enumerate(zip(axes.ravel(), wanted.values(), strict=False)):
        for at, r in enumerate(found.results):
            strip(ax, -at, per_plant(w, r.samples), of[r.name], flat=True)
        for c in found.constraints:
            if (c.metric, c.scenario) == (w.metric, w.scenario):
                ax.axvline(c.bound, color=style.VERMILION, linewidth=1.0, linestyle="--",
                           label=f"{'≤' if c.at_most else '≥'} {c.bound:g}")  # fmt: skip
                ax.legend(frameon=False, fontsize="small", loc="best")
        names = [r.name for r in found.results] if i % columns == 0 else ["" for _ in found.results]
        ax.set_yticks([-a for a in range(len(found.results))], names)
        ax.xaxis.set_major_locator(MaxNLocator(6))
        ax.set_ylim(0.5 - len(found.results), 0.5)
        of_metric = unit(metric_unit(loop, loop.metrics[w.metric]))
        where = f", {w.scenario}" if w.scenario else ", worst scenario" if len(found.scenarios) > 1 else ""
        ax.set_xlabel(f"{w.metric.replace('_', ' ')}{f' ({of_metric})' if of_metric else ''}{where}")
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
    for ax in axes.ravel()[len(wanted) :]:
        ax.set_visible(False)
    runs = "one run: nothing varies" if found.same_run else f"{found.unseen} plants that no tuning saw; bar: median"
    drawn.suptitle(runs, fontsize="medium")
    return drawn


def spread(interval: Interval) -> str:
    """A number with its interval."""
    if math.isnan(interval.low) and not math.isnan(interval.value):
        return number(interval.value)
    return f"{number(interval.value)} [{number(interval.low)}, {number(interval.high)}]"


def ranking_table(found: Comparison) -> TextTable:
    """The ranking."""
    rows = []
    goal = found.goals[0]
    key = f"{goal.metric}{f'@{goal.scenario}' if goal.scenario else ''}"
    for i, r in enumerate(found.results):
        effort = f"{r.tuned.used} evaluations" if r.tuned else "as it is"
        order = ""
        if i < len(found.pairs):
            pair = found.pairs[i]
            shown = "" if pair.shown else " (not shown)"
            order = "no spread" if math.isnan(pair.order) else f"{number(100 * pair.order, 3)} % of resamples{shown}"
        rank = str(i + 1) if r.standings[key].judged else NOTHING
        rows.append([rank, r.name, effort, f"{found.unseen - r.bad} of {found.unseen}",
                     spread(r.standings[key].mean), order])  # fmt: skip
    heads = ("rank", "controller", "effort", "plants kept", "first goal, mean [95 %]", "before the next one in")
    return TextTable(heads, rows, [True, False, False, True, False, False], title="Ranking")


def metric_table(found: Comparison) -> TextTable:
    """Every metric of every contender."""
    rows = [
        [key, unit(found.units.get(key, "")), r.name, spread(s.mean), spread(s.p95), number(s.worst),
         f"{s.judged} of {found.unseen}"]
        for key in found.results[0].standings
        for r, s in ((r, r.standings[key]) for r in found.results)
    ]  # fmt: skip
    heads = ("metric", "unit", "controller", "mean [95 %]", "95th percentile [95 %]", "worst seen", "judged")
    return TextTable(heads, rows, [False, False, False, False, False, True, True], title="Metrics")


def settings(found: Comparison) -> Iterator[str]:
    """What each tuned contender was run with."""
    for result in found.results:
        if result.tuned is not None:
            values = ", ".join(f"{k} = {as_typed(v)}" for k, v in result.tuned.values.items())
            yield f"{result.name}: {values}; {result.tuned.verdict()}"


def report_of(found: Comparison, asked: Contest) -> Report:
    """The report of ``leadscrew compare``."""
    bound = confidence(found)
    return Report(
        {**head("compare"), **found.as_dict()},
        parts=[ranking_table(found), metric_table(found), *settings(found)],
        verdict=" ".join([found.sentence(), *([f"{bound}."] if bound else [])]),
        notes=found.notes,
        page=lambda folder: write(found, asked, folder),
    )


def write(found: Comparison, asked: Contest, folder: str | Path) -> None:
    """Writes the folder, complete or not at all: page, JSON, picture, runs, a file for each tuned controller.

    Raises:
        DataError: it exists already, or cannot be written.
    """
    with atomic_folder(folder) as beside:
        drawn = {"compare": figure(found, asked)}
        save_figures(drawn, beside)
        text = json.dumps(strict(found.as_dict()), indent=1, allow_nan=False)
        (beside / "compare.json").write_text(text + "\n", "utf-8")
        jobs = {c.name: c.job for c in asked.contenders}
        for i, r in enumerate(found.results, 1):
            stem = file_name(f"{i}_{Path(r.name).name}")
            parquet(r.samples, beside / f"{stem}.parquet")
            if r.tuned is not None:
                controller_file.write(beside / f"{stem}.toml", tuned.controller_of(jobs[r.name], r.tuned))
        noted = [*filter(None, [confidence(found)]), *(f"note: {n}" for n in found.notes)]
        tables = [ranking_table(found), metric_table(found)]
        html = page("Comparison", [found.sentence().rstrip("."), *noted], tables, drawn)
        (beside / "report.html").write_text(html, "utf-8")
