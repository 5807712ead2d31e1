"""Amplitudes of known lines in a record: least squares, a fitted fundamental, and the FFT for comparison."""

from leadscrew.analysis.harmonics.lines import (
    Fundamental,
    Harmonics,
    LineFit,
    Spectrum,
    fitted_fundamental,
    least_squares,
    spectrum,
)
from leadscrew.analysis.harmonics.record import Sampling, folded, sampling

__all__ = [
    "Fundamental", "Harmonics", "LineFit", "Sampling", "Spectrum", "fitted_fundamental", "folded", "least_squares",
    "sampling", "spectrum",
]  # fmt: skip
