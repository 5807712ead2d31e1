"""An independent closed loop of the lathe axis: printed transfer functions, all 36 rules, nothing of ours imported.

The plant is the product of (2) and (3) with their printed gains, a screw that turns rad/s into mm/s, an integrator and
(4), stepped by SciPy's matrix exponential; the controllers sum over all rules as (21) is written.
"""

import math

import numpy as np
from scipy.linalg import expm

PERIOD = 1e-3
CENTRES = [-1, -0.67, -0.33, 0.33, 0.67, 1]
PRINTED = """
1.000  1.000  1.000  1.000  0.677  0.677
1.000  1.000  1.000  0.677  0.677  0.677
0.677  0.677  0.677  0.333  0.333  0.333
-0.333 -0.333 -0.333 -0.677 -0.677 -0.677
-0.677 -0.677 -0.677 -1.000 -1.000 -1.000
-0.677 -0.677 -1.000 -1.000 -1.000 -1.000"""
RULES = [[float(x) for x in row.split()] for row in PRINTED.strip().splitlines()]


def triangles(x):
    """Memberships in the six sets."""
    x = min(1.0, max(-1.0, x))
    mu = []
    for i, c in enumerate(CENTRES):
        if x == c:
            mu.append(1.0)
        elif x < c:
            mu.append(0.0 if i == 0 else max(0.0, (x - CENTRES[i - 1]) / (c - CENTRES[i - 1])))
        else:
            mu.append(0.0 if i == 5 else max(0.0, (CENTRES[i + 1] - x) / (CENTRES[i + 1] - c)))
    return mu


def all_rules(x, y):
    """The quotient of (21), both sums over 36 rules."""
    mu, nu = triangles(x), triangles(y)
    above = below = 0.0
    for i in range(6):
        for j in range(6):
            above += RULES[i][j] * mu[i] * nu[j]
            below += mu[i] * nu[j]
    return above / below


def axis_matrices(speed, screw_lag=0.017):
    """Exact step of PWM volts, motor volts, rad/s, mm and mm read."""
    mm_per_rad = speed / (30 * 0.26)
    a = np.zeros((6, 6))
    a[0, 0], a[0, 5] = -1 / 0.0008, -30 / 0.0008
    a[1, 0], a[1, 1] = 0.26 / 0.0015, -1 / 0.0015
    a[2, 1], a[2, 2] = 1 / screw_lag, -1 / screw_lag
    a[3, 2] = mm_per_rad
    a[4, 3], a[4, 4] = 1 / 0.006, -1 / 0.006
    return expm(a * PERIOD)


def simulate(target, periods, law="vud", speed=289.0, encoder=False):
    """True position at the start of every period; laws: vud (21), beta_e (A+), beta_e_half (A), power."""
    step = axis_matrices(speed)
    x = np.zeros(6)
    positions = np.empty(periods)
    rho, error_before = 0.0, 0.0
    for k in range(periods):
        positions[k] = x[3]
        count = 0.001 if encoder else 0.000625
        seen = math.floor((x[3] if encoder else x[4]) / count + 0.5) * count
        error = target - seen
        e = error / 190
        if law == "power":
            rho = -math.copysign(min(1.0, 0.929 * abs(e) ** 0.618), e) if e else 0.0
        else:
            ec = (error - error_before) * (0.1 / PERIOD) / 25.87 if k else 0.0
            alpha_e = abs(e) ** 0.9 + 1e-4 if k else 1.0
            alpha_ec = abs(ec) ** 0.9 + 1e-4 if k else 1.0
            out = all_rules(e / alpha_e, ec / alpha_ec)
            if law == "vud":
                rho = (abs(rho) ** 0.9 + 1e-4 if k else 1.0) * out
            else:
                gain, power = (1.5, 0.6) if law == "beta_e" else (1.0, 0.5)
                rho = gain * (abs(e) ** power + 1e-4 if k else 1.0) * out
        error_before = error
        x[5] = min(1.0, max(-1.0, rho))
        x = step @ x
    return positions


def settled(positions, target, band):
    """Time of the first sample from which the error stays within ``band``."""
    outside = np.flatnonzero(np.abs(positions - target) > band)
    return (outside[-1] + 1) * PERIOD if len(outside) else 0.0
