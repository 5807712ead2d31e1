"""The force loop near its set-point as a linear one: plant, filter and the laws that the fuzzy controllers are there.

Around 150 N at one depth, in deviations, with the plant's own step (1 ms):

    feed servo        dv/dt = a,  da/dt = w^2 (g u - v) - 2 zeta w a                      exact
    chip, compliance  F (1/s + c) = integral of the last revolution's v / 60 + c F(one revolution ago)
    filter            y_k = keep y_(k-1) + (1 - keep) F_k                                  once a period

``s = K b P h^(P-1)`` is the slope of the force, ``c`` the compliance, ``u`` held over the period. The controllers, with
``q`` one period later and the fixed filter ``f = 1 + q^-1 / 2 - q^-3 / 2`` that GM(1,1) is near a set-point:

    TFC, PI     Kp + Ki / (1 - q^-1)                  reading B    f Kp + f Ki / (1 - q^-1)
    two-point   the same with f = 2 - q^-1            reading A    (f - 1) Kp / (1 - q^-1) + f Ki / (1 - q^-1)

All are ``(Kp p(q) + Ki i(q)) / (1 - q^-1)``, so that the gains at which the loop has a pole on the unit circle follow
from two linear equations at each frequency (D-partition, Neimark 1949).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.margins import margins
from leadscrew.kernel.one_thread import one_thread
from leadscrew.plants._turning.process import hold
from leadscrew.studies.grey_turning.scenarios import FORCE_N, MACHINES, PERIOD_S, SUBSTEPS

Polynomial = tuple[float, ...]

FIR: Polynomial = (1.0, 0.5, 0.0, -0.5)
TWO_POINT: Polynomial = (2.0, -1.0)
LAST: Polynomial = (1.0,)
ROUND: Polynomial = (1.0, -1.0)
PULSES = 200
"""Samples of the plant's answer to one pulse: the filter's pole leaves 1e-19 of it behind them."""


def _added(a: Polynomial, b: Polynomial, sign: float = 1.0) -> Polynomial:
    n = max(len(a), len(b))
    return tuple(float(x) for x in np.pad(a, (0, n - len(a))) + sign * np.pad(b, (0, n - len(b))))


def _times(a: Polynomial, b: Polynomial) -> Polynomial:
    return tuple(float(x) for x in np.convolve(a, b))


LAWS: dict[str, tuple[Polynomial, Polynomial]] = {
    "tfc": (ROUND, LAST),
    "gpfc_b": (_times(FIR, ROUND), FIR),
    "gpfc_a": (_added(FIR, LAST, -1.0), FIR),
    "two_point": (_times(TWO_POINT, ROUND), TWO_POINT),
}
"""Polynomials in ``q^-1`` that Kp and Ki multiply, over ``1 - q^-1``."""


@dataclass(frozen=True, eq=False)
class ForcePlant:
    """From the output of the controller to the filtered force, sampled once a period."""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    slope: float
    """Of the force over the feed, N per mm/min."""

    @property
    def gain(self) -> float:
        """In steady state, N/V."""
        return float(self.c @ np.linalg.solve(np.eye(len(self.b)) - self.a, self.b))

    def pulses(self) -> np.ndarray:
        """The answer to one pulse, from one period after it on."""
        found, x = np.empty(PULSES), self.b
        for k in range(PULSES):
            found[k] = self.c @ x
            x = self.a @ x
        return found


@lru_cache
def force_plant(machine: str = "plant_f", force: float = FORCE_N, depth: float = 1.0, keep: float = 0.8) -> ForcePlant:
    """The linear plant of a machine at a force and a depth of cut."""
    p = MACHINES[machine].plant.params
    dt, rev = PERIOD_S / SUBSTEPS, round(60.0 / p.spindle_rpm / (PERIOD_S / SUBSTEPS))
    chip = (force / (p.law.kf * depth)) ** (1.0 / p.law.exponent)
    s = p.law.exponent * force / chip
    soft = p.feed_force_ratio / p.stiffness
    # state: voltages still on their way, v, a, the feeds and forces of the last revolution, newest first
    late = round(p.servo.dead_time_s / dt)
    v, acc, feeds, forces = late, late + 1, late + 2, late + 2 + rev
    n = forces + rev
    one, drive = np.zeros((n, n)), np.zeros(n)
    for k in range(1, late):
        one[k, k - 1] = 1.0
    h, g = hold(p.servo.rate, p.servo.damping, dt), p.servo.gain
    # v, a and the mean feed of the step: what v, a and the voltage leave of each
    moves = {
        v: (h.y_of_y, h.y_of_rate, g * (1.0 - h.y_of_y)),
        acc: (h.rate_of_y, h.rate_of_rate, -g * h.rate_of_y),
        feeds: (h.area_of_y / dt, h.area_of_rate / dt, g * (1.0 - h.area_of_y / dt)),
    }
    for to, (of_v, of_acc, of_voltage) in moves.items():
        one[to, v], one[to, acc] = of_v, of_acc
        if late:
            one[to, late - 1] = of_voltage
        else:
            drive[to] = of_voltage
    if late:
        drive[0] = 1.0
    for k in range(1, rev):
        one[feeds + k, feeds + k - 1] = 1.0
        one[forces + k, forces + k - 1] = 1.0
    share = dt / 60.0 / (1.0 / s + soft)
    row_f = share * one[feeds : feeds + rev].sum(axis=0)
    row_f[forces + rev - 1] += soft / (1.0 / s + soft)
    one[forces], drive[forces] = row_f, share * drive[feeds]
    whole, held = np.eye(n), np.zeros(n)
    for _ in range(SUBSTEPS):
        held = one @ held + drive
        whole = one @ whole
    a, b, c = np.zeros((n + 1, n + 1)), np.zeros(n + 1), np.zeros(n + 1)
    a[:n, :n], b[:n] = whole, held
    a[n, :n], a[n, n], b[n] = (1.0 - keep) * whole[forces], keep, (1.0 - keep) * held[forces]
    c[n] = 1.0
    return ForcePlant(a, b, c, s / p.spindle_rpm)


def polynomial(of: Any, z: np.ndarray) -> np.ndarray:
    """A polynomial in ``q^-1`` at points ``z``."""
    return np.asarray(np.polynomial.polynomial.polyval(1.0 / z, np.asarray(of, dtype=float)))


# ---- the gains that are stable
@lru_cache
def response(machine: str, points: int = 1500, **at: Any) -> tuple[np.ndarray, np.ndarray]:
    """Points from 0 to pi on the unit circle and the plant's response there; further arguments of the plant."""
    z = np.exp(1j * np.geomspace(1e-3, np.pi, points))
    return z, polynomial(force_plant(machine, **at).pulses(), z) / z


def boundary(machine: str, law: str, **at: Any) -> tuple[np.ndarray, np.ndarray]:
    """Kp and Ki (V/N) at which the loop has a pole on the unit circle, from low to high frequency."""
    z, plant = response(machine, **at)
    with_kp, with_ki = (plant * polynomial(part, z) / polynomial(ROUND, z) for part in LAWS[law])
    turn = with_kp.real * with_ki.imag - with_kp.imag * with_ki.real
    return -with_ki.imag / turn, with_kp.imag / turn


def first_part(machine: str, law: str, **at: Any) -> tuple[np.ndarray, np.ndarray]:
    """The boundary of the stable ``Kp, Ki >= 0``, from Kp = 0 round to Ki = 0."""
    kp, ki = boundary(machine, law, **at)
    inside = (kp >= 0.0) & (ki >= 0.0)
    first = int(np.argmax(inside))
    last = len(kp) if inside[first:].all() else first + int(np.argmin(inside[first:]))
    return kp[first:last], ki[first:last]


def stable_area(machine: str, law: str, **at: Any) -> float:
    """Area of the stable ``Kp, Ki >= 0``, (V/N)^2."""
    kp, ki = first_part(machine, law, **at)
    return float(np.trapezoid(ki, kp))


# ---- margins
@dataclass(frozen=True, eq=False)
class ForceLoop(LinearLoop):
    """The loop cut at the error. Its response is the sum of the plant's pulses: a hundred states cost more."""

    pulses: Polynomial = ()
    law: Polynomial = ()

    def response(self, w: Any) -> np.ndarray:
        """As of any :class:`LinearLoop`, to its last digits."""
        z = np.exp(1j * np.asarray(w, dtype=float) * PERIOD_S)
        return np.asarray(polynomial(self.pulses, z) / z * polynomial(self.law, z) / polynomial(ROUND, z))


def force_loop(machine: str, law: str, kp: float, ki: float, **at: Any) -> ForceLoop:
    """The loop of a law with these gains, for the criteria of :mod:`leadscrew.analysis.stability`."""
    plant = force_plant(machine, **at)
    num = _added(tuple(kp * x for x in LAWS[law][0]), tuple(ki * x for x in LAWS[law][1]))
    order = len(num)  # the increments of the last periods and the output
    n = len(plant.b)
    ca, cb = np.zeros((order, order)), np.zeros(order)
    for k in range(1, order - 1):
        ca[k, k - 1] = 1.0
    cb[0] = 1.0
    step = np.zeros(order)
    step[: order - 1] = num[1:]
    ca[order - 1] = step
    ca[order - 1, order - 1] = 1.0
    cb[order - 1] = num[0]
    a = np.block([[plant.a, np.outer(plant.b, ca[order - 1])], [np.zeros((order, n)), ca]])
    b = np.concatenate([plant.b * num[0], cb])[:, None]
    c = np.concatenate([plant.c, np.zeros(order)])[None, :]
    name = f"{law} on {machine}"
    return ForceLoop(a, b, c, np.zeros((1, 1)), PERIOD_S, name=name, pulses=tuple(plant.pulses()), law=num)


class ForceMargins(NamedTuple):
    """Margins of a force loop."""

    gain: float
    """Factor by which the gain may grow; below 1 the loop is unstable, and stable with less than this."""
    phase_deg: float
    """NaN of an unstable loop."""


@lru_cache
@one_thread()
def force_margins(machine: str, law: str, kp: float, ki: float, **at: Any) -> ForceMargins:
    """Gain and phase margin of a law with these gains."""
    found = margins(force_loop(machine, law, kp, ki, **at))
    return ForceMargins(found.gm if np.isfinite(found.gm) else found.gm_down, found.pm_deg)
