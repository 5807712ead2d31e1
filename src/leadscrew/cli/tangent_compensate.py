"""``leadscrew tangent compensate``: the program of the next piece, from the measured cut line of the last."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.output import Json, emit, print_table, progress
from leadscrew.cli.tangent_axis import ClockwiseOfOthers, ZeroOfOthers
from leadscrew.cli.tangent_files import (
    PICTURES,
    PROGRAMS,
    SCHEMA_VERSION,
    cut_program,
    drawing,
    is_program,
    spared,
    wanted,
    written,
)
from leadscrew.kernel.errors import DataError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.paths.curve import Array
    from leadscrew.tangent.settings import Settings
    from leadscrew.tangent.stroke import Stroke


def compensate(
    file: Annotated[
        Path, typer.Argument(metavar="PATH", help="The program that was cut; or the drawing, with --after.")
    ],
    measured: Annotated[
        Path,
        typer.Option(
            "--measured", metavar="FILE", help="The cut line: CSV (x_mm,y_mm or travel_mm,error_deg), SVG or DXF."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="OUT.ngc", help="The program of the next piece.")],
    after: Annotated[
        Path | None,
        typer.Option("--after", metavar="PROGRAM.ngc", help="With a drawing: the program that was cut."),
    ] = None,
    align: Annotated[
        str | None, typer.Option(help="How the scan lies: none (where it was cut), shape, or marks (with --mark).")
    ] = None,
    mark: Annotated[
        list[str] | None,
        typer.Option("--mark", metavar="X,Y=X,Y", help="A mark on the sheet: programmed = scanned; two or more."),
    ] = None,
    learning: Annotated[float, typer.Option(help="Share of the last piece in the new offsets.")] = 1.0,
    gain: Annotated[float, typer.Option(help="By how much the cut is believed to turn with the axis.")] = 0.9,
    axis_lag: Annotated[float, typer.Option(metavar="S", help="Lag of the tangential axis.")] = 0.02,
    width: Annotated[float, typer.Option(metavar="MM", help="Of the Gaussian along the path.")] = 0.75,
    cutoff: Annotated[
        float | None,
        typer.Option(metavar="MM", help="Waves of the scan shorter than this are noise; from the scan unless given."),
    ] = None,
    limit: Annotated[float, typer.Option(metavar="DEG", help="Largest offset.")] = 15.0,
    unit: Annotated[
        str | None, typer.Option("--unit", help="Of the measured file, where it does not say it: mm or inch.")
    ] = None,
    drawing_unit: Annotated[str | None, typer.Option(help="Of the drawing, where it does not say it.")] = None,
    zero: ZeroOfOthers = None,
    clockwise: ClockwiseOfOthers = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="A picture (.png, .svg, .pdf): errors and offsets.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Write the program of the next piece: tangential words with the offsets that the last piece asked for.

    The program that was cut tells its offsets itself, so pieces follow each other: cut, measure, compensate.
    """
    from leadscrew import __version__
    from leadscrew.tangent.compensate import Learning, compensated
    from leadscrew.tangent.emit import program
    from leadscrew.tangent.measured import read_measured

    wanted(out, PROGRAMS, "a program")
    spared(out, [file, measured, after])
    if plot is not None:
        wanted(plot, PICTURES, "a picture")
        spared(plot, [file, measured, after], "--plot")
    pairs = [_mark(text) for text in mark or []]
    how = Learning(learning, gain, axis_lag, width, cutoff, limit)
    settings, strokes = _cut(file, after, drawing_unit, zero, clockwise)
    with progress() as report:
        report(f"{measured}: reading", 0.0)
        found = compensated(
            strokes,
            settings,
            read_measured(measured, unit),
            how,
            align or ("marks" if pairs else "none"),
            pairs,
            lambda done: report(f"{measured}: error of the cut", done),
        )
        notes = [
            f"{file.name}, compensated by {measured.name}, by leadscrew {__version__} tangent compensate",
            f"error of the tangent {found.rms():.2f} deg rms before, {found.rms(True):.2f} predicted",
        ]
        text = program(found.strokes, settings, notes)
        if plot is not None:
            from leadscrew.report.tangent import learned_figure, picture

            drawn = picture(learned_figure(found), plot.suffix)
    written(text, out)
    if plot is not None:
        written(drawn, plot)
    rows = [
        {"stroke": k.number, "length_mm": k.stroke.length, "before_rms_deg": _rms(k.before),
         "predicted_rms_deg": _rms(k.predicted), "largest_offset_deg": float(abs(k.new).max()),
         "clipped_mm": k.clipped_mm, "cutoff_mm": k.seen.cutoff, "noise_mm": k.seen.noise,
         "spacing_mm": k.seen.spacing, "measured_length_mm": k.seen.length}
        for k in found.learned
    ]  # fmt: skip
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "measured": str(measured), "out": out,
              "before_rms_deg": found.rms(), "predicted_rms_deg": found.rms(True),
              "largest_offset_deg": found.largest, "placing": found.placing._asdict(), "strokes": rows,
              "notes": found.notes, "plot": plot})  # fmt: skip
        return
    from leadscrew.cli.door import say

    columns = (
        "stroke",
        "length / mm",
        "error rms / deg",
        "predicted",
        "offset / deg",
        "clipped / mm",
        "cut-off / mm",
    )
    cells = [
        [str(r["stroke"]), f"{r['length_mm']:.1f}", f"{r['before_rms_deg']:.2f}", f"{r['predicted_rms_deg']:.2f}",
         f"{r['largest_offset_deg']:.2f}", f"{r['clipped_mm']:.1f}", f"{r['cutoff_mm']:.1f}" if r["cutoff_mm"] else "-"]
        for r in rows
    ]  # fmt: skip
    print_table(columns, cells, right=columns)
    typer.echo("")
    if found.placing.turn_deg or found.placing.dx or found.placing.dy:
        p = found.placing
        typer.echo(f"the piece lay turned by {-p.turn_deg:.2f} deg; brought back to the programmed line")
    typer.echo(
        f"{out}: the next piece; the last was {found.rms():.2f} deg off (rms), what comes again of it leaves "
        f"{found.rms(True):.2f} deg"
    )
    for note in found.notes:
        say(f"leadscrew: note: {note}")


def _cut(
    file: Path, after: Path | None, unit: str | None, zero: float | None, clockwise: bool | None
) -> tuple[Settings, list[Stroke]]:
    """Settings and strokes of the piece that was cut."""
    from dataclasses import replace

    from leadscrew.cli.door import say
    from leadscrew.tangent.settings import Settings
    from leadscrew.tangent.stroke import strokes_of

    if is_program(file):
        if after is not None:
            raise ValueRefused(f"--after {after}: {file} is a program itself: give the one that was cut as PATH")
        if unit is not None:
            raise ValueRefused(f"--drawing-unit {unit}: {file} is a program, and its unit stands in it")
        cut = cut_program(file, zero, clockwise)
        if cut.passed:
            raise DataError(
                f"{file}: has words that a new program would lose ({'; '.join(cut.passed[:3])}); give the drawing, or "
                "a program of leadscrew tangent gcode"
            )
        if cut.lost:
            raise DataError(
                f"{file}: cannot be written anew: {cut.lost[0]}; give the drawing, or a program of leadscrew tangent "
                "gcode"
            )
        for change in cut.changed:
            say(f"leadscrew: note: {file}: {change}")
        if not cut.ours:
            return cut.settings, cut.strokes
        return cut.settings, [replace(s, feeds=None) for s in cut.strokes]
    before = None if after is None else cut_program(after, zero, clockwise)
    if before is not None and (before.passed or before.lost):
        said = "; ".join([*before.passed, *before.lost][:4])
        say(f"leadscrew: note: the new program is made of {file} and does not have what {after} has: {said}")
    settings = Settings() if before is None else before.settings
    strokes = strokes_of(drawing(file, unit).paths, settings)
    if before is None:
        if zero is not None or clockwise is not None:
            raise ValueRefused("--zero and --clockwise are about a program that was cut: give it with --after")
        say(f"leadscrew: note: {file}: taken as cut by what gcode makes of it without options; else give --after")
        return settings, strokes
    if len(before.strokes) != len(strokes) or any(
        abs(a.length - b.length) > 0.002 * b.length + 0.05 for a, b in zip(before.strokes, strokes, strict=True)
    ):
        raise DataError(
            f"{after}: is not a program of {file}: it has {len(before.strokes)} strokes of "
            f"{sum(s.length for s in before.strokes):.1f} mm, the drawing {len(strokes)} of "
            f"{sum(s.length for s in strokes):.1f} mm"
        )
    return settings, [replace(b, table=a.table) for a, b in zip(before.strokes, strokes, strict=True)]


def _rms(values: Array) -> float:
    return math.sqrt(float((values**2).mean()))


def _mark(text: str) -> tuple[float, float, float, float]:
    try:
        (a, b), (c, d) = ((float(v) for v in half.split(",")) for half in text.split("="))
        values = (a, b, c, d)
    except ValueError:
        values = (math.nan,) * 4
    if not all(math.isfinite(v) for v in values):
        raise ValueRefused(f"--mark {text}: expected X,Y=X,Y, mm: where it was programmed, and where it was scanned")
    return values
