"""From the measured cut line to the error of its tangent along the way.

1. **Travel.** The cut begins where the knife plunged and ends where it was lifted, and is as long as the stroke: a
   point of the cut line belongs to the arc length at which it lies on the cut line itself, both ends made to fit.
   Projecting points onto the programmed line would shift them along it wherever the cut has drifted away, and on a
   curve of radius ``r`` a shift of ``t`` is an angle ``t / r``.
2. **Smoothing.** What is smoothed is the *difference* of cut and programme, in x and y, as a function of travel: by a
   cubic smoothing spline (Reinsch; SciPy's ``make_smoothing_spline``) with the penalty ``(c / 2 pi)^4``, which halves a
   wave of length ``c``, the cut-off. The difference is flat at the ends, where a spline of the line itself would lose
   its curvature.
3. **Angle.** ``e = angle(t + D') - angle(t)``, ``t`` the programmed tangent, ``D'`` the derivative of the spline. With
   it, lengths along the cut line are known better, and 1 to 3 are done again.

**Cut-off.** Points with noise of standard deviation ``n`` at a distance ``h`` leave an angle of

    sqrt(n^2 h w^3 0.278 / pi) rad,      w = 2 pi / c

Unless given, the cut-off is where that is 0.15 deg; ``n`` is told by third differences of the points. At most 25 mm: a
longer one would lose the corners of common curves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from leadscrew.paths.curve import Array
from leadscrew.tangent.stroke import Stroke
from leadscrew.util.errors import DataError

NOISE_ANGLE_DEG = 0.15
"""Noise that the automatic cut-off leaves in the angle."""
CUTOFFS_MM = (4.0, 25.0)
"""Range of the automatic cut-off."""
SHARE = math.pi / (8.0 * math.sqrt(2.0))
"""Integral of u^2 / (1 + u^4)^2."""
FINE_MM = 0.1
"""Step of the arc lengths."""
ROUNDS = 3
STRETCH = 0.015
"""How far the length of a cut may be from that of its stroke, as a share."""
FAR_RMS_DEG, FAR_DEG = 20.0, 60.0
"""An error beyond these is no error of a cut but another line."""


class Deviation(NamedTuple):
    """The error of the tangent along a stroke."""

    travel: Array
    """mm"""
    error: Array
    """deg"""
    cutoff: float
    """Waves shorter than this, mm, are taken for noise; 0: errors were measured themselves."""
    noise: float
    """Standard deviation of the points, mm."""
    spacing: float
    """Of the points, mm."""
    length: float
    """Of the measured line, mm."""


def noise_of(across: Array) -> float:
    """Standard deviation of noise in evenly spaced distances, mm, by third differences."""
    if across.size < 8:
        return 0.0
    return float(np.median(np.abs(np.diff(across, 3)))) / 0.6745 / math.sqrt(20.0)


def cutoff_of(noise: float, spacing: float) -> float:
    """The cut-off at which such points leave :data:`NOISE_ANGLE_DEG` in the angle, mm."""
    least = max(CUTOFFS_MM[0], 3.0 * spacing)
    if noise <= 0.0:
        return least
    cubed = math.radians(NOISE_ANGLE_DEG) ** 2 * math.pi / (noise**2 * spacing * SHARE)
    return min(max(2.0 * math.pi / cubed ** (1.0 / 3.0), least), max(CUTOFFS_MM[1], least))


def deviation_of(stroke: Stroke, x: Array, y: Array, cutoff: float | None, where: str) -> Deviation:
    """The error along a stroke from points of its cut line, in order and direction of the cut, in its coordinates.

    Raises:
        DataError: points that do not cover the stroke, or are of another line.
    """
    from scipy.interpolate import CubicHermiteSpline, make_smoothing_spline

    length = stroke.length
    spacing = length / (x.size - 1)
    grid = np.linspace(0.0, length, max(math.ceil(length / FINE_MM), 40) + 1)
    line = stroke.at(grid)
    tangent = np.radians(line.heading)
    tx, ty = np.cos(tangent), np.sin(tangent)
    between = CubicHermiteSpline(grid, np.column_stack((line.x, line.y)), np.column_stack((tx, ty)))
    s, real = _first_travel(x, y, length, cutoff)
    for k in range(ROUNDS):
        dx, dy = np.array([x, y]) - between(s).T
        if k == 0:
            normal = np.interp(s, grid, tangent)
            noise = noise_of(dy * np.cos(normal) - dx * np.sin(normal))
            wave = cutoff_of(noise, spacing) if cutoff is None else cutoff
        weight = np.gradient(s)
        lam = (wave / (2.0 * math.pi)) ** 4
        slopes = [make_smoothing_spline(s, d, w=weight, lam=lam).derivative()(grid) for d in (dx, dy)]
        cx, cy = tx + slopes[0], ty + slopes[1]
        speed = np.hypot(cx, cy)
        arc = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(grid))))
        real = float(arc[-1])
        # On the measured line, arc lengths are those of the cut.
        s = _rising(np.interp(s, grid, arc) * length / real, length)
    error = np.degrees(np.arctan2(cy * tx - cx * ty, cx * tx + cy * ty))
    found = Deviation(grid, error, wave, noise, spacing, real)
    _believed(found, stroke, where)
    return found


def _first_travel(x: Array, y: Array, length: float, cutoff: float | None) -> tuple[Array, float]:
    """Arc lengths along the points, smoothed a little so that noise does not lengthen them."""
    from scipy.interpolate import make_smoothing_spline

    steps = np.hypot(np.diff(x), np.diff(y))
    q = np.concatenate(([0.0], np.cumsum(steps)))
    spacing = length / (x.size - 1)
    wave = cutoff_of(max(noise_of(x), noise_of(y)), spacing) if cutoff is None else cutoff
    lam = (min(wave, 8.0 * q[-1] / length) / (2.0 * math.pi)) ** 4
    weight = np.gradient(q)
    fx, fy = (make_smoothing_spline(q, v, w=weight, lam=lam) for v in (x, y))
    fine = np.linspace(0.0, q[-1], max(math.ceil(length / FINE_MM), 40) + 1)
    arc = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(fx(fine)), np.diff(fy(fine))))))
    return _rising(np.interp(q, fine, arc) * length / arc[-1], length), float(arc[-1])


def _rising(s: Array, length: float) -> Array:
    """Places that rise, from 0 to the length."""
    held = np.maximum.accumulate(s) + 1e-9 * np.arange(s.size)
    return np.asarray((held - held[0]) * length / (held[-1] - held[0]))


def _believed(found: Deviation, stroke: Stroke, where: str) -> None:
    off = found.length / stroke.length - 1.0
    worst = float(np.abs(found.error).max())
    mean = math.sqrt(float(np.mean(found.error**2)))
    if abs(off) > STRETCH:
        what = "does not cover the path" if off < 0.0 else "is longer than the path"
        raise DataError(
            f"{where}: {what}: it is {found.length:.1f} mm long, the path {stroke.length:.1f} mm; expected the whole "
            f"cut, from plunge to lift, to {100.0 * STRETCH:g} %"
        )
    if mean > FAR_RMS_DEG or worst > FAR_DEG:
        raise DataError(
            f"{where}: its tangent is {mean:.0f} deg off on average and {worst:.0f} deg at most: this is not the cut "
            f"of this path, or its points are not in order (expected up to {FAR_RMS_DEG:g} and {FAR_DEG:g} deg)"
        )


def errors_along(stroke: Stroke, travel: Array, error: Array, where: str) -> Deviation:
    """The error along a stroke where it was measured itself.

    Raises:
        DataError: places that do not rise or do not cover the stroke, or angles too large.
    """
    if travel.size < 2:
        raise DataError(f"{where}: {travel.size} row is too few: expected travel from 0 to {stroke.length:.1f} mm")
    if not (np.diff(travel) > 0.0).all():
        k = int(np.argmin(np.diff(travel))) + 1
        raise DataError(f"{where}: travel does not rise after its entry {k}; expected the order of the cut")
    span = float(travel[-1] - travel[0])
    if (
        travel[0] < -STRETCH * stroke.length
        or abs(travel[-1] - stroke.length) > STRETCH * stroke.length
        or (travel[0] > STRETCH * stroke.length)
    ):
        raise DataError(
            f"{where}: goes from {travel[0]:.1f} to {travel[-1]:.1f} mm and does not cover the path: expected 0 to "
            f"{stroke.length:.1f} mm, to {100.0 * STRETCH:g} %"
        )
    found = Deviation(travel, error, 0.0, 0.0, span / (travel.size - 1), stroke.length)
    _believed(found, stroke, where)
    return found
