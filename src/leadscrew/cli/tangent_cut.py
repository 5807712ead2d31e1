"""``leadscrew tangent cut``: a program on a simulated cutter, and the line it cuts as a scanner would give it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.output import Json, emit, print_table, progress
from leadscrew.cli.tangent_axis import ClockwiseOfOthers, ZeroOfOthers
from leadscrew.cli.tangent_files import PROGRAMS, SCHEMA_VERSION, cut_program, is_program, spared, wanted, written
from leadscrew.kernel.errors import DataError, ValueRefused


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
    with progress() as report:
        found = machine.cut(
            program.strokes, program.settings, material, seed, lambda done: report(f"{file}: {material}", done)
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
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "material": material, "seed": seed, "out": out,
              "rms_error_deg": machine.rms(found), "strokes": rows, "marks": marks})  # fmt: skip
        return
    columns = ("stroke", "length / mm", "time / s", "error rms / deg", "max / deg", "cut off by / mm", "offset / deg")
    cells = [
        [str(r["stroke"]), f"{r['length_mm']:.1f}", f"{r['seconds']:.1f}", f"{r['rms_error_deg']:.2f}",
         f"{r['max_error_deg']:.2f}", f"{r['max_distance_mm']:.2f}", f"{r['max_offset_deg']:.2f}"]
        for r in rows
    ]  # fmt: skip
    print_table(columns, cells, right=columns)
    typer.echo(f"\n{out}: the line cut in {material}; error of its tangent {machine.rms(found):.2f} deg rms")
    for mark in marks:
        typer.echo("mark: --mark {:g},{:g}={:.4f},{:.4f}".format(*mark))


def _placed(text: str) -> tuple[float, float, float]:
    from math import isfinite

    try:
        dx, dy, deg = (float(part) for part in text.split(","))
    except ValueError:
        dx = dy = deg = float("nan")
    if not all(isfinite(v) and abs(v) <= 1e5 for v in (dx, dy, deg)):
        raise ValueRefused(f"--placed {text}: expected DX,DY,DEG, a shift in mm and a turn")
    return dx, dy, deg
