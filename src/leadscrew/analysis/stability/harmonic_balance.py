"""Harmonic balance: limit cycles with several harmonics and a mean, by Newton's method on the Fourier coefficients.

The error of a cycle of frequency ``w`` is ``e(theta) = E0 + Re(sum of E_n e^(j n theta), n = 1 .. N)``, and with
``F_n`` the same coefficients of ``phi(e(theta))`` the loop ``e = -G phi(e)`` asks for

    E_n + G(n w) F_n = 0,   n = 1 .. N                F0 + E0 / G0 = load

``E_1`` is real: where the phase counts from is free. Unknown are the ``E_n`` and ``w``; the first equation is divided
by ``E_1``, which takes away the solution at rest.

A sampled loop sees the cycle at ``theta = k w T``. Unless ``w`` is in a simple ratio to the sampling rate the samples
come to lie everywhere on the turn (the motion is quasi-periodic), and the equations hold on the continuous phase
with ``G`` at ``e^(j n w T)``: harmonics above half the sampling rate are folded by ``G`` itself, nothing is left out
but what lies above ``N``.

Newton starts from the cycles of the describing function, and from where its ``N`` comes within 20 % of a gain that
oscillates without reaching it. Stability as there (Loeb's rule with all harmonics following the amplitude): the
amplitude is shifted, and the equations are solved for the rate at which it then grows.

Source: A. I. Mees, *Dynamics of Feedback Systems*, Wiley 1981, chapter 5, for the balance; on the continuous phase of a
sampled loop it is ours. Against the largest Lyapunov exponents of the loop linearised along the cycle the rate is right
to 20 % (a test compares them), its sign in all cases tried.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from leadscrew.analysis.stability.balance_task import Task
from leadscrew.analysis.stability.cycles import CyclePrediction, LimitCycle
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.kernel.errors import ValueRefused

HARMONICS = 30
"""In a sampled loop those that fold to low frequencies count, where ``G`` is large: 10, 20, 30 at 10 samples a turn."""
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


def harmonic_balance(
    loop: LinearLoop,
    curve: Any,
    load: float = 0.0,
    *,
    harmonics: int = HARMONICS,
    static_gain: float = math.inf,
    amplitudes: tuple[float, float] = (1e-5, 1.0),
    unit: str = "mm",
) -> CyclePrediction:
    """The limit cycles of a loop with several harmonics and a mean.

    Args:
        loop: the linear part, cut at the error; sampled or continuous with dead time.
        curve: ``phi`` in mm, rising and continuous (kinks are welcome; at a jump Newton's method has no slope to go
            by), a function of arrays or what ``lure(controller)`` gives.
        load: mean that the curve has to give, mm: ``phi(e)`` at rest.
        harmonics: how many are balanced, 1 to 100; 1 is the describing function.
        static_gain: ``G0``, gain of the loop for slow changes; infinite for a loop with integral action.
        amplitudes: smallest and largest amplitude searched, mm.
        unit: of the curve's argument, where that is not the error in mm: V for a loop cut at the drive's voltage, say.

    Raises:
        ValueRefused: a number of harmonics that is not allowed, and what the describing function refuses.
    """
    if not 1 <= harmonics <= MOST_HARMONICS:
        raise ValueRefused(f"harmonics = {harmonics!r} (harmonic_balance): allowed are 1 to {MOST_HARMONICS}")
    task = Task(loop, curve, load, static_gain, amplitudes, unit)
    factor, word = task.shown
    found: list[LimitCycle] = []
    warnings: list[str] = []
    for w, limit in task.crossings:
        if w >= loop.nyquist * (1.0 - 1e-9):
            found += [task.cycle(w, limit, size) for size in task.amplitudes_of_gain(w, limit)]
            continue
        sure = task.amplitudes_of_gain(w, limit)
        for size in [*sure, *_near(task, w, limit)]:
            balance = Balance(task, harmonics)
            start = np.zeros(2 * harmonics + 1)
            start[0], start[1], start[2] = task.one(w, size)[0], size, w
            solution = balance.solve(start)
            if solution is None:
                if size in sure:
                    warnings.append(
                        "Newton's method did not settle from the describing function's cycle of "
                        f"{2.0 * factor * size:.3g} {word}"
                    )
                continue
            cycle = balance.cycle(solution, w, limit)
            if all(abs(cycle.amplitude / c.amplitude - 1.0) > SAME or
                   abs(cycle.frequency_hz / c.frequency_hz - 1.0) > SAME for c in found):  # fmt: skip
                found.append(cycle)
    found.sort(key=lambda c: c.amplitude)
    warnings += [w for w in task.warnings(found) if "left out" not in w]
    for c in found:
        if c.left_out > LARGE_TAIL:
            warnings.append(
                f"cycle of {factor * c.peak_to_peak:.3g} {word}: the next harmonics are still "
                f"{100.0 * c.left_out:.0f} % of the fundamental; balance more of them"
            )
    return task.prediction(f"harmonic balance, {harmonics} harmonics", tuple(found), warnings)


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
