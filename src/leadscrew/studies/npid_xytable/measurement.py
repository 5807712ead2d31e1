"""How well amplitudes like those of Table II can be measured: a record whose lines are known, and ways to read it.

The record has the following error of a motion of 1 mm at 0.7 Hz under Table I's PID, 7.12 um, and the five lines of the
PID column at 1,000 1/min, sampled at 2 kHz. The paper says only "Fast Fourier Transform": no length, no window. The
phases are ours.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadscrew.analysis.harmonics import Sampling, least_squares, spectrum
from leadscrew.analysis.harmonics.lines import Reading, Window
from leadscrew.studies.npid_xytable.calibration import PERIOD_S, responses
from leadscrew.studies.npid_xytable.table2 import BASE_HZ, LINES_HZ, PID_UM

MOTION_UM = 1e3 * abs(responses(BASE_HZ)[0])
"""Following error at 1 mm under Table I's PID in L*: 7.12 um."""
LABELS_HZ = (2.0, 3.5, 5.0, 6.3, 7.7)
"""Frequencies as printed."""
COHERENT, SHORT, LONG = 20000, 8192, 16384
"""Samples: seven periods of 0.7 Hz, and two powers of two as an FFT of the time would take."""

FREQUENCIES_HZ = (BASE_HZ, *LINES_HZ)
AMPLITUDES_UM = (MOTION_UM, *PID_UM[1000])
PHASES = (0.3, *np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, len(LINES_HZ)).tolist())


def record_um(samples: int, phases: Sequence[float] = PHASES) -> tuple[Sampling, np.ndarray]:
    """The record: its sampling, and the error in um."""
    taken = Sampling(samples, 0.0, PERIOD_S)
    angle = 2.0 * np.pi * np.multiply.outer(np.array(FREQUENCIES_HZ), taken.time) + np.array(phases)[:, None]
    return taken, np.array(AMPLITUDES_UM) @ np.sin(angle)


def percent(measured: np.ndarray) -> np.ndarray:
    """Error of measured amplitudes of the five lines, % of the true one."""
    return 100.0 * (measured / np.array(AMPLITUDES_UM[1:]) - 1.0)


def by_fft(samples: int, window: Window, reading: Reading = "nearest", phases: Sequence[float] = PHASES) -> np.ndarray:
    """Error of the five lines read off an FFT, %."""
    taken, y = record_um(samples, phases)
    return percent(spectrum(taken, y, window).amplitude(LINES_HZ, reading))


def by_least_squares(samples: int, lines: Sequence[float] = LINES_HZ) -> np.ndarray:
    """Error of the five lines by least squares at frequencies, together with the motion's own, %."""
    taken, y = record_um(samples)
    return percent(least_squares(taken, y, (BASE_HZ, *lines), noise="none").amplitudes[1:])


def encoded(
    runs: int, phases: Sequence[float] = PHASES, count_um: float = 0.5, noise_um: float = 0.1, seed: int = 1
) -> np.ndarray:
    """Amplitudes of the five lines in ``runs`` coherent records of an encoder, by least squares, um, ``(runs, 5)``."""
    taken, y = record_um(COHERENT, phases)
    noise = noise_um * np.random.default_rng(seed).standard_normal((runs, taken.samples))
    seen = count_um * np.round((y + noise) / count_um)
    return least_squares(taken, seen, FREQUENCIES_HZ, noise="none").amplitudes[:, 1:]


def turned(draws: int, seed: int = 2) -> np.ndarray:
    """Random phases of the motion and the five lines, rad, ``(draws, 6)``."""
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (draws, len(FREQUENCIES_HZ)))
