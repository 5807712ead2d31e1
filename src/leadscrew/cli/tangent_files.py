"""Files of ``leadscrew tangent``: drawings and programs in, and nothing written over what it was made of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.output import note
from leadscrew.figures.table import NOTHING, fixed, number
from leadscrew.paths.suffixes import GCODE
from leadscrew.report.report import TextTable
from leadscrew.util.errors import DataError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.paths.read import Drawing
    from leadscrew.tangent.program import Program
    from leadscrew.tangent.settings import Settings
    from leadscrew.tangent.stroke import Stroke

PROGRAMS = GCODE
"""Suffixes of G-code."""

Drawn = Annotated[Path, typer.Argument(metavar="DRAWING", help="SVG, DXF, or G-code of a line in XY.")]
Unit = Annotated[
    str | None,
    typer.Option("--unit", help="mm, cm, m, inch or px, where the file does not say its unit (SVG: 96 px an inch)."),
]
Zero = Annotated[
    float, typer.Option("--zero", metavar="DEG", help="Heading, counter-clockwise from +X, at which the axis reads 0.")
]
Clockwise = Annotated[bool, typer.Option("--clockwise", help="The axis counts clockwise.")]


def is_program(file: Path) -> bool:
    """Whether a file is G-code, by its name."""
    return file.suffix.lower() in PROGRAMS


def drawing(file: Path, unit: str | None) -> Drawing:
    """The lines of a drawing; prints its notes."""
    from leadscrew.paths.read import read_drawing

    read = read_drawing(file, unit)
    for line in read.notes:
        note(line)
    return read


def cut_program(file: Path, zero: float | None = None, clockwise: bool | None = None) -> Program:
    """A program that was cut; prints its notes."""
    from leadscrew.tangent.program import read_program

    read = read_program(file, zero, clockwise)
    for line in read.notes:
        note(line)
    return read


def spared(out: Path, inputs: Sequence[Path | None], option: str = "--out") -> None:
    """Refuses to write over a file that is read; ``option`` is what names it."""
    for file in inputs:
        if file is not None and out.exists() and file.exists() and out.samefile(file):
            raise ValueRefused(f"{option} {out}: is read by this command; write to another file")


def written(data: str | bytes, out: Path) -> None:
    """Writes a file; through a link, the file that it points to, and the link stays."""
    from leadscrew.util.atomic import atomic_write

    atomic_write(data, out)


def wanted(out: Path, suffixes: Sequence[str], what: str) -> None:
    """Refuses the name of another kind of file."""
    if out.suffix.lower() not in suffixes:
        raise ValueRefused(f"{out}: {what} ends in {', '.join(suffixes)}")


def there(file: Path) -> None:
    """Refuses a file that is not there, before work begins."""
    if not file.is_file():
        raise DataError(f"{file}: no such file")


MOST_PLACES = 200_000
"""Of a stroke that are looked at."""


def program_row(stroke: Stroke, settings: Settings, count: int) -> dict[str, Any]:
    """What a stroke asks of the machine."""
    import math

    import numpy as np

    at = stroke.at(stroke.grid(max(0.1, stroke.length / MOST_PLACES)))
    sharpest = float(np.abs(at.curvature).max())
    per_mm = math.degrees(sharpest)
    rate = per_mm * settings.feed / 60.0
    limit = 60.0 * settings.swivel / per_mm if per_mm > 0.0 else math.inf
    return {
        "stroke": count,
        "path": stroke.path.name,
        "closed": stroke.path.closed,
        "length_mm": stroke.length,
        "bends": len(stroke.bends),
        "turn_deg": float(at.heading[-1] - at.heading[0]),
        "smallest_radius_mm": 1.0 / sharpest if sharpest > 0.0 else math.inf,
        "peak_swivel_deg_s": rate,
        "feed_limit_mm_min": limit,
    }


def program_table(rows: Sequence[dict[str, Any]]) -> TextTable:
    """The rows of :func:`program_row`."""
    cells = [
        [
            str(r["stroke"]), r["path"] or NOTHING, fixed(r["length_mm"], 1), "closed" if r["closed"] else "open",
            str(r["bends"]), fixed(r["turn_deg"], 1),
            number(r["smallest_radius_mm"], 3) if r["smallest_radius_mm"] < 1e4 else "straight",
            fixed(r["peak_swivel_deg_s"], 0),
            fixed(r["feed_limit_mm_min"], 0) if r["feed_limit_mm_min"] < 1e6 else "none",
        ]
        for r in rows
    ]  # fmt: skip
    heads = ("stroke", "path", "length (mm)", "", "bends", "turn (°)", "radius (mm)", "swivel (°/s)",
             "feed limit (mm/min)")  # fmt: skip
    return TextTable(heads, cells, [True, False, True, False, *[True] * 5])
