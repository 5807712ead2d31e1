"""Friction that a controller learns while it runs: LuGre without Stribeck's fall, its numbers found from each period.

With the share ``w`` of the bristles' full bend (-1 to 1), the bend ``g = F_C / sigma_0`` and a travel ``x`` one way:

    w(x) = side + (w_0 - side) exp(-abs(x) / g)                         LuGre's bristles without Stribeck's fall, exact
    F    = F_C w + sigma_1 g dw/dt + sigma_2 v + load

1. Learned are ``F_C, g, sigma_1, sigma_2`` and a constant ``load``; they start at the believed model, Table 2's hat.
2. Each period the friction that was there, ``T - J y''``, is compared with what the model says of the *measured*
   motion, both as the mean over two periods, because the second difference of the angle is. The difference ``r``
   corrects the numbers by recursive least squares, with the slopes ``s = dF / d(number)`` taken on the *commanded*
   motion, which has no noise:  ``k = P s / (R + s' P s),  numbers += k r,  P += -k (P s)' + forget (P_0 - P)``
3. ``R = torque_noise^2 + (speed_noise D)^2``, ``D = sigma_1 (1 - side w)``: while the bristles still damp, a digit of
   the encoder is many N m; where they let go, none
4. ``abs(r)`` is cut at three times its expected size. The numbers are kept between the shares :data:`LEAST` and
   :data:`MOST` of the believed ones, so the feed-forward is a LuGre model whatever the stage does
5. ``forget`` counts only while the commanded bristles turn over: a long feed forgets nothing

Least squares with forgetting towards a prior: L. Ljung, *System Identification*, 2nd ed. (1999), chapter 11; adaptive
LuGre compensation: C. Canudas de Wit, P. Lischinsky, Int. J. Adaptive Control and Signal Processing 11 (1997) 65. The
form here, with bend and share, commanded slopes and measured residuals, is ours.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import Doc, Unit

COUNT = 5
"""Numbers that are learned: F_C, g, sigma_1, sigma_2, load."""
LEAST = np.array([0.6, 0.6, 0.1, 0.0, -0.5])
"""Smallest share of what is believed; of the load, of the believed F_C."""
MOST = np.array([1.5, 6.0, 1.5, 2.0, 0.5])
"""Largest share."""
SPREAD = np.array([0.16, 0.64, 0.32, 0.42, 0.05])
"""How far off the believed numbers may be at the start (one standard deviation), as the same shares."""
FAR = 40.0
"""Travel, in bends, behind which nothing of the old share is left."""


class LearnedPlan(NamedTuple):
    """What :func:`learn` needs, prepared."""

    torque_noise: float
    speed_noise: float
    forget: float
    believed: np.ndarray
    """What the shares are of: F_C, g, sigma_1, sigma_2, F_C."""


class Bristles(NamedTuple):
    """Mean torque over a period and the bristles at its end."""

    torque: Annotated[float, Unit("N m")]
    damping: Annotated[float, Unit("N m"), Doc("the part of sigma_1")]
    share: float
    bent: Annotated[float, Unit("1/rad"), Doc("d share / d g")]


def believed(hat):
    """What the shares are of."""
    return np.array([hat.coulomb, hat.coulomb / hat.stiffness, hat.damping, hat.viscous, hat.coulomb])


def at_start(hat):
    """The five numbers before anything is learned."""
    return believed(hat) * np.array([1.0, 1.0, 1.0, 1.0, 0.0])


def spread_at_start(hat):
    """P_0, the square of :data:`SPREAD` on the diagonal."""
    return np.diag((believed(hat) * SPREAD) ** 2)


def foreseen(known, slope, share, bent, v, a, pieces, dt):
    """Friction over the coming period on the commanded motion; writes ``dF / d(number)`` into ``slope``."""
    h = dt / pieces
    g = known[1]
    w = share
    d = bent
    mean_w = 0.0
    mean_d = 0.0
    for k in range(pieces):
        now = v + a * h * (k + 0.5)
        side = 1.0 if now > 0.0 else -1.0
        x = min(abs(now) * h / g, FAR)
        kept = math.exp(-x)
        next_w = side + (w - side) * kept
        next_d = d * kept + (w - side) * kept * x / g
        mean_w = mean_w + 0.5 * (w + next_w) / pieces
        mean_d = mean_d + 0.5 * (d + next_d) / pieces
        w = next_w
        d = next_d if abs(next_d) > 1e-30 else 0.0
    turned = (w - share) / dt
    speed = v + 0.5 * a * dt
    slope[0] = mean_w
    slope[1] = known[0] * mean_d + known[2] * (turned + g * (d - bent) / dt)
    slope[2] = g * turned
    slope[3] = speed
    slope[4] = 1.0
    damping = known[2] * g * turned
    return Bristles(known[0] * mean_w + damping + known[3] * speed + known[4], damping, w, d)


def seen(known, share, moved, dt):
    """Friction that the model says of the period in which the stage was measured to move by ``moved``."""
    side = 1.0 if moved > 0.0 else -1.0
    w = side + (share - side) * math.exp(-min(abs(moved) / known[1], FAR))
    damping = known[2] * known[1] * (w - share) / dt
    return Bristles(known[0] * 0.5 * (w + share) + damping + known[3] * moved / dt + known[4], damping, w, 0.0)


def learn(p, known, spread, gain, slope, slope_before, difference, damping, turning):
    """Corrects ``known`` and ``spread`` in place by one period; ``gain`` becomes ``P s``. Returns ``r`` as counted."""
    noise = p.speed_noise * damping
    total = p.torque_noise * p.torque_noise + noise * noise
    for i in range(5):
        along = 0.0
        for j in range(5):
            along = along + spread[i, j] * 0.5 * (slope[j] + slope_before[j])
        gain[i] = along
        total = total + along * 0.5 * (slope[i] + slope_before[i])
    most = 3.0 * math.sqrt(total)
    r = min(max(difference, -most), most)
    back = p.forget * turning
    for i in range(5):
        off = p.believed[i] * SPREAD[i]
        moved = known[i] + gain[i] * r / total
        known[i] = min(max(moved, LEAST[i] * p.believed[i]), MOST[i] * p.believed[i])
        for j in range(5):
            less = spread[i, j] - gain[i] * gain[j] / total
            spread[i, j] = less + back * ((off * off if i == j else 0.0) - less)
    return r
