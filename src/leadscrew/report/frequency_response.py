"""A measured frequency response for reading: a table, what it says in words, its Bode picture with coherence."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.figures.style import BLUE, GREEN, VERMILION
from leadscrew.figures.table import finite, fixed
from leadscrew.report.report import Report, TextTable, head
from leadscrew.util import escape

if TYPE_CHECKING:
    from pathlib import Path

    from leadscrew.analysis.frequency_response import FrequencyResponse
    from leadscrew.figures.figure import Figure

ROWS = 24
"""Of the printed table, evenly on a logarithmic scale; files and JSON have all."""


def table(found: FrequencyResponse, level: float = 0.95, most: int | None = ROWS) -> TextTable:
    """All frequencies, or about ``most`` evenly over their logarithm."""
    places = np.arange(len(found.frequencies))
    if most is not None and len(places) > most:
        wanted = np.geomspace(found.frequencies[0], found.frequencies[-1], most)
        places = np.unique([int(np.argmin(np.abs(found.frequencies - f))) for f in wanted])
    low, high = found.gain_confidence(level)
    with np.errstate(divide="ignore"):
        ends = 20.0 * np.log10(np.stack([low, high]))
    phase, wide = np.degrees(found.phase), np.degrees(found.phase_confidence(level))
    heads = ("f (Hz)", "gain", "gain (dB)", "from (dB)", "to (dB)", "phase (°)", "± (°)", "coherence")
    rows = [
        [finite(found.frequencies[k], 5), finite(found.gain[k]), fixed(found.gain_db[k], 2), fixed(ends[0, k], 2),
         fixed(ends[1, k], 2), fixed(phase[k], 1), finite(wide[k], 2), fixed(found.coherence[k], 4)]
        for k in places
    ]  # fmt: skip
    return TextTable(heads, rows, [True] * 8)


def sentences(found: FrequencyResponse, loop: bool = False) -> list[str]:
    """What was measured and how, and the figures that a loop is judged by."""
    how = "periods" if found.method == "periodic" else "independent segments"
    lines = [
        f"{found.method}: {found.averages:.3g} {how} of {found.segment_s:g} s, {len(found.frequencies)} frequencies "
        f"from {found.frequencies[0]:g} to {found.frequencies[-1]:g} Hz; coherence {found.coherence.min():.3f} to "
        f"{found.coherence.max():.3f}, median {np.median(found.coherence):.4f}"
    ]
    if loop:
        from leadscrew.analysis.frequency_response import measured_margins

        m = measured_margins(found)
        if m.gain_margin is not None and m.phase_crossover_hz is not None:
            lines.append(f"gain margin {m.gain_margin:.3f} ({20.0 * np.log10(m.gain_margin):.2f} dB) at "
                        f"{m.phase_crossover_hz:.4g} Hz")  # fmt: skip
        if m.phase_margin_deg is not None and m.gain_crossover_hz is not None:
            lines.append(f"phase margin {m.phase_margin_deg:.1f} deg at {m.gain_crossover_hz:.4g} Hz")
        if m.sensitivity is not None:
            lines.append(f"largest sensitivity Ms = {m.sensitivity:.3f} at {m.sensitivity_hz:.4g} Hz")
        if len(lines) == 1:
            lines.append("no crossover where the coherence is high enough: this log cannot determine a margin")
    return lines


def summary(found: FrequencyResponse, source: str, loop: bool, level: float = 0.95) -> dict[str, Any]:
    """The one JSON object of ``leadscrew frequency-response --json``."""
    from leadscrew.analysis.frequency_response import measured_margins

    return {
        **head("frequency-response"), "log": source, "loop_gain": loop,
        "margins": measured_margins(found)._asdict() if loop else None, **found.as_dict(level),
    }  # fmt: skip


def report_of(
    found: FrequencyResponse, log: Path, names: tuple[str, str], excitation: str | None, loop: bool, level: float
) -> Report:
    """The report of ``leadscrew frequency-response``; ``names`` are the input and the output."""
    of = {"input": names[0], "output": names[1], "excitation": excitation}
    title = f"{log.name}: loop gain" if loop else f"{log.name}: {names[0]} to {names[1]}"
    return Report(
        {**summary(found, str(log), loop, level), **of},
        parts=[table(found, level), *sentences(found, loop)],
        notes=found.notes,
        figure=lambda: picture(found, title, level),
        csv=lambda: csv(found, level),
    )


def csv(found: FrequencyResponse, level: float = 0.95) -> str:
    """All frequencies as a table, digits enough to read the numbers back."""
    low, high = found.gain_confidence(level)
    table = (found.frequencies, found.gain, low, high, found.phase, found.phase_confidence(level), found.coherence)
    lines = ["frequency_hz,gain,gain_low,gain_high,phase_rad,phase_half_width_rad,coherence"]
    lines += [",".join(repr(float(x)) for x in row) for row in zip(*table, strict=True)]
    return "\n".join(lines) + "\n"


def picture(found: FrequencyResponse, title: str = "", level: float = 0.95) -> Figure:
    """Gain, phase and coherence over the frequency, with confidence bands."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(7.5, 7.0), layout="constrained")
    gain, phase, coherence = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 2))
    style: dict[str, Any] = {"linewidth": 1.0} if found.method != "periodic" else {"linewidth": 0, "marker": "."}
    low, high = found.gain_confidence(level)
    floor = 0.1 * float(np.min(found.gain))
    gain.fill_between(found.frequencies, np.maximum(low, floor), high, color=BLUE, alpha=0.2, linewidth=0,
                      label=f"{100.0 * level:g} %")  # fmt: skip
    gain.plot(found.frequencies, found.gain, color=BLUE, label=found.method, **style)
    gain.set(yscale="log", ylabel="gain")
    gain.set_ylim(0.5 * float(np.min(found.gain)), 2.0 * float(np.max(found.gain)))
    degrees, wide = np.degrees(found.phase), np.degrees(found.phase_confidence(level))
    phase.fill_between(found.frequencies, degrees - wide, degrees + wide, color=VERMILION, alpha=0.2, linewidth=0)
    phase.plot(found.frequencies, degrees, color=VERMILION, **style)
    phase.set_ylabel("phase (deg)")
    coherence.plot(found.frequencies, found.coherence, color=GREEN, **style)
    coherence.set(ylim=(0.0, 1.05), ylabel="coherence", xlabel="frequency (Hz)", xscale="log")
    for axes in (gain, phase, coherence):
        axes.grid(which="both", color="0.92", linewidth=0.6)
        axes.margins(x=0)
    gain.legend(frameon=False, fontsize="small")
    if title:
        gain.set_title(escape.figure(title), fontsize="medium")
    figure.align_ylabels()
    return figure
