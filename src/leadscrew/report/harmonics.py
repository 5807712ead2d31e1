"""Measured lines for reading: a table, sentences, their picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLUE, VERMILION
from leadscrew.util import escape

if TYPE_CHECKING:
    from leadscrew.analysis.harmonics.measured import Measured
    from leadscrew.figures.figure import Figure

SCHEMA_VERSION = 1


def columns(found: Measured, unit: str = "", level: float = 0.95) -> tuple[str, ...]:
    """Headings of the table."""
    of = f" {unit}" if unit else ""
    return (
        "line",
        "Hz",
        f"amplitude{of}",
        f"{100.0 * level:g} % from",
        "to",
        "phase deg",
        f"FFT, {found.spectrum.window}",
    )


def rows(found: Measured, level: float = 0.95) -> list[tuple[str, ...]]:
    """One row a line."""
    h = found.harmonics
    low, high = h.confidence(level)
    return [
        (name, f"{f:.5g}", f"{a:.4g}", f"{lo:.4g}", f"{hi:.4g}", f"{np.degrees(p):.1f}", f"{fft:.4g}")
        for name, f, a, lo, hi, p, fft in zip(
            found.names, h.frequencies, h.amplitudes, low, high, h.phases, found.fft, strict=True
        )
    ]


def sentences(found: Measured, unit: str = "", level: float = 0.95) -> list[str]:
    """The rest of the result in words, a line each."""
    h, of = found.harmonics, f" {unit}" if unit else ""
    said = []
    for name, fit, scale, hz in (("base", found.base, 1.0, "Hz"), ("spindle", found.spindle, 60.0, "1/min")):
        if fit is not None:
            low, high = fit.confidence(level)
            said.append(
                f"{name} fitted: {scale * fit.frequency:.7g} {hz}, {100.0 * level:g} % from {scale * low:.7g} to "
                f"{scale * high:.7g} {hz}"
            )
    said.append(
        f"{h.taken.samples} samples at {h.taken.rate:g} Hz, {h.taken.duration:g} s; offset {float(h.offset):.4g}{of}, "
        f"trend {float(h.trend):.3g}{of}/s, residual {float(h.residual_rms):.4g}{of} rms"
    )
    return said


def summary(found: Measured, source: str, signal: str, unit: str = "", level: float = 0.95) -> dict[str, Any]:
    """The one JSON object of ``leadscrew harmonics --json``."""
    return {
        "schema_version": SCHEMA_VERSION, "kind": "leadscrew harmonics", "log": source, "signal": signal, "unit": unit,
        **found.as_dict(level),
    }  # fmt: skip


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
