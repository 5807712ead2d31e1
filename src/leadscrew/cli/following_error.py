"""``leadscrew following-error``: following error and lag of logged axes, by axis and by phase of the process."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.output import Json, busy, emit, print_table


def following_error(
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG...", help="Files, folders of logs, or patterns with *: CSV, Parquet, MATLAB, a run."
        ),
    ],
    period: Annotated[
        float | None, typer.Option(metavar="S", help="Seconds from row to row, where the logs have no column of times.")
    ] = None,
    by: Annotated[str | None, typer.Option(metavar="COLUMN", help="Column that names the phase of each row.")] = None,
    pair: Annotated[
        list[str] | None,
        typer.Option(metavar="AXIS=COMMAND,ACTUAL", help="Columns of an axis, where their names do not say it."),
    ] = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Times of the rows.")] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option(metavar="ROLE=UNIT", help="Of time, position (or command, actual), velocity, over the headers'."),
    ] = None,
    start: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is before.")] = None,
    end: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is after.")] = None,
    each: Annotated[bool, typer.Option("--each", help="Also a row for every log and axis.")] = False,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="DIR", help="A folder for the report.")] = None,
    csv: Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="Also write all rows there.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Also draw it: .png, .svg or .pdf.")] = None,
    as_json: Json = False,
) -> None:
    """Following error (max, rms, mean by direction) and lag with 95 % intervals, of all logs together and of each.

    Says what is odd about the logs: rows out of order, rounding, counters that wrap, torn, frozen and double rows.
    """
    from leadscrew.analysis.following import following, pair_of, read_logs
    from leadscrew.cli.fuzzy_files import PICTURES, save_figure, suffix_of
    from leadscrew.cli.pairs import texts
    from leadscrew.cli.tune import free
    from leadscrew.kernel import validate
    from leadscrew.report import following as report
    from leadscrew.report.following import picture

    if period is not None:
        validate.positive("--period", period, "s")
    if plot is not None:
        suffix_of(plot, PICTURES, "--plot")
    if csv is not None:
        suffix_of(csv, (".csv",), "--csv")
    pairs = dict(pair_of(text) for text in pair or [])
    units = texts("--unit", unit, "ROLE=UNIT, as in time=ms")
    free([out, csv, plot])
    with busy("following error"):
        read = read_logs(logs, period=period, time=time, by=by, pairs=pairs, units=units, start=start, end=end)
        found = following(read)
        if out is not None:
            report.write(found, out, picture(found))
        if plot is not None:
            save_figure(picture(found), plot)
        if csv is not None:
            from leadscrew.util.atomic import atomic_write

            atomic_write(report.csv_text(found), csv)
    if as_json:
        written = {"report": out, "csv": csv, "plot": plot}
        emit({**report.summary(found), **{k: None if p is None else str(p) for k, p in written.items()}})
        return
    print_table(report.columns_of(found), report.phase_rows(found), right=report.NUMBERS)
    typer.echo("")
    if each:
        print_table(report.columns_of(found, "log"), report.log_rows(found), right=report.NUMBERS)
        typer.echo("")
    for line in [*report.odd(found), *report.sentences(found)]:
        typer.echo(line)
    for path, what in ((out, "the report"), (csv, "all rows"), (plot, "the picture")):
        if path is not None:
            typer.echo(f"\n{path}: {what}")
