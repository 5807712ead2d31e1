"""``leadscrew harmonics``: amplitudes of a motion's harmonics and of spindle lines in a logged signal."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.output import Json, emit, print_table
from leadscrew.util.errors import DataError, ValueRefused

Log = Annotated[
    Path, typer.Argument(metavar="LOG", help="CSV, Parquet, or a folder of simulate --out; evenly sampled.")
]
Time = Annotated[str, typer.Option(metavar="COLUMN", help="Times; in s unless the header names a unit.")]
Start = Annotated[float | None, typer.Option("--from", metavar="S", help="Leave out what comes before.")]
End = Annotated[float | None, typer.Option("--to", metavar="S", help="Leave out what comes after.")]
Plot = Annotated[Path | None, typer.Option(metavar="FILE", help="Also draw it: .png, .svg or .pdf.")]
Table = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="Also write all rows there.")]
Level = Annotated[float, typer.Option(metavar="P", help="Level of the confidence intervals.")]


def harmonics(
    log: Log,
    signal: Annotated[str, typer.Option(metavar="COLUMN", help="What is looked at.")] = "error",
    base: Annotated[float | None, typer.Option(metavar="HZ", help="Frequency of the motion.")] = None,
    orders: Annotated[str | None, typer.Option(metavar="N,N,..", help="Its harmonics; 1 is always measured.")] = None,
    lines: Annotated[str | None, typer.Option(metavar="HZ,HZ,..", help="Other lines.")] = None,
    fit_base: Annotated[bool, typer.Option("--fit-base", help="Fit the motion's frequency.")] = False,
    within: Annotated[float, typer.Option(metavar="SHARE", help="How far --fit-base looks to both sides.")] = 0.05,
    spindle: Annotated[float | None, typer.Option(metavar="RPM", help="Spindle speed, 1/min.")] = None,
    teeth: Annotated[int, typer.Option(metavar="N", help="Teeth of the cutter.")] = 1,
    fit_spindle: Annotated[bool, typer.Option("--fit-spindle", help="Fit the spindle's speed within 2 %.")] = False,
    scale: Annotated[float, typer.Option(metavar="X", help="Multiplies the signal, as 1000 for um of mm.")] = 1.0,
    unit: Annotated[str, typer.Option(metavar="TEXT", help="Of the scaled signal, for headings.")] = "",
    window: Annotated[str, typer.Option(help="Of the FFT beside: rectangular, hann or flattop.")] = "hann",
    level: Level = 0.95,
    time: Time = "time",
    start: Start = None,
    end: End = None,
    plot: Plot = None,
    csv: Table = None,
    as_json: Json = False,
) -> None:
    """Amplitudes of lines in a logged signal by least squares, with confidence intervals; an FFT for comparison.

    Unlike an FFT it needs no whole number of periods and no window. Name every strong line: what is in the model does
    not leak into the rest.
    """
    from leadscrew.analysis.harmonics.measured import measure
    from leadscrew.analysis.harmonics.record import checked_level
    from leadscrew.cli.exit_codes import say
    from leadscrew.cli.fuzzy_files import PICTURES, save_figure, suffix_of
    from leadscrew.cli.logs import numbers, part_of
    from leadscrew.report import harmonics as report

    if plot is not None:
        suffix_of(plot, PICTURES, "--plot")
    if csv is not None:
        suffix_of(csv, (".csv",), "--csv")
    checked_level(level)
    if not abs(scale) < float("inf") or scale == 0.0:
        raise ValueRefused(f"--scale {scale!r}: expected a finite number that is not 0")
    asked, more = numbers(orders, "--orders"), numbers(lines, "--lines")
    t, read = part_of(log, time, [signal], start, end)
    try:
        found = measure(
            t, scale * read[signal], base=base, orders=asked, lines=more, fit_base=fit_base, within=within,
            spindle_rpm=spindle, teeth=teeth, fit_spindle=fit_spindle, window=window,  # type: ignore[arg-type]
        )  # fmt: skip
    except DataError as error:
        raise DataError(f"{log}, {signal}: {error}") from None
    if plot is not None:
        save_figure(report.picture(found, f"{log.name}: {signal}", unit, level), plot)
    if csv is not None:
        from leadscrew.util.atomic import atomic_write

        rows = [
            ",".join(report.columns(found, unit, level)).replace(", ", " "),
            *map(",".join, report.rows(found, level)),
        ]
        atomic_write("\n".join(rows) + "\n", csv)
    if as_json:
        written = {"plot": None if plot is None else str(plot), "csv": None if csv is None else str(csv)}
        emit({**report.summary(found, str(log), signal, unit, level), **written})
        return
    heads = report.columns(found, unit, level)
    print_table(heads, report.rows(found, level), right=heads[1:])
    typer.echo("")
    for line in report.sentences(found, unit, level):
        typer.echo(line)
    for note in found.notes:
        say(f"leadscrew: note: {note}")
    for path, what in ((plot, "the spectrum with its lines"), (csv, "the table")):
        if path is not None:
            typer.echo(f"\n{path}: {what}")
