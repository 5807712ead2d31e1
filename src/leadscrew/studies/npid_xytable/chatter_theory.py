"""What theory says of the chatter: the curve and its slope, rest under a load, limit cycles, thresholds.

The load is given by what the curve of Table I must carry, um: ``v = d / Kp`` for a load ``d`` in V.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.controllers.npid import npid
from leadscrew.controllers.pid import pid
from leadscrew.plants.xy_table_cutting import xy_table_cutting
from leadscrew.references.eased_sine import eased_sine
from leadscrew.studies.npid_xytable.calibration import DEAD_TIME_S, PERIOD_S

if TYPE_CHECKING:
    from leadscrew.analysis.stability.cycles import CyclePrediction
    from leadscrew.analysis.stability.linear import LinearLoop
    from leadscrew.kernel.loop import Loop

GAINS, AXIS = npid.params, xy_table_cutting.params
STATIC_GAIN = GAINS.kp * AXIS.gain / AXIS.stiffness
"""Of the loop for slow changes, its slow integral apart."""
LIMIT_V = 10.0
"""Of the supply, where it matters."""


def curve(e: Any, e_max: float = 3.0, alpha: float = 0.5) -> Any:
    """``phi`` of Table I on arrays, mm to mm."""
    return e * np.cosh(alpha * np.minimum(1e3 * np.abs(e), e_max))


def slope(e_um: Any, e_max: float = 3.0, alpha: float = 0.5) -> Any:
    """``phi'`` at an error in um, from below at ``e_max``."""
    size = np.abs(e_um)
    x = alpha * np.minimum(size, e_max)
    return np.cosh(x) + np.where(size <= e_max, x * np.sinh(x), 0.0)


def at_rest_um(load_um: Any, e_max: float = 3.0) -> np.ndarray:
    """Error at rest under loads, the integral still empty."""
    from scipy.optimize import brentq

    loads = np.atleast_1d(np.asarray(load_um, dtype=float))
    return np.array(
        [brentq(lambda e, v=v: 1e3 * curve(1e-3 * e, e_max) + e / STATIC_GAIN - v, 0.0, v + 1.0) for v in loads]
    )


def load_of(e_um: float, e_max: float = 3.0) -> float:
    """The load whose rest is at this error, um."""
    return float(1e3 * curve(1e-3 * e_um, e_max) + e_um / STATIC_GAIN)


def error_of_slope(wanted: float) -> float:
    """The error in um at which the slope of Table I's curve is this."""
    from scipy.optimize import brentq

    return float(brentq(lambda e: float(slope(e)) - wanted, 0.1, GAINS.e_max))


def threshold_um() -> float:
    """The error at rest from which on L* chatters: where the slope is its gain limit."""
    return error_of_slope(linear().gain_limit())


@lru_cache(maxsize=32)
def linear(delay_s: float = DEAD_TIME_S, gain: float = 1.0, damping: float = 1.0) -> LinearLoop:
    """The loop of Table I's PID without its slow integral, at this dead time and factors of gain and damping."""
    from leadscrew.analysis.stability.sampled import sampled_loop

    axis = {"dead_time_s": delay_s, "gain": gain * AXIS.gain, "damping": damping * AXIS.damping}
    loop = _plain().using({f"plant.{key}": value for key, value in axis.items()})
    return sampled_loop(loop, f"L, {1e3 * delay_s:g} ms")


@lru_cache(maxsize=1)
def _plain() -> Loop:
    from leadscrew.kernel.loop import Loop

    loop = Loop(
        reference=eased_sine(amplitude=0.0), controller=pid(ki=0.0), plant=xy_table_cutting, period=PERIOD_S, metrics={}
    )
    assert loop.program  # written once: what differs in values alone shares it, and its look at the signals
    return loop


@lru_cache(maxsize=256)
def predicted(load_um: float, e_max: float = 3.0, delay_s: float = DEAD_TIME_S, many: bool = True) -> CyclePrediction:
    """Limit cycles under a load: by harmonic balance, or by the describing function alone (``many`` false)."""
    from leadscrew.analysis.stability.describing import limit_cycles
    from leadscrew.analysis.stability.harmonic_balance import harmonic_balance

    task = harmonic_balance if many else limit_cycles
    return task(
        linear(delay_s), lambda e: curve(e, e_max), 1e-3 * load_um, static_gain=STATIC_GAIN, amplitudes=(1e-5, 0.1)
    )


def fold_um(low: float = 12.0, high: float = 16.0) -> float:
    """The largest load under which a cycle exists beside a quiet rest, by bisection of the balance, um."""
    for _ in range(8):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if predicted(middle).stable_cycles else (low, middle)
    return 0.5 * (low + high)


def delay_threshold_ms() -> float:
    """The dead time at which the gain limit of the loop is the steepest slope of Table I."""
    from scipy.optimize import brentq

    steepest = float(slope(3.0))
    return float(brentq(lambda ms: linear(1e-3 * ms).gain_limit() - steepest, 0.1, 0.2, xtol=1e-5))


def saturated_um(gain: float, delay_s: float, damping: float) -> float:
    """Predicted rms error in um of the cycle that only the supply limits: describing function of the limit.

    Far beyond e_max the nonlinear gain is K(e_max); the loop cut at the voltage is ``K G`` with a saturation.
    """
    from dataclasses import replace

    from leadscrew.analysis.stability.describing import biggest, limit_cycles

    loop = linear(delay_s, gain, damping)
    most = math.cosh(GAINS.alpha * GAINS.e_max)
    cut = replace(loop, b=most * loop.b)
    cycle = biggest(limit_cycles(cut, lambda u: np.clip(u, -LIMIT_V, LIMIT_V), amplitudes=(1.0, 1e4), unit="V"))
    if cycle is None:
        return 0.0
    z = np.exp(2j * np.pi * cycle.frequency_hz * PERIOD_S)
    law = GAINS.kp + GAINS.kd * (1.0 - 1.0 / z) / PERIOD_S
    return float(1e3 * cycle.amplitude / abs(most * law) / math.sqrt(2.0))
