"""``leadscrew tangent show``: what a drawing asks of a tangential axis."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.cli.tangent_files import (
    COLUMNS,
    PICTURES,
    SCHEMA_VERSION,
    Drawn,
    Unit,
    drawing,
    printed,
    program_row,
    spared,
    wanted,
    written,
)
from leadscrew.escape import shell
from leadscrew.tangent.settings import Settings


def show(
    file: Drawn,
    feed: Annotated[float, typer.Option(metavar="MM/MIN", help="Along the line.")] = Settings.feed,
    corner_angle: Annotated[float, typer.Option(metavar="DEG", help="Above it the knife is lifted and turned.")] = (
        Settings.corner_angle
    ),
    max_swivel_rate: Annotated[float, typer.Option(metavar="DEG/S", help="Fastest turn of the axis.")] = (
        Settings.swivel
    ),
    unit: Unit = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="A picture (.png, .svg, .pdf): lines and headings.")
    ] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Write an example drawing to DRAWING (.svg) instead.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Lines, lengths, corners, smallest radius, and how fast the blade has to turn.

    A stroke is what is cut between plunge and lift: a path is divided at its corners.
    """
    if example:
        _write_example(file, plot is not None or as_json or unit is not None)
        return
    from leadscrew.tangent.stroke import strokes_of

    if plot is not None:
        wanted(plot, PICTURES, "a picture")
        spared(plot, [file], "--plot")
    settings = Settings(feed=feed, corner_angle=corner_angle, swivel=max_swivel_rate)
    with busy(str(file)):
        drawn = drawing(file, unit)
        strokes = strokes_of(drawn.paths, settings)
        rows = [program_row(s, settings, k) for k, s in enumerate(strokes, start=1)]
        corners = [c for p in drawn.paths for c in p.corners]
        if plot is not None:
            from leadscrew.report.tangent import drawn_figure, picture

            written(picture(drawn_figure(strokes, settings), plot.suffix), plot)
    lifted = [c for c in corners if settings.lifts(c.turn_deg)]
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "unit": drawn.unit, "paths": len(drawn.paths),
              "length_mm": sum(p.length for p in drawn.paths), "feed_mm_min": feed, "swivel_deg_s": max_swivel_rate,
              "corners": [c._asdict() for c in corners], "lifted": len(lifted), "strokes": rows,
              "notes": list(drawn.notes), "plot": plot})  # fmt: skip
        return
    typer.echo(
        f"{file}: {len(drawn.paths)} path{'s' if len(drawn.paths) != 1 else ''}, "
        f"{sum(p.length for p in drawn.paths):.1f} mm, unit {drawn.unit}; {len(corners)} corners, of which "
        f"{len(lifted)} above {corner_angle:g} deg: {len(strokes)} stroke{'s' if len(strokes) != 1 else ''}"
    )
    typer.echo("")
    print_table(COLUMNS, [printed(r) for r in rows], right=(COLUMNS[0], COLUMNS[2], *COLUMNS[4:]))
    slow = [r for r in rows if float(r["feed_limit_mm_min"]) < feed]  # type: ignore[arg-type]
    if slow:
        typer.echo(
            f"\nat F{feed:g} the blade is too slow in stroke {', '.join(str(r['stroke']) for r in slow[:8])}"
            f"{', ...' if len(slow) > 8 else ''}: gcode lowers the feed there"
        )
    if plot is not None:
        typer.echo(f"\n{plot}: the lines and their headings")


def _write_example(file: Path, more: bool) -> None:
    from leadscrew.kernel.errors import DataError, ValueRefused
    from leadscrew.newfile import save
    from leadscrew.tangent.example import FILE

    wanted(file, (".svg",), "the example drawing")
    if more:
        raise ValueRefused("--example only writes DRAWING; leave the other options for the show of it")
    if file.exists():
        raise DataError(f"{file} exists already; --example overwrites nothing")
    save(FILE.read_bytes(), file)
    typer.echo(f"{file}: an example; next: leadscrew tangent show {shell(file)}")
