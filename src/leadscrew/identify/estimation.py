"""What every fit of this package says of a number: its 95 % interval, its covariance, and whether it is identifiable.

A parameter is **identifiable** where half of its 95 % interval is at most a quarter of its value,

    half <= max(0.25 |value|, negligible)

or too small to matter. A quarter of a gain is 2 dB, a third of the 6 dB that a loop should keep; and a value eight
standard errors from zero is where first-order intervals still hold. Of static friction ``value`` is what it is above
Coulomb friction. ``negligible`` is

- of a delay: one sampling period;
- of Coulomb and viscous friction and offset of an axis: what changes the force by 1 % of its root mean square;
- of the offset of a linear model: 1 % of the root mean square of the signal that it is added to;
- of a lost motion with 0 in its interval: 50 counts of the encoder;
- of every other number: 0.

Interval: ``value -+ t(0.975, degrees of freedom) standard error``, of the logarithm where that is what was fitted.
Standard errors come from the Jacobian ``J`` of the residual ``r``, columns scaled to unit length:

- :func:`white`: ``s^2 (J'J)^-1``, where residuals are independent;
- :func:`coloured`: ``(Z'J)^-1 Z'RZ (J'Z)^-1`` with the autocovariance ``R`` of an autoregression of the residual and
  instruments ``Z`` (``J`` for output error): Söderström and Stoica, *System Identification*, 1989, complement C7.5;
- :func:`clustered`: residuals of any correlation and size within clusters (windows, strokes). With ``M = (J'J)^-1``,
  the rows ``J_g, r_g`` of cluster ``g`` and ``A_g = (I - J_g M J_g')^(-1/2)``

      V = M sum_g (J_g' A_g r_g)(J_g' A_g r_g)' M        ("CR2")

  with Student's t and the degrees of freedom of Bell and McCaffrey, by parameter: few where few clusters tell it.
  R. Bell, D. McCaffrey, *Bias reduction in standard errors for linear regression with multi-stage samples*, Survey
  Methodology 28 (2002) 169; J. Pustejovsky, E. Tipton, J. Business & Economic Statistics 36 (2018) 672.

Whiteness: the share of the first 25 autocorrelations of a residual that lie within ``+- 1.96 / sqrt(n)``, about 95 %
for white noise (G. Box, G. Jenkins, *Time Series Analysis*, 1970).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

CONFIDENCE = 0.95
SHARE = 0.25
"""Half of the interval of an identifiable parameter over its value, at most."""
LITTLE = 0.01
"""Of the root mean square of the force (or of a signal): what a parameter may change of it and still not matter."""
LAGS = 25
"""Of an autocorrelation, or of a cross-correlation with the input."""
PAIRS = 10
"""Pairs of samples that an autocorrelation is taken of at least."""
WEAK = 1e-12
"""Share of the largest singular value below which a direction counts as this flat: its variance is huge, not none."""
LEVERAGE = 1e-3
"""A cluster's own weight in its fit is taken to be at most one less this."""
ORDERS = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
"""Of the autoregression of a residual."""
NAN = math.nan

How = Literal["fitted", "fixed", "given"]
"""Fitted to the log; fixed at a value that says nothing (the log does not determine it); given by the caller."""


class Interval(NamedTuple):
    """What follows from a fit, with its 95 % interval."""

    value: float
    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Whether a value lies inside."""
        return self.low <= value <= self.high


class Parameter(NamedTuple):
    """A number of a model, with its 95 % interval."""

    value: float
    unit: str
    low: float
    """Lower end of the 95 % interval; NaN where ``how`` is not fitted."""
    high: float
    how: How = "fitted"
    identifiable: bool = True
    """Whether the log determines it, by the rule above; what is given counts as known."""
    note: str = ""
    """Why it is fixed, or what limits it."""

    @property
    def interval(self) -> Interval:
        """The value between the ends of its interval."""
        return Interval(self.value, self.low, self.high)

    @property
    def half(self) -> float:
        """Half of the interval."""
        return 0.5 * (self.high - self.low)

    @property
    def percent(self) -> float:
        """Half of the interval as a share of the value, in percent."""
        return abs(50.0 * (self.high - self.low) / self.value) if self.value else math.inf


def identifiable(value: float, half: float, negligible: float = 0.0) -> bool:
    """Whether an interval of half the width ``half`` determines ``value``; NaN and infinite ones do not."""
    return bool(math.isfinite(half) and half <= max(SHARE * abs(value), negligible))


def fitted(
    value: float, ends: tuple[float, float], unit: str = "", *, counted: float | None = None, negligible: float = 0.0,
    note: str = "",
) -> Parameter:  # fmt: skip
    """A fitted parameter, judged by the rule; ``counted``: the size that counts, where it is not the value."""
    low, high = ends
    size = value if counted is None else counted
    known = identifiable(size, 0.5 * (high - low), negligible)
    return Parameter(float(value), unit, float(low), float(high), "fitted", known, note)


def fixed(value: float, unit: str, note: str) -> Parameter:
    """A parameter that the log does not determine."""
    return Parameter(value, unit, NAN, NAN, "fixed", False, note)


def given(value: float, unit: str) -> Parameter:
    """A parameter that the caller knows."""
    return Parameter(value, unit, NAN, NAN, "given")


def quantile(degrees: float = math.inf) -> float:
    """Standard errors to each side of a 95 % interval."""
    from scipy.special import ndtri, stdtrit

    at = 0.5 + 0.5 * CONFIDENCE
    return float(ndtri(at) if math.isinf(degrees) else stdtrit(degrees, at))


def correlations(covariance: np.ndarray, keys: Sequence[str]) -> dict[str, dict[str, float]]:
    """Of each parameter with each, by key."""
    spread = np.sqrt(np.diag(covariance))
    safe = np.where(spread > 0.0, spread, 1.0)
    table = covariance / np.outer(safe, safe)
    return {a: {b: float(table[i, j]) for j, b in enumerate(keys)} for i, a in enumerate(keys)}


class Spread(NamedTuple):
    """How far to trust the values of a fit."""

    covariance: np.ndarray
    degrees: np.ndarray
    """Of freedom of Student's t, by parameter."""
    condition: float
    """Largest over smallest singular value of the Jacobian, columns scaled to the same length."""


def condition(jacobian: np.ndarray) -> float:
    """Largest over smallest singular value, columns without effect left out and the others at unit length."""
    size = np.linalg.norm(jacobian, axis=0)
    unit = jacobian[:, size > 0.0] / size[size > 0.0]
    values = np.linalg.svd(np.linalg.qr(unit)[1], compute_uv=False)
    return float(values[0] / values[-1]) if len(values) and values[-1] > 0.0 else math.inf


def inverse(jacobian: np.ndarray) -> tuple[np.ndarray, float]:
    """``(J'J)^-1`` and the condition number; a direction without effect has a huge variance."""
    size = np.linalg.norm(jacobian, axis=0)
    safe = np.where(size > 0.0, size, 1.0)
    if not len(size):
        return np.zeros((0, 0)), 1.0
    _, s, v = np.linalg.svd(jacobian / safe, full_matrices=False)
    usable = np.maximum(s, WEAK * s[0])
    found = (v.T / usable**2) @ v / np.outer(safe, safe)
    return found, float(s[0] / s[-1]) if s[-1] > 0.0 else math.inf


def white(jacobian: np.ndarray, residual: np.ndarray) -> Spread:
    """Covariance where the residuals are independent and of one size."""
    spare = max(1, len(residual) - jacobian.shape[1])
    middle, ratio = inverse(jacobian)
    return Spread(middle * float(residual @ residual) / spare, np.full(jacobian.shape[1], float(spare)), ratio)


def clustered(jacobian: np.ndarray, residual: np.ndarray, cluster: np.ndarray) -> Spread:
    """CR2 covariance, infinite for fewer than two clusters; ``cluster``: number of the cluster of each row, in runs."""
    middle, ratio = inverse(jacobian)
    values, vectors = np.linalg.eigh(middle)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    edges = np.flatnonzero(np.diff(cluster)) + 1
    scores, sizes, crosses = [], [], []
    for rows, r in zip(np.split(jacobian, edges), np.split(residual, edges), strict=True):
        u, s, _ = np.linalg.svd(rows @ root, full_matrices=False)
        gain = 1.0 / np.sqrt(np.maximum(1.0 - s * s, LEVERAGE)) - 1.0
        scores.append(rows.T @ (r + u @ (gain * (u.T @ r))))
        own = rows @ middle
        own = own + u @ (gain[:, None] * (u.T @ own))
        sizes.append(np.sum(own * own, axis=0))
        crosses.append(rows.T @ own)
    if len(scores) < 2:
        return Spread(np.full_like(middle, np.inf), np.ones(len(middle)), ratio)
    score = np.array(scores)
    covariance = middle @ (score.T @ score) @ middle
    return Spread(covariance, _degrees(np.array(sizes), np.array(crosses), middle), ratio)


def _degrees(sizes: np.ndarray, crosses: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Bell and McCaffrey's, for white residuals."""
    found = []
    for i in range(sizes.shape[1]):
        b = crosses[:, :, i]
        gram = np.diag(sizes[:, i]) - b @ middle @ b.T
        found.append(float(np.trace(gram)) ** 2 / max(float(np.sum(gram * gram)), 1e-300))
    return np.maximum(np.array(found), 1.0)


def coloured(jacobian: np.ndarray, residual: np.ndarray, instruments: np.ndarray | None = None) -> np.ndarray:
    """Covariance of all columns of ``jacobian``, at consecutive samples, under noise of any colour."""
    z = jacobian if instruments is None else instruments
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    j, z = jacobian / scale, z / scale
    spare = max(1, len(residual) - j.shape[1])
    a, variance = autoregression(residual * np.sqrt(len(residual) / spare))
    size = 1 << int(2 * len(residual) - 1).bit_length()
    spectrum = variance / np.abs(np.fft.rfft(a, size)) ** 2
    basis = np.linalg.qr(z)[0]
    seen = np.fft.rfft(basis, size, axis=0)
    weight = np.full(len(spectrum), 2.0)
    weight[0] = weight[-1] = 1.0
    middle = (seen.conj().T @ (seen * (weight * spectrum)[:, None])).real / size
    left, values, right = np.linalg.svd(basis.T @ j)
    bread = (right.T / np.maximum(values, WEAK * values[0])) @ left.T
    return np.asarray(bread @ middle @ bread.T / np.outer(scale, scale))


def autoregression(residual: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients ``1, a_1, ...`` and variance of the driving noise, by Yule and Walker, order by BIC."""
    from scipy.linalg import solve_toeplitz

    n = len(residual)
    r = _autocovariance(residual, min(ORDERS[-1], n // 10))
    best = (np.inf, np.array([1.0]), float(r[0]))
    for order in ORDERS:
        if order >= len(r) or r[0] <= 0.0:
            break
        firm = r[:order] * (1.0 + 1e-9 * (np.arange(order) == 0))
        a = -solve_toeplitz(firm, r[1 : order + 1]) if order else np.array([])
        left = float(r[0] + a @ r[1 : order + 1])
        if left <= 0.0:
            break
        score = n * np.log(left) + order * np.log(n)
        if score < best[0]:
            best = (score, np.concatenate([[1.0], a]), left)
    return best[1], best[2]


def _autocovariance(values: np.ndarray, lags: int) -> np.ndarray:
    """About zero, biased (divided by the number of samples), for 0 to ``lags``."""
    n = len(values)
    size = 1 << int(2 * n - 1).bit_length()
    power = np.abs(np.fft.rfft(values, size)) ** 2
    return np.asarray(np.fft.irfft(power, size)[: lags + 1] / n)


class Whiteness(NamedTuple):
    """Of a residual."""

    percent: float
    """Autocorrelations within the 95 % bounds of white noise; NaN where too few samples are there for any;
    100 where nothing is left."""
    autocorrelation: np.ndarray
    """From lag 1 on; NaN where too few pairs are there."""


def whiteness(residual: np.ndarray, lags: int = LAGS) -> Whiteness:
    """Whether a residual is noise, by its first ``lags`` autocorrelations; NaN marks samples that are left out."""
    known = np.isfinite(residual)
    r = np.where(known, residual - np.mean(residual[known]), 0.0) if known.any() else np.zeros(0)
    power = float(np.mean(r[known] ** 2)) if known.any() else 0.0
    found, bounds = np.full((2, min(lags, len(r) // 4)), NAN)
    if known.sum() < PAIRS or not power > 0.0:
        return Whiteness(NAN if known.sum() < PAIRS else 100.0, np.nan_to_num(found))
    for k in range(1, len(found) + 1):
        pairs = int(np.sum(known[k:] & known[:-k]))
        if pairs >= PAIRS:
            found[k - 1] = float(r[k:] @ r[:-k]) / pairs / power
            bounds[k - 1] = quantile() / math.sqrt(pairs)
    there = np.isfinite(found)
    return Whiteness(100.0 * float(np.mean(np.abs(found[there]) <= bounds[there])) if there.any() else NAN, found)
