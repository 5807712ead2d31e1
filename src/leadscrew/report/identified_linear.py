"""A linear model from a log for reading: rows of tables, sentences, JSON, a page with pictures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLACK, BLUE, GREEN, ORANGE, VERMILION
from leadscrew.figures.table import NOTHING, finite, fixed, unit
from leadscrew.identify.estimation import Parameter, quantile
from leadscrew.identify.linear.result import LinearFit
from leadscrew.report import page as html
from leadscrew.report.report import File, Report, TextTable, head
from leadscrew.util import escape
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure


WIDE = 500.0
"""Percent of the value that half an interval may be wide, for its ends to be worth printing."""


def parameter_table(fit: LinearFit) -> TextTable:
    """Gain, poles, zeros, delay, offset; then the coefficients."""
    rows = [_row(_name(fit, key), p) for key, p in fit.parameters.items()]
    rows.append(_row("input offset" if fit.structure.integrators else "output offset", fit.offset))
    rows += [_row(key, p) for key, p in fit.coefficients.items()]
    heads = ("parameter", "value", "95 % from", "to", "unit", "")
    return TextTable(heads, rows, [False, *[True] * 3, False, False], title="Parameters")


def _name(fit: LinearFit, key: str) -> str:
    if key == "gain" and fit.structure.integrators:
        return ("speed gain", "acceleration gain")[fit.structure.integrators - 1]
    return {"delay_s": "delay"}.get(key, key)


def _row(name: str, p: Parameter) -> list[str]:
    if p.low == p.high:
        return [name, finite(p.value, 5), NOTHING, NOTHING, unit(p.unit), "given"]
    if not p.identifiable and p.percent > WIDE:
        return [name, finite(p.value, 5), NOTHING, NOTHING, unit(p.unit), "not identifiable"]
    return [
        name,
        finite(p.value, 5),
        finite(p.low, 5),
        finite(p.high, 5),
        unit(p.unit),
        "" if p.identifiable else "not identifiable",
    ]


def candidate_table(fit: LinearFit) -> TextTable:
    """All structures that were tried, simplest first."""
    rows = [
        [c.structure.text, finite(_delay(fit, c.delay_s), 3), finite(c.train_rms), finite(c.holdout_rms), c.against]
        for c in fit.candidates
    ]
    of = _of(fit)
    heads = ("model", "delay (s)", f"training rms{of}", f"hold-out rms{of}", "")
    return TextTable(heads, rows, [False, True, True, True, False], title="Models tried")


def _delay(fit: LinearFit, delay_s: float) -> float:
    """Zero where the search ended on its bound."""
    return delay_s if delay_s > 1e-4 * fit.period else 0.0


def _of(fit: LinearFit) -> str:
    """The output's unit, for a head."""
    return f" ({unit(fit.output_unit)})" if unit(fit.output_unit) else ""


def stretch_table(fit: LinearFit) -> TextTable:
    """Errors of simulation on training and hold-out."""
    rows = [
        [s.what, finite(s.start_s), finite(s.end_s), finite(s.rms), finite(s.worst), finite(s.nrmse_percent, 3),
         fixed(s.fit_percent, 2)]
        for s in fit.stretches
    ]  # fmt: skip
    of = _of(fit)
    heads = ("part", "from (s)", "to (s)", f"rms{of}", f"worst{of}", "% of range", "fit (%)")
    return TextTable(heads, rows, [False, *[True] * 6], title="Errors of simulation")


def polynomial(values: Sequence[float] | np.ndarray) -> str:
    """``s^2 + 144.8 s + 166.3``."""
    lines: list[str] = []
    degree = len(values) - 1
    for k, value in enumerate(values):
        power = degree - k
        if value == 0.0 and len(values) > 1:
            continue
        size = f"{abs(value):.5g}"
        factor = "" if power == 0 else "s" if power == 1 else f"s^{power}"
        text = factor if size == "1" and factor else f"{size} {factor}".strip()
        lines.append((("- " if value < 0.0 else "+ ") if lines else ("-" if value < 0.0 else "")) + text)
    return " ".join(lines)


def equation(fit: LinearFit) -> str:
    """The transfer function in one line."""
    above, below = polynomial(fit.numerator), polynomial(fit.denominator)
    above = f"({above})" if " " in above and fit.structure.zeros else above
    return f"{above} / ({below}) exp(-{_delay(fit, fit.delay_s):.4g} s)"


def sentences(fit: LinearFit) -> list[str]:
    """The result in words, a line each."""
    low, high = fit.excited_hz
    tried = len(fit.candidates)
    how = (
        f"the simplest of {tried} within {100.0 * fit.margin:g} % of the least hold-out error"
        if tried > 1
        else "asked for"
    )
    return [
        f"{fit.input_name} ({fit.input_unit}) to {fit.output_name} ({fit.output_unit}), every {finite(fit.period)} s: "
        f"{equation(fit)}",
        f"{fit.structure.text}: {how}; {fit.method}",
        f"the input speaks from {finite(low, 3)} to {finite(high, 3)} Hz; condition number {finite(fit.condition, 2)}",
        f"residual: {fit.whiteness:.0f} % of autocorrelations as of white noise (95 expected); with the input before "
        f"{fit.missed:.1f}, after {fit.feedback:.1f} deviations (above 4 is no chance)",
    ]  # fmt: skip


def summary(fit: LinearFit, log: str) -> dict[str, Any]:
    """The one JSON object of ``leadscrew identify linear --json``."""
    return {
        **head("identify linear"), "log": log, **fit.as_dict(),
        "sentences": sentences(fit),
    }  # fmt: skip


def report_of(fit: LinearFit, log: Path, files: Sequence[File] = ()) -> Report:
    """The report of ``leadscrew identify linear``."""
    return Report(
        summary(fit, str(log)),
        parts=[
            parameter_table(fit), candidate_table(fit), stretch_table(fit), *sentences(fit),
            *(f"to measure next: {a}" for a in fit.advice),
        ],
        notes=fit.notes,
        files=files,
        page=lambda folder: write(fit, folder),
    )  # fmt: skip


def write(fit: LinearFit, folder: str | Path) -> None:
    """Writes ``report.html``, ``linear.json`` and the pictures ``linear_*.png``; complete, or not at all.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as place:
        drawn = pictures(fit)
        for name, (figure, _) in drawn.items():
            figure.savefig(place / f"linear_{name}.png", dpi=130, metadata={"Software": None})
        found = strict(summary(fit, fit.source))
        (place / "linear.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        (place / "report.html").write_text(_page(fit, drawn), encoding="utf-8")


def _page(fit: LinearFit, drawn: dict[str, Any]) -> str:
    title = f"Linear model: {fit.input_name} to {fit.output_name}"
    lines = [*sentences(fit), *(f"note: {n}" for n in fit.notes), *(f"to measure next: {a}" for a in fit.advice)]
    parts = [
        f"<p>{escape.html(fit.source)}</p>",
        *html.paragraphs(lines),
        html.table(stretch_table(fit)),
        html.table(parameter_table(fit)),
        *(html.picture(figure, name, caption, caption) for name, (figure, caption) in drawn.items()),
        html.table(candidate_table(fit)),
    ]
    return html.page(title, parts)


MOST_POINTS = 6000
"""Of a drawn line."""


def pictures(fit: LinearFit) -> dict[str, tuple[Figure, str]]:
    """Figures and captions by name."""
    last = fit.stretches[-1]
    found = {
        "simulated": (simulated(fit), f"Measured and simulated, {last.what}: the model is given the input alone"),
        "bode": (bode(fit), "Response from sample to sample, hold included: model with its 95 % band, and the log's "
                            "own estimate without a model; grey where the training does not excite"),
        "residual": (residual(fit), "Autocorrelation of what the training leaves, with the 95 % bounds of white noise"),
    }  # fmt: skip
    if len(fit.candidates) > 1:
        found["orders"] = (orders(fit), "Errors of simulation of all models that were tried, by number of coefficients")
    return found


def simulated(fit: LinearFit) -> Figure:
    """Measured against simulated, and the difference, on the hold-out."""
    figure, (way, error) = _panels((7.5, 5.0), (3, 2))
    s = fit.stretches[-1]
    part = slice(None, None, max(1, len(s.time) // MOST_POINTS))
    way.plot(s.time[part], s.measured[part], color=BLACK, linewidth=1.0, label="measured")
    way.plot(s.time[part], s.simulated[part], color=BLUE, linewidth=1.0, linestyle="--", label="simulated")
    error.plot(s.time[part], (s.measured - s.simulated)[part], color=VERMILION, linewidth=0.8)
    way.set(
        ylabel=escape.figure(f"{fit.output_name} ({fit.output_unit})"),
        title=escape.figure(f"{s.what}: rms {s.rms:.3g} {fit.output_unit}"),
    )
    error.set(xlabel="time (s)", ylabel=escape.figure(f"difference ({fit.output_unit})"))
    way.legend(frameon=False, fontsize="small")
    figure.align_ylabels()
    return figure


def bode(fit: LinearFit) -> Figure:
    """Gain, phase and coherence: model with band, measured points with theirs."""
    figure, (gain, phase, coherence) = _panels((7.5, 7.0), (3, 3, 1.5))
    b = fit.bode
    size, angle = np.abs(b.response), np.degrees(np.unwrap(np.angle(b.response)))
    wide = np.minimum(b.gain_share, 0.99)
    gain.fill_between(b.frequency_hz, size * (1.0 - wide), size * (1.0 + wide), color=BLUE, alpha=0.25, linewidth=0)
    gain.plot(b.frequency_hz, size, color=BLUE, linewidth=1.1, label="model, 95 %")
    reach = np.degrees(np.minimum(b.phase_half_width, np.pi))
    phase.fill_between(b.frequency_hz, angle - reach, angle + reach, color=BLUE, alpha=0.25, linewidth=0)
    phase.plot(b.frequency_hz, angle, color=BLUE, linewidth=1.1)
    m = fit.measured
    if m is not None:
        dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 3, "color": ORANGE}
        low, high = m.gain_confidence()
        gain.vlines(m.frequencies, np.maximum(low, 1e-3 * m.gain), high, color=ORANGE, linewidth=0.6, alpha=0.6)
        gain.plot(m.frequencies, m.gain, label=f"log, {m.method}", **dots)
        model = np.interp(m.frequencies, b.frequency_hz, np.radians(angle))
        near = np.degrees(model + np.angle(m.response * np.exp(-1j * model)))
        phase.plot(m.frequencies, near, **dots)
        coherence.plot(m.frequencies, m.coherence, color=GREEN, linewidth=0.9)
    shown = size[(b.frequency_hz >= fit.excited_hz[0]) & (b.frequency_hz <= fit.excited_hz[1])] if any(
        fit.excited_hz) else size  # fmt: skip
    shown = shown if len(shown) else size
    gain.set(yscale="log", ylabel=escape.figure(f"gain ({fit.output_unit}/{fit.input_unit})"))
    gain.set_ylim(0.03 * float(shown.min()), 5.0 * float(max(shown.max(), 1e-300)))
    phase.set(ylabel="phase (deg)", ylim=(float(angle.min()) - 60.0, float(angle.max()) + 60.0))
    coherence.set(ylabel="coherence", xlabel="frequency (Hz)", xscale="log", ylim=(0.0, 1.05))
    for ax in (gain, phase, coherence):
        ax.axvspan(b.frequency_hz[0], max(fit.excited_hz[0], b.frequency_hz[0]), color="0.9", zorder=-2)
        ax.axvspan(max(fit.excited_hz[1], b.frequency_hz[0]), b.frequency_hz[-1], color="0.9", zorder=-2)
    gain.legend(frameon=False, fontsize="small")
    figure.align_ylabels()
    return figure


def residual(fit: LinearFit) -> Figure:
    """Autocorrelation of the training residual."""
    figure, (ax,) = _panels((7.5, 2.8), (1,))
    lags = np.arange(1, len(fit.autocorrelation) + 1)
    bound = quantile() / np.sqrt(len(fit.stretches[0].time))
    ax.axhspan(-bound, bound, color=BLUE, alpha=0.15, linewidth=0)
    ax.vlines(lags, 0.0, fit.autocorrelation, color=BLUE, linewidth=1.5)
    ax.plot(lags, fit.autocorrelation, color=BLUE, linestyle="none", marker="o", markersize=3)
    ax.axhline(0.0, color=BLACK, linewidth=0.6)
    ax.set(xlabel="lag (samples)", ylabel="autocorrelation", xlim=(0.0, len(lags) + 1.0))
    return figure


def orders(fit: LinearFit) -> Figure:
    """Errors of all candidates over their number of coefficients."""
    figure, (ax,) = _panels((7.5, 3.4), (1,))
    held = np.isfinite(fit.candidates[0].holdout_rms)
    for q, mark in ((0, "o"), (1, "s"), (2, "D")):
        rows = [c for c in fit.candidates if c.structure.integrators == q]
        if not rows:
            continue
        count = [c.structure.free + c.structure.zeros + 1 for c in rows]
        name = f"{q} pole{'s' * (q != 1)} at 0" if q else "no pole at 0"
        style: dict[str, Any] = {"linestyle": "none", "marker": mark, "markersize": 6}
        if held:
            ax.plot(count, [c.holdout_rms for c in rows], color=BLUE, label=f"{name}, hold-out", **style)
        ax.plot(count, [c.train_rms for c in rows], color=ORANGE, fillstyle="none", label=f"{name}, training", **style)
    best = next(c for c in fit.candidates if c.against == "chosen")
    at = best.structure.free + best.structure.zeros + 1
    error = best.holdout_rms if held else best.train_rms
    ax.annotate(f"chosen: {best.structure.text}", (at, error), (0, -26), textcoords="offset points", ha="center",
                arrowprops={"arrowstyle": "->", "linewidth": 0.8}, fontsize="small")  # fmt: skip
    ax.set(
        yscale="log",
        xlabel="coefficients of numerator and denominator",
        ylabel=escape.figure(f"rms error ({fit.output_unit})"),
    )
    ax.margins(x=0.08, y=0.3)
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.legend(frameon=False, fontsize="small", loc="upper right")
    return figure


def _panels(size: tuple[float, float], heights: tuple[float, ...]) -> tuple[Figure, list[Any]]:
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for ax in axes:
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.margins(x=0)
    return figure, list(axes)
