"""The inference network with certainties and centres beside its consequents, and one extended Kalman update of all.

    a_k = c_k mu_i(E) nu_j(EC)        D = sum a_k w_k / sum a_k

Parameters in order: 49 consequents w (levels), 49 certainties c, the 5 inner centres of E and of EC (levels). Of the
108 derivatives twelve are not zero. The covariance is kept as its lower triangle, row after row, element ``(n, m)`` at
``n (n + 1) / 2 + m``: 46 KiB, where both triangles would not fit into LinuxCNC's HAL.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from leadscrew.neural.centres import Slope, centre_slope, put_in_order
from leadscrew.neural.inference_net import Fired

SIZE = 108
TRIANGLE = SIZE * (SIZE + 1) // 2
LEAST, LARGEST = 0.1, 10.0
"""Between these a certainty stays."""


class Said(NamedTuple):
    """Output of the network and what it is made of."""

    level: float = 0.0
    fired: Fired = Fired()
    total: float = 1.0
    """Sum of the firing strengths times their certainties."""
    slope: Slope = Slope()
    """Derivatives by the centres on both sides."""


def interval_of(centres, x):
    """Number of the interval between seven centres that holds ``x``, from 0; for a step."""
    index = 0
    for i in range(1, 6):
        index = index + (1 if x >= centres[i] else 0)
    return index


def said_by(weights, certainties, centres_e, centres_ec, e, ec):
    """Output of the network at the levels ``(e, ec)``, each held inside its universe; for a step."""
    x = min(max(e, centres_e[0]), centres_e[6])
    y = min(max(ec, centres_ec[0]), centres_ec[6])
    i = interval_of(centres_e, x)
    j = interval_of(centres_ec, y)
    width_e = centres_e[i + 1] - centres_e[i]
    width_ec = centres_ec[j + 1] - centres_ec[j]
    mu = (x - centres_e[i]) / width_e
    nu = (y - centres_ec[j]) / width_ec
    k = 7 * j + i
    c0, c1, c2, c3 = certainties[k], certainties[k + 1], certainties[k + 7], certainties[k + 8]
    w0, w1, w2, w3 = weights[k], weights[k + 1], weights[k + 7], weights[k + 8]
    total = (1.0 - nu) * ((1.0 - mu) * c0 + mu * c1) + nu * ((1.0 - mu) * c2 + mu * c3)
    level = ((1.0 - nu) * ((1.0 - mu) * c0 * w0 + mu * c1 * w1) + nu * ((1.0 - mu) * c2 * w2 + mu * c3 * w3)) / total
    by_mu = (
        (1.0 - nu) * (c1 * (w1 - level) - c0 * (w0 - level)) + nu * (c3 * (w3 - level) - c2 * (w2 - level))
    ) / total
    by_nu = (
        (1.0 - mu) * (c2 * (w2 - level) - c0 * (w0 - level)) + mu * (c3 * (w3 - level) - c1 * (w1 - level))
    ) / total
    at = Fired(i, j, mu, nu)
    return Said(level, at, total, centre_slope(at, by_mu, by_nu, width_e, width_ec))


def learn_all(p, weights, certainties, centres_e, centres_ec, covariance, past, innovation):
    """One extended Kalman update of all parameters, in place; for a step. Gives the innovation's variance.

    ``p`` has ``r``, the walks ``q``, ``q_certainty`` and ``q_centre`` of the groups, ``cap``, ``clamp``, ``gap`` and
    ``forgetting``. A group whose walk is 0 and whose variances are 0 does not move.
    """
    at, i, j = past.fired, past.fired.i, past.fired.j
    place = np.zeros(12)
    h = np.zeros(12)
    for m in range(4):
        k = 7 * j + i + (m if m < 2 else m + 5)
        fires = ((1.0 - at.nu) if m < 2 else at.nu) * (at.mu if m == 1 or m == 3 else 1.0 - at.mu)
        place[m] = k
        h[m] = certainties[k] * fires / past.total
        place[4 + m] = 49 + k
        h[4 + m] = fires * (weights[k] - past.level) / past.total
    place[8] = 97 + max(i, 1)
    place[9] = 98 + min(i, 4)
    place[10] = 102 + max(j, 1)
    place[11] = 103 + min(j, 4)
    h[8] = past.slope.e_lower
    h[9] = past.slope.e_upper
    h[10] = past.slope.ec_lower
    h[11] = past.slope.ec_upper
    gain = np.zeros(108)
    scale = np.zeros(108)
    grown = 1.0 / p.forgetting
    for m in range(12):
        row = int(place[m])
        first = row * (row + 1) // 2
        part = h[m] * grown
        for n in range(row):
            gain[n] = gain[n] + part * covariance[first + n]
        for n in range(row, 108):
            gain[n] = gain[n] + part * covariance[n * (n + 1) // 2 + row]
    s = p.r
    for m in range(12):
        s = s + h[m] * gain[int(place[m])]
    s = max(s, p.r)
    move = innovation / s
    for n in range(49):
        weights[n] = min(max(weights[n] + move * gain[n], -p.clamp), p.clamp)
        certainties[n] = min(max(certainties[n] + move * gain[49 + n], LEAST), LARGEST)
    for n in range(5):
        centres_e[n + 1] = centres_e[n + 1] + move * gain[98 + n]
        centres_ec[n + 1] = centres_ec[n + 1] + move * gain[103 + n]
    put_in_order(centres_e, p.gap)
    put_in_order(centres_ec, p.gap)
    root = 1.0 / math.sqrt(s)
    for n in range(108):
        q = p.q if n < 49 else p.q_certainty if n < 98 else p.q_centre
        g = gain[n] * root
        diagonal = n * (n + 3) // 2
        variance = covariance[diagonal] * grown - g * g + q
        c = math.sqrt(p.cap / variance) if variance > p.cap else 1.0
        gain[n] = g * c
        scale[n] = c
        covariance[diagonal] = covariance[diagonal] + q * p.forgetting
    for n in range(108):
        first = n * (n + 1) // 2
        for m in range(n + 1):
            after = covariance[first + m] * grown * (scale[n] * scale[m]) - gain[n] * gain[m]
            covariance[first + m] = after if abs(after) > 1e-30 else 0.0
    return s


def triangle_of(covariance) -> np.ndarray:
    """A full covariance (108 x 108) as its lower triangle."""
    return np.asarray(covariance, dtype=float)[np.tril_indices(SIZE)]


def full_covariance(triangle) -> np.ndarray:
    """The full covariance (108 x 108) of a lower triangle."""
    full = np.zeros((SIZE, SIZE))
    full[np.tril_indices(SIZE)] = triangle
    return full + np.tril(full, -1).T
