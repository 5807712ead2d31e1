"""Amplitudes of known lines in a record: least squares, a fitted fundamental, and the FFT for comparison."""

from leadscrew.analysis.harmonics.fft import Spectrum, spectrum
from leadscrew.analysis.harmonics.fundamental import Fundamental, fitted_fundamental
from leadscrew.analysis.harmonics.lines import Harmonics, LineFit, least_squares
from leadscrew.analysis.harmonics.record import Sampling, folded, sampling

__all__ = [
    "Fundamental", "Harmonics", "LineFit", "Sampling", "Spectrum", "fitted_fundamental", "folded", "least_squares",
    "sampling", "spectrum",
]  # fmt: skip
