"""The next piece: what the last one's cut line says about the offsets of the tangential axis, and a program with them.

    d_(j+1)(s) = Q [ (1 - L) d_j(s) + L (d_j(s) - e_j(s + lead) / g) ],      held to +-15 deg

is the command form of :mod:`leadscrew.tangent.piece_learning` along the arc length. ``d_j`` are the offsets with which
piece ``j`` was cut: what its program says. ``lead`` is the lag of the axis times the feed. There is no sensor and no
control: the machine needs an axis that turns, and the piece a scanner.

**Prediction.** With a process ``e = g d + c`` that the believed gain describes, the next piece has
``e_(j+1)(s) = e_j(s) + g (d_(j+1) - d_j)(s - lead)``. What does not come again, as the texture of a material, is
learned as if it did: a piece is predicted better than it will be.

Source: ours; the paper of the study ``sofnn_tangent`` has no such workflow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from leadscrew.kernel import validate
from leadscrew.paths.curve import Array
from leadscrew.tangent.deviation import Deviation, deviation_of, errors_along
from leadscrew.tangent.matching import SPAN_MM, Placing, matched
from leadscrew.tangent.measurement import Trace
from leadscrew.tangent.settings import MOST_OFFSET_DEG, Settings
from leadscrew.tangent.stroke import Stroke, Table
from leadscrew.util.errors import ValueRefused

STEP_MM = 0.5
"""Step of the table of offsets."""
RANGES = (("learning", 0.05, 1.5), ("gain", 0.1, 10.0), ("axis_lag_s", 0.0, 1.0), ("width_mm", 0.0, 50.0))
"""Allowed values."""


class Learning(NamedTuple):
    """How the next offsets are learned."""

    learning: float = 1.0
    """L: 1 believes the last piece alone, less keeps some of the table before."""
    gain: float = 0.9
    """g: what the cut turns by when the axis is offset, believed."""
    axis_lag_s: float = 0.02
    """Lag of the tangential axis."""
    width_mm: float = 0.75
    """Standard deviation of the Gaussian Q along the path."""
    cutoff_mm: float | None = None
    """Waves of the scan shorter than this are noise; None: from its noise."""
    limit_deg: float = MOST_OFFSET_DEG
    """Largest offset."""


class Learned(NamedTuple):
    """A stroke, and what was learned of its cut."""

    number: int
    stroke: Stroke
    """With its new table."""
    seen: Deviation
    travel: Array
    """mm"""
    before: Array
    """Error of the piece, deg."""
    predicted: Array
    """Of the next."""
    old: Array
    """Offsets of the piece, deg."""
    new: Array
    clipped_mm: float
    """Length along which the offset is held to its limit."""


class Compensation(NamedTuple):
    """All strokes of the next piece."""

    strokes: list[Stroke]
    learned: list[Learned]
    placing: Placing
    notes: list[str]

    def rms(self, predicted: bool = False) -> float:
        """Of the error over the strokes that were measured, deg; before, or as predicted."""
        power = length = 0.0
        for k in self.learned:
            e = k.predicted if predicted else k.before
            power += float(np.trapezoid(e**2, k.travel))
            length += float(k.travel[-1])
        return math.sqrt(power / length)

    @property
    def largest(self) -> float:
        """Offset, deg, of either sign."""
        return max(float(np.abs(k.new).max()) for k in self.learned)


def compensated(
    strokes: Sequence[Stroke],
    settings: Settings,
    traces: Sequence[Trace],
    learning: Learning = Learning(),  # noqa: B008
    align: str = "none",
    marks: Sequence[tuple[float, float, float, float]] = (),
    progress: Callable[[float], None] = lambda done: None,
) -> Compensation:
    """The strokes of the next piece.

    Raises:
        DataError: a measured line that is not that of these strokes; see :mod:`leadscrew.tangent.matching`.
        ValueRefused: a setting out of range.
    """
    _checked(learning)
    span = SPAN_MM if learning.cutoff_mm is None else learning.cutoff_mm / 40.0
    matching = matched(strokes, traces, align, marks, min(span, 5.0 * SPAN_MM))
    notes = list(matching.notes)
    after = list(strokes)
    found = []
    for k, m in enumerate(matching.found):
        progress(k / len(matching.found))
        stroke = strokes[m.number - 1]
        if m.trace.points:
            seen = deviation_of(stroke, m.x, m.y, learning.cutoff_mm, m.trace.where)
            seen = seen._replace(noise=seen.noise * math.sqrt(m.each), spacing=seen.spacing / m.each)
        else:
            seen = errors_along(stroke, m.trace.travel, m.trace.error, m.trace.where)
        learned = _learned(m.number, stroke, settings, seen, learning)
        found.append(learned)
        after[m.number - 1] = learned.stroke
    told = {t.stroke for t in traces} | {m.number for m in matching.found}
    missing = sorted(set(range(1, len(strokes) + 1)) - told)
    if missing:
        said = ", ".join(str(k) for k in missing[:8]) + (", ..." if len(missing) > 8 else "")
        notes.append(f"not measured, kept as they were: stroke {said}")
    if align == "shape":
        notes.append(
            "aligned by its shape: an angle by which the whole cut is off cannot be separated from how the piece lay, "
            "and is not compensated; two marks (--mark) determine it"
        )
    done = Compensation(after, found, matching.placing, notes)
    clipped = sum(k.clipped_mm for k in found)
    if clipped:
        notes.append(f"the offset is held to {learning.limit_deg:g} deg along {clipped:.1f} mm")
    return done


def _checked(learning: Learning) -> None:
    for name, low, high in RANGES:
        value = validate.number(name, getattr(learning, name), "")
        if not low <= value <= high:
            raise ValueRefused(f"{name} = {value:g}: allowed range is {low:g} to {high:g}")
    if learning.cutoff_mm is not None and not 0.5 <= learning.cutoff_mm <= 200.0:
        raise ValueRefused(f"cutoff = {learning.cutoff_mm:g}: allowed range is 0.5 to 200 mm")
    if not 0.0 < learning.limit_deg <= 45.0:
        raise ValueRefused(f"limit = {learning.limit_deg:g}: allowed range is above 0 to 45 deg")


def _learned(number: int, stroke: Stroke, settings: Settings, seen: Deviation, how: Learning) -> Learned:
    from leadscrew.tangent.piece_learning import next_offsets_along

    s = stroke.grid(STEP_MM)
    old = stroke.offset(s)
    feed = settings.feed if stroke.feeds is None else float(np.median(stroke.feeds.value))
    lead = min(how.axis_lag_s * feed / 60.0, 0.5 * stroke.length)
    raw = next_offsets_along(
        s, old, old, seen.travel, seen.error, gain=how.learning, lead_mm=lead,
        width_mm=min(how.width_mm, 0.25 * stroke.length), plant_gain=how.gain,
    )  # fmt: skip
    new = np.clip(raw, -how.limit_deg, how.limit_deg)
    before = np.interp(s, seen.travel, seen.error)
    predicted = before + how.gain * np.interp(s - lead, s, new - old)
    held = float(np.mean(np.abs(raw) > how.limit_deg)) * stroke.length
    table = Table(s, new)
    return Learned(number, replace(stroke, table=table), seen, s, before, predicted, old, new, held)
