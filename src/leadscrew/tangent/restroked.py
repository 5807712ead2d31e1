"""Moves of a program that was read as a stroke: lines and arcs put together, headings and offsets from its words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from leadscrew.kernel.errors import DataError
from leadscrew.paths.curve import Curve
from leadscrew.paths.path import Path, wrapped
from leadscrew.paths.segments import Arc, Line
from leadscrew.tangent.interpreter import Step
from leadscrew.tangent.runs import Run
from leadscrew.tangent.settings import Settings
from leadscrew.tangent.stroke import NO_OFFSETS, Stroke, Table, Words

SAME_CENTRE_MM = 5e-4
"""Centres of two arcs, this close, are one; so are points this close to a line on it: rounding of the words."""
CLOSED_MM = 2e-4
"""A stroke that ends this close to its start is closed, where its heading goes on as well."""
TOLD_MM = 0.05
"""A shorter move does not tell its direction."""
FAR_DEG = 45.0
"""A tangential word further from its move than this is not one."""


def stroke_of(cut: Run, settings: Settings, name: str, ours: bool) -> Stroke:
    """The stroke that was cut; the words of a program that is not ``ours`` must follow its moves.

    Raises:
        DataError: they do not.
    """
    run = cut.steps
    moving = [s for s in run if s.flat > 0.0]
    segments = _merged(moving)
    lengths = np.array([s.flat for s in moving])
    # Where the words stand, turns on the spot included.
    ways = np.concatenate(([0.0], np.cumsum([s.flat for s in run])))
    angles = [settings.angle(run[0].words[0]), *(settings.angle(s.words[1]) for s in run)]
    offsets = np.array([cut.offset, *_offsets(cut)])
    headings = np.array(angles) - offsets
    _check(run, headings, name, FAR_DEG + (0.5 * settings.corner_angle if ours else 0.0))
    path_length = sum(s.length for s in segments)
    scale = path_length / ways[-1]
    places = ways * scale
    words = _ascending(places, headings, settings.blend)
    closed = math.dist(segments[0].start, segments[-1].end) <= CLOSED_MM and (
        abs(wrapped(float(headings[-1] - headings[0]))) < settings.corner_angle
    )
    path = Path(segments, closed, f"line {run[0].line}", 0.06)
    table = Table(places, offsets) if offsets.any() else NO_OFFSETS
    if table is not NO_OFFSETS:
        keep = np.append(np.diff(places) > 0.0, True)
        table = Table(places[keep], offsets[keep])
    ends = np.concatenate(([0.0], np.cumsum(lengths))) * scale
    feeds = np.array([s.feed for s in moving])
    return Stroke(
        path, path.length, (), words, table, run[0].line, depth=run[0].start[2],
        feeds=Words(ends, np.append(feeds, feeds[-1])),
    )  # fmt: skip


def _offsets(cut: Run) -> list[float]:
    """Offsets at the end of each move; a line that says none has that of the line before."""
    found, last = [], cut.offset
    for step in cut.steps:
        last = last if step.offset is None else step.offset
        found.append(last)
    return found


def _merged(steps: Sequence[Step]) -> list[Curve]:
    """Lines and arcs, parts of one and the same put together."""
    found: list[Curve] = []
    inner: list[tuple[float, float]] = []
    for step in steps:
        curve = step.curve
        assert curve is not None
        last = found[-1] if found else None
        if isinstance(curve, Line) and isinstance(last, Line):
            points = [*inner, last.last]
            if _on_line(last.first, curve.last, points):
                found[-1], inner = Line(last.first, curve.last), points
                continue
        if (
            isinstance(curve, Arc)
            and isinstance(last, Arc)
            and math.dist(last.centre, curve.centre) <= SAME_CENTRE_MM
            and (last.sweep > 0.0) == (curve.sweep > 0.0)
        ):
            found[-1] = replace(last, sweep=last.sweep + curve.sweep)
            continue
        inner = []
        found.append(curve)
    return found


def _on_line(a: tuple[float, float], b: tuple[float, float], points: list[tuple[float, float]]) -> bool:
    """Whether points lie on the way from ``a`` to ``b``, in order."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    size = math.hypot(dx, dy)
    if size == 0.0:
        return False
    before = 0.0
    for x, y in points:
        along = ((x - a[0]) * dx + (y - a[1]) * dy) / size
        across = ((y - a[1]) * dx - (x - a[0]) * dy) / size
        if abs(across) > SAME_CENTRE_MM or not before < along < size:
            return False
        before = along
    return True


def _ascending(places: np.ndarray, headings: np.ndarray, length: float) -> Words:
    """Headings at places each behind the other: a turn on the spot is spread over the way before it."""
    s, h = [float(places[0])], [float(headings[0])]
    for place, heading in zip(places[1:].tolist(), headings[1:].tolist(), strict=True):
        if place > s[-1]:
            s.append(place)
            h.append(heading)
            continue
        if len(s) == 1:
            h[0] = heading
            continue
        s[-1] -= min(length, 0.5 * (s[-1] - s[-2]))
        s.append(place)
        h.append(heading)
    return Words(np.array(s), np.array(h))


def _check(run: list[Step], headings: np.ndarray, name: str, limit: float) -> None:
    """The blade points where it goes: in the middle of each move, at its ends, and by how much it turns."""
    off, ends = [], []
    # A shorter move is a rest between others; its direction is in the last decimals.
    least = TOLD_MM if any(s.flat >= TOLD_MM for s in run) else 0.0
    for k, step in enumerate(run):
        if step.curve is None or step.flat < least:
            continue
        first, last = step.curve.headings
        a, b = float(headings[k]), float(headings[k + 1])
        off.append((wrapped(0.5 * (a + b) - 0.5 * (first + last)), step.line))
        missed = (wrapped(a - first), wrapped(b - last))
        ends.append((max(missed, key=abs), step.line))
        turn, bend = b - a, last - first
        if abs(turn - bend) > 2.0 * limit and max(abs(v) for v in missed) <= limit:
            raise DataError(
                f"{name}, line {step.line}: the blade turns by {turn:.0f} deg in a move that turns by {bend:.0f} deg; "
                "words must run on beyond 360 (those of an axis that begins again at 0, WRAPPED_ROTARY, do not)"
            )
    worst, line = max(off, key=lambda v: abs(v[0]))
    if abs(worst) <= limit:
        worst, line = max(ends, key=lambda v: abs(v[0]))
        if abs(worst) <= limit:
            return
    middle = float(np.median([v for v, _ in off]))
    hint = (
        f"; most are {middle:.0f} deg off: --zero {-middle:.0f} or --clockwise may be what is missing"
        if abs(middle) > FAR_DEG
        else ""
    )
    raise DataError(
        f"{name}, line {line}: the blade stands at {worst:.0f} deg to its move; a tangential word is the heading "
        f"of the move, to {FAR_DEG:g} deg{hint}"
    )
