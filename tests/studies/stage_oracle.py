"""The paper's closed loops in continuous time, written out again from its equations, for SciPy's Radau.

State: angle, speed, bristle, integral of the error, believed bristle; rad and s throughout.
"""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

TRAVEL = 1.5923
INERTIA = 2.12e-4 + 62.4 * 1.5923e-3**2
LAM, PHI = 150.0, 0.1
TRUE = (1e5, math.sqrt(1e5), 0.4, 6.24, 9.36, 0.001)
HAT = (2e5, 2.0 * math.sqrt(1e5), 1.2, 6.24, 9.36, 0.005)
"""Table 2: sigma_0, sigma_1, sigma_2, F_C, F_S, v_s."""

SINES = {"sine_slow": (0.01, 1.0), "sine_wide": (5.0, 1.0), "sine_fast": (1.0, 2.0 * math.pi)}


def level(table, v):
    """sigma_0 g(v), (3)."""
    return table[3] + (table[4] - table[3]) * math.exp(-((v / table[5]) ** 2))


def lugre(table, v, z):
    """Friction and bristle rate, (1) and (2)."""
    rate = v - abs(v) * z * table[0] / level(table, v)
    return table[0] * z + table[1] * rate + table[2] * v, rate


def gain(v, eta):
    """K with the tilde column of Table 2: sigma_2 1, v_s 0.005."""
    return (6.24 + 3.12 * math.exp(-((v / 0.005) ** 2)) + abs(v)) / INERTIA + eta


def clipped(x):
    return min(1.0, max(-1.0, x))


def smc(e, rate, xi, v):
    return -LAM * rate - gain(v, 120.0) * clipped((rate + LAM * e) / PHI)


def u_hat(e, rate, xi):
    return -3.0 * LAM * rate - 3.0 * LAM**2 * e - LAM**3 * xi


def smc_integral(e, rate, xi, v):
    return u_hat(e, rate, xi) - gain(v, 120.0) * clipped((rate + 2.0 * LAM * e + LAM**2 * xi) / PHI)


def csmc(e, rate, xi, v):
    return u_hat(e, rate, xi) - gain(v, 20.0) * clipped(2.0 * (rate + LAM * e) / PHI)


def centroid(heights):
    """Of triangles at -1, -0.5, 0, 0.5, 1, half as wide as a unit, cut at heights and joined by maximum.

    Between two kinks the joined line is straight, so that Simpson's rule is exact for it times its place.
    """
    area = moment = 0.0
    peaks = [0.0, *heights, 0.0]
    for k, (left, right) in enumerate(pairwise(peaks)):
        low = 0.5 * k - 1.5
        kinks = sorted({0.0, 0.5, 1.0, left, 1.0 - left, right, 1.0 - right})
        for a, b in pairwise(kinks):
            for x, weight in ((a, 1.0), (0.5 * (a + b), 4.0), (b, 1.0)):
                held = weight * (b - a) / 6.0 * max(min(left, 1.0 - x), min(right, x))
                area += held
                moment += held * (low + 0.5 * x)
    return moment / area


CORRECTED = {(0, 0): 4, (0, 1): 3, (1, 0): 3, (0, 2): 2, (1, 1): 2, (2, 0): 2, (1, 2): 1, (2, 1): 1, (2, 2): 0}
"""From (s, s_c) in N, Z, P to NB, NS, ZO, PS, PB."""


def grades(x):
    x = clipped(x)
    return max(0.0, -x), 1.0 - abs(x), max(0.0, x)


def surface(s, s_c):
    """K(s, s_c): minimum, maximum, centroid, with the rules along s + s_c."""
    of_s, of_c, heights = grades(s), grades(s_c), [0.0] * 5
    for (i, j), out in CORRECTED.items():
        heights[out] = max(heights[out], min(of_s[i], of_c[j]))
    return centroid(heights)


def fuzzy(side):
    def law(e, rate, xi, v):
        s, s_c = rate + 2.0 * LAM * e + LAM**2 * xi, rate - LAM**2 * xi
        return u_hat(e, rate, xi) + 120.0 / INERTIA * surface(s / 0.65, side * s_c / 2.6)

    return law


LAWS: dict[str, Callable[..., float]] = {
    "corrected.smc": smc, "paper.smc": smc_integral, "paper.csmc": csmc, "corrected.fsmc": fuzzy(1.0),
    "paper.fsmc": fuzzy(-1.0),
}  # fmt: skip
"""u without f_hat and y_r''; the printed rules are the corrected ones with s_c turned round."""


def sine(scenario):
    amplitude, w = SINES[scenario]
    a = amplitude / TRAVEL
    return lambda t: (a * math.sin(w * t), a * w * math.cos(w * t), -a * w * w * math.sin(w * t))


def step(t):
    return 1.0 / TRAVEL, 0.0, 0.0


def torque(law, command, t, x):
    """T and the rate of the believed bristles."""
    angle, speed, acceleration = command(t)
    held, rate = lugre(HAT, speed, x[4])
    return held + INERTIA * (acceleration + LAWS[law](x[0] - angle, x[1] - speed, x[3], x[1])), rate


def radau(law, command, start, times, rtol=1e-10):
    """States at the times; columns as in the module's first lines."""

    def rates(t, x):
        push, believed = torque(law, command, t, x)
        held, rate = lugre(TRUE, x[1], x[2])
        return [x[1], (push - held) / INERTIA, rate, x[0] - command(t)[0], believed]

    atol = [1e-13, 1e-12, 1e-15, 1e-15, 1e-15]
    done = solve_ivp(rates, (0.0, times[-1]), start, method="Radau", t_eval=times, rtol=rtol, atol=atol)
    assert done.success
    return done.y.T


def sliding_start(scenario):
    """On the command, both bristles at steady sliding."""
    v = sine(scenario)(0.0)[1]
    return np.array([0.0, v, level(TRUE, v) / TRUE[0], 0.0, level(HAT, v) / HAT[0]])
