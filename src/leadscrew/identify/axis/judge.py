"""Measured against simulated over a stretch of the log, and what inverse dynamics leaves of its force."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from leadscrew.identify.axis.filters import window
from leadscrew.identify.axis.inverse_dynamics import rows_of
from leadscrew.identify.axis.record import Record
from leadscrew.identify.axis.result import Judged
from leadscrew.identify.axis.terms import SIDES, Terms, friction_key
from leadscrew.identify.axis.whiteness import whiteness


def terms_of(values: Mapping[str, float]) -> Terms:
    """A model all of whose parameters are known, from values by key of the plant."""
    known = {"mass": values["mass"], "offset": values.get("offset", 0.0)}
    falls = []
    for side in SIDES:
        coulomb = values[friction_key(side, "coulomb")]
        static = values.get(friction_key(side, "static"), coulomb)
        known |= {
            friction_key(side, "coulomb"): coulomb,
            friction_key(side, "viscous"): values.get(friction_key(side, "viscous"), 0.0),
            friction_key(side, "excess"): static - coulomb,
        }
        falls.append(values.get(friction_key(side, "stribeck_speed"), 0.0))
    return Terms(False, (falls[0], falls[1]) if min(falls) > 0.0 else None, known)


def force_left(record: Record, values: Mapping[str, float], length: int, delay: float) -> tuple[np.ndarray, np.ndarray]:
    """What the model leaves of the force, and the force, at every sample, both under the window.

    NaN at the edges and where the axis stands or may stand; shape (n,) each.
    """
    rows = rows_of(record, terms_of(values), length, delay, step=1)
    left, force = np.full((2, len(record.position)), np.nan)
    at = rows.at[rows.used]
    left[at], force[at] = rows.force[rows.used], (rows.force + rows.known)[rows.used]
    return left, force


def judged(
    what: str,
    time: np.ndarray,
    record: Record,
    simulated: np.ndarray,
    values: Mapping[str, float],
    length: int,
    delay: float,
) -> Judged:
    """A stretch of the log against its simulation, all of the same length; ``delay`` in periods."""
    left, force = force_left(record, values, length, delay)
    known = np.isfinite(left)
    rms_left = float(np.sqrt(np.mean(left[known] ** 2))) if known.any() else float("nan")
    rms_force = float(np.sqrt(np.mean(force[known] ** 2))) if known.any() else float("nan")
    error = simulated - record.position
    rms = float(np.sqrt(np.mean(error**2)))
    return Judged(
        what=what, start_s=float(time[0]), end_s=float(time[-1]), rms=rms, worst=float(np.max(np.abs(error))),
        nrmse_percent=100.0 * rms / float(np.ptp(record.position)) if np.ptp(record.position) > 0.0 else float("nan"),
        rms_force=rms_left, force_percent=100.0 * rms_left / rms_force if rms_force > 0.0 else float("nan"),
        whiteness=whiteness(left[length // 2 :: length]), time=np.asarray(time),
        measured=np.asarray(record.position), simulated=simulated, speed=speed_of(record), force_left=left,
    )  # fmt: skip


def speed_of(record: Record) -> np.ndarray:
    """Smoothed speed at every sample, shape (n,)."""
    smooth = record.samples.smooth
    return np.concatenate([smooth[:1], smooth, smooth[-1:]])


def extent(record: Record, length: int) -> dict[str, Any]:
    """Top speed and acceleration of a record, and its travel."""
    acceleration = np.convolve(record.samples.acceleration, window(length), "valid")
    return {
        "top_speed": float(np.max(np.abs(speed_of(record)))),
        "top_acceleration": float(np.max(np.abs(acceleration))) if acceleration.size else 0.0,
        "travel": (float(np.min(record.position)), float(np.max(record.position))),
    }
