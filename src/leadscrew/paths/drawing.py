"""What a drawing's file gives: paths in mm, and what was left out; and how loose pieces become paths.

Pieces whose ends lie within the tolerance are joined into one path, turned round where needed. Where more than two
meet, a path goes on with the piece that turns least. A piece drawn twice is cut once.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from leadscrew.paths.curve import Array, Curve
from leadscrew.paths.path import JOIN_MM, SHORTEST_MM, Path, wrapped
from leadscrew.util.errors import DataError, ValueRefused

UNITS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "px": 25.4 / 96.0}
"""Units a user may name, in mm; ``px``: 96 to the inch."""
SAME_UNIT = {"inch": "in"}

LARGEST_MM = 1e6
"""Coordinates beyond are a broken file."""
DOUBLE_MM = 1e-6
"""Pieces that agree to this are the same."""


def unit_named(unit: str | None) -> str | None:
    """The unit a user names, as :data:`UNITS_MM` has it.

    Raises:
        ValueRefused: a unit not known.
    """
    found = SAME_UNIT.get(unit, unit) if unit is not None else None
    if found is not None and found not in UNITS_MM:
        raise ValueRefused(f"unit = {unit!r}: expected one of {', '.join(UNITS_MM)} (in or inch)")
    return found


class Programmed(NamedTuple):
    """The angle of the tangential axis that a program gives along a path: rows of its blocks."""

    travel: Array
    """Arc length at the start and at the end of each block, mm: shape (n, 2)."""
    angle: Array
    """The programmed angle there, deg: shape (n, 2)."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """The paths of a file, in mm, y upwards."""

    paths: tuple[Path, ...]
    unit: str
    """The unit that the file is drawn in."""
    notes: tuple[str, ...] = ()
    """What was left out or changed, a sentence each."""
    layers: tuple[str, ...] = ()
    """The layer of each path; empty where the file has none."""
    programmed: tuple[Programmed | None, ...] = ()
    """Of G-code: the tangential words of each path, none where it has none."""
    name: str = ""

    @property
    def length(self) -> float:
        """Length of all cuts, mm."""
        return sum(p.length for p in self.paths)


class Piece(NamedTuple):
    """Curves that follow one another in the file."""

    curves: list[Curve]
    layer: str = ""
    name: str = ""

    @property
    def start(self) -> tuple[float, float]:
        """First point."""
        return self.curves[0].start

    @property
    def end(self) -> tuple[float, float]:
        """Last point."""
        return self.curves[-1].end

    def reversed(self) -> Piece:
        """Run the other way."""
        return self._replace(curves=[c.reversed() for c in reversed(self.curves)])


def drawing(
    pieces: Iterable[Piece], unit: str, name: str, notes: Sequence[str] = (), tolerance: float = JOIN_MM
) -> Drawing:
    """Pieces in mm as a drawing: empty ones and doubles left out, the rest joined.

    Raises:
        DataError: nothing to cut, or points that are not finite.
    """
    said = list(notes)
    kept, empty = [], 0
    for piece in pieces:
        if not all(c.scale + math.hypot(*c.start) < LARGEST_MM for c in piece.curves):
            raise DataError(f"{name}: a coordinate beyond {LARGEST_MM / 1e6:g} km: is the unit right?")
        curves = [c for c in piece.curves if c.length > SHORTEST_MM]
        empty += len(piece.curves) - len(curves)
        if curves:
            kept.append(piece._replace(curves=curves))
    if empty:
        said.append(f"{_counted(empty, 'segment')} of no length left out")
    once = _without_doubles(kept)
    if len(once) < len(kept):
        said.append(f"{_counted(len(kept) - len(once), 'piece')} drawn twice, cut once")
    chains = _chained(once, tolerance)
    if len(chains) < len(once):
        said.append(f"{len(once)} pieces joined into {_counted(len(chains), 'path')}")
    if not chains:
        raise nothing(name, said)
    gaps = 0
    paths = []
    for k, chain in enumerate(chains):
        joints = list(zip(chain.curves, chain.curves[1:], strict=False))
        closed = _closed(chain, tolerance)
        ends = [(a.end, b.start) for a, b in joints] + ([(chain.end, chain.start)] if closed else [])
        gaps += sum(1e-6 < math.dist(a, b) <= tolerance for a, b in ends)
        try:
            paths.append(Path(chain.curves, closed, chain.name or f"path {k + 1}", tolerance))
        except ValueRefused as refused:
            raise DataError(f"{name}: {refused}") from None
    if gaps:
        said.append(f"{_counted(gaps, 'gap')} of at most {tolerance:g} mm closed")
    layers = tuple(c.layer for c in chains)
    return Drawing(tuple(paths), unit, tuple(said), layers if any(layers) else (), name=name)


def nothing(name: str, notes: Sequence[str]) -> DataError:
    """The refusal of a drawing without a path."""
    why = "; ".join(notes) if notes else "the file has no lines or curves"
    return DataError(f"there is nothing to cut in {name}: {why}")


def left_out(kinds: Counter[str], why: str = "not cut") -> list[str]:
    """A note for things of some kinds that are not read."""
    if not kinds:
        return []
    listed = ", ".join(f"{n} {kind}" for kind, n in sorted(kinds.items()))
    return [f"{why}: {listed}"]


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun}" + ("" if n == 1 else "s")


def _closed(piece: Piece, tolerance: float) -> bool:
    length = sum(c.length for c in piece.curves)
    return math.dist(piece.start, piece.end) <= tolerance < 0.5 * length


def _without_doubles(pieces: list[Piece]) -> list[Piece]:
    """Of pieces with the same ends, length and middle only the first."""
    seen: dict[tuple[int, int], list[tuple[float, ...]]] = defaultdict(list)
    found = []
    for piece in pieces:
        length = sum(c.length for c in piece.curves)
        middle = piece.curves[len(piece.curves) // 2]
        place = middle.at(0.5 * middle.length if len(piece.curves) % 2 else 0.0)
        x, y = float(place.x), float(place.y)
        key = (length, len(piece.curves), x, y, *min(ends := (piece.start, piece.end)), *max(ends))
        near = [row for i in (-1, 0, 1) for j in (-1, 0, 1) for row in seen.get((round(x) + i, round(y) + j), ())]
        if any(max(abs(a - b) for a, b in zip(key, row, strict=True)) <= DOUBLE_MM for row in near):
            continue
        seen[(round(x), round(y))].append(key)
        found.append(piece)
    return found


def _chained(pieces: list[Piece], tolerance: float) -> list[Piece]:
    """Open pieces of one layer joined end to end."""
    cells: dict[tuple[str, int, int], set[int]] = defaultdict(set)
    width = 2.0 * max(tolerance, 1e-9)

    def cell(p: tuple[float, float]) -> tuple[int, int]:
        return math.floor(p[0] / width), math.floor(p[1] / width)

    whole = {k for k, p in enumerate(pieces) if _closed(p, tolerance)}
    free = {k: p for k, p in enumerate(pieces) if k not in whole}
    for k, piece in free.items():
        for p in (piece.start, piece.end):
            cells[(piece.layer, *cell(p))].add(k)

    def following(chain: Piece) -> Piece | None:
        """The free piece that goes on from the end, turning least."""
        x, y = cell(chain.end)
        heading = chain.curves[-1].headings[1]
        best: tuple[float, int, Piece] | None = None
        near = {k for i in (-1, 0, 1) for j in (-1, 0, 1) for k in cells.get((chain.layer, x + i, y + j), ())}
        for k in sorted(near):
            if k not in free:
                continue
            for way in (free[k], free[k].reversed()):
                if math.dist(way.start, chain.end) <= tolerance:
                    turn = abs(wrapped(way.curves[0].headings[0] - heading))
                    if best is None or turn < best[0] - 1e-9:
                        best = (turn, k, way)
        if best is None:
            return None
        del free[best[1]]
        return best[2]

    found: list[Piece] = []
    for k, piece in enumerate(pieces):
        if k not in free:
            if k in whole:
                found.append(piece)
            continue
        del free[k]
        chain = piece
        # From its end, then from its start: turned round twice, it is run as its first piece is drawn.
        for _ in range(2):
            curves = list(chain.curves)
            end = chain
            while math.dist(chain.start, end.end) > tolerance and (more := following(end)) is not None:
                curves += more.curves
                end = more
            chain = chain._replace(curves=curves).reversed()
        found.append(chain)
    return found
