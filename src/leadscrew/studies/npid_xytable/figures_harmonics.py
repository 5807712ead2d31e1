"""How amplitudes of Table II's size are read: windows beside least squares; and spectra of simulated errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.harmonics import Sampling, spectrum
from leadscrew.report.style import BLACK, BLUE, GREEN, ORANGE, VERMILION, colour
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, LINES_HZ
from leadscrew.studies.npid_xytable.columns import PID_UM
from leadscrew.studies.npid_xytable.measured_loop import loop_figure
from leadscrew.studies.npid_xytable.measurement import COHERENT, LONG, SHORT, by_fft, by_least_squares, turned
from leadscrew.studies.npid_xytable.runs import Loops, amplitudes_um
from leadscrew.studies.study import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WAYS = (
    ("no window", "rectangular", VERMILION, "o"), ("Hann", "hann", BLUE, "s"), ("flat-top", "flattop", GREEN, "^"),
)  # fmt: skip
HIGHEST_HZ = 60.0
DRAWS = 60
SHOWN = ("corrected.npid_um", "paper.pid")
"""In the order of the paper's figures."""


def harmonics_pictures(loops: Loops) -> list[Picture]:
    """Three pictures."""
    return [
        Picture(
            "windows",
            "Errors of the five amplitudes at 1,000 1/min read off an FFT at the nearest bin, over sixty draws of the "
            "phases (bars: all of them); least squares at the lines' frequencies beside it",
            windows,
        ),
        Picture(
            "fft_1000_simulated",
            "Spectra of the simulated error at 1,000 1/min over the last 10 s, seven periods of the motion (Hann: the "
            "spindle's lines at 16.7 and 33.3 Hz are not coherent). Crosses: the five amplitudes by least squares; "
            "dots: Table II, PID",
            lambda: spectra([(name, loops.run(name, "spindle_1000")) for name in SHOWN]),
        ),
        Picture(
            "measured_loop",
            "Gain of the broken loop L* as a log tells it: a swept command of 0.1 mm over 20 s, an encoder of 0.5 um "
            "with noise, segments of 2 s; below 5 Hz they are too short",
            lambda: loop_figure(loops),
        ),
    ]


def windows() -> Figure:
    """Errors of the FFT's amplitudes for two lengths that are not coherent, and for the coherent one."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 4.0), layout="constrained")
    places = np.arange(len(LINES_HZ))
    for axes, samples in zip(figure.subplots(1, 3, sharey=True), (SHORT, LONG, COHERENT), strict=True):
        for k, (label, window, ink, mark) in enumerate(WAYS):
            found = np.array([by_fft(samples, window, phases=tuple(p)) for p in turned(DRAWS)])  # type: ignore[arg-type]
            middle = np.median(found, axis=0)
            spread = np.abs(np.array([found.min(axis=0), found.max(axis=0)]) - middle)
            axes.errorbar(places + 0.2 * (k - 1.5), middle, yerr=spread, fmt=mark, color=ink, capsize=3, markersize=5,
                          label=label if samples == SHORT else None)  # fmt: skip
        axes.plot(places + 0.3, by_least_squares(samples), "x", color=BLACK, markersize=7,
                  label="least squares" if samples == SHORT else None)  # fmt: skip
        axes.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
        seconds = samples / 2000.0
        coherent = ", coherent" if samples == COHERENT else ""
        axes.set_title(f"{samples} samples, {seconds:g} s{coherent}", fontsize="medium")
        axes.set_xticks(places, [f"{hz:.1f}" for hz in LINES_HZ])
        axes.set_xlabel("line (Hz)")
        axes.grid(axis="y", color="0.9", linewidth=0.6)
    figure.axes[0].set_ylabel("error of the amplitude (%)")
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure


def spectra(runs: list[tuple[str, Any]]) -> Figure:
    """Amplitude spectra of the true error in the second half of runs, one panel each: ``(name, run)``."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 1.0 + 2.4 * len(runs)), layout="constrained")
    for axes, (name, run) in zip(
        np.atleast_1d(figure.subplots(len(runs), 1, sharex=True, sharey=True)), runs, strict=True
    ):
        error = 1e3 * run["true_error"]
        error = error[len(error) // 2 :]
        step = float(run.time[1] - run.time[0])
        seen = spectrum(Sampling(len(error), 0.0, step), error, "hann")
        shown = (seen.frequencies > 0.0) & (seen.frequencies <= HIGHEST_HZ)
        axes.vlines(seen.frequencies[shown], 1e-5, np.maximum(seen.amplitudes[shown], 1e-5), color=colour(name))
        axes.plot(LINES_HZ, amplitudes_um(run), "x", color=BLACK, markersize=7, label="least squares")
        axes.plot(LINES_HZ, PID_UM[1000], ".", color=ORANGE, markersize=7, label="Table II, PID")
        axes.annotate(f"motion, {BASE_HZ:g} Hz", (BASE_HZ, float(seen.amplitudes.max())), (5, 0),
                      textcoords="offset points", fontsize="small", va="center")  # fmt: skip
        axes.set_yscale("log")
        axes.set(ylim=(1e-4, 30.0), xlim=(0.0, HIGHEST_HZ), ylabel="amplitude (µm)")
        axes.set_title(name, fontsize="medium")
        axes.grid(color="0.92", linewidth=0.6)
    figure.axes[0].legend(loc="upper right", fontsize="small")
    figure.axes[-1].set_xlabel("frequency (Hz)")
    return figure
