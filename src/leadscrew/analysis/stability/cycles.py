"""What a limit-cycle prediction returns: the cycles, the loop at rest, what to distrust, a report and a figure.

A prediction is no proof: it says which oscillations a loop of a static nonlinearity sustains, up to the harmonics that
were counted. See :mod:`leadscrew.analysis.stability.harmonic_balance` and
:mod:`leadscrew.analysis.stability.harmonic_balance`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

PHASES = 4096
"""At which a wave is looked through for its peaks."""


def shown(unit: str) -> tuple[float, str]:
    """The factor and the unit in which a value is written: mm in um, anything else as it is."""
    return (1e3, "um") if unit == "mm" else (1.0, unit)


@dataclass(frozen=True)
class LimitCycle:
    """One self-sustained oscillation of the error, in mm: ``e = Re(sum over n of harmonics[n] e^(j n theta))``."""

    frequency_hz: float
    harmonics: tuple[complex, ...]
    """Mean error, fundamental (real, positive), second harmonic, ...; mm."""
    gain: float
    """``N``: fundamental of the curve's output over the fundamental of the error."""
    stable: bool
    """Whether the loop returns to it after a small change of amplitude."""
    growth: float
    """Rate in 1/s at which a small deviation of the amplitude grows; negative where it dies away."""
    left_out: float
    """Largest harmonic of the error that the balance has left out, as a part of the fundamental."""

    @property
    def amplitude(self) -> float:
        """Of the fundamental, half of peak to peak, mm."""
        return abs(self.harmonics[1])

    @property
    def bias(self) -> float:
        """Mean error, mm."""
        return self.harmonics[0].real

    def wave(self, phase: Any) -> np.ndarray:
        """The error in mm at these phases in rad."""
        angles = np.multiply.outer(np.asarray(phase, dtype=float), np.arange(len(self.harmonics)))
        return np.asarray((np.exp(1j * angles) @ np.array(self.harmonics)).real)

    @property
    def peak_to_peak(self) -> float:
        """Largest minus smallest error, mm."""
        if len(self.harmonics) == 2:
            return 2.0 * self.amplitude
        lines = np.zeros(PHASES // 2 + 1, dtype=complex)
        lines[: len(self.harmonics)] = np.array(self.harmonics) * 0.5 * PHASES
        lines[0] = 0.0
        return float(np.ptp(np.fft.irfft(lines, PHASES)))

    def as_dict(self) -> dict[str, Any]:
        """For JSON; complex numbers as pairs."""
        return {
            "frequency_hz": self.frequency_hz, "amplitude": self.amplitude, "bias": self.bias,
            "peak_to_peak": self.peak_to_peak, "gain": self.gain, "stable": self.stable,
            "growth_per_s": self.growth, "left_out": self.left_out,
            "harmonics": [[h.real, h.imag] for h in self.harmonics],
        }  # fmt: skip


@dataclass(frozen=True)
class Locus:
    """What the picture is drawn from."""

    amplitude: np.ndarray
    """mm."""
    gain: np.ndarray
    """``N`` at each amplitude, the mean error following as the load asks."""
    response: np.ndarray
    """``G`` over a range of frequencies around the crossings."""


@dataclass(frozen=True)
class CyclePrediction:
    """The limit cycles of a loop with a static nonlinearity under a constant load."""

    criterion: str
    """``describing function``, or ``harmonic balance, N harmonics``."""
    loop: str
    """Its name."""
    dt: float | None
    dead_time: float
    load: float
    """What the curve has to give on average, mm."""
    rest_error: float
    """Error at rest under the load, mm."""
    rest_slope: float
    """Slope of the curve there: the local loop gain, relative to the linear part."""
    crossings: tuple[tuple[float, float], ...]
    """Phase crossovers: frequency in Hz, and the gain ``-1 / G`` that sustains an oscillation there."""
    rest_stable: bool
    """Whether the loop, closed with the slope at rest, is stable."""
    cycles: tuple[LimitCycle, ...]
    """By rising amplitude; unstable ones are the edge between rest and a larger cycle."""
    warnings: list[str] = field(default_factory=list)
    locus: Locus | None = field(default=None, compare=False, repr=False)
    grade: str = "prediction"
    unit: str = "mm"
    """Of the curve's argument, and so of every amplitude."""

    @property
    def stable_cycles(self) -> tuple[LimitCycle, ...]:
        """Those that the loop can be seen in."""
        return tuple(c for c in self.cycles if c.stable)

    @property
    def statement(self) -> str:
        """What is predicted, in one sentence."""
        seen = self.stable_cycles
        factor, unit = shown(self.unit)
        said = (
            f"{factor * seen[-1].peak_to_peak:.3g} {unit} from peak to peak at {seen[-1].frequency_hz:.4g} Hz"
            if seen
            else ""
        )
        if not self.rest_stable:
            return (
                f"The loop does not come to rest: it chatters, {said}." if seen else "The loop does not come to rest."
            )
        if not seen:
            return "The loop comes to rest; no limit cycle was found."
        kick = [c for c in self.cycles if not c.stable and c.amplitude < seen[-1].amplitude]
        beyond = f" by more than about {factor * kick[-1].amplitude:.3g} {unit}" if kick else ""
        return f"The loop stays at rest, but once disturbed{beyond} it chatters, {said}."

    @property
    def shown_in(self) -> tuple[float, str]:
        """The factor and the unit in which its errors are written."""
        return shown(self.unit)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "criterion": self.criterion, "grade": self.grade, "statement": self.statement, "loop": self.loop,
            "dt": self.dt, "dead_time": self.dead_time, "unit": self.unit, "load": self.load,
            "rest_error": self.rest_error,
            "rest_slope": self.rest_slope, "rest_stable": self.rest_stable,
            "crossings": [{"frequency_hz": f, "gain": k} for f, k in self.crossings],
            "cycles": [c.as_dict() for c in self.cycles], "warnings": list(self.warnings),
        }  # fmt: skip

    def report(self) -> str:
        """The prediction in words, a line each."""
        kind = f"sampled at {1e-3 / self.dt:g} kHz" if self.dt else f"continuous, dead time {1e3 * self.dead_time:g} ms"
        factor, unit = shown(self.unit)
        limit = min((k for _, k in self.crossings), default=math.inf)
        lines = [
            f"Limit cycles by {self.criterion} ({self.grade}, not a proof)",
            f"  loop         {self.loop or 'unnamed'}, {kind}",
            f"  at rest      error {factor * self.rest_error:.4g} {unit}, slope {self.rest_slope:.4g}, "
            f"least gain that oscillates {limit:.4g}: {'stable' if self.rest_stable else 'unstable'}",
        ]
        for c in self.cycles:
            lines.append(
                f"  cycle        {factor * c.peak_to_peak:.4g} {unit} peak to peak about {factor * c.bias:.4g} {unit} "
                f"at {c.frequency_hz:.5g} Hz, {'stable' if c.stable else 'unstable'} ({c.growth:+.3g} 1/s)"
            )
        lines.append(f"  {self.statement}")
        lines += [f"  warning      {w}" for w in self.warnings]
        return "\n".join(lines)

    def figure(self) -> Any:
        """Nyquist curve with the locus ``-1 / N(A)``, and ``N`` against amplitude with the gain of each crossing."""
        from leadscrew.figures.stability import cycles_figure

        return cycles_figure(self)
