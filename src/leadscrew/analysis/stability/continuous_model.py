"""A continuous model of a sampled loop: the same poles and a dead time, fitted to its frequency response.

    G(e^(jwT))  ~  e^(-jw tau) num(jw) / prod_i (jw - s_i),        s_i = log(z_i) / T for the poles z_i that are slow

Poles near ``z = 0`` (delays, the backward difference) become dead time. For a given ``tau`` the numerator follows
by linear least squares of the relative error up to the phase crossover; ``tau`` is the best one. The model's notes say
how well it fits. It is a model: what is proved for it is not proved for the sampled loop.
"""

from __future__ import annotations

import numpy as np

from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.kernel.errors import ValueRefused

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

    from leadscrew.analysis.stability.crossings import phase_crossings
    from leadscrew.analysis.stability.grid import SMALLEST_RAD_S, modes

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
