"""``leadscrew tangent gcode``: a drawing as a program with tangential words."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.output import Json, busy, emit
from leadscrew.cli.tangent_files import (
    PROGRAMS,
    SCHEMA_VERSION,
    Clockwise,
    Drawn,
    Unit,
    Zero,
    drawing,
    spared,
    wanted,
    written,
)
from leadscrew.tangent.settings import Settings

Out = Annotated[Path, typer.Option("--out", "-o", metavar="OUT.ngc", help="The program.")]


def gcode(
    file: Drawn,
    out: Out,
    feed: Annotated[float, typer.Option(metavar="MM/MIN", help="Along the line.")] = Settings.feed,
    axis: Annotated[str, typer.Option(help="The tangential axis: C or A.")] = Settings.axis,
    corner_angle: Annotated[
        float, typer.Option(metavar="DEG", help="Above it lift, turn, plunge; below it turn while cutting.")
    ] = Settings.corner_angle,
    blend: Annotated[float, typer.Option(metavar="MM", help="Length over which a smaller corner is turned.")] = (
        Settings.blend
    ),
    lift: Annotated[
        float, typer.Option(metavar="Z", help="Z of the lifted knife, mm, above the sheet: above 0.")
    ] = Settings.lift,
    depth: Annotated[float, typer.Option(metavar="Z", help="Z of the cutting knife, mm: 0 or below.")] = Settings.depth,
    plunge: Annotated[float, typer.Option(metavar="MM/MIN", help="Feed down.")] = Settings.plunge,
    max_swivel_rate: Annotated[
        float, typer.Option(metavar="DEG/S", help="Fastest turn of the axis: the feed is lowered to it.")
    ] = Settings.swivel,
    tolerance: Annotated[float, typer.Option(metavar="MM", help="Of an arc in place of another curve.")] = (
        Settings.tolerance
    ),
    angle_tolerance: Annotated[
        float, typer.Option(metavar="DEG", help="Of the blade between two words, and of a move's tangent.")
    ] = (Settings.angle_tolerance),
    overcut: Annotated[float, typer.Option(metavar="MM", help="How far a closed line is cut beyond its start.")] = (
        Settings.overcut
    ),
    start_angle: Annotated[float, typer.Option(metavar="DEG", help="What the axis reads before the program.")] = (
        Settings.start_angle
    ),
    prick: Annotated[
        list[str] | None,
        typer.Option(
            "--prick", metavar="X,Y", help="A mark in the sheet, mm; two tell how a piece lay on the scanner."
        ),
    ] = None,
    zero: Zero = Settings.zero,
    clockwise: Clockwise = False,
    inverse_time: Annotated[
        bool, typer.Option("--inverse-time", help="Feeds as G93, for controls that count degrees in F.")
    ] = False,
    inch: Annotated[bool, typer.Option("--inch", help="Words in inches (G20).")] = False,
    unit: Unit = None,
    as_json: Json = False,
) -> None:
    """Write G-code with tangential words: lines and arcs as they are, other curves in arcs, headings exact.

    Words are unwrapped: they run on beyond 360 deg.
    """
    wanted(out, PROGRAMS, "a program")
    spared(out, [file])
    settings = Settings(
        feed=feed, axis=axis.upper(), zero=zero, clockwise=clockwise, start_angle=start_angle,
        corner_angle=corner_angle, blend=blend, lift=lift, depth=depth, plunge=plunge, swivel=max_swivel_rate,
        tolerance=tolerance, angle_tolerance=angle_tolerance, overcut=overcut, inverse_time=inverse_time, inch=inch,
        pricks=" ".join(prick or []),
    ).over_the_sheet()  # fmt: skip
    from leadscrew import __version__
    from leadscrew.tangent.emit import program
    from leadscrew.tangent.moves import moves_of, tight_turns
    from leadscrew.tangent.stroke import strokes_of

    with busy(str(file)):
        strokes = strokes_of(drawing(file, unit).paths, settings)
        each = [moves_of(s, settings) for s in strokes]
        text = program(strokes, settings, [f"{file.name}, by leadscrew {__version__} tangent gcode"], each)
    moves = [m for part in each for m in part]
    written(text, out)
    words = [float(x) for x in re.findall(rf"^G[0-3] .*{settings.axis}(\S+)", text, re.MULTILINE)]
    slowest = min(m.feed for m in moves)
    found = {
        "strokes": len(strokes),
        "length_mm": sum(s.length for s in strokes),
        "moves": len(moves),
        "arcs": sum(m.arc is not None for m in moves),
        "seconds": sum(60.0 * m.length / m.feed for m in moves),
        "slowest_feed_mm_min": slowest,
        "angles_deg": [min(words), max(words)],
        "tight": [{"stroke": k, **t._asdict()} for k, part in enumerate(each, start=1)
                  for t in tight_turns(part, settings)],
    }  # fmt: skip
    _say_tight(found["tight"])  # type: ignore[arg-type]
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "out": out, **found})
        return
    typer.echo(
        f"{out}: {found['strokes']} stroke{'s' if len(strokes) != 1 else ''}, {found['length_mm']:.1f} mm in "
        f"{len(moves)} moves ({found['arcs']} arcs), {found['seconds']:.1f} s of cutting"
    )
    typer.echo(f"{settings.axis} from {min(words):.1f} to {max(words):.1f} deg")
    if slowest < feed:
        typer.echo(f"feed lowered to F{slowest:.0f} where the blade turns at {max_swivel_rate:g} deg/s")


def _say_tight(found: list[dict[str, float]]) -> None:
    """The places where the blade turns sharply while it cuts."""
    from leadscrew.cli.door import say

    if found:
        worst = max(found, key=lambda t: abs(t["turn"]))
        say(
            f"leadscrew: note: in {len(found)} place{'s' if len(found) > 1 else ''} the blade turns by more than the "
            f"corner angle within less than the blend while it cuts: most at X{worst['x']:.4g} Y{worst['y']:.4g} mm, "
            f"by {abs(worst['turn']):.0f} deg over {worst['length']:.2g} mm (stroke {worst['stroke']}); draw a sharp "
            "corner there, and the knife lifts"
        )
