"""``leadscrew harmonics``: amplitudes of a motion's harmonics and of spindle lines in a logged signal."""

from __future__ import annotations

from typing import Annotated

import typer

from leadscrew.cli.options import Csv, From, Json, Level, Log, Plot, TimeColumn, To
from leadscrew.cli.output import deliver
from leadscrew.util.errors import DataError, ValueRefused


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
    time: TimeColumn = "time",
    start: From = None,
    end: To = None,
    plot: Plot = None,
    csv: Csv = None,
    as_json: Json = False,
) -> None:
    """Amplitudes of lines in a logged signal by least squares, with confidence intervals; an FFT for comparison.

    Unlike an FFT it needs no whole number of periods and no window. Name every strong line: what is in the model does
    not leak into the rest.
    """
    from leadscrew.analysis.harmonics.measured import measure
    from leadscrew.analysis.harmonics.record import checked_level
    from leadscrew.cli.logs import numbers, part_of
    from leadscrew.report.harmonics import report_of

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
    deliver(report_of(found, log, signal, unit, level), plot=plot, csv=csv, as_json=as_json)
