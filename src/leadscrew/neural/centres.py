"""The inference network with centres that learn too: 49 consequents and the five inner centres of each input.

    x = (49 consequents, 5 inner centres of E, 5 of EC)        innovation = target - D(x)
    extended Kalman filter: h = dD/dx, then as for the consequents alone

The outer centres stay at -6 and 6. After each step the inner ones are put in order again, at least ``GAP`` apart, so
that the seven sets always cover the universe and always sum to one. At a centre ``D`` has a kink; the slope to its
right is taken there.

Membership parameters ``v_ji`` of the paper of the study sofnn_tangent, Y. Deng, X. Liu, L. Wu, Q. Zhang, in our
reading.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.fuzzy.inference import Axis
from leadscrew.neural.inference_net import CENTRES, RULES, SETS, Fired, fired, network_output, regressors
from leadscrew.neural.samples import P0, R, Samples, checked, rms
from leadscrew.util.errors import ValueRefused

GAP = 0.4
"""Least distance of two neighbouring centres, levels."""
P0_CENTRES = 0.01
"""Variance of a centre before training, levels squared."""
INNER = SETS - 2
PARAMETERS = RULES + 2 * INNER


class Slope(NamedTuple):
    """Derivatives of the output by the centres on both sides of the point; 0 where that centre is an outer one."""

    e_lower: float = 0.0
    e_upper: float = 0.0
    ec_lower: float = 0.0
    ec_upper: float = 0.0


def centre_slope(fired, by_mu, by_nu, width_e, width_ec):
    """Derivatives of an output by the four centres that it depends on, from those by the two memberships; for a step.

    With mu = (x - c_i) / w, w = c_(i+1) - c_i:   dmu/dc_i = (mu - 1) / w,   dmu/dc_(i+1) = -mu / w.
    """
    e = by_mu / width_e
    ec = by_nu / width_ec
    return Slope(
        e * (fired.mu - 1.0) if fired.i > 0 else 0.0,
        -e * fired.mu if fired.i < 5 else 0.0,
        ec * (fired.nu - 1.0) if fired.j > 0 else 0.0,
        -ec * fired.nu if fired.j < 5 else 0.0,
    )


def put_in_order(centres, gap):
    """Moves the five inner ones of seven centres so that neighbours are ``gap`` apart or more, in place; for a step.

    From the left each is brought above the one before it and held below where the rest still fits. Where the centres
    are far enough apart nothing moves.
    """
    for i in range(1, 6):
        centres[i] = min(max(centres[i], centres[i - 1] + gap), centres[6] - (6 - i) * gap)
    return gap


class TrainedCentres(NamedTuple):
    """Consequents and centres after training."""

    weights: np.ndarray
    centres_e: np.ndarray
    centres_ec: np.ndarray
    rmse: float
    """Over the samples, levels."""


def train_centres(
    samples: Samples,
    passes: int = 10,
    r: float = R,
    p0: float = P0,
    p0_centres: float = P0_CENTRES,
    gap: float = GAP,
) -> TrainedCentres:
    """Consequents and centres after ``passes`` passes of an extended Kalman filter over the samples, in their order.

    ``p0`` and ``p0_centres`` are the variances of a consequent and of a centre before the first pass (levels squared);
    the covariance is carried from pass to pass. It starts from consequents of 0 and even centres.

    Raises:
        DataError: no samples, arrays of different lengths, a value that is not finite.
        ValueRefused: a number not above zero, or a gap of more than 2 levels, for which there is no room.
    """
    from leadscrew.neural.kalman_dense import regressor

    for name, value in (("r", r), ("p0", p0), ("p0_centres", p0_centres), ("passes", passes), ("gap", gap)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueRefused(f"{name} = {value!r} (train_centres): expected a number above 0")
    if gap > 2.0:
        raise ValueRefused(f"gap = {gap!r} (train_centres): expected 2 levels at most, six gaps fill -6 to 6")
    given = checked(samples)
    weights, first, second = np.zeros(RULES), CENTRES.copy(), CENTRES.copy()
    p = np.diag(np.concatenate([np.full(RULES, p0), np.full(2 * INNER, p0_centres)]))
    for _ in range(passes):
        for e, ec, d in zip(*given, strict=True):
            where = fired(_axis(first), _axis(second), e, ec)
            h = np.concatenate([regressor(where), _by_centres(weights, first, second, where)])
            ph = p @ h
            move = ph * ((d - network_output(weights, where)) / (h @ ph + r))
            p = p - np.outer(ph, ph) / (h @ ph + r)
            weights = weights + move[:RULES]
            first[1:-1] += move[RULES : RULES + INNER]
            second[1:-1] += move[RULES + INNER :]
            put_in_order(first, gap)
            put_in_order(second, gap)
    found = regressors(given.e, given.ec, first, second) @ weights
    return TrainedCentres(weights, first, second, rms(found - given.d))


def best_centres(samples: Samples, gap: float = GAP) -> TrainedCentres:
    """The least-squares optimum of consequents and centres together, near even centres: what training can reach.

    For given centres the consequents are a linear problem; SciPy's trust region searches the ten centres.

    Raises:
        DataError: no samples, arrays of different lengths, a value that is not finite.
    """
    from scipy.optimize import least_squares

    given = checked(samples)

    def solved(inner: np.ndarray) -> TrainedCentres:
        first, second = (np.concatenate([[-6.0], part, [6.0]]) for part in np.split(inner, 2))
        put_in_order(first, gap)
        put_in_order(second, gap)
        h = regressors(given.e, given.ec, first, second)
        weights = np.linalg.lstsq(h, given.d, rcond=None)[0]
        return TrainedCentres(weights, first, second, rms(h @ weights - given.d))

    def left(inner: np.ndarray) -> np.ndarray:
        one = solved(inner)
        return np.asarray(regressors(given.e, given.ec, one.centres_e, one.centres_ec) @ one.weights - given.d)

    start = np.tile(CENTRES[1:-1], 2)
    off = np.array([0.1, -0.1, 0.1, -0.1, 0.1])  # off the kinks at whole levels, to both sides
    found = [solved(start)] + [
        solved(least_squares(left, start + np.concatenate([a * off, b * off]), diff_step=1e-4, max_nfev=25).x)
        for a in (-1.0, 1.0)
        for b in (-1.0, 1.0)
    ]
    return min(found, key=lambda one: one.rmse)


def _axis(centres: np.ndarray) -> Axis:
    """The partition with centres that are known to be in order."""
    return Axis(centres, 1.0 / np.diff(centres))


def _by_centres(weights: np.ndarray, first: np.ndarray, second: np.ndarray, at: Fired) -> np.ndarray:
    """Derivatives of the output by the ten inner centres."""
    k = 7 * at.j + at.i
    by_mu = (1.0 - at.nu) * (weights[k + 1] - weights[k]) + at.nu * (weights[k + 8] - weights[k + 7])
    by_nu = (1.0 - at.mu) * (weights[k + 7] - weights[k]) + at.mu * (weights[k + 8] - weights[k + 1])
    steep = centre_slope(at, by_mu, by_nu, first[at.i + 1] - first[at.i], second[at.j + 1] - second[at.j])
    e, ec = np.zeros(SETS), np.zeros(SETS)
    e[at.i : at.i + 2] = steep.e_lower, steep.e_upper
    ec[at.j : at.j + 2] = steep.ec_lower, steep.ec_upper
    return np.concatenate([e[1:-1], ec[1:-1]])


__all__ = ["GAP", "TrainedCentres", "best_centres", "centre_slope", "put_in_order", "train_centres"]
