"""The Popov criterion: a continuous loop with a static, time-invariant nonlinearity in a sector.

    Re[(1 + j w q) G1(jw)] + 1 / (k2 - k1) > 0 for all w >= 0,        G1 = G / (1 + k1 G) stable

for one real ``q`` of either sign: then ``e = -G phi(e)`` is absolutely stable in the sector ``[k1, k2]``. The largest
``k2`` is ``k1 + 1/m`` with ``m = min_q max_w -Re[(1 + j w q) G1]``; it is infinite where ``m <= 0``. Source: V. M.
Popov, Automation and Remote Control 22 (1961) 857; both signs and any sector: M. A. Aizerman, F. R. Gantmacher,
*Absolute Stability of Regulator Systems*, Holden-Day 1964. With an integrator and ``k1 = 0`` (the critical case) phi
must not vanish and ``q >= 0``. The limits of ``w Im G1`` at infinite frequency are part of the condition: with a dead
time and one pole more than zeros it never dies out.

It is a criterion for continuous loops. Asked of a sampled one it is answered for the continuous model of that loop, and
says so.

A continuous model of a sampled loop: the same poles and a dead time, fitted to its frequency response.

    G(e^(jwT))  ~  e^(-jw tau) num(jw) / prod_i (jw - s_i),        s_i = log(z_i) / T for the poles z_i that are slow

Poles near ``z = 0`` (delays, the backward difference) become dead time. For a given ``tau`` the numerator follows
by linear least squares of the relative error up to the phase crossover; ``tau`` is the best one. The model's notes say
how well it fits. It is a model: what is proved for it is not proved for the sampled loop.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.criterion import ask, best, outcome
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.stability.lure import Lure


NAME = "Popov"


def popov(
    loop: LinearLoop,
    k1: float | None = None,
    k2: float | None = None,
    q: float | None = None,
    nonlinearity: Lure | None = None,
    grid: Any = None,
) -> Certificate:
    """The Popov certificate of a sector, or the largest one from ``k1`` on where ``k2`` is not given.

    Args:
        loop: cut at the error; a sampled one is replaced by its continuous model.
        k1: lower bound of the sector; that of ``nonlinearity`` where not given, else 0.
        k2: upper bound; that of ``nonlinearity`` where not given, else as large as can be proved.
        q: multiplier in s; the best one where not given.
        nonlinearity: checked against the sector.
        grid: frequencies in rad/s; the loop's own where not given.

    Raises:
        ValueRefused: bounds out of order; a sampled loop that has no continuous model.
    """
    notes: list[str] = []
    if loop.sampled:
        name, loop = loop.name, continuous_model(loop)
        notes.append(
            "Popov is a criterion for continuous loops: what is proved is proved for the continuous model of "
            f"{name!r}, not for the loop as it is sampled; for that one ask circle, tsypkin or jury_lee."
        )
    asked = ask(NAME, loop, k1, k2, nonlinearity, grid)
    asked.warnings = [*notes, *asked.warnings]
    if asked.critical and q is not None and q < 0.0:
        asked.refusal = asked.refusal or (
            f"q = {q:g} s: with an integrator in the loop and a sector from 0 the multiplier must not be negative."
        )
    if asked.refusal:
        return asked.refused()

    def lines(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        g = asked.response(w)
        return -g.real, w * g.imag

    lead = float((loop.c @ loop.b)[0, 0])
    ends = [(-float(loop.d[0, 0]) / (1.0 + asked.k1 * float(loop.d[0, 0])), -lead)]
    if loop.dead_time:
        ends.append((0.0, lead))
    poles = np.abs(loop.closed_poles(asked.k1 if asked.k1 else 1.0))
    unit = 1.0 / float(poles.max())
    found = best(lines, asked.grid.w, q, 0.0 if asked.critical else -math.inf, math.inf, unit, tuple(ends))
    data = {"q_s": found.q, "response": asked.response, "loop": loop}
    return outcome(asked, found, " that does not change with time", found.q, data, "popov")


FAST = 0.05
"""Poles with ``|z|`` below this count as delay."""
POINTS = 200
ROUGH = 0.05
"""Misfit from which the model says so."""
REACH = 1.2
"""The fit's upper end, in phase crossover frequencies."""


def continuous_model(loop: LinearLoop) -> LinearLoop:
    """The continuous model of a sampled loop.

    Raises:
        ValueRefused: a loop that is continuous, or one with a pole on the negative real axis of ``z``, which no real
            continuous loop of the same order has.
    """
    from scipy.optimize import minimize_scalar

    from leadscrew.analysis.stability.linear import SMALLEST_RAD_S, modes, phase_crossings

    if loop.dt is None:
        raise ValueRefused(f"continuous_model: the loop {loop.name!r} is continuous already")
    z = np.linalg.eigvals(loop.a).astype(complex)
    z = z[np.abs(z) > FAST]
    if np.any((np.abs(z.imag) < 1e-9) & (z.real < 0.0)):
        raise ValueRefused(
            f"continuous_model: the loop {loop.name!r} has a pole at z = {z[np.argmin(z.real)].real:.3g}, an "
            "oscillation at half the sampling rate, which no continuous loop of the same order has"
        )
    s = np.log(z) / loop.dt
    s[np.abs(s) < 1e-7 / loop.dt] = 0.0
    crossed = phase_crossings(loop)
    top = min(REACH * crossed[0].w, 0.9 * loop.nyquist) if crossed else 0.3 * loop.nyquist
    slow = np.abs(modes(loop))
    low = 0.1 * float(slow[slow > SMALLEST_RAD_S].min(initial=1e-2 * top))
    w = np.concatenate([np.geomspace(low, top, POINTS), np.linspace(0.1 * top, top, POINTS)])
    g = loop.response(w)
    den = np.real(np.poly(s))
    order = len(s)

    def fitted(tau: float) -> tuple[np.ndarray, float]:
        base = np.exp(-1j * w * tau) / np.polyval(den, 1j * w)
        # numerator in units of the band, or its powers would differ by tens of decades
        columns = np.column_stack([base * (1j * w / top) ** (order - 1 - k) for k in range(order)]) / g[:, None]
        matrix = np.vstack([columns.real, columns.imag])
        wanted = np.concatenate([np.ones(len(w)), np.zeros(len(w))])
        num, *_ = np.linalg.lstsq(matrix, wanted, rcond=None)
        return num / top ** np.arange(order - 1, -1, -1), float(np.sqrt(np.mean(np.abs(columns @ num - 1.0) ** 2)))

    tried = np.linspace(0.0, len(loop.a) * loop.dt, 40)
    k = int(np.argmin([fitted(t)[1] for t in tried]))
    sought = minimize_scalar(
        lambda t: fitted(t)[1], bounds=(tried[max(k - 1, 0)], tried[min(k + 1, len(tried) - 1)]), method="bounded",
        options={"xatol": 1e-9 * loop.dt},
    )  # fmt: skip
    tau = max(float(sought.x), 0.0)
    num, off = fitted(tau)
    from leadscrew.analysis.stability.loop import realised

    a, b, c, d = realised(num, den)
    note = (
        f"The continuous model has a dead time of {1e3 * tau:.4g} ms and fits the sampled response within "
        f"{100 * off:.2g} % (rms) up to {top / (2 * np.pi):.4g} Hz."
        + (" That is too far off to conclude anything about the sampled loop." if off > ROUGH else "")
    )
    return LinearLoop(a, b, c, d, None, tau, f"continuous model of {loop.name}", (*loop.notes, note))
