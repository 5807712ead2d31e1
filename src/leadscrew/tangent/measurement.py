"""The cut line of a piece as a file: points of a scan or a gauge, angle errors along the way, or a traced drawing.

- **CSV of points**: columns ``x_mm, y_mm`` in the order of the cut, and ``stroke`` (1, 2, ...) where there are several.
- **CSV of errors**: ``travel_mm, error_deg`` (tangent of the cut less the programmed one, counter-clockwise), and
  ``stroke``.
- **SVG, DXF**: the traced line, a path for each stroke.

A unit stands in the header, as in ``x_mm``, ``x (inch)``; without one, it is the one given, or mm.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path as File
from typing import NamedTuple

import numpy as np

from leadscrew.paths.curve import Array
from leadscrew.tangent.settings import MM_PER_INCH
from leadscrew.util.csv_lines import number, read_lines
from leadscrew.util.errors import DataError, ValueRefused

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": MM_PER_INCH, "in": MM_PER_INCH}
"""mm in a unit of length."""
DRAWN = (".svg", ".dxf")
STEP_MM = 0.2
"""Distance at which a traced line is read."""
MOST_ROWS = 2_000_000
MOST_MM = 1e6
"""No point is further away."""
NAMES = {
    "x": "x", "y": "y", "travel": "travel", "s": "travel", "way": "travel", "error": "error", "angle_error": "error",
    "deviation": "error", "e": "error", "stroke": "stroke", "path": "stroke",
}  # fmt: skip
"""Columns by what they may be called."""
HEADER = re.compile(r"^(.+?)(?:\s*[(\[]\s*(\w+)\s*[)\]]|_(mm|cm|m|inch|in|deg))?$")


class Trace(NamedTuple):
    """The measured line of one stroke."""

    stroke: int
    """Number of the stroke, from 1; 0: not said."""
    x: Array
    """mm; empty where errors were measured."""
    y: Array
    travel: Array
    """mm; empty where points were measured."""
    error: Array
    """deg"""
    closed: bool
    """Whether it was drawn as a closed line: where it begins says nothing."""
    where: str
    """What a message calls it."""

    @property
    def points(self) -> bool:
        """Whether these are points, not errors."""
        return bool(self.x.size)


def read_measured(file: File, unit: str | None = None) -> list[Trace]:
    """The measured lines in a file.

    Raises:
        DataError: a file that cannot be read, with row and column.
        ValueRefused: a unit that is none.
    """
    if unit is not None and unit not in UNITS:
        raise ValueRefused(f"unit {unit!r}: expected {', '.join(UNITS)}")
    if file.suffix.lower() in DRAWN:
        return _drawn(file, unit)
    lines = read_lines(file, "x_mm, y_mm or travel_mm, error_deg")
    _told_apart(file, lines)
    found: dict[str, tuple[int, float]] = {}
    for place, cell in enumerate(lines[0][1]):
        match = HEADER.match(cell.lower())
        name = NAMES.get(match[1].strip().replace(" ", "_")) if match else None
        if match is None or name is None:
            continue
        if name in found:
            raise DataError(f"{file}, row {lines[0][0]}: two columns for {name}")
        said = match[2] or match[3]
        if name in ("error", "stroke"):
            if name == "error" and said not in (None, "deg"):
                raise DataError(f"{file}, row {lines[0][0]}: {cell!r}: expected deg")
            found[name] = (place, 1.0)
            continue
        if said is not None and said not in UNITS:
            raise DataError(f"{file}, row {lines[0][0]}: {cell!r}: expected a unit of {', '.join(UNITS)}")
        found[name] = (place, UNITS[said or unit or "mm"])
    wanted = next((pair for pair in (("x", "y"), ("travel", "error")) if set(pair) <= set(found)), None)
    if wanted is None:
        raise DataError(
            f"{file}, row {lines[0][0]}: the header is {', '.join(lines[0][1])}; expected x_mm and y_mm, or travel_mm "
            "and error_deg"
        )
    return _traces(file, lines, found, wanted)


def _told_apart(file: File, lines: Sequence[tuple[int, list[str]]]) -> None:
    """Refuses other dividers than commas, decimal commas, and more rows than there can be."""
    row, header = lines[0]
    if len(lines) > MOST_ROWS:
        raise DataError(f"{file}: has {len(lines) - 1} rows: expected {MOST_ROWS - 1} or fewer; thin the points out")
    if len(header) == 1 and (divider := next((c for c in ";\t" if c in header[0]), "")):
        what = "semicolons" if divider == ";" else "tabs"
        raise DataError(f"{file}, row {row}: cells are divided by {what}; expected commas, and a decimal point")
    for n, cells in lines[1:]:
        if any(cells[len(header) :]):
            raise DataError(
                f"{file}, row {n}: has {len(cells)} cells, the header {len(header)}; a decimal comma? expected a point"
            )


def _traces(
    file: File, lines: Sequence[tuple[int, list[str]]], found: dict[str, tuple[int, float]], wanted: tuple[str, str]
) -> list[Trace]:
    header = lines[0][1]
    rows: dict[int, list[tuple[float, float]]] = {}
    for n, cells in lines[1:]:
        values = []
        for name in (*wanted, *(["stroke"] if "stroke" in found else [])):
            place, scale = found[name]
            if place >= len(cells):
                raise DataError(f"{file}, row {n}: has {len(cells)} cells; column {header[place]!r} is missing")
            values.append(number(file, n, header[place], cells[place]) * scale)
        stroke = values[2] if len(values) == 3 else 0.0
        if len(values) == 3 and (not 1.0 <= stroke <= MOST_ROWS or stroke != int(stroke)):
            raise DataError(f"{file}, row {n}: stroke {stroke:.4g}: expected a whole number, 1 for the first stroke")
        if wanted[0] == "x" and not max(abs(v) for v in values[:2]) <= MOST_MM:
            far = max(values[:2], key=abs)
            raise DataError(f"{file}, row {n}: lies {far:.4g} mm away; expected up to {MOST_MM:g} mm")
        rows.setdefault(int(stroke), []).append((values[0], values[1]))
    none = np.empty(0)
    traces = []
    for stroke, pairs in rows.items():
        a, b = np.array(pairs).T
        where = f"{file}, stroke {stroke}" if stroke else f"{file}"
        x, y, travel, error = (a, b, none, none) if wanted[0] == "x" else (none, none, a, b)
        traces.append(Trace(stroke, x, y, travel, error, False, where))
    return traces


def _drawn(file: File, unit: str | None) -> list[Trace]:
    from leadscrew.paths.read import read_drawing

    drawing = read_drawing(file, unit)
    none = np.empty(0)
    traces = []
    for k, path in enumerate(drawing.paths, start=1):
        travel = np.linspace(0.0, path.length, max(int(path.length / STEP_MM), 8) + 1)
        if path.closed:
            travel = travel[:-1]
        x, y, _, _ = path.at(travel)
        traces.append(Trace(0, x, y, none, none, path.closed, f"{file}, line {k}"))
    return traces
