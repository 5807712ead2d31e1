"""One loop, one curve, one load: what describing function and harmonic balance both start from.

The equations are in :mod:`leadscrew.analysis.stability.describing`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from leadscrew.analysis.stability.crossings import phase_crossings
from leadscrew.analysis.stability.cycles import CyclePrediction, LimitCycle, Locus, shown
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.kernel.errors import ValueRefused

Curve = Callable[[Any], Any]
"""``phi``: error in mm to error in mm, element by element on arrays."""

POINTS = 4096
"""Phases over half a turn."""
SCAN_POINTS = 192
SCAN_AMPLITUDES = 320
SETTLED = 1e-12
HALVINGS = 60
LARGE_HARMONIC = 0.25
"""Part of the fundamental above which a harmonic that was left out is worth a warning."""


class Described(NamedTuple):
    """What a curve gives for ``bias + amplitude cos theta``."""

    mean: np.ndarray
    gain: np.ndarray
    """``N``: the fundamental over the amplitude."""


def half_turn(points: int) -> np.ndarray:
    """``cos theta`` at the middles of ``points`` equal parts of half a turn."""
    return np.cos(np.pi * (np.arange(points) + 0.5) / points)


ALTERNATING = np.array([1.0, -1.0])
"""The two phases of an oscillation at half the sampling frequency."""


def described_by(phi: Curve, size: np.ndarray, bias: np.ndarray, cosines: np.ndarray) -> Described:
    """Mean and fundamental for arrays of amplitudes and biases, over the phases with these cosines."""
    seen = np.asarray(phi(bias[..., None] + size[..., None] * cosines), dtype=float)
    if not np.isfinite(seen).all():
        raise ValueRefused("describing_function: the curve gives a value that is not finite")
    return Described(seen.mean(-1), (seen @ cosines) / (size * (cosines @ cosines)))


def curve_function(curve: Any, reach: float | None = None) -> Curve:
    """A function of arrays; a Lure works point by point, and is tabulated where ``reach`` says how far it is asked."""
    law = getattr(curve, "curve", None)
    if law is None:
        if not callable(curve):
            raise ValueRefused(f"curve = {curve!r}: a function of the error in mm, or what lure() gives, is wanted")
        return on_arrays(curve)
    if getattr(curve, "dependent", False):
        raise ValueRefused(
            f"{curve.block.name}: its gain stands behind the linear part and multiplies all of it; a describing "
            "function is of a static map of the error in front of it. Simulate this one"
        )
    if reach is None:
        return law
    scale = curve.scale_mm if math.isfinite(curve.scale_mm) else reach
    x = np.arcsinh(1e3 * reach / scale) * np.linspace(-1.0, 1.0, 40001)
    errors = scale * np.sinh(x) / 1e3
    values = np.asarray(law(errors))
    return lambda e: np.interp(e, errors, values)


def on_arrays(curve: Curve) -> Curve:
    """The curve itself, or one that calls it point by point where it only takes numbers."""
    try:
        if np.shape(curve(np.array([0.5, 1.0]))) == (2,):
            return curve
    except (TypeError, ValueError):
        pass
    return np.vectorize(curve, otypes=[float])


class Task:
    """One loop, one curve, one load: what both predictions start from."""

    def __init__(
        self,
        loop: LinearLoop,
        curve: Any,
        load: float,
        static_gain: float,
        amplitudes: tuple[float, float],
        unit: str = "mm",
    ) -> None:
        self.unit = unit
        self.shown = shown(unit)
        self.least, self.most = (float(a) for a in amplitudes)
        if not 0.0 < self.least < self.most < math.inf:
            raise ValueRefused(
                f"amplitudes = {amplitudes!r}: smallest and largest in {unit} are wanted, 0 < small < large"
            )
        if not static_gain > 0.0 or not math.isfinite(load):
            raise ValueRefused(f"load = {load!r}, static_gain = {static_gain!r}: a finite load and a gain above 0")
        self.loop, self.load, self.slack = loop, float(load), 1.0 / static_gain
        self.phi = curve_function(curve, 4.0 * self.most + 4.0 * abs(load))
        self.crossings = [(c.w, -1.0 / c.value) for c in phase_crossings(loop) if c.w > 0.0]
        self.rest = float(self._bias(np.array([0.0]), np.array([1.0]))[0])
        step = 1e-6 * max(self.least, abs(self.rest))
        self.slope = float(
            np.diff(np.asarray(self.phi(np.array([self.rest - step, self.rest + step]))))[0] / 2.0 / step
        )
        self.sizes = np.geomspace(self.least, self.most, SCAN_AMPLITUDES)
        self._scan: dict[bool, np.ndarray] = {}

    def _phases(self, w: float, points: int) -> np.ndarray:
        return ALTERNATING if w >= self.loop.nyquist * (1.0 - 1e-9) else half_turn(points)

    def _bias(self, sizes: np.ndarray, cosines: np.ndarray) -> np.ndarray:
        """The mean error under the load for each amplitude: bisection of a rising function."""

        def left(b: np.ndarray) -> np.ndarray:
            inputs = b[..., None] + sizes[..., None] * cosines
            return np.asarray(self.phi(inputs)).mean(-1) + self.slack * b - self.load

        reach = abs(self.load) + float(sizes.max()) + self.least
        low, high = np.full(sizes.shape, -reach), np.full(sizes.shape, reach)
        for _ in range(40):
            if (left(low) <= 0.0).all() and (left(high) >= 0.0).all():
                break
            low, high = 2.0 * low, 2.0 * high
        else:
            far = float(high.flat[0])
            given = float(np.asarray(self.phi(np.array([far])))[0])
            raise ValueRefused(
                f"load = {self.load!r} {self.unit}: the curve cannot carry it; at {far:.3g} {self.unit} it gives "
                f"{given:.4g} {self.unit}"
            )
        below, above = left(low), left(high)
        for k in range(HALVINGS):
            # false position, every third step a halving: no kink or plateau of the curve can hold it up
            width = np.where(above > below, above - below, 1.0)
            middle = np.where(k % 3 == 2, 0.5 * (low + high), low - below * (high - low) / width)
            middle = np.clip(middle, low, high)
            value = left(middle)
            up = value < 0.0
            low, below = np.where(up, middle, low), np.where(up, value, below)
            high, above = np.where(up, high, middle), np.where(up, above, value)
            if (np.minimum(high - low, np.minimum(abs(below), abs(above))) <= SETTLED * reach).all():
                break
        return np.where(abs(below) < abs(above), low, high)

    def described(self, w: float, sizes: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
        """Mean error and ``N`` for each amplitude, the load carried."""
        cosines = self._phases(w, points)
        bias = self._bias(sizes, cosines)
        return bias, described_by(self.phi, sizes, bias, cosines).gain

    def gains(self, w: float) -> np.ndarray:
        """``N`` on the scanned amplitudes."""
        two = len(self._phases(w, SCAN_POINTS)) == 2
        if two not in self._scan:
            self._scan[two] = self.described(w, self.sizes, SCAN_POINTS)[1]
        return self._scan[two]

    def one(self, w: float, size: float) -> tuple[float, float]:
        """Mean error and ``N`` at one amplitude, with all phases."""
        bias, gain = self.described(w, np.array([size]), POINTS)
        return float(bias[0]), float(gain[0])

    def amplitudes_of_gain(self, w: float, limit: float) -> list[float]:
        """Every amplitude with ``N = limit``."""
        from scipy.optimize import brentq

        over = self.gains(w) - limit
        found = []
        for i in np.nonzero(np.sign(over[:-1]) * np.sign(over[1:]) < 0)[0]:
            low, high = math.log(self.sizes[i]), math.log(self.sizes[i + 1])

            def left(x: float) -> float:
                return self.one(w, math.exp(x))[1] - limit

            if left(low) * left(high) < 0.0:
                found.append(math.exp(brentq(left, low, high, xtol=1e-10)))
        return found

    def cycle(self, w: float, limit: float, size: float) -> LimitCycle:
        """The cycle at a crossing, with its stability."""
        bias, gain = self.one(w, size)
        step = 1e-3 * size
        steeper = (self.one(w, size + step)[1] - self.one(w, size - step)[1]) / (2.0 * step)
        growth = self.growth(w, gain, steeper * size)
        turn = 2.0 * np.pi * np.arange(1024) / 1024
        seen = np.asarray(self.phi(bias + size * np.cos(turn)))
        orders = np.arange(2, 8)
        parts = 2.0 * np.fft.rfft(seen)[orders] / len(turn)
        two = w >= self.loop.nyquist * (1.0 - 1e-9)
        left_out = 0.0 if two else float(np.abs(self.loop.response(orders * w) * parts).max() / size)
        stable = growth < 0.0 and self.others_stable(w, gain)
        return LimitCycle(w / (2.0 * np.pi), (complex(bias), complex(size)), gain, stable, growth, left_out)

    def slope_of_response(self, w: Any) -> np.ndarray:
        """``dG/ds`` on the boundary, by central difference; 1/(rad/s)."""
        w = np.asarray(w, dtype=float)
        step = 1e-5 * w
        return np.asarray((self.loop.response(w + step) - self.loop.response(w - step)) / (2j * step))

    def growth(self, w: float, gain: float, change: float) -> float:
        """Loeb: rate of a small deviation, ``A ds/dA``; ``change`` is ``A dN/dA``."""
        response = complex(self.loop.response(np.array([w]))[0])
        slope = complex(self.slope_of_response(np.array([w]))[0])
        return float((-(change / gain) / (slope / response)).real)

    def others_stable(self, w: float, gain: float) -> bool:
        """Whether every pole but the oscillating pair is inside, in the loop closed with ``gain``."""
        poles = self.loop.closed_poles(gain)
        if self.loop.dt is not None:
            own = np.exp(1j * w * self.loop.dt)
            others = poles[np.minimum(abs(poles - own), abs(poles - own.conjugate())) > 1e-4]
            return bool((np.abs(others) < 1.0).all())
        others = poles[np.minimum(abs(poles - 1j * w), abs(poles + 1j * w)) > 1e-3 * w]
        return bool((others.real < 0.0).all())

    def warnings(self, cycles: list[LimitCycle]) -> list[str]:
        """What a user should know before trusting the cycles."""
        found = []
        spread = np.linspace(-1.0, 1.0, 2001) * 2.0 * max([c.amplitude + abs(c.bias) for c in cycles] or [self.least])
        if (np.diff(np.asarray(self.phi(self.rest + spread))) < -1e-12 * self.most).any():
            found.append(
                "the curve falls somewhere: for each amplitude one mean error was looked at, there may be more"
            )
        factor, unit = self.shown
        for c in cycles:
            size = f"cycle of {factor * c.peak_to_peak:.3g} {unit}"
            if c.left_out > LARGE_HARMONIC:
                found.append(
                    f"{size}: a harmonic of {100.0 * c.left_out:.0f} % of the fundamental was left out; use "
                    "harmonic_balance"
                )
            if self.loop.dt is not None and 2.0 * c.frequency_hz * self.loop.dt > 1.0 / 2.5:
                found.append(f"{size}: fewer than 5 samples a period; it may lock to a multiple of the sampling period")
        for w, limit in self.crossings:
            at_most = self.gains(w)[-1]
            if at_most > limit:
                found.append(
                    f"at {factor * self.most:g} {unit}, the largest amplitude searched, N = {at_most:.3g} is still "
                    f"above {limit:.3g}: a large oscillation grows further, until something else limits it"
                )
                break
        return found

    def prediction(self, criterion: str, cycles: tuple[LimitCycle, ...], warnings: list[str]) -> CyclePrediction:
        """All of it."""
        loop = self.loop
        at = [w for w, _ in self.crossings] or [1.0]
        top = min(loop.nyquist, 30.0 * max(at))
        w = np.geomspace(0.1 * min(at), top, 2000)
        gain = self.gains(at[0])
        return CyclePrediction(
            criterion, loop.name, loop.dt, loop.dead_time, self.load, self.rest, self.slope,
            tuple((x / (2.0 * np.pi), k) for x, k in self.crossings), loop.stable(self.slope), cycles, warnings,
            Locus(self.sizes, gain, loop.response(w)), unit=self.unit,
        )  # fmt: skip
