"""Describing function of a static nonlinearity, and the limit cycles that it predicts in a loop.

For ``e = b + A cos theta`` the curve ``phi`` answers with a mean and a fundamental,

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
from typing import Any

import numpy as np

from leadscrew.analysis.stability.balance_task import (
    POINTS,
    Described,
    Task,
    curve_function,
    described_by,
    half_turn,
)
from leadscrew.analysis.stability.cycles import CyclePrediction, LimitCycle
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.kernel.errors import ValueRefused


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


def limit_cycles(
    loop: LinearLoop,
    curve: Any,
    load: float = 0.0,
    *,
    static_gain: float = math.inf,
    amplitudes: tuple[float, float] = (1e-5, 1.0),
    unit: str = "mm",
) -> CyclePrediction:
    """Every limit cycle that the describing function predicts: amplitude and mean error together, frequency, stability.

    Args:
        loop: the linear part, cut at the error; sampled or continuous with dead time.
        curve: ``phi`` in mm, rising, a function of arrays or what ``lure(controller)`` gives.
        load: mean that the curve has to give, mm: ``phi(e)`` at rest.
        static_gain: ``G0``, gain of the loop for slow changes; infinite for a loop with integral action.
        amplitudes: smallest and largest amplitude searched, mm.
        unit: of the curve's argument, where that is not the error in mm: V for a loop cut at the drive's voltage, say.

    Raises:
        ValueRefused: a load that the curve cannot carry, a range of amplitudes that is none, a curve that is no static
            map.
    """
    task = Task(loop, curve, load, static_gain, amplitudes, unit)
    cycles: list[LimitCycle] = []
    warnings: list[str] = []
    for w, limit in task.crossings:
        for size in task.amplitudes_of_gain(w, limit):
            cycles.append(task.cycle(w, limit, size))
    cycles.sort(key=lambda c: c.amplitude)
    warnings += task.warnings(cycles)
    return task.prediction("describing function", tuple(cycles), warnings)


def biggest(prediction: CyclePrediction) -> LimitCycle | None:
    """The largest stable cycle, or ``None``."""
    return max(prediction.stable_cycles, key=lambda c: c.amplitude, default=None)
