"""The differentiating circuit of Figure 5: what two cascaded differentiators make of e, ec and u of a controller.

Each stage is a real differentiator, ``s / (T s + 1)``, exact for a signal that runs in straight lines between its
samples:

    y_k = a y_(k-1) + (1 - a) (x_k - x_(k-1)) / dt,    a = exp(-dt / T)

Two stages give ``d2e/dt2``, ``d2(ec)/dt2`` and ``d2u/dt2``, derivatives over *time*. The paper reads second derivatives
over *e* and *ec* off a scope, (8) and (9), and does not say how one comes from the other. For a law ``u(e, c)``

    d2u/dt2 = u_ee e'^2 + 2 u_ec e' c' + u_cc c'^2 + u_e e'' + u_c c''

so one signal holds five terms, and the quotient ``(d2u/dt2) / (d2e/dt2)`` is not ``u_ee``: for a straight law
``u = -k e`` it is ``-k`` where ``u_ee`` is 0, and it has a pole wherever ``e''`` passes zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from leadscrew.studies.vud_lathe.curvature_trials import RATE_MM, SCALE_MM, TRUE

LAG_S = 0.01
"""Of each stage; the paper gives no component. Ten periods of the controller."""
LAGS_S = (0.001, 0.003, 0.01, 0.03)
PERIOD_S = 0.001


class Partials(NamedTuple):
    """Partial derivatives of a law u(e, c), each a function of e and c."""

    e: Callable[[Any, Any], Any]
    c: Callable[[Any, Any], Any]
    ee: Callable[[Any, Any], Any]
    ec: Callable[[Any, Any], Any]
    cc: Callable[[Any, Any], Any]


def _zero(e, c):
    return 0.0 * e


CUBIC = Partials(
    e=lambda e, c: -(0.5 + 0.5 * TRUE[0] * e * e),
    c=lambda e, c: -(0.1 + 0.5 * TRUE[1] * c * c),
    ee=lambda e, c: -TRUE[0] * e,
    ec=_zero,
    cc=lambda e, c: -TRUE[1] * c,
)
"""Of the smooth law of :mod:`leadscrew.studies.vud_lathe.curvature_trials`."""


def power_curvature(e, gain: float, exponent: float):
    """``|u_ee|`` of ``u = -sgn(e) gain |e|^exponent``; without bound towards e = 0."""
    return gain * exponent * (1.0 - exponent) * np.abs(e) ** (exponent - 2.0)


def error_with_curvature(value: float, gain: float, exponent: float) -> float:
    """The ``|e|`` at which the power law's ``|u_ee|`` has this value."""
    return float((gain * exponent * (1.0 - exponent) / value) ** (1.0 / (2.0 - exponent)))


def differentiate(x: np.ndarray, lag_s: float = LAG_S, stages: int = 2, dt: float = PERIOD_S) -> np.ndarray:
    """The output of cascaded stages; before the first sample the signal stood still."""
    from scipy.signal import lfilter

    a = math.exp(-dt / lag_s)
    y = np.asarray(x, dtype=float)
    for _ in range(stages):
        y = lfilter([(1.0 - a) / dt, -(1.0 - a) / dt], [1.0, -a], y - y[0])
    return y


def terms(e: np.ndarray, c: np.ndarray, law: Partials, dt: float = PERIOD_S) -> Mapping[str, np.ndarray]:
    """The five terms of d2u/dt2 along a path, derivatives of e and c by central differences."""
    e1, c1 = np.gradient(e, dt), np.gradient(c, dt)
    e2, c2 = np.gradient(e1, dt), np.gradient(c1, dt)
    return {
        "u_ee e'^2": law.ee(e, c) * e1**2,
        "2 u_ec e'c'": 2.0 * law.ec(e, c) * e1 * c1,
        "u_cc c'^2": law.cc(e, c) * c1**2,
        "u_e e''": law.e(e, c) * e2,
        "u_c c''": law.c(e, c) * c2,
    }


class Scope(NamedTuple):
    """What the circuit puts out along one move."""

    time: np.ndarray
    e: np.ndarray
    u2: np.ndarray
    e2: np.ndarray
    c2: np.ndarray

    @property
    def over_e(self) -> np.ndarray:
        """The quotient of the outputs of u and e."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.abs(self.u2 / self.e2)

    @property
    def over_c(self) -> np.ndarray:
        """The quotient of the outputs of u and ec."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.abs(self.u2 / self.c2)

    def at(self, error: float) -> int:
        """Row at which the size of e first is no more than this."""
        return int(np.argmax(np.abs(self.e) <= error))


def scope(time: np.ndarray, e: np.ndarray, c: np.ndarray, u: np.ndarray, lag_s: float = LAG_S) -> Scope:
    """The circuit on the signals of one move."""
    return Scope(time, e, *(differentiate(x, lag_s) for x in (u, e, c)))


def signals(run: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time, e, ec and duty of a run of the loop, as its controller's terminals show them."""
    error = run["command"] - run["feedback"]
    change = np.diff(error, prepend=error[0]) * (0.1 / PERIOD_S)
    return run.time, error / SCALE_MM, change / RATE_MM, run["output"]
