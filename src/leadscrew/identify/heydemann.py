"""Heydemann's correction: the ellipse through a logged pair of signals, and the map that makes it a circle.

P. L. M. Heydemann, "Determination and correction of quadrature fringe measurement errors in interferometers", Applied
Optics 20 (1981) 3382. Samples ``(u, v)`` of a reader with offsets, unequal amplitudes and a phase error lie on

    A u^2 + B v^2 + C u v + D u + E v = 1

whose five constants are the least-squares solution over the samples. From them, with ``u = a + R_u sin(phi)`` and
``v = b + R_v cos(phi + d)``:

    2 A a + C b = -D,   C a + 2 B b = -E,   sin(d) = C / (2 sqrt(A B)),   K = 1 + A a^2 + B b^2 + C a b,
    R_u^2 = K / (A cos^2 d),   R_v^2 = K / (B cos^2 d)

and back ``sin(phi) = (u - a) / R_u``, ``cos(phi) = ((v - b) / R_v + sin(d) sin(phi)) / cos(d)``. A third harmonic ``h``
looks to the fit like amplitudes that differ by ``2 h``: the correction doubles its error instead of removing it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from leadscrew.sensors.grating._quadrature import Floats
from leadscrew.util.errors import DataError

LARGEST_GAP_DEG = 120.0
"""Samples must leave no larger arc of the ellipse empty: our limit, a third of a turn."""
LARGEST_SCATTER = 0.2
"""Samples must lie this near to the ellipse, as root mean square over its radius: our limit."""
LARGEST_CONDITION = 1e6
"""Of the least-squares problem in scaled signals: beyond it the samples lie on a line, or on fewer than five points."""


class EllipseFit(NamedTuple):
    """The ellipse of a pair of signals; offsets and amplitudes in the unit of the samples."""

    offset_u: float
    offset_v: float
    amplitude_u: float
    amplitude_v: float
    phase: float
    """How far v is ahead of 90 degrees before u, rad."""
    scatter: float
    """Root mean square distance of the corrected samples from the unit circle."""
    condition: float
    """Condition number of the least-squares problem in scaled signals."""

    def corrected(self, u: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        """The samples on the unit circle: ``(sin(phi), cos(phi))`` up to noise and harmonics."""
        sine = (np.asarray(u, dtype=np.float64) - self.offset_u) / self.amplitude_u
        across = (np.asarray(v, dtype=np.float64) - self.offset_v) / self.amplitude_v
        return sine, (across + math.sin(self.phase) * sine) / math.cos(self.phase)

    def parameters(self) -> dict[str, float]:
        """The correction for a sensor: ``grating_ruler(**fit.parameters())``; offsets in amplitudes of u."""
        return {
            "correct_offset_u": self.offset_u / self.amplitude_u,
            "correct_offset_v": self.offset_v / self.amplitude_u,
            "correct_gain": self.amplitude_v / self.amplitude_u - 1.0,
            "correct_phase": self.phase,
        }


def fit_ellipse(u: ArrayLike, v: ArrayLike, where: str = "samples") -> EllipseFit:
    """The ellipse through samples of the two signals, at least five, spread over the turn.

    Raises:
        DataError: fewer than five samples, not as many of u as of v, one that is not finite, all on a line or in fewer
            than five places, on no ellipse, on an arc only, or too far from the ellipse. The text names ``where``.
    """
    u, v = np.asarray(u, dtype=np.float64).ravel(), np.asarray(v, dtype=np.float64).ravel()
    if u.shape != v.shape:
        raise DataError(f"{where}: {u.size} values of u but {v.size} of v; an ellipse needs pairs")
    if u.size < 5:
        raise DataError(f"{where}: {u.size} samples; an ellipse needs at least 5")
    if not (np.isfinite(u).all() and np.isfinite(v).all()):
        raise DataError(f"{where}: a sample is not finite; leave such samples out")
    mean_u, mean_v = float(u.mean()), float(v.mean())
    size = math.sqrt(float(np.mean((u - mean_u) ** 2 + (v - mean_v) ** 2)))
    if not size > 0.0:
        raise DataError(f"{where}: all samples are equal; move the axis by at least one pitch while logging")
    x, y = (u - mean_u) / size, (v - mean_v) / size
    rows = np.stack([x * x, y * y, x * y, x, y], axis=1)
    (a, b, c, d, e), _, _, singular = np.linalg.lstsq(rows, np.ones(u.size), rcond=None)
    condition = float(singular[0] / singular[-1]) if singular[-1] > 0.0 else math.inf
    if not condition <= LARGEST_CONDITION:
        raise DataError(
            f"{where}: the samples lie on a line or in fewer than five places (condition number {condition:.3g}, "
            f"{LARGEST_CONDITION:.0e} allowed); log both signals over at least one pitch"
        )
    det = 4.0 * a * b - c * c
    if not (a > 0.0 and b > 0.0 and det > 0.0):
        raise DataError(f"{where}: the samples do not lie on an ellipse; log both signals over at least one pitch")
    x0, y0 = (c * e - 2.0 * b * d) / det, (c * d - 2.0 * a * e) / det
    phase = math.asin(c / (2.0 * math.sqrt(a * b)))
    level = (1.0 + a * x0 * x0 + b * y0 * y0 + c * x0 * y0) / math.cos(phase) ** 2
    fit = EllipseFit(
        mean_u + size * x0, mean_v + size * y0, size * math.sqrt(level / a), size * math.sqrt(level / b), phase, 0.0,
        condition,
    )  # fmt: skip
    sine, cosine = fit.corrected(u, v)
    angles = np.sort(np.arctan2(sine, cosine))
    gap = float(np.degrees(np.diff(angles, append=angles[0] + 2.0 * np.pi).max()))
    if gap > LARGEST_GAP_DEG:
        raise DataError(
            f"{where}: the samples leave {gap:.0f} degrees of the ellipse empty, {LARGEST_GAP_DEG:.0f} are allowed; "
            "log at least one whole pitch"
        )
    scatter = float(np.sqrt(np.mean((np.hypot(sine, cosine) - 1.0) ** 2)))
    if scatter > LARGEST_SCATTER:
        raise DataError(
            f"{where}: the samples scatter by {scatter:.2g} of the ellipse's radius, {LARGEST_SCATTER:g} is allowed"
        )
    return fit._replace(scatter=scatter)


def fit_log(path: str | Path) -> EllipseFit:
    """The ellipse of a logged pair of signals: a CSV file with columns ``u`` and ``v``, others ignored.

    Raises:
        DataError: see :func:`leadscrew.logs.csv_columns.read_log` and :func:`fit_ellipse`.
    """
    from leadscrew.logs.csv_columns import read_log

    log = read_log(path, ("u", "v"))
    return fit_ellipse(log["u"], log["v"], where=str(path))
