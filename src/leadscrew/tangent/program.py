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

from dataclasses import dataclass
from pathlib import Path as File

from leadscrew import reading
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.tangent.interpreter import Moves, read_moves
from leadscrew.tangent.kept import as_it_is, changed_of, lost_of, slowed
from leadscrew.tangent.restroked import stroke_of
from leadscrew.tangent.runs import Run, runs_of, top_of
from leadscrew.tangent.settings import Settings, settings_of
from leadscrew.tangent.stroke import LEAST_MM, Stroke


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
