"""Measured lines for reading: a table, sentences, their picture."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLUE, VERMILION
from leadscrew.figures.table import finite, fixed
from leadscrew.figures.table import unit as shown_unit
from leadscrew.report.report import Report, TextTable, head
from leadscrew.util import escape

if TYPE_CHECKING:
    from pathlib import Path

    from leadscrew.analysis.harmonics.measured import Measured
    from leadscrew.figures.figure import Figure


def table(found: Measured, unit: str = "", level: float = 0.95) -> TextTable:
    """One row a line."""
    heads = (
        "line", "f (Hz)", f"amplitude ({shown_unit(unit)})" if unit else "amplitude", f"{100.0 * level:g} % from", "to",
        "phase (°)", f"FFT, {found.spectrum.window}",
    )  # fmt: skip
    rows = [
        [name, finite(f, 5), finite(a), finite(lo), finite(hi), fixed(float(np.degrees(p)), 1), finite(fft)]
        for name, f, a, lo, hi, p, fft in _rows(found, level)
    ]
    return TextTable(heads, rows, [False, *[True] * 6])


def csv(found: Measured, unit: str = "", level: float = 0.95) -> str:
    """The same for a program."""
    heads = ["line", "Hz", f"amplitude {unit}".strip(), f"{100.0 * level:g} % from", "to", "phase deg",
             f"FFT {found.spectrum.window}"]  # fmt: skip
    lines = [",".join(heads)]
    lines += [
        f"{name},{f:.5g},{a:.4g},{lo:.4g},{hi:.4g},{np.degrees(p):.1f},{fft:.4g}"
        for name, f, a, lo, hi, p, fft in _rows(found, level)
    ]
    return "\n".join(lines) + "\n"


def _rows(found: Measured, level: float) -> Iterator[tuple[Any, ...]]:
    h = found.harmonics
    low, high = h.confidence(level)
    return zip(found.names, h.frequencies, h.amplitudes, low, high, h.phases, found.fft, strict=True)


def sentences(found: Measured, unit: str = "", level: float = 0.95) -> list[str]:
    """The rest of the result in words, a line each."""
    h, of = found.harmonics, f" {shown_unit(unit)}" if unit else ""
    lines = []
    for name, fit, scale, hz in (("base", found.base, 1.0, "Hz"), ("spindle", found.spindle, 60.0, "1/min")):
        if fit is not None:
            low, high = fit.confidence(level)
            lines.append(
                f"{name} fitted: {scale * fit.frequency:.7g} {hz}, {100.0 * level:g} % from {scale * low:.7g} to "
                f"{scale * high:.7g} {hz}"
            )
    lines.append(
        f"{h.taken.samples} samples at {h.taken.rate:g} Hz, {h.taken.duration:g} s; offset {float(h.offset):.4g}{of}, "
        f"trend {float(h.trend):.3g}{of}/s, residual {float(h.residual_rms):.4g}{of} rms"
    )
    return lines


def summary(found: Measured, source: str, signal: str, unit: str = "", level: float = 0.95) -> dict[str, Any]:
    """The one JSON object of ``leadscrew harmonics --json``."""
    return {
        **head("harmonics"), "log": source, "signal": signal, "unit": unit,
        **found.as_dict(level),
    }  # fmt: skip


def report_of(found: Measured, log: Path, signal: str, unit: str = "", level: float = 0.95) -> Report:
    """The report of ``leadscrew harmonics``."""
    return Report(
        summary(found, str(log), signal, unit, level),
        parts=[table(found, unit, level), *sentences(found, unit, level)],
        notes=found.notes,
        figure=lambda: picture(found, f"{log.name}: {signal}", unit, level),
        csv=lambda: csv(found, unit, level),
    )


def picture(found: Measured, title: str = "", unit: str = "", level: float = 0.95) -> Figure:
    """The spectrum with the measured lines and their confidence intervals over it."""
    from leadscrew.figures.figure import Figure

    h, seen = found.harmonics, found.spectrum
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes = figure.subplots()
    top = min(seen.taken.nyquist, 1.6 * float(np.max(h.frequencies)))
    kept = (seen.frequencies > 0.0) & (seen.frequencies <= top)
    floor = max(float(np.percentile(seen.amplitudes[kept], 5)), 1e-6 * float(np.max(h.amplitudes)), 1e-300)
    axes.plot(seen.frequencies[kept], np.maximum(seen.amplitudes[kept], floor), color=BLUE, linewidth=0.9,
              label=f"FFT, {seen.window}")  # fmt: skip
    low, high = h.confidence(level)
    ends = np.array([h.amplitudes - np.maximum(low, floor), high - h.amplitudes])
    axes.errorbar(h.frequencies, h.amplitudes, yerr=np.maximum(np.nan_to_num(ends), 0.0), fmt="o", markersize=4,
                  color=VERMILION, capsize=3, label=f"least squares, {100.0 * level:g} %")  # fmt: skip
    for name, f, a in zip(found.names, h.frequencies, h.amplitudes, strict=True):
        axes.annotate(name, (f, a), (0, 6), textcoords="offset points", fontsize="x-small", rotation=90, ha="center",
                      va="bottom")  # fmt: skip
    axes.set_yscale("log")
    axes.set(xlabel="frequency (Hz)", ylabel=f"amplitude ({unit})" if unit else "amplitude", xlim=(0.0, top))
    axes.set_ylim(0.5 * floor, 20.0 * max(float(np.max(h.amplitudes)), float(np.max(seen.amplitudes[kept]))))
    axes.grid(color="0.92", linewidth=0.6)
    if title:
        axes.set_title(escape.figure(title), fontsize="medium")
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize="small")
    return figure
