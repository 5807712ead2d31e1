"""A path from G-code: the subset of RS274/NGC that moves three axes along lines and arcs.

Understood: ``G0 G1 G2 G3`` (arcs in XY with ``I J`` or ``R``, helical with ``Z``), ``G4 P`` (dwell, seconds), ``G17``,
``G20 G21`` (inch, mm), ``G90 G91`` (absolute, incremental), ``G61 G61.1`` (exact stop: what is run anyway), ``G40 G49
G94`` (already so), ``G80`` (no motion in force), ``F X Y Z N``, ``M2 M30 %`` (end), comments in ``( )`` or after ``;``.
Everything else is refused by line and word, because a word that is skipped is a path that is not the program's.

Source: LinuxCNC documentation, "G-Codes" (arc formats and their tolerances: 2 * 0.001 inch or 0.1 % of the radius).
"""

from __future__ import annotations

from collections.abc import Iterable

from leadscrew.kernel.block import Block
from leadscrew.references._gcode_reader import (  # noqa: F401  (the names of the reader that others use)
    MM_PER_INCH,
    RADIUS_TOLERANCE_MM,
    WORD,
    Dialect,
    Move,
    RefusedError,
    centre_from_radius,
    moves_from_gcode,
)
from leadscrew.references._path import Segment, arc, line, path
from leadscrew.util.errors import DataError, entry_point


@entry_point
def path_from_gcode(
    program: str | Iterable[str],
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    name: str = "G-code",
    with_z: bool = False,
    **params: float,
) -> Block:
    """A reference block that runs a G-code program with an exact stop after each block of code.

    ``program`` is a text or its lines, ``start`` the position in mm before it, ``name`` what errors call it. The other
    keywords are those of :func:`leadscrew.references.path`: ``max_acceleration=...``, ``rapid=...``.

    Raises:
        DataError: a line that is not understood: names line and word.
        ValueRefused: a parameter out of range.
    """
    segments = segments_from_gcode(program, start, name)
    return path(segments, with_z=with_z, **params)


def segments_from_gcode(
    program: str | Iterable[str], start: tuple[float, float, float] = (0.0, 0.0, 0.0), name: str = "G-code"
) -> list[Segment]:
    """The segments of a program, in mm.

    Raises:
        DataError: see :func:`path_from_gcode`, or a program without motion.
    """
    segments = [_segment(move) for move in moves_from_gcode(program, start, name, Dialect())]
    segments = [s for s in segments if s.length > 0.0 or s.dwell > 0.0]
    if not any(s.length > 0.0 for s in segments):
        raise DataError(f"{name}: the program does not move X, Y or Z")
    return segments


def _segment(move: Move) -> Segment:
    """A move as a row of the path."""
    if move.motion is None:
        return Segment(0.0, *move.start, dwell=move.dwell)
    if move.centre is None:
        return line(move.start, move.end, move.feed)
    return arc(move.start, move.end, move.centre, move.motion == 2.0, move.feed)
