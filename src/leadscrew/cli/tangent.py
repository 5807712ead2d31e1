"""``leadscrew tangent``: from a drawing to a compensated G-code program; and nets that learn while they cut."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.options import Example, Json, Plot, ends
from leadscrew.cli.output import busy, deliver, free, note, progress, write_example
from leadscrew.cli.tangent_files import (
    PROGRAMS,
    Clockwise,
    Drawn,
    Unit,
    Zero,
    cut_program,
    drawing,
    is_program,
    program_row,
    program_table,
    spared,
    wanted,
    written,
)
from leadscrew.figures.table import fixed
from leadscrew.report.report import File, Report, TextTable, Verbatim, head
from leadscrew.tangent.settings import Settings
from leadscrew.util.errors import DataError, ValueRefused
from leadscrew.util.escape import shell

if TYPE_CHECKING:
    from leadscrew.neural.training import Trained
    from leadscrew.paths.curve import Array
    from leadscrew.tangent.settings import Settings
    from leadscrew.tangent.stroke import Stroke


ZeroOfOthers = Annotated[
    float | None,
    typer.Option(
        "--zero",
        metavar="DEG",
        help="Heading, counter-clockwise from +X, at which the axis reads 0: 0, or what a program of ours says.",
    ),
]
ClockwiseOfOthers = Annotated[
    bool | None,
    typer.Option("--clockwise/--counter-clockwise", help="How the axis counts; a program of ours says it."),
]


def cut(
    file: Annotated[Path, typer.Argument(metavar="FILE.ngc", help="A program with tangential words.")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE.csv", help="The cut line.")],
    material: Annotated[str, typer.Option("--material", "-m", help="fabric, leather or foam.")] = "fabric",
    seed: Annotated[int, typer.Option(help="Of the texture and of the scan's noise: another piece, another seed.")] = 1,
    noise: Annotated[float, typer.Option(metavar="MM", help="Of the scanned points, standard deviation.")] = 0.0,
    placed: Annotated[
        str | None, typer.Option(metavar="DX,DY,DEG", help="How the piece lay on the scanner, and two marks with it.")
    ] = None,
    zero: ZeroOfOthers = None,
    clockwise: ClockwiseOfOthers = None,
    as_json: Json = False,
) -> None:
    """Cut in simulation: a blade in flexible material, which springs back behind it.

    The material is a reconstruction, none was measured. With --noise or --placed the file has what a scan has: stroke,
    x_mm and y_mm.
    """
    from leadscrew.tangent import machine
    from leadscrew.tangent.machine import Scan, cut_csv, marks_of, scan_csv

    wanted(out, (".csv",), "a cut line")
    spared(out, [file])
    if not is_program(file):
        raise DataError(
            f"{file}: a program that is cut ends in {', '.join(PROGRAMS)}; leadscrew tangent gcode makes one"
        )
    if not 0.0 <= noise <= 10.0:
        raise ValueRefused(f"--noise {noise:g}: allowed range is 0 to 10 mm")
    if seed < 0:
        raise ValueRefused(f"--seed {seed}: expected 0 or more")
    lying = None if placed is None else _placed(placed)
    machine.material_of(material)
    program = cut_program(file, zero, clockwise)
    with progress() as bar:
        found = machine.cut(
            program.strokes, program.settings, material, seed, lambda done: bar(f"{file}: {material}", done)
        )
    scan = None if lying is None and not noise else Scan(noise, *(lying or (0.0, 0.0, 0.0)), seed)
    written(cut_csv(found) if scan is None else scan_csv(found, scan), out)
    marks = [] if scan is None or lying is None else marks_of(program.strokes, scan, program.settings.places())
    rows = [
        {"stroke": k, "length_mm": float(c.travel[-1]), "seconds": c.seconds, "rms_error_deg": machine.rms([c]),
         "max_error_deg": float(abs(c.error).max()), "max_distance_mm": float(c.distance.max()),
         "max_offset_deg": float(abs(c.offset).max())}
        for k, c in enumerate(found, start=1)
    ]  # fmt: skip
    cells = [
        [str(r["stroke"]), fixed(r["length_mm"], 1), fixed(r["seconds"], 1), fixed(r["rms_error_deg"], 2),
         fixed(r["max_error_deg"], 2), fixed(r["max_distance_mm"], 2), fixed(r["max_offset_deg"], 2)]
        for r in rows
    ]  # fmt: skip
    heads = ("stroke", "length (mm)", "time (s)", "error, rms (°)", "max (°)", "cut off by (mm)", "offset (°)")
    rms = machine.rms(found)
    report = Report(
        {**head("tangent cut"), "file": str(file), "material": material, "seed": seed, "rms_error_deg": rms,
         "strokes": rows, "marks": marks},
        parts=[
            TextTable(heads, cells, [True] * 7),
            *([Verbatim("mark: --mark {:g},{:g}={:.4f},{:.4f}".format(*mark) for mark in marks)] if marks else []),
        ],
        files=[File("out", out, f"the line cut in {material}; error of its tangent {rms:.2f}° rms")],
    )  # fmt: skip
    deliver(report, as_json=as_json)


def _placed(text: str) -> tuple[float, float, float]:
    from math import isfinite

    try:
        dx, dy, deg = (float(part) for part in text.split(","))
    except ValueError:
        dx = dy = deg = float("nan")
    if not all(isfinite(v) and abs(v) <= 1e5 for v in (dx, dy, deg)):
        raise ValueRefused(f"--placed {text}: expected DX,DY,DEG, a shift in mm and a turn")
    return dx, dy, deg


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
    plot: Plot = None,
    example: Example = False,
    as_json: Json = False,
) -> None:
    """Lines, lengths, corners, smallest radius, and how fast the blade has to turn.

    A stroke is what is cut between plunge and lift: a path is divided at its corners.
    """
    if example:
        _write_example(file, plot is not None or as_json or unit is not None)
        return
    from leadscrew.report.tangent import drawn_figure
    from leadscrew.tangent.stroke import strokes_of

    if plot is not None:
        spared(plot, [file], "--plot")
    settings = Settings(feed=feed, corner_angle=corner_angle, swivel=max_swivel_rate)
    with busy(str(file)):
        drawn = drawing(file, unit)
        strokes = strokes_of(drawn.paths, settings)
        rows = [program_row(s, settings, k) for k, s in enumerate(strokes, start=1)]
        corners = [c for p in drawn.paths for c in p.corners]
    lifted = [c for c in corners if settings.lifts(c.turn_deg)]
    length = sum(p.length for p in drawn.paths)
    slow = [r["stroke"] for r in rows if r["feed_limit_mm_min"] < feed]
    report = Report(
        {**head("tangent show"), "file": str(file), "unit": drawn.unit, "paths": len(drawn.paths), "length_mm": length,
         "feed_mm_min": feed, "swivel_deg_s": max_swivel_rate, "corners": [c._asdict() for c in corners],
         "lifted": len(lifted), "strokes": rows, "notes": list(drawn.notes)},
        parts=[
            f"{file}: {len(drawn.paths)} path{'s' if len(drawn.paths) != 1 else ''}, {fixed(length, 1)} mm, unit "
            f"{drawn.unit}; {len(corners)} corners, of which {len(lifted)} above {corner_angle:g}°: "
            f"{len(strokes)} stroke{'s' if len(strokes) != 1 else ''}",
            program_table(rows),
        ],
        verdict=f"at F{feed:g} the blade is too slow in stroke {', '.join(map(str, slow[:8]))}"
        f"{', ...' if len(slow) > 8 else ''}: gcode lowers the feed there" if slow else "",
        figure=lambda: drawn_figure(strokes, settings),
    )  # fmt: skip
    deliver(report, plot=plot, as_json=as_json)


def _write_example(file: Path, more: bool) -> None:
    from leadscrew.tangent.example import FILE

    wanted(file, (".svg",), "the example drawing")
    if more:
        raise ValueRefused("--example only writes DRAWING; leave the other options for the show of it")
    write_example(file, FILE.read_bytes(), "an example", f"leadscrew tangent show {shell(file)}")


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
    from leadscrew._version import __version__
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
    found: dict[str, Any] = {
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
    what = (
        f"{len(strokes)} stroke{'s' if len(strokes) != 1 else ''}, {found['length_mm']:.1f} mm in {len(moves)} moves "
        f"({found['arcs']} arcs), {found['seconds']:.1f} s of cutting"
    )
    lowered = f"feed lowered to F{slowest:.0f} where the blade turns at {max_swivel_rate:g}°/s"
    report = Report(
        {**head("tangent gcode"), "file": str(file), **found, "notes": _tight(found["tight"])},
        parts=[
            f"{settings.axis} from {fixed(min(words), 1)} to {fixed(max(words), 1)}°",
            *([lowered] if slowest < feed else []),
        ],
        notes=_tight(found["tight"]),
        files=[File("out", out, what)],
    )  # fmt: skip
    deliver(report, as_json=as_json)


def _tight(found: list[dict[str, float]]) -> list[str]:
    """The places where the blade turns sharply while it cuts."""
    if not found:
        return []
    worst = max(found, key=lambda t: abs(t["turn"]))
    return [
        f"in {len(found)} place{'s' if len(found) > 1 else ''} the blade turns by more than the corner angle within "
        f"less than the blend while it cuts: most at X{worst['x']:.4g} Y{worst['y']:.4g} mm, by "
        f"{abs(worst['turn']):.0f}° over {worst['length']:.2g} mm (stroke {worst['stroke']}); draw a sharp corner "
        "there, and the knife lifts"
    ]


def train(
    table: Annotated[
        Path | None,
        typer.Option(
            "--table", metavar="FILE.csv", help="13 x 13 levels, rows EC, columns E; the paper's unless given."
        ),
    ] = None,
    hidden: Annotated[int, typer.Option(metavar="N", help="Hidden neurons.")] = 6,
    biases: Annotated[str, typer.Option(help="none, output, hidden or all.")] = "none",
    linear: Annotated[bool, typer.Option("--linear", help="A linear output in place of 6 tanh.")] = False,
    method: Annotated[str, typer.Option(help="ga, ga+polish, cma, cma+polish, pymoo or pymoo+polish.")] = "ga+polish",
    seed: Annotated[int, typer.Option(help="Of the search.")] = 0,
    population: Annotated[int, typer.Option(metavar="N", help="Networks in a generation.")] = 80,
    generations: Annotated[int, typer.Option(metavar="N", help="Of the search.")] = 600,
    tries: Annotated[int, typer.Option(metavar="N", help="Searches before training gives up.")] = 8,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE.json",
            help="File of the network.",
            callback=ends("--out", "the file of a network", ".json"),
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Train the network that corrects a self-organising controller, and check that it cannot run away.

    A network that would drive the loop the wrong way is not written: exit code 2. One that goes the right way and knows
    the table less well than asked is written with a note: exit code 1.
    """
    from leadscrew.neural.performance import TABLE, Shape, read_table, write_net
    from leadscrew.neural.training import train as trained

    wanted = TABLE if table is None else read_table(table)
    shape = Shape(hidden, biases, linear)  # type: ignore[arg-type]
    free([out])
    with progress() as bar:
        searches = 0

        def report(done: int, total: int) -> None:
            nonlocal searches
            searches += done == 1
            bar(f"{shape.name}: search {searches}", done / total)

        found = trained(wanted, shape, method, seed, population, generations, tries, report)  # type: ignore[arg-type]
    name = "Table 1 of the paper" if table is None else str(table)

    def write(path: Path) -> None:
        write_net(found.net, path.resolve() if path.is_symlink() else path, {"table": name, **found.as_dict()})

    deliver(_trained(found, name, [File("file", out, "the network", write)]), as_json=as_json)


def _trained(found: Trained, name: str, files: list[File]) -> Report:
    from leadscrew.neural.safety import NEAR, ORIGIN, WORST_RMSE

    safe = found.safety
    searches = f"{found.tries} search{'es' if found.tries > 1 else ''}"
    low, high = safe.slope_range
    rows = [
        ("RMSE, levels", fixed(safe.rmse, 3), f"{WORST_RMSE:g} or less"),
        ("largest difference, levels", fixed(safe.largest, 2), ""),
        ("cells exact, rounded", f"{100.0 * safe.exact:.0f} %", ""),
        ("cells within one level", f"{100.0 * safe.within_one:.0f} %", ""),
        ("P(0, 0), levels", fixed(safe.origin, 3), f"below {ORIGIN:g} in size"),
        ("slope dP/dE at the origin", fixed(safe.slope, 2), f"{low:g} to {high:g}"),
        (f"largest P sign(E), |E| to {NEAR:g}", fixed(safe.wrong_way, 4), "below 0"),
    ]
    return Report(
        {**head("tangent train"), "table": name, **found.as_dict(), "net": found.net._asdict()},
        parts=[
            f"{name}: {found.shape.name}, {found.shape.weights} weights",
            f"{found.method}, seed {found.seed}, {searches} in {found.wall_s:.1f} s",
            TextTable(["of the network", "value", "required"], rows, [False, True, False]),
        ],
        notes=found.notes,
        files=files,
        code=0 if safe.accepted else MISSED,
    )


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
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Write the program of the next piece: tangential words with the offsets that the last piece asked for.

    The program that was cut tells its offsets itself, so pieces follow each other: cut, measure, compensate.
    """
    from leadscrew._version import __version__
    from leadscrew.report.tangent import learned_figure
    from leadscrew.tangent.compensate import Learning, compensated
    from leadscrew.tangent.emit import program
    from leadscrew.tangent.measurement import read_measured

    wanted(out, PROGRAMS, "a program")
    spared(out, [file, measured, after])
    if plot is not None:
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
    written(text, out)
    rows = [
        {"stroke": k.number, "length_mm": k.stroke.length, "before_rms_deg": _rms(k.before),
         "predicted_rms_deg": _rms(k.predicted), "largest_offset_deg": float(abs(k.new).max()),
         "clipped_mm": k.clipped_mm, "cutoff_mm": k.seen.cutoff, "noise_mm": k.seen.noise,
         "spacing_mm": k.seen.spacing, "measured_length_mm": k.seen.length}
        for k in found.learned
    ]  # fmt: skip
    cells = [
        [str(r["stroke"]), fixed(r["length_mm"], 1), fixed(r["before_rms_deg"], 2), fixed(r["predicted_rms_deg"], 2),
         fixed(r["largest_offset_deg"], 2), fixed(r["clipped_mm"], 1), fixed(r["cutoff_mm"] or None, 1)]
        for r in rows
    ]  # fmt: skip
    heads = ("stroke", "length (mm)", "error, rms (°)", "predicted (°)", "offset (°)", "clipped (mm)", "cut-off (mm)")
    p = found.placing
    turned = f"the piece lay turned by {-p.turn_deg:.2f}°; brought back to the programmed line"
    result = Report(
        {**head("tangent compensate"), "file": str(file), "measured": str(measured), "before_rms_deg": found.rms(),
         "predicted_rms_deg": found.rms(True), "largest_offset_deg": found.largest, "placing": p._asdict(),
         "strokes": rows, "notes": found.notes},
        parts=[TextTable(heads, cells, [True] * 7), *([turned] if p.turn_deg or p.dx or p.dy else [])],
        notes=found.notes,
        files=[File("out", out, f"the next piece; the last was {found.rms():.2f}° off (rms), what comes again of it "
                                f"leaves {found.rms(True):.2f}°")],
        figure=lambda: learned_figure(found),
    )  # fmt: skip
    deliver(result, plot=plot, as_json=as_json)


def _cut(
    file: Path, after: Path | None, unit: str | None, zero: float | None, clockwise: bool | None
) -> tuple[Settings, list[Stroke]]:
    """Settings and strokes of the piece that was cut."""
    from dataclasses import replace

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
            note(f"{file}: {change}")
        if not cut.ours:
            return cut.settings, cut.strokes
        return cut.settings, [replace(s, feeds=None) for s in cut.strokes]
    before = None if after is None else cut_program(after, zero, clockwise)
    if before is not None and (before.passed or before.lost):
        lost = "; ".join([*before.passed, *before.lost][:4])
        note(f"the new program is made of {file} and does not have what {after} has: {lost}")
    settings = Settings() if before is None else before.settings
    strokes = strokes_of(drawing(file, unit).paths, settings)
    if before is None:
        if zero is not None or clockwise is not None:
            raise ValueRefused("--zero and --clockwise are about a program that was cut: give it with --after")
        note(f"{file}: taken as cut by what gcode makes of it without options; else give --after")
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


app = typer.Typer(
    help="Cut with a tangential knife: drawings to G-code, and compensated G-code from a measured piece.",
    no_args_is_help=True,
)
app.command("show")(show)
app.command("gcode")(gcode)
app.command("cut")(cut)
app.command("compensate")(compensate)
app.command("train")(train)
