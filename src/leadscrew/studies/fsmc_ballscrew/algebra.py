"""Numbers that follow from the paper's equations by hand: eigenvalues, tight bounds, binomials, a Lyapunov function."""

from __future__ import annotations

import math
from math import comb

import numpy as np
from scipy.integrate import quad

from leadscrew.friction.lugre import HAT, LuGre, steady_bristle
from leadscrew.plants.ballscrew_stage import INERTIA, BallscrewStageParams, BallscrewStageState, stage_jacobian

SPEEDS = (0.0, 1e-5, 1e-4, 3e-4, 1e-3, 2e-3, 5e-3, 0.1, 3.14, 10.0)
"""Steady speeds of the table of eigenvalues, rad/s."""


def open_loop_eigenvalues(speed: float) -> tuple[float, float]:
    """Eigenvalues of the stage's speed and bristles in steady sliding, 1/s, the one of larger size first.

    At rest the bristles are unbent. A positive one means that friction falls with speed faster than the stage can
    follow: the motion runs away until it sticks or slides fast.
    """
    p = BallscrewStageParams()
    rows = stage_jacobian(p, BallscrewStageState(0.0, speed, steady_bristle(p.friction, speed)))
    found = np.linalg.eigvals(np.array(rows)[1:, 1:]).real
    return float(found[np.abs(found).argmax()]), float(found[np.abs(found).argmin()])


def explicit_limits_us() -> tuple[float, float]:
    """Largest stable steps of Euler's method and of RK4 while the stage sticks, us."""
    rate = -open_loop_eigenvalues(0.0)[0]
    ends = [r.real for r in np.roots([1 / 24, 1 / 6, 1 / 2, 1, 0]) if abs(r.imag) < 1e-9 and r.real < -1e-9]
    return 2e6 / rate, -1e6 * max(ends) / rate


def explicit_limit_speed() -> float:
    """Speed above which the bristles' own relaxation is faster than the sticking stage, rad/s."""
    f = LuGre()
    return -open_loop_eigenvalues(0.0)[0] * f.coulomb / f.stiffness


def passive_viscosity(f: LuGre) -> float:
    """Least ``s2`` with which the model passes no energy from bristles to motion, ``s1 (F_S - F_C) / F_C``."""
    return f.damping * (f.static - f.coulomb) / f.coulomb


def stick_damping(f: LuGre, inertia: float) -> float:
    """Damping ratio of a stuck stage on its bristles."""
    return (f.damping + f.viscous) / (2.0 * math.sqrt(f.stiffness * inertia))


def tight_bounds() -> tuple[float, float]:
    """Largest ``lam |e| / phi`` and ``|e'| / phi`` that ``|s| <= phi`` allows, with ``s = (d/dt + lam)^2 xi``.

    Integrals of the size of the responses to an impulse of s, in time ``lam t``: ``e = p / (p + 1)^2 s`` answers with
    ``(1 - t) e^-t``, ``e' = p^2 / (p + 1)^2 s`` with the impulse itself and ``(t - 2) e^-t``. None smaller hold.
    """

    def size(zero: float) -> float:
        parts = ((0.0, zero), (zero, 60.0))
        return sum(abs(quad(lambda t: (t - zero) * math.exp(-t), a, b, epsabs=1e-12)[0]) for a, b in parts)

    return size(1.0), 1.0 + size(2.0)


def binomial_error(n: int, lam: float = 150.0) -> float:
    """Largest relative difference between (10) and ``s' + lam s = delta_f + v_c``, coefficient by coefficient.

    With ``y^(n) = f + u`` that equation says ``e^(n) + sum over k of C(n+1, k+1) lam^(n-k) e^(k) + lam^(n+1) xi``
    ``= (d/dt + lam)^(n+1) xi``, where ``e^(k)`` is the derivative k + 1 of xi.
    """
    printed = [lam ** (n + 1), *(comb(n + 1, k + 1) * lam ** (n - k) for k in range(n)), 1.0]
    product = np.array([1.0])
    for _ in range(n + 1):
        product = np.polymul(product, [1.0, lam])
    return float(np.max(np.abs(np.array(printed[::-1]) - product) / product))


def lyapunov_residual(lam: float = 150.0, draws: int = 1000) -> float:
    """Largest relative error of ``V' = -lam (s + s_c)^2 + (s + s_c) (delta_f + v_c)``, ``V = (s^2 + s_c^2) / 2``.

    ``V'`` by the chain rule from e'', for random states and random ``w = delta_f + v_c``.
    """
    xi, e, rate, w = np.random.default_rng(7).normal(size=(4, draws)) * np.array([[1e-6], [1e-4], [1e-2], [1e4]])
    acceleration = w - 3.0 * lam * rate - 3.0 * lam**2 * e - lam**3 * xi
    s, s_c = rate + 2.0 * lam * e + lam**2 * xi, rate - lam**2 * xi
    terms = s * (acceleration + 2.0 * lam * rate + lam**2 * e), s_c * (acceleration - lam**2 * e)
    stated = -lam * (s + s_c) ** 2 + (s + s_c) * w
    return float(np.max(np.abs(terms[0] + terms[1] - stated) / (np.abs(terms[0]) + np.abs(terms[1]))))


def printed_rules_poles(gain: float, lam: float = 150.0) -> np.ndarray:
    """Poles of the loop under ``K_f = -gain (s - s_c) / 2``: ``(p + lam) ((p + lam)^2 + lam gain)``, 1/s."""
    return np.roots(np.polyadd(np.poly([-lam] * 3), lam * gain * np.poly([-lam])))


def corrected_rules_poles(gain: float, lam: float = 150.0) -> np.ndarray:
    """Poles of the loop under ``K_f = -gain (s + s_c) / 2``: ``(p + lam) ((p + lam)^2 + gain p)``, 1/s."""
    return np.roots(np.polyadd(np.poly([-lam] * 3), gain * np.poly([-lam, 0.0])))


def feedback_growth() -> float:
    """Growth rate of a stuck stage under ``T = F_hat`` of the measured speed, ``s1`` included, 1/s."""
    true, hat = LuGre(), HAT
    by_speed = (hat.damping + hat.viscous - true.damping - true.viscous) / INERTIA
    rows = [[by_speed, -true.stiffness / INERTIA, hat.stiffness / INERTIA], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    return float(np.linalg.eigvals(np.array(rows)).real.max())
