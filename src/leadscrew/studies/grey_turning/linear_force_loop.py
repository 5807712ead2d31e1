"""The force loop near its set-point as a linear one: plant, filter and the laws that the fuzzy controllers are there.

Around 150 N at one depth, in deviations, with the plant's own step (1 ms) and its semi-implicit Euler:

    feed servo        a += dt (w^2 (g u - v) - 2 zeta w a),  v += dt a
    chip, compliance  F (1/s + c) = sum of the last revolution's v dt / 60 + c F(one revolution ago)
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
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.studies.grey_turning.machines import MACHINES, PERIOD_S, SUBSTEPS

if TYPE_CHECKING:
    from leadscrew.analysis.stability.linear import LinearLoop

FIR = (1.0, 0.5, 0.0, -0.5)
TWO_POINT = (2.0, -1.0)
LAST = (1.0,)
ROUND = (1.0, -1.0)


def _added(a: tuple[float, ...], b: tuple[float, ...], sign: float = 1.0) -> tuple[float, ...]:
    n = max(len(a), len(b))
    return tuple(float(x) for x in np.pad(a, (0, n - len(a))) + sign * np.pad(b, (0, n - len(b))))


def _times(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(float(x) for x in np.convolve(a, b))


LAWS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
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
    gain: float
    """In steady state, N/V."""


@lru_cache
def force_plant(
    machine: str = "plant_f", force: float = 150.0, depth: float = 1.0, keep: float = 0.8, rigid: bool = False
) -> ForcePlant:
    """The linear plant of a machine at a force and a depth of cut; ``rigid``: without its compliance."""
    p = MACHINES[machine].plant.params
    dt, rev = PERIOD_S / SUBSTEPS, round(60.0 / p.spindle_rpm / (PERIOD_S / SUBSTEPS))
    chip = (force / (p.law.kf * depth)) ** (1.0 / p.law.exponent)
    s = p.law.exponent * force / chip
    soft = 0.0 if rigid else p.feed_force_ratio / p.stiffness
    # state: voltages still on their way, v, a, the feeds and forces of the last revolution, newest first
    late = round(p.servo.dead_time_s / dt)
    v, acc, feeds, forces = late, late + 1, late + 2, late + 2 + rev
    n = forces + rev
    one, drive = np.zeros((n, n)), np.zeros(n)
    for k in range(1, late):
        one[k, k - 1] = 1.0
    w, zeta = p.servo.rate, p.servo.damping
    row_a, push = np.zeros(n), np.zeros(n)
    row_a[acc], row_a[v] = 1.0 - 2.0 * dt * zeta * w, -dt * w * w
    if late:
        row_a[late - 1] = dt * w * w * p.servo.gain
        drive[0] = 1.0
    else:
        drive[acc] = dt * w * w * p.servo.gain
    row_v = dt * row_a
    row_v[v] += 1.0
    push[v] = dt * drive[acc]
    one[acc], one[v] = row_a, row_v
    drive = drive + push
    one[feeds], drive[feeds] = row_v, drive[v]
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
    gain = float(c @ np.linalg.solve(np.eye(n + 1) - a, b))
    return ForcePlant(a, b, c, s / p.spindle_rpm, gain)


@lru_cache
def response(machine: str, points: int = 1500, **at: Any) -> tuple[np.ndarray, np.ndarray]:
    """Angles from 0 to pi (rad a period) and the plant's frequency response there; further arguments of the plant."""
    plant = force_plant(machine, **at)
    pulses: list[float] = []
    x = plant.b
    while len(pulses) < 400:
        pulses.append(float(plant.c @ x))
        x = plant.a @ x
    angle = np.geomspace(1e-3, np.pi, points)
    late = np.exp(-1j * np.outer(angle, np.arange(1, len(pulses) + 1)))
    return angle, late @ np.array(pulses)


def polynomial(of: tuple[float, ...], angle: np.ndarray) -> np.ndarray:
    """A polynomial in ``q^-1`` on the unit circle."""
    return np.asarray(np.exp(-1j * np.outer(angle, np.arange(len(of)))) @ np.array(of))


def boundary(machine: str, law: str, **at: Any) -> tuple[np.ndarray, np.ndarray]:
    """Kp and Ki (V/N) at which the loop has a pole on the unit circle, from low to high frequency."""
    angle, plant = response(machine, **at)
    with_kp, with_ki = (plant * polynomial(part, angle) / polynomial(ROUND, angle) for part in LAWS[law])
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


class ForceMargins(NamedTuple):
    """Margins of a force loop."""

    gain: float
    """Factor by which the gain may grow; below 1 the loop is unstable."""
    phase_deg: float


def force_margins(machine: str, law: str, kp: float, ki: float, **at: Any) -> ForceMargins:
    """Gain and phase margin, by straight lines between 1,500 frequencies (to about 1e-3)."""
    angle, plant = response(machine, **at)
    law_there = kp * polynomial(LAWS[law][0], angle) + ki * polynomial(LAWS[law][1], angle)
    g = plant * law_there / polynomial(ROUND, angle)
    size, phase = np.log(np.abs(g)), np.unwrap(np.angle(g))
    i, j = int(np.argmax(phase < -np.pi)), int(np.argmax(size < 0.0))
    at_i = (-np.pi - phase[i - 1]) / (phase[i] - phase[i - 1])
    at_j = -size[j - 1] / (size[j] - size[j - 1])
    return ForceMargins(
        float(np.exp(-(size[i - 1] + at_i * (size[i] - size[i - 1])))),
        float(180.0 + np.degrees(phase[j - 1] + at_j * (phase[j] - phase[j - 1]))),
    )


def force_loop(machine: str, law: str, kp: float, ki: float, **at: Any) -> LinearLoop:
    """The loop cut at the error, for the stability criteria of :mod:`leadscrew.analysis.stability`."""
    from leadscrew.analysis.stability.linear import LinearLoop

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
    return LinearLoop(a, b, c, np.zeros((1, 1)), PERIOD_S, name=f"{law} on {machine}")
