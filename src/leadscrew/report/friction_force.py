"""Friction models of a measured force for reading: rows of tables, sentences, JSON, a picture, a page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.friction import friction_velocity
from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from leadscrew.figures.table import finite, fixed, unit
from leadscrew.friction.static_map import TwoSided
from leadscrew.identify.friction_force.result import (
    DAHL,
    LUGRE,
    MAP,
    SLIP,
    STRIBECK,
    FrictionForceFit,
    ModelFit,
    better_percent,
    judged_rms,
    map_of,
    set_table,
    settings,
)
from leadscrew.report import page as html
from leadscrew.report.report import Report, TextTable, head
from leadscrew.util import escape
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure


PENS = {MAP: (ORANGE, ":"), STRIBECK: (SKY, "--"), DAHL: (GREEN, "-."), LUGRE: (BLUE, "-"), SLIP: (VERMILION, "--")}
MOST = 6000
"""Points of a line."""


def picture(fit: FrictionForceFit, title: str = "") -> Figure:
    """Force against position and against speed, and residuals; measured and by the models."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(10.0, 8.6), layout="constrained")
    panels = figure.subplot_mosaic([["loops", "speeds"], ["left", "left"]], height_ratios=[1.35, 1.0])
    loops, speeds, left = (panels[name] for name in ("loops", "speeds", "left"))
    r = fit.record
    held = fit.training < len(r.time)
    rows = np.arange(fit.training if held else 0, len(r.time))
    rows = rows[:: max(1, len(rows) // MOST)]
    unit = r.force_unit
    um = 1e6 if r.unit == "m" else 1e3
    way = "um" if r.unit == "m" else "mrad"
    loops.plot(um * r.position[rows], r.force[rows], color=BLACK, linewidth=1.0, label="measured")
    for name in (MAP, LUGRE, SLIP):
        colour, line = PENS[name]
        loops.plot(um * r.position[rows], fit.models[name].simulated[rows], color=colour, linestyle=line,
                   linewidth=0.9, label=name)  # fmt: skip
    loops.set(xlabel=f"position ({way})", ylabel=f"friction ({unit})",
              title="hold-out: not seen by any fit" if held else "fitted samples")  # fmt: skip
    _against_speed(fit, speeds, um, way)
    for name in (MAP, LUGRE, SLIP):
        colour, line = PENS[name]
        every = slice(None, None, max(1, len(r.time) // MOST))
        left.plot(r.time[every], (r.force - fit.models[name].simulated)[every], color=colour, linewidth=0.6, label=name)
    if held:
        left.axvline(r.time[fit.training], color=BLACK, linewidth=1.0, linestyle="--")
    left.set(xlabel="time (s)", ylabel=f"measured minus model ({unit})",
             title="residual; hold-out right of the line" if held else "residual")  # fmt: skip
    for ax in (loops, speeds, left):
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
        columns = 3 if ax is left else 2
        ax.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=columns)
    if title:
        figure.suptitle(escape.figure(title), fontsize="medium")
    return figure


def _against_speed(fit: FrictionForceFit, ax: Any, um: float, way: str) -> None:
    r = fit.record
    n = fit.training
    some = np.flatnonzero(r.travel[:n])
    some = some[:: max(1, len(some) // MOST)]
    ax.plot(um * r.speed[some], r.force[some], ",", color="0.6", label="measured, moving", rasterized=True)
    scale = fit.normal_mean if fit.load == "coefficient" else 1.0
    reach = np.nan_to_num([max(scale * (b.force - b.low), 0.0) for b in fit.bins])
    ax.errorbar([um * b.speed for b in fit.bins], [scale * b.force for b in fit.bins],
                yerr=reach, fmt="o", color=BLACK, markersize=4, label="sliding, 95 %")  # fmt: skip
    fast = 1.1 * float(np.abs(r.speed[:n]).max())
    v = np.concatenate([-np.geomspace(fast, 1e-4 * fast, 200), np.geomspace(1e-4 * fast, fast, 200)])
    ax.plot(um * v, friction_velocity(map_of(fit), v), color=PENS[LUGRE][0], label="LuGre, steady")
    if STRIBECK in fit.models:
        f = fit.models[STRIBECK].friction
        assert isinstance(f, TwoSided)
        ax.plot(um * v, scale * friction_velocity(f, v), color=PENS[STRIBECK][0], linestyle="--", label=STRIBECK)
    ax.set(xlabel=f"speed ({way}/s)", ylabel=f"friction ({r.force_unit})", title="fitted samples")


def model_table(fit: FrictionForceFit) -> TextTable:
    """Errors of every model, on what it was fitted to and on the hold-out; with the other load below."""
    rows = [_model_row(m, fit.models, "") for m in fit.models.values()]
    other = {"coefficient": ", coefficient", "force": ", force"}
    rows += [_model_row(m, fit.others, other[m.load]) for m in fit.others.values()]
    heads = ("model", "fitted rms", "hold-out rms", "of amplitude (%)", "worst", "better (%)", "condition")
    return TextTable(heads, rows, [False, *[True] * 6], title=f"Models ({fit.record.force_unit})")


def _model_row(m: ModelFit, among: dict[str, ModelFit], suffix: str) -> list[str]:
    percent = m.training_percent if np.isnan(m.holdout_percent) else m.holdout_percent
    better = fixed(None if m.name == MAP else better_percent(among, m.name), 1)
    return [m.name + suffix, finite(m.training_rms), finite(m.holdout_rms), finite(percent, 3),
            finite(m.holdout_worst, 3), better, finite(m.condition, 2)]  # fmt: skip


def value_table(model: ModelFit) -> TextTable:
    """Parameters of a model with their intervals; what is not identifiable says why."""
    rows = []
    for key, p in model.parameters.items():
        word = (
            p.note if p.identifiable else f"not identifiable: {p.note}" if p.how == "fitted" else f"{p.how}: {p.note}"
        )
        rows.append([key, finite(p.value, 5), finite(p.low, 5), finite(p.high, 5), unit(p.unit), word])
    heads = ("parameter", "value", "95 % from", "to", "unit", "")
    return TextTable(heads, rows, [False, *[True] * 3, False, False], title=model.name)


def bin_table(fit: FrictionForceFit) -> TextTable:
    """Binned force against speed."""
    rows = [[finite(b.speed), finite(b.force), finite(b.low), finite(b.high), str(b.strokes)] for b in fit.bins]
    title = f"Sliding friction against speed ({fit.record.unit}/s)"
    return TextTable(("speed", "friction", "95 % from", "to", "strokes"), rows, [True] * 5, title=title)


def sentences(fit: FrictionForceFit) -> list[str]:
    """The result in words, a line each."""
    r, chosen = fit.record, fit.chosen
    force, way = r.force_unit, r.unit
    part = "hold-out" if fit.training < len(r.time) else "fitted part"
    lines = [
        f"{len(r.time)} samples in {r.time[-1] - r.time[0]:.4g} s, {int(r.strokes[-1])} reversals over "
        f"{np.ptp(r.position):.3g} {way}; the first {fit.training} were fitted",
        f"friction amplitude of the {part}: {fit.amplitude:.4g} {force}; LuGre leaves {judged_rms(chosen):.3g} {force} "
        f"rms, {100.0 * judged_rms(chosen) / fit.amplitude:.3g} % of it, {fit.better_percent(chosen.name):.3g} % less "
        "than Coulomb and viscous friction",
    ]
    if fit.load == "coefficient":
        lines.append(
            f"values are of the coefficient of friction, per newton of normal force (mean {fit.normal_mean:.5g} N "
            "while sliding); rows with 'force' take no notice of it"
        )
    least = min(fit.models.values(), key=lambda m: m.training_rms)
    if least.name != chosen.name:
        lines.append(f"nearest to the fitted part is {least.name}; LuGre is what plants and controllers take")
    if chosen.whiteness < 80.0:
        lines.append(
            "what LuGre leaves is not noise (it repeats from sample to sample): the shape is not quite LuGre's, and "
            "intervals say how well values repeat, not how right the shape is"
        )
    return lines


def for_simulation(fit: FrictionForceFit) -> str:
    """The friction of a plant, as options of a command."""
    return "for a simulation: " + " ".join(f"--set {key}={value:.6g}" for key, value in settings(fit).items())


def summary(fit: FrictionForceFit) -> dict[str, Any]:
    """The result as the one JSON object that ``leadscrew identify friction-force --json`` prints."""
    return {
        **head("identify friction-force"), **fit.as_dict(), "set": settings(fit),
        "sentences": sentences(fit),
    }  # fmt: skip


def report_of(fit: FrictionForceFit, file: Path) -> Report:
    """The report of ``leadscrew identify friction-force``."""
    return Report(
        {**summary(fit), "file": str(file)},
        parts=[
            model_table(fit), value_table(fit.chosen), *sentences(fit), *(f"to measure next: {a}" for a in fit.advice),
        ],
        notes=fit.notes,
        page=lambda folder: write(fit, folder),
    )  # fmt: skip


def write(fit: FrictionForceFit, folder: str | Path) -> None:
    """Writes ``report.html``, ``friction_force.json``, ``friction_force.png`` and ``friction.toml``; all or nothing.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as place:
        name = Path(fit.record.source).name
        figure = picture(fit, name)
        figure.savefig(place / "friction_force.png", dpi=130, metadata={"Software": None})
        text = json.dumps(strict(summary(fit)), indent=1, allow_nan=False) + "\n"
        (place / "friction_force.json").write_text(text, encoding="utf-8")
        (place / "friction.toml").write_text(set_table(fit, name), encoding="utf-8")
        (place / "report.html").write_text(_page(fit, name, figure), encoding="utf-8")


def _page(fit: FrictionForceFit, source: str, figure: Figure) -> str:
    title = f"Friction force: {source}"
    lines = [*sentences(fit), *(f"note: {n}" for n in fit.notes), *(f"to measure next: {a}" for a in fit.advice)]
    parts = [
        *html.paragraphs(lines),
        html.picture(figure, "friction_force", "loops, force against speed, residual"),
        html.table(model_table(fit)),
        *(html.table(value_table(m)) for m in reversed(fit.models.values())),
        html.table(bin_table(fit)),
        f"<h2>As a friction block</h2><pre>{escape.html(set_table(fit, source))}</pre>",
    ]
    return html.page(title, parts)
