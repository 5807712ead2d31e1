"""Limit cycles of a loop with a static nonlinearity: harmonic balance, with one harmonic the describing function.

A prediction is no proof: it gives the oscillations that a loop sustains, up to the harmonics that were counted.

The error of a cycle of frequency ``w`` is ``e(theta) = E0 + Re(sum of E_n e^(j n theta), n = 1 .. N)``, and with
``F_n`` the same coefficients of ``phi(e(theta))`` the loop ``e = -G phi(e)`` asks for

    E_n + G(n w) F_n = 0,   n = 1 .. N                F0 + E0 / G0 = load

``E_1`` is real: where the phase counts from is free. Unknown are the ``E_n`` and ``w``; the first equation is divided
by ``E_1``, which takes away the solution at rest.

A sampled loop sees the cycle at ``theta = k w T``. Unless ``w`` is in a simple ratio to the sampling rate the samples
come to lie everywhere on the turn (the motion is quasi-periodic), and the equations hold on the continuous phase
with ``G`` at ``e^(j n w T)``: harmonics above half the sampling rate are folded by ``G`` itself, nothing is left out
but what lies above ``N``.

Newton's method solves the balance. It starts from the cycles of the describing function, and from where its ``N`` comes
within 20 % of a gain that oscillates without reaching it. Stability as there (Loeb's rule with all harmonics following
the amplitude): the amplitude is shifted, and the equations are solved for the rate at which it then grows.

Source: A. I. Mees, *Dynamics of Feedback Systems*, Wiley 1981, chapter 5, for the balance; on the continuous phase of a
sampled loop it is ours. Against the largest Lyapunov exponents of the loop linearised along the cycle the rate is right
to 20 % (a test compares them), its sign in all cases tried.

One harmonic, the describing function: for ``e = b + A cos theta`` the curve ``phi`` answers with mean and fundamental,

    F0 = mean of phi(b + A cos theta),      N = 2 / A mean of phi(b + A cos theta) cos theta        over one turn

``N`` is the describing function, with a mean error ``b`` the dual-input one. Around the loop ``e = -G phi(e)`` an
oscillation is sustained where

    1 + N(A, b) G = 0        and        F0(A, b) + b / G0 = load

A curve without hysteresis has a real ``N``, so it oscillates at phase crossovers, where ``-1 / G`` is real, and at no
other frequency. The second equation says that the mean of the curve carries the load: ``load`` is ``phi(e)`` at rest, a
constant force divided by the controller's proportional gain, or what a following error asks for; ``G0``,
``static_gain``, is the loop's gain for slow things, infinite under integral action.

In a sampled loop the phase advances by ``w T`` from sample to sample and so comes to lie everywhere; the means above
are over the continuous phase, ``G`` is that of the samples, and nothing of the delay is approximated. At half the
sampling frequency only two phases exist; there ``N = (phi(b + A) - phi(b - A)) / (2 A)``, which is exact.

A cycle is stable where a larger amplitude dies away: Loeb's rule, ``ds/dA = -(dN/dA / N) / (dG/ds / G)`` with a
negative real part, and every other pole of the loop closed with ``N`` stable. The mean error is taken to
follow the amplitude without delay.

Source: A. Gelb, W. E. Vander Velde, *Multiple-Input Describing Functions and Nonlinear System Design*, McGraw-Hill
1968, chapters 2, 3 and 6.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from leadscrew.analysis.stability.linear import LinearLoop, phase_crossings
from leadscrew.util.errors import ValueRefused

WAVE_PHASES = 4096
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
        lines = np.zeros(WAVE_PHASES // 2 + 1, dtype=complex)
        lines[: len(self.harmonics)] = np.array(self.harmonics) * 0.5 * WAVE_PHASES
        lines[0] = 0.0
        return float(np.ptp(np.fft.irfft(lines, WAVE_PHASES)))

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
        size = (
            f"{factor * seen[-1].peak_to_peak:.3g} {unit} from peak to peak at {seen[-1].frequency_hz:.4g} Hz"
            if seen
            else ""
        )
        if not self.rest_stable:
            return (
                f"The loop does not come to rest: it chatters, {size}." if seen else "The loop does not come to rest."
            )
        if not seen:
            return "The loop comes to rest; no limit cycle was found."
        kick = [c for c in self.cycles if not c.stable and c.amplitude < seen[-1].amplitude]
        beyond = f" by more than about {factor * kick[-1].amplitude:.3g} {unit}" if kick else ""
        return f"The loop stays at rest, but once disturbed{beyond} it chatters, {size}."

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


Curve = Callable[[Any], Any]
"""``phi``: error in mm to error in mm, element by element on arrays."""

POINTS = 4096
"""Phases over half a turn."""
SCAN_POINTS = 192
SCAN_AMPLITUDES = 320
BISECTED = 1e-12
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
            if (np.minimum(high - low, np.minimum(abs(below), abs(above))) <= BISECTED * reach).all():
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
        amplitudes = []
        for i in np.nonzero(np.sign(over[:-1]) * np.sign(over[1:]) < 0)[0]:
            low, high = math.log(self.sizes[i]), math.log(self.sizes[i + 1])

            def left(x: float) -> float:
                return self.one(w, math.exp(x))[1] - limit

            if left(low) * left(high) < 0.0:
                amplitudes.append(math.exp(brentq(left, low, high, xtol=1e-10)))
        return amplitudes

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

    def warnings(self, cycles: list[LimitCycle], largest: float) -> list[str]:
        """What a user should know before trusting the cycles; ``largest``: harmonic that may be left out."""
        warnings = []
        spread = np.linspace(-1.0, 1.0, 2001) * 2.0 * max([c.amplitude + abs(c.bias) for c in cycles] or [self.least])
        if (np.diff(np.asarray(self.phi(self.rest + spread))) < -1e-12 * self.most).any():
            warnings.append(
                "the curve falls somewhere: for each amplitude one mean error was looked at, there may be more"
            )
        factor, unit = self.shown
        for c in cycles:
            size = f"cycle of {factor * c.peak_to_peak:.3g} {unit}"
            if c.left_out > largest:
                warnings.append(
                    f"{size}: a harmonic of {100.0 * c.left_out:.0f} % of the fundamental was left out; balance more "
                    "harmonics"
                )
            if self.loop.dt is not None and 2.0 * c.frequency_hz * self.loop.dt > 1.0 / 2.5:
                warnings.append(
                    f"{size}: fewer than 5 samples a period; it may lock to a multiple of the sampling period"
                )
        for w, limit in self.crossings:
            at_most = self.gains(w)[-1]
            if at_most > limit:
                warnings.append(
                    f"at {factor * self.most:g} {unit}, the largest amplitude searched, N = {at_most:.3g} is still "
                    f"above {limit:.3g}: a large oscillation grows further, until something else limits it"
                )
                break
        return warnings

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


MOST_HARMONICS = 100
PHASES_PER_HARMONIC = 32
STEPS = 60
SETTLED = 1e-10
"""Largest equation left, as a part of the fundamental."""
CLOSE = 0.2
"""How far below a gain that oscillates the describing function may stay for Newton to be started there."""
SAME = 1e-4
"""Two cycles are one where frequency and amplitude agree this well."""
LARGE_TAIL = 0.02
"""The same where several harmonics are balanced."""


def limit_cycles(
    loop: LinearLoop,
    curve: Any,
    load: float = 0.0,
    *,
    harmonics: int = 1,
    static_gain: float = math.inf,
    amplitudes: tuple[float, float] = (1e-5, 1.0),
    unit: str = "mm",
) -> CyclePrediction:
    """Every limit cycle of a loop: amplitude and mean error together, frequency, stability.

    Args:
        loop: the linear part, cut at the error; sampled or continuous with dead time.
        curve: ``phi`` in mm, rising, a function of arrays or what ``lure(controller)`` gives; with more than one
            harmonic it has to be continuous (kinks are welcome; at a jump Newton's method has no slope to go by).
        load: mean that the curve has to give, mm: ``phi(e)`` at rest.
        harmonics: how many are balanced, 1 to 100. One is the describing function; 30 count those of a sampled loop
            that fold to low frequencies, where ``G`` is large: 10, 20, 30 at 10 samples a turn.
        static_gain: ``G0``, gain of the loop for slow changes; infinite for a loop with integral action.
        amplitudes: smallest and largest amplitude searched, mm.
        unit: of the curve's argument, where that is not the error in mm: V for a loop cut at the drive's voltage, say.

    Raises:
        ValueRefused: a number of harmonics that is not allowed, a load that the curve cannot carry, a range of
            amplitudes that is none, a curve that is no static map.
    """
    if not 1 <= harmonics <= MOST_HARMONICS:
        raise ValueRefused(f"harmonics = {harmonics!r} (limit_cycles): allowed are 1 to {MOST_HARMONICS}")
    task = Task(loop, curve, load, static_gain, amplitudes, unit)
    factor, word = task.shown
    cycles: list[LimitCycle] = []
    warnings: list[str] = []
    for w, limit in task.crossings:
        sizes = task.amplitudes_of_gain(w, limit)
        if harmonics == 1 or w >= loop.nyquist * (1.0 - 1e-9):
            cycles += [task.cycle(w, limit, size) for size in sizes]
            continue
        for size in [*sizes, *_near(task, w, limit)]:
            balance = Balance(task, harmonics)
            start = np.zeros(2 * harmonics + 1)
            start[0], start[1], start[2] = task.one(w, size)[0], size, w
            solution = balance.solve(start)
            if solution is None:
                if size in sizes:
                    warnings.append(
                        "Newton's method did not settle from the describing function's cycle of "
                        f"{2.0 * factor * size:.3g} {word}"
                    )
                continue
            cycle = balance.cycle(solution, w, limit)
            if all(abs(cycle.amplitude / c.amplitude - 1.0) > SAME or
                   abs(cycle.frequency_hz / c.frequency_hz - 1.0) > SAME for c in cycles):  # fmt: skip
                cycles.append(cycle)
    cycles.sort(key=lambda c: c.amplitude)
    warnings += task.warnings(cycles, LARGE_HARMONIC if harmonics == 1 else LARGE_TAIL)
    criterion = "describing function" if harmonics == 1 else f"harmonic balance, {harmonics} harmonics"
    return task.prediction(criterion, tuple(cycles), warnings)


def _near(task: Task, w: float, limit: float) -> list[float]:
    """Amplitudes around maxima of the describing function that nearly reach the limit."""
    gain = task.gains(w)
    close = np.nonzero((gain > (1.0 - CLOSE) * limit) & (gain < limit))[0]
    tops = []
    for part in np.split(close, np.nonzero(np.diff(close) > 1)[0] + 1) if len(close) else []:
        top = part[int(np.argmax(gain[part]))]
        if gain[top] - max(gain[part[0]], gain[part[-1]]) > 1e-3 * limit:
            tops.append(float(task.sizes[top]))
    return [share * top for top in tops for share in (1.0, 0.7, 1.3)]


class Balance:
    """The equations. Unknowns in order: E0, E1, w, then real and imaginary part of E2, E3, ..."""

    def __init__(self, task: Task, harmonics: int) -> None:
        self.task = task
        self.orders = np.arange(1, harmonics + 1)
        self.phases = 1 << max(10, math.ceil(math.log2(PHASES_PER_HARMONIC * harmonics)))

    def coefficients(self, x: np.ndarray) -> np.ndarray:
        """``E_1 .. E_N``."""
        return np.concatenate([[x[1] + 0j], x[3::2] + 1j * x[4::2]])

    def wave(self, x: np.ndarray) -> np.ndarray:
        """The error at equally spaced phases."""
        lines = np.zeros(self.phases // 2 + 1, dtype=complex)
        lines[0] = x[0] * self.phases
        lines[1 : len(self.orders) + 1] = 0.5 * self.phases * self.coefficients(x)
        return np.fft.irfft(lines, self.phases)

    def response(self, w: float) -> np.ndarray:
        """``G`` at the harmonics; a sampled loop folds."""
        return self.task.loop.response(self.orders * w)

    def equations(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What is left of the equations, and its derivative by the unknowns."""
        task, n = self.task, len(self.orders)
        e = self.wave(x)
        value = np.asarray(task.phi(e))
        step = 1e-6 * (abs(x[1]) + task.least)
        slope = (np.asarray(task.phi(e + step)) - np.asarray(task.phi(e - step))) / (2.0 * step)
        f = 2.0 * np.fft.rfft(value)[1 : n + 1] / self.phases
        # the slope's own coefficients d: a change of E_m turns up in F_n by d_(n-m) and d_(n+m)
        d = np.fft.fft(slope) / self.phases
        near, far = d[self.orders[:, None] - self.orders], d[self.orders[:, None] + self.orders]
        df = np.zeros((n, 2 * n + 1), dtype=complex)
        df[:, 0], df[:, 1] = 2.0 * d[1 : n + 1], near[:, 0] + far[:, 0]
        df[:, 3::2], df[:, 4::2] = (near + far)[:, 1:], 1j * (near - far)[:, 1:]
        g, size = self.response(x[2]), x[1]
        de = np.zeros((n, 2 * n + 1), dtype=complex)
        de[0, 1] = 1.0
        for k in range(1, n):
            de[k, 2 * k + 1], de[k, 2 * k + 2] = 1.0, 1j
        left = self.coefficients(x) + g * f
        slope_of = self.turning(x[2])
        change = de + g[:, None] * df
        change[:, 2] = 1j * slope_of * f
        change[0] = change[0] / size
        change[0, 1] -= left[0] / size**2
        left[0] = left[0] / size
        rest = value.mean() + task.slack * x[0] - task.load
        d_rest = np.zeros(2 * n + 1)
        d_rest[0], d_rest[1] = d[0].real + task.slack, d[1].real
        d_rest[3::2], d_rest[4::2] = d[2 : n + 1].real, d[2 : n + 1].imag
        scale = abs(size)
        left[1:] /= scale
        change[1:] /= scale
        return (
            np.concatenate([[rest / scale], left.real, left.imag]),
            np.vstack([d_rest / scale, change.real, change.imag]),
        )

    def turning(self, w: float) -> np.ndarray:
        """``dG/ds`` at the harmonics times the order: by how much ``E_n`` sees a change of ``s``."""
        step = 1e-6 * w
        return np.asarray((self.response(w + step) - self.response(w - step)) / (2j * step))

    def solve(self, x: np.ndarray) -> np.ndarray | None:
        """Newton's method with shortened steps; ``None`` where it does not settle on a cycle in the range."""
        task = self.task
        left, change = self.equations(x)
        for _ in range(STEPS):
            if np.abs(left).max() < SETTLED:
                return x if task.least <= x[1] <= task.most and 0.0 < x[2] < task.loop.nyquist else None
            try:
                step = np.linalg.solve(change, -left)
            except np.linalg.LinAlgError:
                return None
            for share in (1.0, 0.5, 0.25, 0.1, 0.03, 0.01):
                tried = x + share * step
                if not (0.0 < tried[1] < 10.0 * task.most and 0.5 * x[2] < tried[2] < 2.0 * x[2]):
                    continue
                new_left, new_change = self.equations(tried)
                if np.linalg.norm(new_left) < (1.0 - 0.2 * share) * np.linalg.norm(left):
                    break
            else:
                return None
            x, left, change = tried, new_left, new_change
        return None

    def cycle(self, x: np.ndarray, w: float, limit: float) -> LimitCycle:
        """The solution as a cycle, with stability and what lies above the last harmonic; ``w``: its crossover."""
        _, change = self.equations(x)
        lines = 2.0 * np.fft.rfft(np.asarray(self.task.phi(self.wave(x)))) / self.phases
        f = lines[self.orders]
        # the amplitude shifted by its own size: all others and w follow, and the fundamental grows at the rate s
        by_rate = self.turning(x[2]) * f / x[1]
        by_rate = np.concatenate([[0.0], by_rate.real, by_rate.imag])
        matrix = change.copy()
        matrix[:, 1] = by_rate
        growth = float(np.linalg.solve(matrix, -change[:, 1] * x[1])[1])
        gain = float((f[0] / x[1]).real)
        harmonics = self.coefficients(x)
        above = np.arange(len(self.orders) + 1, len(self.orders) + 9)
        left_out = float(np.abs(self.task.loop.response(above * x[2]) * lines[above]).max() / x[1])
        stable = growth < 0.0 and self.task.others_stable(w, limit)
        return LimitCycle(x[2] / (2.0 * np.pi), (complex(x[0]), *harmonics.tolist()), gain, stable, growth, left_out)


def describing_function(curve: Any, amplitude: Any, bias: Any = 0.0, points: int = POINTS) -> Described:
    """Mean and describing function of a static, single-valued curve; for arrays of amplitudes and biases.

    Args:
        curve: ``phi``, a function of arrays, or a :class:`~leadscrew.analysis.stability.lure.Lure`.
        amplitude: of the fundamental, above 0.
        bias: mean of the input.
        points: phases over half a turn, midpoint rule: error of the order ``points**-2`` for a curve with kinks,
            ``1 / points`` where the curve jumps away from the zero of a bias.

    Raises:
        ValueRefused: an amplitude that is not positive, or a curve that does not give finite numbers.
    """
    size, b = np.broadcast_arrays(np.asarray(amplitude, dtype=float), np.asarray(bias, dtype=float))
    if not (np.isfinite(size).all() and (size > 0.0).all()):
        raise ValueRefused(f"describing_function: amplitude = {amplitude!r}; allowed are finite values above 0")
    return described_by(curve_function(curve), size, b, half_turn(points))


def biggest(prediction: CyclePrediction) -> LimitCycle | None:
    """The largest stable cycle, or ``None``."""
    return max(prediction.stable_cycles, key=lambda c: c.amplitude, default=None)
