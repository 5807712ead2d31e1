"""Learning from piece to piece: the next table of offsets of a tangential axis, of what the last cut showed.

    command form     u_(j+1)(k) = Q [ (1 - L) u_j(k) + L (d_j(k) - e_j(k + lead) / g) ]
    textbook form    u_(j+1)(k) = Q [ u_j(k) - L e_j(k + lead) ]

``u`` (deg) is the table of a piece (:func:`~leadscrew.controllers.taught_offset`), ``d`` (deg)
the offset that was sent in it, with the part of a feedback controller, ``e`` (deg) the deviation of the cut line from
the drawn one, ``g`` the believed gain from offset to deviation. ``lead`` is what lies between the two, in samples: the
lag of the axis, and the delay of the sensor if ``e`` is its reading (2 + 4 in the study), the lag alone if the piece
was measured afterwards. ``Q`` is the Gaussian of :func:`~leadscrew.controllers._trial_learning.smoothed`, of ``width``
samples.

With the delay made up for and ``e = g d + c``, ``c`` what the material does, ``d - e / g`` is ``-c / g``: the offset
that was needed, whatever was sent. So the command form learns the same from a piece with feedback as from one without,
and with ``L`` near 1 it is nearly done after one piece. The textbook form is the same without feedback, where ``d`` is
``u`` (and its ``L`` is the other's times the gain). With feedback it waits for what the feedback left over.

**Ends.** An open path has nothing behind its last sample: the last ``lead`` places take the last target that is known,
and the Gaussian is of the places that exist, its weights made to sum to one again. ``closed=True`` is a path cut lap
behind lap, where the last place is followed by the first.

Measured pieces have no sampling period: :func:`next_offsets_along` takes the arc length instead, with any spacing.

Errors: DataError for rows that do not fit together or are not finite; ValueRefused for a setting out of range.

Source: iterative learning control with a zero-phase filter and a lead, D. A. Bristow, M. Tharayil, A. G. Alleyne,
*A survey of iterative learning control*, IEEE Control Systems Magazine 26 (2006) 96. The paper of the study
``sofnn_tangent`` does not learn from piece to piece.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leadscrew.controllers._trial_learning import REACH, smoothed
from leadscrew.util.errors import DataError, ValueRefused

FINE = 4.0
"""Points of the even grid in one standard deviation of the Gaussian along the path."""
MOST_POINTS = 2_000_000
"""Of that grid."""


def next_offsets(
    u: Any,
    d: Any,
    e: Any,
    gain: float = 0.8,
    lead: int = 6,
    width: float = 1.5,
    plant_gain: float = 0.9,
    closed: bool = False,
) -> np.ndarray:
    """The command form: the next table (deg) of the table, the offsets sent and the deviations, sample by sample.

    Arrays of one shape; the last axis is the samples, those before it are pieces side by side.
    """
    u, d, e = rows(u=u, d=d, e=e)
    settings(u.shape[-1], gain, lead, width)
    between("plant_gain", plant_gain, 0.01, 100.0)
    target = d - ahead(e, lead, closed) / plant_gain
    if not closed and lead:
        target[..., -lead:] = target[..., -lead - 1, None]
    return gaussian((1.0 - gain) * u + gain * target, width, closed)


def next_offsets_textbook(
    u: Any, e: Any, gain: float = 0.8, lead: int = 6, width: float = 1.5, closed: bool = False
) -> np.ndarray:
    """The textbook form: the next table (deg) of the table and the deviations, sample by sample."""
    u, e = rows(u=u, e=e)
    settings(u.shape[-1], gain, lead, width)
    return gaussian(u - gain * ahead(e, lead, closed), width, closed)


def next_offsets_along(
    travel: Any,
    u: Any,
    d: Any,
    measured_travel: Any,
    e: Any,
    gain: float = 0.8,
    lead_mm: float = 1.0,
    width_mm: float = 0.75,
    plant_gain: float = 0.9,
    length_mm: float | None = None,
) -> np.ndarray:
    """The command form along the path: the next offsets (deg) at the places ``travel`` (mm, ascending).

    ``u`` and ``d`` belong to ``travel``, ``e`` to ``measured_travel``; the two may differ in number and spacing, and
    neither has to be even. Between places the straight line, outside the measured ones the nearest. ``lead_mm`` is how
    far behind its command the axis acts: its lag times the feed (0.02 s at 50 mm/s: 1 mm). ``length_mm`` is the length
    of a closed path; None: the path is open.
    """
    s, u, d = places(travel=travel, u=u, d=d)
    seen, e = places(measured_travel=measured_travel, e=e)
    between("gain", gain, 0.0, 2.0)
    between("plant_gain", plant_gain, 0.01, 100.0)
    least, most = (s[0], s[-1]) if length_mm is None else (0.0, float(length_mm))
    if not most > least or s[0] < least or s[-1] > most + 1e-9 * most:
        raise ValueRefused(f"length_mm = {length_mm} (next_offsets_along): expected {s[-1]:g} mm or more")
    between("lead_mm", lead_mm, 0.0, most - least)
    between("width_mm", width_mm, 0.0, most - least)
    if length_mm is None:
        found = np.interp(s + lead_mm, seen, e)
        last = int(np.searchsorted(s, s[-1] - lead_mm, side="right")) - 1
        target = d - found / plant_gain
        target[last + 1 :] = target[max(last, 0)]
    else:
        target = d - np.interp(s + lead_mm, seen, e, period=most) / plant_gain
    raw = (1.0 - gain) * u + gain * target
    if width_mm == 0.0:
        return raw
    count = int(np.ceil(FINE * (most - least) / min(width_mm, most - least)))
    if count > MOST_POINTS:
        raise ValueRefused(f"width_mm = {width_mm} (next_offsets_along): expected 1/500000 of the path or more")
    step = (most - least) / count
    if length_mm is None:
        grid = least + step * np.arange(count + 1)
        return np.interp(s, grid, gaussian(np.interp(grid, s, raw), width_mm / step, False))
    grid = step * np.arange(count)
    return np.interp(s, grid, gaussian(np.interp(grid, s, raw, period=most), width_mm / step, True), period=most)


def ahead(e: np.ndarray, lead: int, closed: bool) -> np.ndarray:
    """``e(k + lead)``; behind the end of an open path its last value."""
    if closed:
        return np.roll(e, -lead, axis=-1)
    return np.concatenate([e[..., lead:], np.repeat(e[..., -1:], lead, axis=-1)], axis=-1)


def gaussian(values: np.ndarray, width: float, closed: bool) -> np.ndarray:
    """Every row through the Gaussian; on an open path of the places that exist."""
    flat = values.reshape(-1, values.shape[-1])
    if closed:
        return np.array([smoothed(row, width) for row in flat]).reshape(values.shape)
    reach = int(np.ceil(REACH * width))
    around = np.pad(flat, ((0, 0), (0, reach)))  # the row's two ends meet in zeros
    share = smoothed(np.pad(np.ones(flat.shape[1]), (0, reach)), width)[: flat.shape[1]]
    return np.array([smoothed(row, width)[: flat.shape[1]] / share for row in around]).reshape(values.shape)


def rows(**given: Any) -> list[np.ndarray]:
    """The arrays as floats of their own, of one shape, not empty, finite."""
    arrays = {name: np.array(value, dtype=np.float64) for name, value in given.items()}
    shapes = {a.shape for a in arrays.values()}
    if len(shapes) != 1 or not next(iter(shapes)) or 0 in next(iter(shapes)):
        said = ", ".join(f"{name} of shape {a.shape}" for name, a in arrays.items())
        raise DataError(f"{said} (piece learning): expected rows of one length")
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise DataError(f"{name} (piece learning): has values that are not finite; the piece before has diverged")
    return list(arrays.values())


def places(**given: Any) -> list[np.ndarray]:
    """One row of ascending places, and what belongs to them."""
    arrays = rows(**given)
    name, s = next(iter(given)), arrays[0]
    if s.ndim != 1 or s.size < 2 or not (np.diff(s) > 0.0).all():
        raise DataError(f"{name} of shape {s.shape} (piece learning): expected two or more ascending places in mm")
    return arrays


def between(name: str, value: float, least: float, most: float) -> None:
    """Refuses a setting outside ``least`` to ``most``."""
    if not least <= value <= most:
        raise ValueRefused(f"{name} = {value} (piece learning): expected {least:g} to {most:g}")


def settings(size: int, gain: float, lead: int, width: float) -> None:
    """Refuses what does not fit a row of ``size`` samples."""
    if lead != int(lead):
        raise ValueRefused(f"lead = {lead} (piece learning): expected a whole number of samples")
    between("gain", gain, 0.0, 2.0)
    between("lead", lead, 0, size - 1)
    between("width", width, 0.0, size)
