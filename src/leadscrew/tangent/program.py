"""A program that was cut, read back as strokes: what was programmed, and by how much the axis was offset.

A stroke is what is cut between two lifts: moves of G1, G2 and G3 that move X or Y; a G0, and a move of Z, end it. Parts
of one circle become one arc again, and parts of one line one line.

Of a program of ours the comments tell the offsets, and the rest of each word is the programmed heading: the tangent of
the drawn curve, although the program has chords. Of any other program the words themselves are taken as the heading,
without offset; they must follow the moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path as File
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.errors import DataError
from leadscrew.paths.curve import Curve
from leadscrew.paths.path import Path, wrapped
from leadscrew.paths.segments import Arc, Line
from leadscrew.tangent.interpreter import Moves, Step, read_moves
from leadscrew.tangent.settings import Settings, settings_of
from leadscrew.tangent.stroke import LEAST_MM, NO_OFFSETS, Stroke, Table, Words

SAME_CENTRE_MM = 5e-4
"""Centres of two arcs, this close, are one; so are points this close to a line on it: rounding of the words."""
CLOSED_MM = 2e-4
"""A stroke that ends this close to its start is closed, where its heading goes on as well."""
FAR_DEG = 45.0
"""A tangential word further from its move than this is not one."""


@dataclass(frozen=True)
class Program:
    """A program, read back."""

    name: str
    settings: Settings
    strokes: list[Stroke]
    ours: bool
    passed: list[str]
    """Words that were passed over: a program written anew would not have them."""
    notes: list[str]


def read_program(file: File, zero: float = 0.0, clockwise: bool = False) -> Program:
    """The strokes of a program; ``zero`` and ``clockwise`` are about programs that are not ours.

    Raises:
        DataError: what cannot be read; no tangential words; words that do not follow the moves.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as problem:
        raise DataError(f"{file}: cannot be read ({problem.strerror or problem})") from None
    except UnicodeDecodeError as problem:
        raise DataError(f"{file}: is not UTF-8 text (byte {problem.start})") from None
    return program_of(text, str(file), zero, clockwise)


def program_of(text: str, name: str = "program", zero: float = 0.0, clockwise: bool = False) -> Program:
    """As :func:`read_program`, of its text."""
    own = settings_of(text, name)
    moves = read_moves(text, name)
    runs = _runs(moves.steps)
    if not runs:
        raise DataError(f"{name}: no G1, G2 or G3 moves X or Y, so nothing is cut")
    if not moves.axis:
        raise DataError(
            f"{name}: has no words of a tangential axis, A or C; leadscrew tangent gcode puts them into a drawing "
            "or a plain G-code program"
        )
    settings = own if own is not None else _settings(moves.steps, runs, moves, zero, clockwise)
    if settings.axis != moves.axis:
        raise DataError(f"{name}: its comments say axis {settings.axis}, its words are of {moves.axis}")
    strokes = [_stroke(run, settings, name) for run in runs]
    kept = [s for s in strokes if s.length >= LEAST_MM]
    if not kept:
        raise DataError(f"{name}: no stroke is {LEAST_MM:g} mm long or longer")
    notes = [] if own is not None else [f"{name}: not of leadscrew tangent; its words are taken as headings, no offset"]
    return Program(name, settings, kept, own is not None, moves.passed, notes)


class Run(NamedTuple):
    """Moves that cut, from plunge to lift."""

    steps: list[Step]
    offset: float
    """Of the axis at the plunge, deg, as a comment says."""


def _runs(steps: Sequence[Step]) -> list[Run]:
    found: list[Run] = []
    cutting, offset = False, 0.0
    for step in steps:
        if step.code == 0 or step.start[2] != step.end[2]:
            cutting = False
        elif step.flat > 0.0 and not cutting:
            found.append(Run([], offset))
            cutting = True
        if cutting:
            found[-1].steps.append(step)
        offset = offset if step.offset is None else step.offset
    return found


def _settings(steps: Sequence[Step], runs: list[Run], moves: Moves, zero: float, clockwise: bool) -> Settings:
    """What a program of others tells of the machine."""
    depth = runs[0].steps[0].start[2]
    lift = max(s.end[2] for s in steps)
    plain = Settings()
    return Settings(
        feed=max(s.feed for run in runs for s in run.steps),
        axis=moves.axis,
        zero=zero,
        clockwise=clockwise,
        depth=depth,
        lift=lift if lift > depth else depth + plain.lift,
        inverse_time=moves.inverse_time,
        inch=moves.inch,
    )


def _stroke(cut: Run, settings: Settings, name: str) -> Stroke:
    run = cut.steps
    moving = [s for s in run if s.flat > 0.0]
    segments = _merged(moving)
    lengths = np.array([s.flat for s in moving])
    # Where the words stand, turns on the spot included.
    ways = np.concatenate(([0.0], np.cumsum([s.flat for s in run])))
    angles = [settings.angle(run[0].words[0]), *(settings.angle(s.words[1]) for s in run)]
    offsets = np.array([cut.offset, *_offsets(cut)])
    _check(run, angles, offsets, name)
    headings = np.array(angles) - offsets
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
        start, end = step.start[:2], step.end[:2]
        last = found[-1] if found else None
        if step.centre is not None:
            if (
                isinstance(last, Arc)
                and math.dist(last.centre, step.centre) <= SAME_CENTRE_MM
                and (last.sweep > 0.0) == (step.code == 3)
            ):
                found[-1] = replace(last, sweep=last.sweep + step.sweep)
                continue
            x, y = start[0] - step.centre[0], start[1] - step.centre[1]
            found.append(Arc(step.centre, math.hypot(x, y), math.atan2(y, x), step.sweep))
            continue
        if isinstance(last, Line):
            points = [*inner, last.last]
            if _on_line(last.first, end, points):
                found[-1], inner = Line(last.first, end), points
                continue
        inner = []
        found.append(Line(start, end))
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


def _check(run: list[Step], angles: Sequence[float], offsets: np.ndarray, name: str) -> None:
    """The blade points where it goes."""
    off = []
    for k, step in enumerate(run):
        if step.flat == 0.0:
            continue
        if step.centre is None:
            middle = math.degrees(math.atan2(step.end[1] - step.start[1], step.end[0] - step.start[0]))
        else:
            x, y = step.start[0] - step.centre[0], step.start[1] - step.centre[1]
            middle = math.degrees(math.atan2(y, x) + 0.5 * step.sweep + math.copysign(0.5 * math.pi, step.sweep))
        mean = 0.5 * (angles[k] - offsets[k] + angles[k + 1] - offsets[k + 1])
        off.append((wrapped(mean - middle), step.line))
    worst, line = max(off, key=lambda v: abs(v[0]))
    if abs(worst) > FAR_DEG:
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
