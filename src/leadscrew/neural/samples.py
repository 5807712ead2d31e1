"""Training of the inference network before it is used: fuzzy reasoning samples, and one Kalman pass over them.

"Fuzzy reasoning samples" are what a Mamdani system with the same rules says (minimum, minimum, maximum, centroid) at
the 13 x 13 whole levels of E and EC: 169 samples of a level D. The network is linear in its consequents, so one pass of
a Kalman filter without random walk ends at the least-squares solution (but for the prior variance), and more passes
find nothing. What is left over is the difference between Mamdani's inference and interpolation.

Step (2) of the training in the paper of the study sofnn_tangent, Y. Deng, X. Liu, L. Wu, Q. Zhang, which gives neither
the rules nor the samples.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from leadscrew.fuzzy.build import mamdani, triangles
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.system import Input, Output, System
from leadscrew.neural.inference_net import CENTRES, LABELS, RULES, SETS, initial_rules, regressors
from leadscrew.util.errors import DataError, ValueRefused

LEVELS = np.arange(-6.0, 7.0)
"""The 13 whole levels."""
UNIVERSE = 241
"""Points from -6 to 6 over which the centroid is taken."""
R = 0.01
"""Variance of a sample, levels squared."""
P0 = 100.0
"""Variance of a consequent before training, levels squared."""


class Samples(NamedTuple):
    """What the network is trained on; levels, one entry a sample."""

    e: np.ndarray
    ec: np.ndarray
    d: np.ndarray


class Trained(NamedTuple):
    """Consequents after training."""

    weights: np.ndarray
    """49 levels, number 7 EC + E."""
    covariance: np.ndarray
    """49 x 49, levels squared."""
    rmse: float
    """Over the samples, levels."""
    least: float
    """The same for the least-squares solution: nothing linear in the consequents is better."""


def rules_given(rules) -> np.ndarray:
    """Rules as 7 x 7 whole sets, -3 (NB) to 3 (PB).

    Raises:
        ValueRefused: another shape, or a consequent that is no peak of the seven sets.
    """
    table = np.asarray(initial_rules() if rules is None else rules, dtype=float)
    if table.shape != (SETS, SETS):
        raise ValueRefused(f"rules of shape {table.shape}: expected {SETS} rows (EC) of {SETS} (E)")
    sets = np.rint(table / 2.0)
    if not (np.isfinite(table).all() and (sets * 2.0 == table).all() and (np.abs(sets) <= 3).all()):
        raise ValueRefused("rules: every consequent has to be one of -6, -4, -2, 0, 2, 4, 6 levels, a set's peak")
    return sets.astype(np.int64)


def reasoning_system(rules=None) -> System:
    """The Mamdani system whose answers are the samples; inputs ``EC`` and ``E``, output ``D``, levels.

    ``rules``: 7 x 7 levels, rows EC from NB, columns E from NB; :func:`initial_rules` unless given. The output's
    universe has 241 cells whose centres are the points -6, -5.95 .. 6.

    Raises:
        ValueRefused: rules of another shape, or a consequent that is no set's peak.
    """
    sets = rules_given(rules)
    names = " ".join(LABELS)
    terms = triangles(names, -6.0, 6.0)
    half = 6.0 / (UNIVERSE - 1)
    lines = [names, *(f"{LABELS[j]} {' '.join(LABELS[k + 3] for k in sets[j])}" for j in range(SETS))]
    inputs = [Input(name, -6.0, 6.0, terms) for name in ("EC", "E")]
    output = Output("D", -6.0 - half, 6.0 + half, terms, resolution=UNIVERSE)
    return mamdani("reasoning", inputs, output, "\n".join(lines), integration="midpoint")


def reasoning_samples(rules=None) -> Samples:
    """The 169 fuzzy reasoning samples of ``rules``, EC the slow one.

    Raises:
        ValueRefused: see :func:`reasoning_system`.
    """
    ec, e = (x.ravel() for x in np.meshgrid(LEVELS, LEVELS, indexing="ij"))
    sets = tuple(tuple(row) for row in rules_given(rules).tolist())
    return Samples(e, ec, _answers(sets).copy())


@lru_cache(maxsize=8)
def _answers(sets: tuple[tuple[int, ...], ...]) -> np.ndarray:
    """What the system with these rules says at the 169 levels; it takes longer to compile than to ask."""
    ec, e = (x.ravel() for x in np.meshgrid(LEVELS, LEVELS, indexing="ij"))
    return np.asarray(compiled(reasoning_system(2.0 * np.array(sets))).many(EC=ec, E=e))


def checked(samples: Samples) -> Samples:
    """The samples as arrays.

    Raises:
        DataError: none, arrays of different lengths, or a value that is not finite.
    """
    e, ec, d = (np.asarray(x, dtype=float).ravel() for x in samples)
    if not (e.size and e.size == ec.size == d.size):
        raise DataError(
            f"samples: {e.size} of E, {ec.size} of EC, {d.size} of D; expected as many of each, one or more"
        )
    for name, x in (("E", e), ("EC", ec), ("D", d)):
        if not np.isfinite(x).all():
            raise DataError(f"samples: {name}[{int(np.argmin(np.isfinite(x)))}] is not finite")
    return Samples(e, ec, d)


def train_rules(samples: Samples, r: float = R, p0: float = P0, start=None, passes: int = 1) -> Trained:
    """The consequents after ``passes`` passes of a Kalman filter over the samples, in their order.

    ``r`` and ``p0`` (levels squared): variance of a sample, and of each consequent before; ``start``: the consequents
    before, zeros unless given. A further pass starts from the covariance that the last one left.

    Raises:
        DataError: no samples, arrays of different lengths, a value that is not finite.
        ValueRefused: ``r``, ``p0`` or ``passes`` not above zero.
    """
    from leadscrew.neural.kalman_dense import updated

    for name, value in (("r", r), ("p0", p0), ("passes", passes)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueRefused(f"{name} = {value!r} (train_rules): expected a number above 0")
    given = checked(samples)
    h = regressors(given.e, given.ec)
    weights = np.zeros(RULES) if start is None else np.array(start, dtype=float).ravel()
    covariance = p0 * np.eye(RULES)
    for _ in range(passes):
        for row, d in zip(h, given.d, strict=True):
            gain, covariance = updated(covariance, row, r, "joseph")
            weights = weights + gain * (d - row @ weights)
    best = np.linalg.lstsq(h, given.d, rcond=None)[0]
    return Trained(weights, covariance, rms(h @ weights - given.d), rms(h @ best - given.d))


def rms(x) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(x))))


def trained_start(rules=None) -> Trained:
    """Consequents trained on the reasoning samples of ``rules``: those of :data:`W0` for the initial ones."""
    return train_rules(reasoning_samples(rules))


def copied_rmse(rules=None) -> float:
    """RMS difference of the network with untrained consequents from the Mamdani system, over the samples, levels."""
    table = initial_rules() if rules is None else np.asarray(rules, dtype=float)
    samples = reasoning_samples(table)
    return rms(regressors(samples.e, samples.ec) @ table.ravel() - samples.d)


__all__ = ["CENTRES", "Samples", "Trained", "copied_rmse", "reasoning_samples", "reasoning_system", "train_rules",
           "trained_start"]  # fmt: skip
