"""The curve of the nonlinear gain, ``phi(e) = K(e) e`` of Table I: its slope, its inverse, compression.

A load is given by what the curve must carry, um: ``v = d / Kp`` for a load ``d`` in V. At rest ``phi(e) = v`` but for
the finite gain of the axis.

Compression: high loop gain and ``C`` about ``Kp`` in this band make ``C phi(e_NPID) = C e_PID``, so

    e_NPID(t) = phi^-1(e_PID(t)),      phi(e) = K(e) e
    e_PID(t)  = e_1 sin th + sum_n a_n sin(n th + p_n),      n = 3, 5, 7, 9, 11,  th: phase of the fundamental error

with ``a_n`` the PID column of Table II. The phases ``p_n`` and ``e_1`` are unknown. :data:`FITTED` has those for which
the law comes closest to the NPID column: fifteen phases and one amplitude for fifteen numbers, so it shows that the
table can be explained by the law; it predicts nothing.
"""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import Any

import numpy as np

from leadscrew.controllers._npid import gain, npid, scaled_error
from leadscrew.plants._xy_table_cutting import xy_table_cutting
from leadscrew.studies.npid_xytable.calibration import responses
from leadscrew.studies.npid_xytable.table2 import BASE_HZ, LINES_HZ, NPID_UM, ORDERS, PID_UM

GAINS, AXIS = npid.params, xy_table_cutting.params
STATIC_GAIN = GAINS.kp * AXIS.gain / AXIS.stiffness
"""Of the loop for slow changes, its slow integral apart."""
X = GAINS.alpha * GAINS.e_max
STEEPEST = math.cosh(X) + X * math.sinh(X)
"""Slope just below e_max, 5.5463: the largest local gain."""


def curve(e: Any, e_max: float = 3.0, alpha: float = 0.5) -> Any:
    """``phi`` of Table I on arrays, mm to mm."""
    return e * np.cosh(alpha * np.minimum(1e3 * np.abs(e), e_max))


def slope(e_um: Any, e_max: float = 3.0, alpha: float = 0.5) -> Any:
    """``phi'`` at an error in um, from below at ``e_max``."""
    size = np.abs(e_um)
    x = alpha * np.minimum(size, e_max)
    return np.cosh(x) + np.where(size <= e_max, x * np.sinh(x), 0.0)


def straight_fit() -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """e_max from 0 to 3 in steps of 0.01, K(e_max), the straight line of least squares, and its R^2."""
    x = np.linspace(0.0, 3.0, 301)
    k = np.array([gain(GAINS._replace(e_max=max(v, 1e-9)), 1e-3 * v) for v in x.tolist()])
    line = np.polyval(np.polyfit(x, k, 1), x)
    return x, k, line, float(1.0 - np.sum((k - line) ** 2) / np.sum((k - k.mean()) ** 2))


# ---- compression
FITTED_UM = 3.0
"""Amplitude of the following error under PID that fits best; it is e_max."""

FITTED = MappingProxyType(
    {
        1000: (3.5641, 4.1087, 4.4654, 0.3940, 0.6346),
        2000: (3.8795, 1.8573, 1.8298, 0.7406, 3.8397),
        3000: (3.3123, 2.2289, 2.3574, 1.9472, 1.7267),
    }
)
"""Phases ``p_n`` in rad, by spindle speed; :func:`refitted` finds them again."""

TURN = 2.0 * np.pi * np.arange(720) / 720.0
_ERRORS = np.concatenate([np.linspace(0.0, 3.0, 3001), [1e4]])
_SCALED = np.array([1e3 * scaled_error(GAINS, 1e-3 * e) for e in _ERRORS])


def uncompressed(e_um: np.ndarray) -> np.ndarray:
    """``phi^-1``, for errors in um; ``phi`` is straight beyond ``e_max``, and tabulated every nm before."""
    return np.asarray(np.sign(e_um) * np.interp(np.abs(e_um), _SCALED, _ERRORS))


def pid_error(rpm: int, phases: np.ndarray, motion_um: float) -> np.ndarray:
    """``e_PID`` over one turn of the motion, um: ``(..., 720)`` for phases ``(..., 5)``."""
    waves = np.sin(np.multiply.outer(np.array(ORDERS), TURN) + np.asarray(phases)[..., None])
    return np.asarray(motion_um * np.sin(TURN) + np.einsum("n,...nt->...t", np.array(PID_UM[rpm]), waves))


def npid_rows(rpm: int, phases: np.ndarray, motion_um: float) -> np.ndarray:
    """Amplitudes at the five lines that the law leaves, um: ``(..., 5)``."""
    left = uncompressed(pid_error(rpm, phases, motion_um))
    return np.asarray(np.abs(np.fft.rfft(left, axis=-1)[..., list(ORDERS)]) * 2.0 / TURN.size)


def misfit_um(motion_um: float, phases: dict[int, np.ndarray]) -> float:
    """Root mean square over the fifteen rows of law less printed NPID column."""
    off = [npid_rows(rpm, np.asarray(p), motion_um) - NPID_UM[rpm] for rpm, p in phases.items()]
    return float(np.sqrt(np.mean(np.square(off))))


def refitted(motion_um: float, starts: int = 40, seed: int = 0) -> dict[int, np.ndarray]:
    """Phases that make the law come closest to the NPID column, by least squares from many starts."""
    from scipy.optimize import least_squares

    rng, found = np.random.default_rng(seed), {}
    for rpm in PID_UM:
        tried = [
            least_squares(lambda p, rpm=rpm: npid_rows(rpm, p, motion_um) - NPID_UM[rpm], start, xtol=1e-6)
            for start in rng.uniform(0.0, 2.0 * np.pi, (starts, len(ORDERS)))
        ]
        found[rpm] = np.mod(min(tried, key=lambda t: t.cost).x, 2.0 * np.pi)
    return found


def of_the_disturbance(phases: np.ndarray, dead_time_s: float) -> np.ndarray:
    """Phases of the disturbance at t = 0 that make ``p_n`` in the error under Table I's PID, on an axis so late."""
    motion = np.angle(responses(BASE_HZ, dead_time_s)[0])
    late = np.angle(np.array([responses(f, dead_time_s)[1] for f in LINES_HZ]))
    return np.asarray(np.asarray(phases) + np.array(ORDERS) * motion - late)
