"""Files of ``leadscrew tangent``: drawings and programs in, and nothing written over what it was made of."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.paths.suffixes import GCODE
from leadscrew.util.errors import DataError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.paths.read import Drawing
    from leadscrew.tangent.program import Program
    from leadscrew.tangent.settings import Settings
    from leadscrew.tangent.stroke import Stroke

SCHEMA_VERSION = 1
PROGRAMS = GCODE
"""Suffixes of G-code."""
PICTURES = (".png", ".svg", ".pdf")
"""Suffixes of pictures."""

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
    """The lines of a drawing, its notes said."""
    from leadscrew.cli.exit_codes import say
    from leadscrew.paths.read import read_drawing

    found = read_drawing(file, unit)
    for note in found.notes:
        say(f"leadscrew: note: {note}")
    return found


def cut_program(file: Path, zero: float | None = None, clockwise: bool | None = None) -> Program:
    """A program that was cut, its notes said."""
    from leadscrew.cli.exit_codes import say
    from leadscrew.tangent.program import read_program

    found = read_program(file, zero, clockwise)
    for note in found.notes:
        say(f"leadscrew: note: {note}")
    return found


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
    """Refuses a name that says another kind of file."""
    if out.suffix.lower() not in suffixes:
        raise ValueRefused(f"{out}: {what} ends in {', '.join(suffixes)}")


def there(file: Path) -> None:
    """Refuses a file that is not there, before work begins."""
    if not file.is_file():
        raise DataError(f"{file}: no such file")


MOST_PLACES = 200_000
"""Of a stroke that are looked at."""


def program_row(stroke: Stroke, settings: Settings, number: int) -> dict[str, object]:
    """What a stroke asks of the machine."""
    import math

    import numpy as np

    at = stroke.at(stroke.grid(max(0.1, stroke.length / MOST_PLACES)))
    sharpest = float(np.abs(at.curvature).max())
    per_mm = math.degrees(sharpest)
    rate = per_mm * settings.feed / 60.0
    limit = 60.0 * settings.swivel / per_mm if per_mm > 0.0 else math.inf
    return {
        "stroke": number,
        "path": stroke.path.name,
        "closed": stroke.path.closed,
        "length_mm": stroke.length,
        "bends": len(stroke.bends),
        "turn_deg": float(at.heading[-1] - at.heading[0]),
        "smallest_radius_mm": 1.0 / sharpest if sharpest > 0.0 else math.inf,
        "peak_swivel_deg_s": rate,
        "feed_limit_mm_min": limit,
    }


COLUMNS = ("stroke", "path", "length / mm", "", "bends", "turn / deg", "radius / mm", "swivel / deg/s", "feed limit")


def printed(row: dict[str, object]) -> list[str]:
    """A row of the table."""
    radius, limit = float(row["smallest_radius_mm"]), float(row["feed_limit_mm_min"])  # type: ignore[arg-type]
    return [
        str(row["stroke"]),
        str(row["path"]) or "-",
        f"{row['length_mm']:.1f}",
        "closed" if row["closed"] else "open",
        str(row["bends"]),
        f"{row['turn_deg']:.1f}",
        f"{radius:.3g}" if radius < 1e4 else "straight",
        f"{row['peak_swivel_deg_s']:.0f}",
        f"{limit:.0f}" if limit < 1e6 else "none",
    ]
