"""The Zames-Falb criterion as a verified matrix inequality: fixed odd laws of bounded slope, sampled loops.

The multiplier ``1 + M(z)`` of :mod:`leadscrew.analysis.stability.zames_falb`, found on a grid of frequencies, remembers
the last errors; they become states. With ``w = v - k1 e``, ``g = e - w / s``, ``s = s2 - k1`` and ``k = k2 - k1``, what
is added to the circle's ``2 w (k e - w)`` is, for the coefficients of the delay ``i``::

    2 k q_i w (g - g_i),     2 k p_i w (g + g_i)           the delayed signal against the present w,
    2 k q_-i w_i (g_i - g),  2 k p_-i w_i (g_i + g)        the present signal against the delayed w

The second row makes ``x' P x`` no Lyapunov function, and ``P`` need not be positive: the inequality is the
Kalman-Yakubovich-Popov form of the frequency condition, and proves it at **every** frequency. That the condition makes
the loop stable is the theorem of Zames and Falb (R. O'Shea, M. I. Younis, IEEE Trans. Automatic Control 12, 1967;
J. C. Willems, R. W. Brockett, *ibid.* 13, 1968), which asks that the loop closed with ``k1`` is stable: that is proved
beside it.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate, Grade, of_loop
from leadscrew.analysis.stability.exact import Inequality, rational
from leadscrew.analysis.stability.kyp import ROUNDING, inequality, solve
from leadscrew.analysis.stability.linear import LinearLoop
from leadscrew.analysis.stability.lmi import refusal
from leadscrew.kernel.errors import ValueRefused

TAPS = 6
"""Delays of the multiplier to either side; on the loop L* of the XY table fewer gain nothing over one."""
SMALLEST = 1e-9
"""Coefficients below this part of the largest are left out."""


def lmi_zames_falb(loop: LinearLoop, k1: float, k2: float, slope: float, taps: int = TAPS) -> Certificate:
    """The sector ``[k1, k2]`` for every fixed odd law whose slope lies in ``[k1, slope]``.

    Raises:
        ValueRefused: a continuous loop, bounds out of order, no taps.
    """
    from leadscrew.analysis.stability.zames_falb import zames_falb

    if not loop.sampled:
        raise ValueRefused(f"loop {loop.name!r} is continuous: this form of Zames-Falb is for sampled loops")
    if not (math.isfinite(slope) and k1 < k2 <= slope):
        raise ValueRefused(f"sector [{k1!r}, {k2!r}], slope {slope!r}: needs k1 < k2 <= slope, all finite")
    refused = refusal(loop, k1)
    if refused is not None:
        return _made(loop, (k1, k2), "refused", refused, None, {})
    found = zames_falb(loop, k1, slope=slope, taps=taps)
    limit = found.limit if found.limit is not None else k1
    weights = np.asarray(found.data.get("weights", np.zeros(4 * taps)))
    numbers: dict[str, object] = {"grid_limit": limit, "taps": taps, "weights": weights}
    rest = solve(inequality(loop, k1, k1), k1)
    asked = zames_falb_inequality(loop, k1, k2, weights, taps, slope)
    proof = solve(asked, k1, positive=False) if k2 <= limit else None
    if proof is None or rest is None:
        said = f"No proof of [{k1:g}, {k2:g}] for {loop.name!r}: on a grid the criterion holds up to {limit:.5g}."
        return _made(loop, (k1, k2), "refused", said, limit, numbers)
    tolerance = min(proof.tolerance, rest.tolerance)
    law = f"between {k1:g} e and {k2:.6g} e with slopes in [{k1:g}, {slope:.6g}]"
    said = (
        f"At rest, with every fixed odd error law {law}, {loop.name!r} returns to rest from every state: the condition "
        "of Zames and Falb is proved at every frequency, in exact arithmetic, for its matrices in double precision and "
        f"for all that differ from them by up to {tolerance:.2g} of each entry; their rounding is below {ROUNDING:.2g}."
    )
    numbers |= {"p": proof.p, "order": proof.order, "tolerance": tolerance, "rounding": ROUNDING}
    return _made(loop, (k1, k2), "certificate", said, k2, numbers)


def _made(
    loop: LinearLoop, sector: tuple[float, float], grade: Grade, said: str, limit: float | None,
    numbers: dict[str, object],
) -> Certificate:  # fmt: skip
    margin = None if limit is None else limit / sector[1]
    return Certificate(
        "Zames-Falb, matrix inequality", grade, said, of_loop(loop), sector, limit, margin, None, None,
        list(loop.notes), numbers,
    )  # fmt: skip


def zames_falb_inequality(
    loop: LinearLoop, k1: float, k2: float, weights: np.ndarray, taps: int, slope: float
) -> Inequality:
    """The inequality for the coefficients ``q`` then ``p``, each for the delays ``-taps .. -1, 1 .. taps``."""
    used = np.where(weights > SMALLEST * max(float(weights.max()), SMALLEST), weights, 0.0)
    delays = [i for i in range(-taps, taps + 1) if i]
    most = max(
        (abs(i) for i, q, p in zip(delays, used[: 2 * taps], used[2 * taps :], strict=True) if q or p), default=1
    )
    n = len(loop.a)
    order = n + 2 * most
    e = rational(np.zeros(order + 1))
    e[:n], e[order] = -rational(loop.c.ravel()), -rational(loop.d)[0, 0]
    unit = rational(np.eye(order + 1))
    z = rational(np.zeros((order, order + 1)))
    z[:n, :n], z[:n, order] = rational(loop.a), rational(loop.b)[:, 0]
    first = n, n + most
    z[first[0]], z[first[1]] = e, unit[order]
    for start in first:
        for j in range(1, most):
            z[start + j] = unit[start + j - 1]
    y = np.vstack([e, unit[order], unit[n:order]])
    z_bound, y_bound = 0 * z, 0 * y
    z_bound[:n], z_bound[n], y_bound[0] = abs(z[:n]), abs(e), abs(e)
    low, k = Fraction(k1), Fraction(k2) - Fraction(k1)

    def signals(i: int) -> tuple[np.ndarray, np.ndarray]:
        """``w`` and ``g``, ``i`` periods ago, over ``y``."""
        error, law = np.array([Fraction(0)] * len(y), dtype=object), np.array([Fraction(0)] * len(y), dtype=object)
        error[0 if i == 0 else 1 + i] = Fraction(1)
        law[1 if i == 0 else 1 + most + i] = Fraction(1)
        w = law - low * error
        return w, error - w / (Fraction(slope) - low)

    error = np.array([Fraction(1)] + [Fraction(0)] * (len(y) - 1), dtype=object)
    (w, g), s = signals(0), np.outer(signals(0)[0], k * error - signals(0)[0])
    for sign, part in ((-1, used[: 2 * taps]), (1, used[2 * taps :])):
        for i, size in zip(delays, part, strict=True):
            if size == 0.0:
                continue
            w_then, g_then = signals(abs(i))
            more = np.outer(w, g + sign * g_then) if i > 0 else np.outer(w_then, g_then + sign * g)
            s = s + k * Fraction(float(size)) * more
    return Inequality(z, y, s + s.T, True, z_bound, y_bound)
