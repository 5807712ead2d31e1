"""What follows from the paper's equations by hand: eigenvalues, tight bounds, binomials, a Lyapunov function, poles."""

from __future__ import annotations

import math
from math import comb

import numpy as np
from scipy.integrate import quad

from leadscrew.controllers._sliding.fuzzy import RULES, fsmc, sliding_system
from leadscrew.friction.lugre import HAT, LuGre, level, level_slope, steady_bristle
from leadscrew.plants._ballscrew_stage import INERTIA, BallscrewStageParams, BallscrewStageState, stage_jacobian

SYSTEMS = {name: sliding_system(rules) for name, rules in RULES.items()}
"""The fuzzy systems of Figures 8 and 9, by rule base."""
PHI, LAM = 0.1, 150.0
"""Printed boundary layer, rad/s, and rate of the surface, 1/s."""
SLOPE = 120.0 / (INERTIA * 0.65)
"""Slope of the fuzzy law inside, U / (J S), 1/s."""


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


def feedback_growth() -> float:
    """Growth rate of a stuck stage under ``T = F_hat`` of the measured speed, ``s1`` included, 1/s."""
    true, hat = LuGre(), HAT
    by_speed = (hat.damping + hat.viscous - true.damping - true.viscous) / INERTIA
    rows = [[by_speed, -true.stiffness / INERTIA, hat.stiffness / INERTIA], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    return float(np.linalg.eigvals(np.array(rows)).real.max())


def surface(rules: str, s: float, s_c: float) -> float:
    """K of a rule base; both inputs over their scales."""
    return float(SYSTEMS[rules](s=s, s_c=s_c)["k"])


def fuzzy_slope() -> float:
    """How strongly the fuzzy law answers to e' near 0, 1/s: ``(U / J) dK/de'`` with ``s = s_c = e'``."""
    p, small = fsmc.params, 1e-6
    return -p.fuzzy_torque / p.inertia * surface("corrected", small / p.scale_s, small / p.scale_sc) / small


def longest_periods_us() -> dict[str, float]:
    """Longest stable control period with the printed gains, by law: 2 over the slope against e', in sliding."""
    sliding = LuGre().coulomb / INERTIA
    slopes = {"SMC": (sliding + 120.0) / PHI, "CSMC": 2.0 * (sliding + 20.0) / PHI, "FSMC": fuzzy_slope()}
    return {law: 2e6 / slope for law, slope in slopes.items()}


def printed_slopes() -> dict[str, float]:
    """How strongly the printed laws answer to e' near 0 while the stage slides slowly, 1/s, by law."""
    return {law: 2e6 / period for law, period in longest_periods_us().items()}


def friction_slope(speed: float) -> float:
    """Slope of the steady friction over the speed, N m s/rad."""
    return level_slope(LuGre(), speed) + LuGre().viscous


def g_falls() -> bool:
    """Whether g(v) falls at every speed up to 10 rad/s."""
    f = LuGre()
    return bool(np.all(np.diff([level(f, v) for v in np.geomspace(1e-6, 10.0, 2001)]) <= 0.0))


def scales(torque: float, ratio: float, slope: float = SLOPE) -> dict[str, float]:
    """Parameters of a fuzzy law with ``U = torque``, this slope, and ``S_c = ratio S``."""
    s = torque / (INERTIA * slope)
    return {"controller.fuzzy_torque": torque, "controller.scale_s": s, "controller.scale_sc": ratio * s}
