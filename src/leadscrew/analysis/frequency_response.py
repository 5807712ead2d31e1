"""Frequency response from logged signals, with coherence and confidence: open or inside a closed loop.

For an input ``x`` and an output ``y`` with averaged spectra ``S`` (Welch: Hann segments, half overlapped, means out):

| estimate | equation | right where |
|---|---|---|
| ``H1`` | ``S_xy / S_xx`` | noise is on the output only |
| ``H2`` | ``S_yy / S_yx`` | noise is on the input only |
| ``joint`` | ``S_ry / S_rx`` | ``r`` is an excitation from outside the loop: noise circulates in ``x`` and ``y`` |
| loop gain | ``S_rb / S_rf`` | ``f`` enters the broken loop, ``b`` comes back: error, feedback; ``L = T / (1 - T)`` |

Inside a loop, H1 of plant or controller is biased towards the inverse of the rest of the loop wherever noise is not
small (Ljung, *System Identification*); ``joint`` is not. Coherence is ``abs(S_xy)^2 / (S_xx S_yy)``.

Confidence: variance of a quadrature of the estimate ``S_vv S_rr / (2 n_d abs(S_rx)^2)``, ``v = y - H x``, with
Student's t at ``2 n_d - 2`` degrees of freedom; for H1 it is the well-known ``(1 - c) / (2 n_d c)`` of the gain (Bendat
and Piersol, *Random Data*). ``n_d`` are the segments less what their overlap repeats (Welch 1967). It holds for
stationary Gaussian noise, and says nothing of leakage: segments must be longer than the loop's memory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.analysis.harmonics.record import Array, Sampling, checked_level, sampling, values
from leadscrew.util.errors import DataError, ValueRefused

if TYPE_CHECKING:
    from control import FrequencyResponseData

Complex = NDArray[np.complex128]
Method = Literal["H1", "H2"]

SEGMENTS = 8
"""Segments, not counting overlap, unless a length is given."""
COHERENT = 0.8
"""Coherence below which a note says that the log does not tell the response."""
EXCITED = 1e-3
"""Of the largest line of a periodic input: what counts as excited."""


@dataclass(frozen=True)
class FrequencyResponse:
    """A measured response at rising frequencies."""

    frequencies: Array
    """Hz, from the first one above zero."""
    response: Complex
    """Output per input, in their units."""
    coherence: Array
    """0 to 1: the share of the output that is linear in the input; of a joint estimate the smaller one with the
    excitation."""
    deviation: Array
    """Relative standard deviation of the gain; in rad that of the phase."""
    dof: float
    """Degrees of freedom of the deviation."""
    method: str
    averages: float
    """Independent segments, or periods."""
    segment_s: float
    """Length of a segment, or of a period; its inverse is the distance of the frequencies."""
    notes: tuple[str, ...] = ()

    @property
    def gain(self) -> Array:
        """Magnitude."""
        return np.abs(self.response)

    @property
    def gain_db(self) -> Array:
        """Magnitude in dB."""
        with np.errstate(divide="ignore"):
            return np.asarray(20.0 * np.log10(self.gain))

    @property
    def phase(self) -> Array:
        """Angle in rad, unwrapped from the lowest frequency."""
        return np.asarray(np.unwrap(np.angle(self.response)))

    def gain_confidence(self, level: float = 0.95) -> tuple[Array, Array]:
        """Lower (not below 0) and upper end of the gain's confidence interval."""
        wide = self.gain * self.deviation * self._student(level)
        return np.maximum(self.gain - wide, 0.0), self.gain + wide

    def phase_confidence(self, level: float = 0.95) -> Array:
        """Half width of the phase's confidence interval, rad; pi where the log does not tell it."""
        wide = self.deviation * self._student(level)
        return np.where(wide < 1.0, np.arcsin(np.minimum(wide, 1.0)), np.pi)

    def within(self, low: float, high: float) -> FrequencyResponse:
        """The part from ``low`` to ``high`` Hz.

        Raises:
            ValueRefused: no frequency of the response lies there.
        """
        kept = (self.frequencies >= low) & (self.frequencies <= high)
        if not kept.any():
            raise ValueRefused(
                f"from {low:g} to {high:g} Hz: the response has frequencies every {1.0 / self.segment_s:g} Hz from "
                f"{self.frequencies[0]:g} to {self.frequencies[-1]:g} Hz, none of them there"
            )
        return FrequencyResponse(
            self.frequencies[kept], self.response[kept], self.coherence[kept], self.deviation[kept], self.dof,
            self.method, self.averages, self.segment_s, self.notes,
        )  # fmt: skip

    def to_control(self) -> FrequencyResponseData:
        """The response for python-control: its Bode and Nyquist plots, margins, connections."""
        import control

        return control.frd(self.response, 2.0 * np.pi * self.frequencies)

    def as_dict(self, level: float = 0.95) -> dict[str, Any]:
        """Everything for JSON."""
        low, high = self.gain_confidence(level)
        return {
            "method": self.method, "averages": self.averages, "segment_s": self.segment_s, "confidence_level": level,
            "frequency_hz": self.frequencies.tolist(), "gain": self.gain.tolist(), "phase_rad": self.phase.tolist(),
            "coherence": self.coherence.tolist(), "gain_low": low.tolist(), "gain_high": high.tolist(),
            "phase_half_width_rad": self.phase_confidence(level).tolist(), "notes": list(self.notes),
        }  # fmt: skip

    def _student(self, level: float) -> float:
        from scipy.special import stdtrit

        return float(stdtrit(self.dof, 0.5 + 0.5 * checked_level(level)))


def frequency_response(
    t: Any,
    x: Any,
    y: Any,
    *,
    method: Method = "H1",
    excitation: Any = None,
    segment: float | None = None,
    overlap: float = 0.5,
) -> FrequencyResponse:
    """The response from ``x`` to ``y``, each one record over evenly spaced times ``t`` in s.

    Args:
        t: evenly spaced times, s.
        x: the input.
        y: the output.
        method: ``H1`` or ``H2``, where no excitation is given.
        excitation: a signal from outside the loop (command, injected disturbance): gives the ``joint`` estimate.
        segment: length of a segment in s; an eighth of the record unless given.
        overlap: share of a segment that the next one repeats, 0 to 0.9.

    Raises:
        DataError: times that are not even, a value that is not finite, or an input or excitation that does not move.
        ValueRefused: a signal that does not fit ``t``, a segment too short or so long that fewer than two fit.
    """
    taken = t if isinstance(t, Sampling) else sampling(t, 16)
    given = {"x": x, "y": y} | ({} if excitation is None else {"excitation": excitation})
    seen = {name: _one(value, taken, name) for name, value in given.items()}
    if method not in ("H1", "H2"):
        raise ValueRefused(f"method = {method!r}: expected 'H1' or 'H2'; an excitation gives the joint estimate")
    if not 0.0 <= overlap <= 0.9:
        raise ValueRefused(f"overlap = {overlap!r}: allowed range is [0, 0.9] of a segment")
    for name in ("excitation", "x") if excitation is not None else ("x",) if method == "H1" else ("y",):
        if np.ptp(seen[name]) == 0.0:
            raise DataError(f"{name} does not move: a constant signal tells no response")
    size = _segment(taken, segment)
    step = max(1, size - int(overlap * size))
    count = 1 + (taken.samples - size) // step
    tool = seen["excitation"] if excitation is not None else seen["x"] if method == "H1" else seen["y"]
    spectra = _Spectra(taken, size, size - step)
    rx, ry, rr = (spectra.cross(tool, other) for other in (seen["x"], seen["y"], tool))
    xx, yy, xy = spectra.cross(seen["x"], seen["x"]), spectra.cross(seen["y"], seen["y"]), spectra.cross(
        seen["x"], seen["y"])  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        found = ry / rx
        left = np.maximum((yy + np.abs(found) ** 2 * xx - 2.0 * np.real(np.conj(found) * xy)).real, 0.0)
        averages = _independent(count, step, spectra.window)
        deviation = np.sqrt(left * rr.real / (2.0 * averages * np.abs(rx) ** 2)) / np.abs(found)
        if excitation is None:
            coherence = np.abs(xy) ** 2 / (xx * yy).real
        else:
            coherence = np.minimum(np.abs(rx) ** 2 / (rr * xx).real, np.abs(ry) ** 2 / (rr * yy).real)
    told = np.isfinite(found) & np.isfinite(deviation) & np.isfinite(coherence)
    told[0] = False
    if not told.any():
        raise DataError("the input has no power at any frequency above zero")
    frequencies = np.arange(len(found)) / (size * taken.step)
    coherence = np.clip(coherence, 0.0, 1.0)
    return FrequencyResponse(
        frequencies[told], found[told], coherence[told], deviation[told], max(2.0 * averages - 2.0, 1.0),
        "joint" if excitation is not None else method, averages, size * taken.step,
        tuple(_notes(frequencies[told], coherence[told])),
    )  # fmt: skip


def loop_gain(
    t: Any,
    forward: Any,
    back: Any,
    excitation: Any,
    segment: float | None = None,
    overlap: float = 0.5,
) -> FrequencyResponse:
    """The gain of the broken loop from a log of the closed one: ``L`` of ``1 / (1 + L)``, delays included.

    Args:
        t: evenly spaced times, s.
        forward: what enters the broken loop: the error where a command excites it, the sum after the point where a
            disturbance is injected.
        back: what comes back, with the sign in which ``forward`` = excitation - ``back``: the feedback, or minus the
            signal before the injection.
        excitation: the command or the disturbance, in the same unit.
        segment: length of a segment in s, as in :func:`frequency_response`.
        overlap: share of a segment that the next one repeats.

    Raises:
        DataError: ``forward`` is not the excitation minus ``back``; what :func:`frequency_response` refuses.
        ValueRefused: what :func:`frequency_response` refuses.
    """
    taken = t if isinstance(t, Sampling) else sampling(t, 16)
    f, b, r = (_one(v, taken, n) for v, n in ((forward, "forward"), (back, "back"), (excitation, "excitation")))
    off = f - (r - b)
    off = off - np.mean(off)
    if np.sqrt(np.mean(off**2)) > 1e-3 * max(float(np.std(f)), float(np.std(b))):
        raise DataError(
            "forward is not the excitation minus back (they differ by "
            f"{np.sqrt(np.mean(off**2)):.3g} rms): this is no loop with unity negative feedback at that point"
        )
    return frequency_response(taken, f, b, excitation=r, segment=segment, overlap=overlap)


def periodic_response(
    t: Any, x: Any, y: Any, period: float, *, excitation: Any = None, settle: int = 1
) -> FrequencyResponse:
    """The response at the lines of a periodic excitation: no leakage, noise from what differs between the periods.

    The first ``settle`` periods are left out, the last whole ones are averaged. With an ``excitation`` (command,
    disturbance) lines count by its power and the estimate is the ratio of means, which is right inside a loop too.
    Variance of a quadrature: ``sum abs(V_p)^2 / (2 P (P - 1) abs(X)^2)`` with ``V_p = Y_p - H X_p`` of period ``p``.

    Raises:
        DataError: times that are not even, or an input without a line.
        ValueRefused: a period that is no whole number of samples, or fewer than two periods after settling.
    """
    taken = t if isinstance(t, Sampling) else sampling(t, 16)
    u, v = _one(x, taken, "x"), _one(y, taken, "y")
    r = u if excitation is None else _one(excitation, taken, "excitation")
    samples = round(period * taken.rate) if 0.0 < period < np.inf else 0
    if samples < 4 or abs(samples * taken.step - period) > 1e-6 * period:
        raise ValueRefused(
            f"period = {period!r} s: expected a whole number of samples of {taken.step:g} s, at least 4 of them"
        )
    periods = taken.samples // samples - settle
    if settle < 0 or periods < 2:
        raise ValueRefused(
            f"{taken.samples * taken.step:g} s hold {taken.samples // samples} periods of {period:g} s; expected "
            f"{settle} to settle and at least 2 more"
        )
    parts = [np.fft.rfft(s[-periods * samples :].reshape(periods, samples)) for s in (u, v, r)]
    whole_u, whole_v, whole_r = (p.mean(axis=0) for p in parts)
    lines = np.flatnonzero(np.abs(whole_r) > EXCITED * np.max(np.abs(whole_r[1:]), initial=0.0))
    lines = lines[(lines > 0) & (np.abs(whole_u[lines]) > 0.0)]
    if not len(lines):
        raise DataError("the excitation has no line above zero: a constant signal tells no response")
    found = whole_v[lines] / whole_u[lines]
    scatter = parts[1][:, lines] - found * parts[0][:, lines]
    power = np.sum(np.abs(scatter) ** 2, axis=0) / (2.0 * periods * (periods - 1))
    deviation = np.sqrt(power) / np.abs(whole_u[lines]) / np.abs(found)
    together = np.abs(np.mean(parts[1][:, lines] * np.conj(parts[0][:, lines]), axis=0)) ** 2
    apart = np.mean(np.abs(parts[0][:, lines]) ** 2, axis=0) * np.mean(np.abs(parts[1][:, lines]) ** 2, axis=0)
    coherence = np.clip(together / apart, 0.0, 1.0)
    frequencies = lines / (samples * taken.step)
    return FrequencyResponse(
        frequencies, found, coherence, deviation, 2.0 * (periods - 1), "periodic", float(periods),
        samples * taken.step, tuple(_notes(frequencies, coherence)),
    )  # fmt: skip


class Margins(NamedTuple):
    """Margins of a measured loop gain; ``None`` where the log shows no crossover."""

    gain_margin: float | None
    """Factor by which the gain may grow: the smallest, at a crossing of -180 degrees."""
    phase_crossover_hz: float | None
    phase_margin_deg: float | None
    gain_crossover_hz: float | None
    sensitivity: float | None
    """Largest ``abs(1 / (1 + L))``."""
    sensitivity_hz: float | None


def measured_margins(loop: FrequencyResponse, least: float = COHERENT) -> Margins:
    """Margins of a measured loop gain, from the frequencies whose coherence is at least ``least``.

    Crossovers are found by python-control (``stability_margins`` of gain, phase and frequency), between the measured
    frequencies by interpolation.
    """
    from control import stability_margins

    told = loop.coherence >= least
    if told.sum() < 3:
        return Margins(None, None, None, None, None, None)
    w = 2.0 * np.pi * loop.frequencies[told]
    response = loop.response[told]
    phase = np.degrees(np.unwrap(np.angle(response)))
    found = stability_margins((np.abs(response), phase, w))
    gain, degrees, _, at_gain, at_phase, _ = (_finite(x) for x in found)
    hertz = 1.0 / (2.0 * np.pi)
    sensitivity = np.abs(1.0 / (1.0 + response))
    k = int(np.argmax(sensitivity))
    return Margins(
        gain, None if gain is None or at_gain is None else at_gain * hertz,
        degrees, None if degrees is None or at_phase is None else at_phase * hertz,
        float(sensitivity[k]), float(loop.frequencies[told][k]),
    )  # fmt: skip


def _finite(x: Any) -> float | None:
    return float(x) if x is not None and np.isfinite(x) else None


class _Spectra:
    """Averaged cross spectra of one set of segments."""

    def __init__(self, taken: Sampling, size: int, repeated: int) -> None:
        from scipy.signal.windows import hann

        self.window = np.asarray(hann(size, sym=False))
        self.options = {"fs": taken.rate, "nperseg": size, "noverlap": repeated, "detrend": "constant"}

    def cross(self, one: Array, other: Array) -> Complex:
        """Mean over the segments of conj(one) times other."""
        from scipy.signal import csd

        return np.asarray(csd(one, other, window=self.window, **self.options)[1], dtype=np.complex128)


def _one(given: Any, taken: Sampling, name: str) -> Array:
    found = values(given, taken.samples, name)
    if found.ndim != 1:
        raise ValueRefused(f"{name} has the shape {found.shape}; expected one record of {taken.samples} samples")
    return found


def _segment(taken: Sampling, segment: float | None) -> int:
    size = taken.samples // SEGMENTS if segment is None else 0
    if segment is not None and 0.0 < segment < np.inf:
        size = round(segment * taken.rate)
    if size < 8 or size > taken.samples // 2:
        raise ValueRefused(
            f"segment = {taken.duration / SEGMENTS if segment is None else segment:g} s: expected between "
            f"{8 * taken.step:g} s (8 samples) and {0.5 * taken.duration:g} s (half of the record)"
        )
    return size


def _independent(count: int, step: int, window: Array) -> float:
    """Segments less what their overlap repeats (Welch 1967)."""
    total = float(np.sum(window**2))
    repeated = 0.0
    for k in range(1, count):
        if k * step >= len(window):
            break
        shared = float(np.sum(window[k * step :] * window[: -k * step])) / total
        repeated += 2.0 * (count - k) / count * shared**2
    return count / (1.0 + repeated)


def _notes(frequencies: Array, coherence: Array) -> list[str]:
    bad = coherence < COHERENT
    if not bad.any():
        return []
    said = f"from {frequencies[bad][0]:g} to {frequencies[bad][-1]:g} Hz" if bad.sum() > 1 else (
        f"at {frequencies[bad][0]:g} Hz")  # fmt: skip
    return [
        f"coherence below {COHERENT:g} at {bad.sum()} of {len(bad)} frequencies, {said}: there the log does not tell "
        "the response; excite more, or average longer"
    ]
