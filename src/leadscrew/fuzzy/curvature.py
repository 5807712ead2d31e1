"""How strongly a function bends along each input, estimated from scattered samples of it.

    K_i = percentile over the samples of abs(d2f / dx_i2),    x_i scaled so that its universe is [-1, 1]

in units of the output. Two estimates, by least squares:

``polynomial``
    one polynomial of total degree ``degree`` (2 is the full quadratic) in Legendre products for all samples; right if
    the function is one, or nearly;
``local``
    around each of up to ``points`` samples a full quadratic of those within ``bandwidth`` in every scaled input; right
    as the bandwidth goes to 0, and too low by what the curvature changes within it.

Data along a curve, such as one step response, cannot tell the inputs apart: the condition number (largest over smallest
singular value of the matrix of the fit, its columns scaled to length 1) says so, and a fit above ``most_condition`` is
refused. Random samples of two inputs give 1 to 20, Table 1 of the lathe study 45 (quadratic) to 870000 (degree 5).
Noise bends too: ``error`` says by how much.

Source: the two suprema of equations (8) and (9) of Long et al. (2014); the estimates are ours.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.polynomial import legendre

from leadscrew.util.errors import ValueRefused

Method = Literal["local", "polynomial"]
MOST_POINTS = 5000
"""About how many samples a polynomial's curvature is taken at."""
MOST_NEAR = 2000
"""About how many samples around a point a local fit takes, evenly chosen from more."""


@dataclass(frozen=True)
class Curvature:
    """Curvature along each input, and how it was found."""

    values: tuple[float, ...]
    """One an input, in units of the output, for universes scaled to [-1, 1]."""
    condition: float
    """Condition number of the fit; of local fits the largest that was used."""
    error: tuple[float, ...]
    """Standard error of the curvature along each input by what the fits leave, median over the points."""
    samples: int
    points: int
    """At how many samples curvature was taken."""
    asked: int
    """At how many it was tried: where a local fit has too few samples, or is badly conditioned, it is left out."""
    method: str
    degree: int
    bandwidth: float
    percentile: float

    def __str__(self) -> str:
        how = f"degree {self.degree}" if self.method == "polynomial" else f"bandwidth {self.bandwidth:g}"
        return (
            f"curvature {', '.join(f'{v:.4g} +- {e:.2g}' for v, e in zip(self.values, self.error, strict=True))} "
            f"({self.method}, {how}, percentile {self.percentile:g} over {self.points} of {self.asked} points, "
            f"condition number {self.condition:.3g})"
        )

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)


def estimate_curvature(
    points: Any,
    values: Any,
    universes: Sequence[tuple[float, float]],
    *,
    method: Method = "local",
    degree: int = 3,
    bandwidth: float = 0.3,
    percentile: float = 99.0,
    at_most: int = 300,
    most_condition: float = 30.0,
) -> Curvature:
    """Curvature from ``points`` (one row a sample, one column an input) and the ``values`` of the output there.

    Samples outside a universe are left out. ``bandwidth`` is a half width in scaled units (the universe is 2 wide).

    Raises:
        ValueRefused: options out of range, arrays that do not fit, too few samples, or data that cannot tell the inputs
            apart (condition number); one sentence.
    """
    _check(method, degree, bandwidth, percentile)
    x, y = _scaled(points, values, universes)
    if method == "polynomial":
        bends, condition, error = _polynomial(x, y, degree, most_condition)
        asked = len(bends)
    else:
        chosen = np.unique(np.linspace(0, len(x) - 1, min(at_most, len(x))).round().astype(int))
        asked = len(chosen)
        bends, condition, error = _local(x, y, x[chosen], bandwidth, most_condition)
    found = np.percentile(np.abs(bends), percentile, axis=0)
    return Curvature(
        tuple(found.tolist()), condition, tuple(np.median(error, axis=0).tolist()), len(x), len(bends), asked, method,
        degree if method == "polynomial" else 2, bandwidth, percentile,
    )  # fmt: skip


def _check(method: str, degree: int, bandwidth: float, percentile: float) -> None:
    if method not in ("local", "polynomial"):
        raise ValueRefused(f"method = {method!r}: allowed are local, polynomial")
    if not 2 <= degree <= 9:
        raise ValueRefused(f"degree = {degree}: allowed are 2 to 9")
    if not 0.0 < bandwidth <= 2.0:
        raise ValueRefused(f"bandwidth = {bandwidth}: allowed is above 0 to 2, the width of a scaled universe")
    if not 0.0 < percentile <= 100.0:
        raise ValueRefused(f"percentile = {percentile}: allowed is above 0 to 100")


def _scaled(points: Any, values: Any, universes: Sequence[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    x, y = np.asarray(points, dtype=float), np.asarray(values, dtype=float)
    if x.ndim != 2 or x.shape[1] != len(universes) or y.shape != x.shape[:1]:
        raise ValueRefused(f"points of shape {x.shape} and values of shape {y.shape} for {len(universes)} inputs")
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueRefused("curvature needs finite samples")
    low, high = (np.array(side, dtype=float) for side in zip(*universes, strict=True))
    scaled = (2.0 * x - (low + high)) / (high - low)
    inside = (np.abs(scaled) <= 1.0 + 1e-12).all(axis=1)
    return scaled[inside], y[inside]


def _polynomial(x: np.ndarray, y: np.ndarray, degree: int, most: float) -> tuple[np.ndarray, float, np.ndarray]:
    powers = [p for p in itertools.product(range(degree + 1), repeat=x.shape[1]) if sum(p) <= degree]
    if len(x) < 2 * len(powers):
        raise ValueRefused(
            f"{len(x)} samples for the {len(powers)} terms of a polynomial of degree {degree}: curvature needs "
            f"{2 * len(powers)} at least"
        )
    columns = [legendre.legvander(x[:, k], degree) for k in range(x.shape[1])]
    matrix = np.stack([np.prod([columns[k][:, n] for k, n in enumerate(p)], axis=0) for p in powers], axis=1)
    weights, condition, cover = _fit(matrix, y)
    if condition > most:
        raise ValueRefused(
            f"the samples do not tell the inputs' curvatures apart: condition number {condition:.3g} of a polynomial "
            f"of degree {degree}, allowed is {most:g}; log moves of several sizes, or with an added excitation"
        )
    keep = slice(None, None, max(1, len(x) // MOST_POINTS))
    x, columns = x[keep], [c[keep] for c in columns]
    second = np.zeros((x.shape[1], len(x), len(powers)))
    for k in range(x.shape[1]):
        for at, p in enumerate(powers):
            if p[k] >= 2:
                rest = np.prod([columns[j][:, n] for j, n in enumerate(p) if j != k], axis=0)
                second[k, :, at] = rest * legendre.legval(x[:, k], legendre.legder(np.eye(degree + 1)[p[k]], 2))
    return (second @ weights).T, condition, np.sqrt(np.einsum("kmi,ij,kmj->mk", second, cover, second, optimize=True))


def _local(
    x: np.ndarray, y: np.ndarray, chosen: np.ndarray, bandwidth: float, most: float
) -> tuple[np.ndarray, float, np.ndarray]:
    inputs = x.shape[1]
    pairs = list(itertools.combinations_with_replacement(range(inputs), 2))
    least = 2 * (1 + inputs + len(pairs))
    bends, conditions, errors = [], [], []
    thin = worst = 0
    for centre in chosen:
        near = np.flatnonzero((np.abs(x - centre) <= bandwidth).all(axis=1))
        near = near[:: max(1, len(near) // MOST_NEAR)]
        if len(near) < least:
            thin += 1
            continue
        d = (x[near] - centre) / bandwidth
        matrix = np.column_stack([np.ones(len(d)), d, *(d[:, i] * d[:, j] for i, j in pairs)])
        weights, condition, cover = _fit(matrix, y[near])
        if condition > most:
            worst += 1
            continue
        square = [1 + inputs + pairs.index((k, k)) for k in range(inputs)]
        bends.append(2.0 * weights[square] / bandwidth**2)
        conditions.append(condition)
        errors.append(2.0 * np.sqrt(np.diag(cover)[square]) / bandwidth**2)
    if 2 * len(bends) < len(chosen) or not bends:
        raise ValueRefused(
            f"the samples do not carry local curvatures with bandwidth {bandwidth:g}: of {len(chosen)} points {thin} "
            f"have fewer than {least} samples around them and {worst} a condition number above {most:g}; log moves of "
            "several sizes, or with an added excitation"
        )
    return np.array(bends), float(max(conditions)), np.array(errors)


def _fit(matrix: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Coefficients, condition number of the matrix with columns of length 1, covariance of the coefficients."""
    length = np.linalg.norm(matrix, axis=0)
    length[length == 0.0] = 1.0
    u, singular, v = np.linalg.svd(matrix / length, full_matrices=False)
    if singular[-1] <= 1e-13 * singular[0]:
        return np.zeros(len(length)), float("inf"), np.zeros((len(length), len(length)))
    inverse = v.T / singular / length[:, None]
    weights = inverse @ (u.T @ y)
    variance = np.sum((y - matrix @ weights) ** 2) / (len(y) - len(length))
    return weights, float(singular[0] / singular[-1]), variance * (inverse @ inverse.T)
