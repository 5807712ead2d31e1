"""The five published systems in a minute: for each a conclusion, a picture and three numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.table import NOTHING, number
from leadscrew.report.report import KeyNumber, Picture, Report, TextTable
from leadscrew.report.tables import first_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from leadscrew.kernel.run import Run
    from leadscrew.studies.study import Study


@dataclass(frozen=True)
class Pair:
    """A scenario under the law as printed and under the corrected one, and the number that compares them.

    Args:
        when: the scenario in words, to begin a sentence with.
        command: signal that is followed; empty where the result should be zero.
        result: signal that follows it.
        factor: from the signal's unit to ``unit``.
        what: the number in words.
        judge: the number, from the error.
        from_s: from when on it counts.
    """

    scenario: str
    when: str
    printed: str
    corrected: str
    command: str
    result: str
    factor: float
    unit: str
    what: str
    judge: Callable[[np.ndarray], float]
    from_s: float = 0.0


def _largest(error: np.ndarray) -> float:
    return float(np.max(np.abs(error)))


def _rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(error))))


PAIRS = {
    "fsmc_ballscrew": Pair(
        scenario="sine_fast",
        when="On a sine of 1 mm at 1 Hz (Figure 14)",
        printed="paper.smc",
        corrected="corrected.smc",
        command="command.position",
        result="actual.position",
        factor=1e3,
        unit="µm",
        what="largest error",
        judge=_largest,
        from_s=1.0,
    ),
    "npid_xytable": Pair(
        scenario="spindle_1000",
        when="On a sine of 1 mm at 0.7 Hz, cutting at 1,000 1/min",
        printed="paper.npid_mm",
        corrected="corrected.npid_um",
        command="command",
        result="actual",
        factor=1e3,
        unit="µm",
        what="rms error",
        judge=_rms,
        from_s=2.0,
    ),
    "grey_turning": Pair(
        scenario="fig9_falling_depth",
        when="As the depth of cut falls (Figure 9)",
        printed="paper.gpfc_printed_s9",
        corrected="corrected.gpfc_b_s9",
        command="command",
        result="actual.force",
        factor=1.0,
        unit="N",
        what="largest error of the force after 1 s",
        judge=_largest,
        from_s=1.0,
    ),
    "sofnn_tangent": Pair(
        scenario="wave_fabric",
        when="Along the wave in fabric",
        printed="paper.sofnn_pnn",
        corrected="corrected.sofnn_table",
        command="",
        result="actual.deviation",
        factor=1.0,
        unit="°",
        what="rms deviation of the cut from the tangent",
        judge=_rms,
    ),
}
"""What the demo runs of a study that has no contents yet."""


def report_of(study: Study, pair: Pair) -> Report:
    """Both runs of a pair, and what follows from them."""
    scenario = study.scenarios[pair.scenario]
    runs = {name: study.loop(name, pair.scenario).run(scenario.duration_s) for name in (pair.printed, pair.corrected)}
    errors = {name: pair.factor * error_of(run, pair) for name, run in runs.items()}
    values = [judged(run, errors[name], pair) for name, run in runs.items()]
    printed, corrected = values
    smaller = min(values)
    ratio = number(max(values) / smaller, 2) if smaller else NOTHING
    numbers = [
        KeyNumber(_with_unit(printed, pair.unit), f"{pair.what}, law as printed ({pair.printed})"),
        KeyNumber(_with_unit(corrected, pair.unit), f"{pair.what}, corrected law ({pair.corrected})"),
        KeyNumber(f"{ratio} ×", "printed over corrected" if corrected < printed else "corrected over printed"),
    ]
    rows = [
        [name, first_line(study.controllers[name].doc), number(value, 3)]
        for name, value in zip(runs, values, strict=True)
    ]
    caption = f"{pair.when}: above the law as printed, below the corrected one, each with its own scale."
    return Report(
        name=study.name,
        title=study.title,
        citation=study.paper,
        conclusion=[sentence(pair, printed, corrected, runs)],
        key_table=TextTable(["controller", "what it is", f"{pair.what} ({pair.unit})"], rows, [False, False, True]),
        key_title="Both runs",
        key_picture=Picture("both_laws", caption, partial(draw, pair, runs, errors)),
        key_numbers=numbers,
        notes=[f"Two runs. `leadscrew run {study.name}` judges all claims of the paper."],
        data={
            "study": study.name,
            "title": study.title,
            "scenario": pair.scenario,
            "what": pair.what,
            "unit": pair.unit,
            "values": dict(zip(runs, values, strict=True)),
        },
        command=f"leadscrew compare {study.name} --controller {pair.printed} --controller {pair.corrected} "
        f"--scenario {pair.scenario}",
    )


def sentence(pair: Pair, printed: float, corrected: float, runs: dict[str, Run]) -> str:
    """What the two runs say, from their numbers."""
    diverged = {name: run.diverged for name, run in runs.items() if run.diverged}
    if pair.printed in diverged or pair.corrected in diverged:
        which = "printed" if pair.printed in diverged else "corrected"
        return f"{pair.when} the {which} law diverges ({diverged[next(iter(diverged))]})."
    first = f"{pair.when} the {pair.what} is {_with_unit(printed, pair.unit)} with the law as printed"
    if number(printed, 3) == number(corrected, 3):
        return f"{first}, and the same with the corrected law."
    smaller = corrected < printed
    ratio = number(printed / corrected if smaller else corrected / printed, 2)
    way = "smaller" if smaller else "larger"
    return f"{first} and {_with_unit(corrected, pair.unit)} with the corrected law, {way} by a factor of {ratio}."


def error_of(run: Run, pair: Pair) -> np.ndarray:
    """Command minus result; of a deviation, which has no command, the deviation itself."""
    result = np.asarray(run[pair.result], dtype=float)
    return result if not pair.command else np.asarray(run[pair.command], dtype=float) - result


def judged(run: Run, error: np.ndarray, pair: Pair) -> float:
    """The number of a run, from ``from_s`` on."""
    return pair.judge(error[np.asarray(run.time) >= pair.from_s])


def draw(pair: Pair, runs: dict[str, Run], errors: dict[str, np.ndarray]) -> Figure:
    """Errors of both runs, one above the other, each with its own scale."""
    from matplotlib.figure import Figure

    from leadscrew.report.style import BLUE, VERMILION

    figure = Figure(figsize=(8.0, 4.4), layout="constrained")
    panels: Any = figure.subplots(2, 1, sharex=True)
    style = ((VERMILION, "--", "as printed"), (BLUE, "-", "corrected"))
    for axes, (name, error), (colour, line, whose) in zip(panels, errors.items(), style, strict=True):
        time = np.asarray(runs[name].time)
        shown = time >= pair.from_s
        step = max(1, int(shown.sum()) // 4000)
        axes.plot(time[shown][::step], error[shown][::step], color=colour, linestyle=line, linewidth=1.0)
        axes.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
        axes.set_title(f"{whose}: {name}", fontsize="medium", loc="left")
        axes.set_ylabel(f"error ({pair.unit})")
        axes.margins(x=0)
    panels[-1].set_xlabel("time (s)")
    figure.align_ylabels(panels)
    return figure


def _with_unit(value: float, unit: str) -> str:
    return f"{number(value, 3)} {unit}" if unit != "°" else f"{number(value, 3)}°"
