"""A program that was cut, read back as strokes: what was programmed, and by how much the axis was offset.

A stroke is what is cut between two lifts: moves of G1, G2, G3 and G5 that move X or Y; a G0, and a move of Z, end it.
Feeds at the height of the lift position, they do not cut. Parts of one circle become one arc again, and parts of one
line one line.

Of a program of ours the comments tell the offsets, and the rest of each word is the programmed heading: the tangent of
the drawn curve, although the program has chords. Of any other program the words themselves are taken as the heading,
without offset; they must follow the moves.

What a program written anew would do otherwise than the one that was read is said: ``lost`` is why it may not be
written, ``changed`` what it has in another way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path as File
from typing import NamedTuple

import numpy as np

from leadscrew.paths.curve import Curve
from leadscrew.paths.path import Path, wrapped
from leadscrew.paths.segments import Arc, Line
from leadscrew.tangent.interpreter import Moves, Step, read_moves
from leadscrew.tangent.settings import Settings, settings_of
from leadscrew.tangent.stroke import LEAST_MM, NO_OFFSETS, Stroke, Table, Words
from leadscrew.util import reading
from leadscrew.util.errors import DataError, ValueRefused

SAME_HEIGHT_MM = 1e-6
"""Heights this close are one."""


class Run(NamedTuple):
    """Moves that cut, from plunge to lift."""

    steps: list[Step]
    offset: float
    """Of the axis at the plunge, deg, as a comment says."""
    plunge: float | None
    """Slowest feed of the way down to it, mm/min; 0: rapid; None: it does not go down."""


def runs_of(steps: Sequence[Step], name: str) -> tuple[list[Run], list[int]]:
    """What cuts, and the lines of what moves X or Y above the work otherwise than to the start of a cut."""
    lowest = min((s.end[2] for s in steps if s.code and s.flat > 0.0), default=0.0)
    top = top_of(steps)
    found: list[Run] = []
    above: list[int] = []
    cutting, offset = False, 0.0
    plunge: float | None = None
    waiting: Step | None = None
    for step in steps:
        falls = step.end[2] - step.start[2]
        if step.code and step.flat > 0.0 and abs(falls) > SAME_HEIGHT_MM:
            raise DataError(
                f"{name}, line {step.line}: X or Y moves together with Z: a ramp is not a cut at one depth; expected "
                "to plunge, then to cut"
            )
        air = lowest + SAME_HEIGHT_MM < step.end[2] >= top - SAME_HEIGHT_MM
        if falls or (step.flat > 0.0 and (step.code == 0 or air)):
            cutting = False
            if step.flat > 0.0:
                above += [] if waiting is None else [waiting.line]
                waiting = step
            if falls > 0.0:
                plunge = None
            elif falls < 0.0:
                plunge = min((v for v in (plunge, step.feed) if v), default=0.0)
        elif step.flat > 0.0 and not cutting:
            found.append(Run([], offset, plunge))
            cutting, waiting = True, None
        if cutting:
            found[-1].steps.append(step)
        offset = offset if step.offset is None else step.offset
    above += [] if waiting is None else [waiting.line]
    for run in found:
        while run.steps[-1].curve is None:
            run.steps.pop()
    return found, above


def top_of(steps: Sequence[Step]) -> float:
    """The highest place that the program brings the knife to, mm; where it is before the first, nobody knows."""
    return max((s.end[2] for s in steps if s.end[2] != s.start[2]), default=steps[0].start[2])


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


def as_it_is(own: Settings, steps: Sequence[Step], runs: Sequence[Run]) -> Settings:
    """Settings of a program of ours, after lines were edited by hand: not faster down, and not lifted less."""
    slowest = min((run.plunge for run in runs if run.plunge), default=own.plunge)
    lift = top_of(steps)
    if slowest < own.plunge - 0.15:
        own = replace(own, plunge=slowest)
    return replace(own, lift=lift) if lift > own.lift + 0.01 else own


def lost_of(moves: Moves, runs: list[Run], pricks: int) -> list[str]:
    """Why a program written anew would not be this one."""
    found = []
    depths = [run.steps[0].start[2] for run in runs]
    deepest, shallowest = min(depths), max(depths)
    if not moves.heights:
        return ["it has no Z word, and a new program would move Z"]
    if top_of(moves.steps) <= shallowest + SAME_HEIGHT_MM:
        return [f"it never lifts the knife above Z{shallowest:g}, and a new program would"]
    told = next(k for k, s in enumerate(moves.steps) if s.start[2] != s.end[2]) + 1
    for step in moves.steps[told:]:
        if not step.code and step.flat > 0.0 and min(step.start[2], step.end[2]) <= shallowest:
            found.append(f"line {step.line}: G0 moves X or Y in the depth of a cut, and a new program would lift there")
            break
    for run in runs:
        if run.plunge is None:
            found.append(f"line {run.steps[0].line}: nothing goes down to this cut, and a new program would")
            break
    spots = [(abs(s.words[1] - s.words[0]), s.line) for run in runs for s in run.steps if s.curve is None]
    if spots and max(spots)[0] > Settings.corner_angle:
        turn, line = max(spots)
        found.append(
            f"line {line}: the blade turns on the spot by {turn:.0f} deg, and a new program would turn it along the "
            f"last {Settings.blend:g} mm before"
        )
    holes = _holes(moves.steps, {run.steps[0].line for run in runs}, shallowest)
    if len(holes) > pricks:
        found.append(f"line {holes[pricks]}: the knife goes down and up without a cut, and a new program would not")
    unsaid = [p for p in moves.rounding if p is not None and not 1e-4 <= p <= 1.0]
    if unsaid or len({p for p in moves.rounding if p is not None}) > 1:
        found.append("its G64 P is not the same all through, or out of 0.0001 to 1 mm")
    if deepest < -1000.0:
        found.append(f"it cuts at Z{deepest:g}")
    return found


def _holes(steps: Sequence[Step], cuts: set[int], shallowest: float) -> list[int]:
    """Lines of what goes down, at a feed or as deep as a cut, without a cut after it."""
    found = []
    down: int | None = None
    for step in steps:
        if step.flat > 0.0 and step.line in cuts:
            down = None
        if step.end[2] < step.start[2] and (step.code or step.end[2] <= shallowest + SAME_HEIGHT_MM):
            down = step.line
        elif step.end[2] > step.start[2] and down is not None:
            found.append(down)
            down = None
    return found if down is None else [*found, down]


def slowed(runs: Sequence[Run], own: Settings) -> list[str]:
    """Feeds of a program of ours that were lowered by hand: its head, which makes the next, does not know of them."""
    for run in runs:
        for step in run.steps:
            turn = abs(step.words[1] - step.words[0])
            if step.flat < 0.1:
                continue
            wanted = min(own.feed, 60.0 * own.swivel * step.flat / turn if turn > 0.0 else math.inf)
            if step.feed < 0.9 * wanted:
                return [
                    f"line {step.line}: its feed is {step.feed:.4g} mm/min, and a new program would have that by the "
                    f"head of this one, {wanted:.4g}"
                ]
    return []


def changed_of(moves: Moves, runs: Sequence[Run], above: Sequence[int], settings: Settings) -> list[str]:
    """What a program written anew has in another way, for a note."""
    found = []
    if above:
        said = ", ".join(str(n) for n in above[:8]) + (", ..." if len(above) > 8 else "")
        found.append(
            f"moves above the work that lead to no cut are not kept (line {said}): each stroke is approached straight, "
            f"at Z{settings.lift:g} mm"
        )
    if not any(moves.rounding):
        found.append(f"has no G64 P: the new program rounds to {settings.tolerance:g} mm")
    plunges = {run.plunge for run in runs}
    if any(s.curve is None and s.words[0] != s.words[1] for run in runs for s in run.steps):
        found.append(f"turns on the spot: the new program turns along the last {settings.blend:g} mm before")
    if len(plunges) > 1:
        found.append(f"plunges at several feeds: the new program at the slowest, {settings.plunge:g} mm/min")
    elif plunges <= {None, 0.0}:
        found.append(f"plunges at the rapid rate: the new program at {settings.plunge:g} mm/min")
    return found


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
    lost: list[str]
    """Why a program written anew would not cut as this one; empty where it may be written."""
    changed: list[str]
    """What a program written anew has in another way."""


def read_program(file: File, zero: float | None = None, clockwise: bool | None = None) -> Program:
    """The strokes of a program; ``zero`` and ``clockwise`` are about programs that are not ours.

    Raises:
        DataError: what cannot be read; no tangential words; words that do not follow the moves.
        ValueRefused: an axis other than the head of a program of ours says.
    """
    return program_of(reading.text(file, reading.PROGRAM, "programs"), str(file), zero, clockwise)


def program_of(text: str, name: str = "program", zero: float | None = None, clockwise: bool | None = None) -> Program:
    """As :func:`read_program`, of its text."""
    own = settings_of(text, name)
    if own is not None:
        _same_axis(own, zero, clockwise, name)
    moves = read_moves(text, name, own is not None)
    runs, above = runs_of(moves.steps, name)
    if not runs:
        raise DataError(f"{name}: no G1, G2, G3 or G5 moves X or Y, so nothing is cut")
    if not moves.axis:
        raise DataError(
            f"{name}: has no words of a tangential axis, A or C; leadscrew tangent gcode puts them into a drawing "
            "or a plain G-code program"
        )
    if own is not None:
        settings = as_it_is(own, moves.steps, runs)
    else:
        settings = _settings(runs, moves, zero or 0.0, bool(clockwise), name)
    if settings.axis != moves.axis:
        raise DataError(f"{name}: its comments say axis {settings.axis}, its words are of {moves.axis}")
    strokes = [stroke_of(run, settings, name, own is not None) for run in runs]
    kept = [s for s in strokes if s.length >= LEAST_MM]
    if not kept:
        raise DataError(f"{name}: no stroke is {LEAST_MM:g} mm long or longer")
    notes = [] if own is not None else [f"{name}: not of leadscrew tangent; its words are taken as headings, no offset"]
    lost = lost_of(moves, runs, 0 if own is None else len(own.places()))
    if own is not None:
        lost += slowed(runs, own)
    changed = [] if own is not None else changed_of(moves, runs, above, settings)
    return Program(name, settings, kept, own is not None, moves.passed, notes, lost, changed)


def _same_axis(own: Settings, zero: float | None, clockwise: bool | None, name: str) -> None:
    if zero is not None and abs(zero - own.zero) > 1e-9:
        raise ValueRefused(f"zero = {zero:g}: the head of {name} says {own.zero:g} deg; leave the option")
    if clockwise is not None and clockwise != own.clockwise:
        counts = "clockwise" if own.clockwise else "counter-clockwise"
        raise ValueRefused(f"the head of {name} says that the axis counts {counts}; leave the option")


def _settings(runs: list[Run], moves: Moves, zero: float, clockwise: bool, name: str) -> Settings:
    """What a program of others tells of the machine; the slowest plunge is that of all."""
    depth = runs[0].steps[0].start[2]
    lift = top_of(moves.steps)
    plain = Settings()
    plunges = [run.plunge for run in runs if run.plunge]
    rounding = set(moves.rounding)
    try:
        return Settings(
            feed=max(s.feed for run in runs for s in run.steps),
            axis=moves.axis,
            zero=zero,
            clockwise=clockwise,
            depth=depth,
            lift=lift if lift > depth else depth + plain.lift,
            plunge=min(plunges, default=plain.plunge),
            tolerance=rounding.pop() or plain.tolerance if len(rounding) == 1 else plain.tolerance,
            inverse_time=moves.inverse_time,
            inch=moves.inch,
        )
    except ValueRefused as refused:
        raise DataError(f"{name}: {refused}") from None
