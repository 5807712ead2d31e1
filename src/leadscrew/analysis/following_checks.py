"""Whether command and actual position can be those of one axis: one signal, no jumps of its own, a possible speed."""

from __future__ import annotations

import numpy as np

from leadscrew.analysis.following_odd import Track, folded
from leadscrew.logs.finding import Finding
from leadscrew.logs.jumps import jumps
from leadscrew.logs.measure import Motion, encoder_step, noise
from leadscrew.logs.plausible import check_units
from leadscrew.logs.units import length_in

UNLIKE = 0.5
"""Standard deviation of the error over that of the command from which the two are hardly one signal."""
IN_ORDER = 20
"""Rows of a typical stretch from which jumps can be told from rows out of order."""


def looked_at(track: Track, stretch: np.ndarray, period: float) -> list[Finding]:
    """What is odd about the two positions of an axis."""
    return [*_unlike(track, period), *_jumps(track, stretch, period), *_fast(track, stretch, period)]


def _unlike(track: Track, period: float) -> list[Finding]:
    moved, error = float(np.std(track.command)), folded(track, period)
    left = float(np.std(error))
    if not moved or left <= UNLIKE * moved or left <= 3.0 * float(np.max(track.steps)):
        return []
    return [Finding(
        "unlike", "warning",
        f"{track.name}: the error varies by {left:.3g} where the command varies by {moved:.3g} (rms): command and "
        "actual are hardly one signal; look whether the right columns were named and both are in one unit",
    )]  # fmt: skip


def _jumps(track: Track, stretch: np.ndarray, period: float) -> list[Finding]:
    """Jumps of the actual position that the command does not make, within stretches."""
    if np.median(np.bincount(stretch)) < IN_ORDER:
        return []
    step = max(encoder_step(track.actual), float(np.max(track.steps)))
    found, sizes = jumps(track.actual, period, step, noise(track.actual, step))
    if not len(found):
        return []
    own = np.abs(np.diff(folded(track, period))[found - 1]) > 0.5 * np.abs(sizes)
    near = np.clip(found[:, None] + np.arange(-3, 3), 0, len(stretch) - 1)
    own &= (stretch[near] == stretch[found][:, None]).all(axis=1)
    found, sizes = found[own], sizes[own]
    if not len(found):
        return []
    k = int(np.argmax(np.abs(sizes)))
    times = "once" if len(found) == 1 else f"{len(found)} times"
    return [Finding(
        "jump", "warning",
        f"{track.name}: the actual position jumps {times} where the command does not, most by {sizes[k]:.3g}"
        f"{' ' + track.unit if track.unit else ''} at data row {int(found[k]) + 1}: an encoder that lost counts, or a "
        "bad sample; errors and lag hold these rows",
    )]  # fmt: skip


def _fast(track: Track, stretch: np.ndarray, period: float) -> list[Finding]:
    """Speeds and travels that no axis has, where the unit is known."""
    if not track.unit:
        return []
    kind, size = length_in(track.unit)
    speed = size * track.both_speeds(period, stretch)[1]
    seen = check_units(size * track.actual, Motion(speed, np.zeros(len(speed)), 0), period, kind)
    return [Finding("unit", "warning", f"{track.name}: {f.sentence}") for f in seen if f.severity == "refused"]
