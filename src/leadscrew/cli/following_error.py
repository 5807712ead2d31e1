"""``leadscrew following-error``: following error and lag of logged axes, by axis and by phase of the process."""

from __future__ import annotations

from typing import Annotated

import typer

from leadscrew.cli.options import Csv, End, Folder, Json, Plot, Start
from leadscrew.cli.output import busy, deliver, free


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
    start: Start = None,
    end: End = None,
    each: Annotated[bool, typer.Option("--each", help="Also a row for every log and axis.")] = False,
    out: Folder = None,
    csv: Csv = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Following error (max, rms, mean by direction) and lag with 95 % intervals, of all logs together and of each.

    Says what is odd about the logs: rows out of order, rounding, counters that wrap, torn, frozen and double rows.
    """
    from leadscrew.analysis.following import following, pair_of, read_logs
    from leadscrew.cli.pairs import texts
    from leadscrew.kernel import validate
    from leadscrew.report.following import report_of

    if period is not None:
        validate.positive("--period", period, "s")
    pairs = dict(pair_of(text) for text in pair or [])
    units = texts("--unit", unit, "ROLE=UNIT, as in time=ms")
    free([out, csv, plot])
    with busy("following error"):
        read = read_logs(logs, period=period, time=time, by=by, pairs=pairs, units=units, start=start, end=end)
        found = following(read)
    deliver(report_of(found, each), out=out, plot=plot, csv=csv, as_json=as_json)
