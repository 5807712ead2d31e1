"""``leadscrew frequency-response``: gain, phase and coherence from a log, open or inside a closed loop."""

from __future__ import annotations

from typing import Annotated

import typer

from leadscrew.cli.options import Csv, From, Json, Level, Log, Plot, TimeColumn, To
from leadscrew.cli.output import deliver
from leadscrew.util.errors import DataError, ValueRefused


def frequency_response(
    log: Log,
    input_: Annotated[str, typer.Option("--input", metavar="COLUMN", help="From this signal.")] = "command",
    output: Annotated[str, typer.Option("--output", metavar="COLUMN", help="To this signal.")] = "feedback",
    excitation: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="What excites the loop from outside: right where noise circulates."),
    ] = None,
    loop_gain: Annotated[
        bool,
        typer.Option("--loop-gain", help="The gain of the broken loop, with margins: input is the command."),
    ] = False,
    method: Annotated[str, typer.Option(help="H1 (noise on the output) or H2 (noise on the input).")] = "H1",
    segment: Annotated[
        float | None, typer.Option(metavar="S", help="Length of a segment; an eighth of the log unless given.")
    ] = None,
    period: Annotated[
        float | None, typer.Option(metavar="S", help="The excitation repeats so: average its periods instead.")
    ] = None,
    low: Annotated[float | None, typer.Option(metavar="HZ", help="Leave out lower frequencies.")] = None,
    high: Annotated[float | None, typer.Option(metavar="HZ", help="Leave out higher ones.")] = None,
    level: Level = 0.95,
    time: TimeColumn = "time",
    start: From = None,
    end: To = None,
    plot: Plot = None,
    csv: Csv = None,
    as_json: Json = False,
) -> None:
    """Frequency response of an axis from one log, with coherence and confidence.

    From command to feedback it is the closed loop; with --loop-gain the broken loop, delays and all, and its margins.
    Inside a loop, say from output to feedback, name the --excitation (command or an injected disturbance): the direct
    estimate is biased there.
    """
    from leadscrew.analysis import frequency_response as analysis
    from leadscrew.analysis.harmonics.record import checked_level
    from leadscrew.cli.logs import part_of
    from leadscrew.report.frequency_response import report_of

    checked_level(level)
    if input_ == output:
        raise ValueRefused(f"--input and --output are both {output!r}: expected two signals")
    if loop_gain and excitation is not None:
        raise ValueRefused("--loop-gain takes the command as --input and needs no --excitation")
    if period is not None and segment is not None:
        raise ValueRefused("--period averages whole periods: leave out --segment")
    names = [input_, output] + ([excitation] if excitation is not None else [])
    t, read = part_of(log, time, names, start, end)
    x, y = read[input_], read[output]
    r = x if loop_gain else None if excitation is None else read[excitation]
    try:
        if period is not None:
            found = analysis.periodic_response(t, x - y if loop_gain else x, y, period, excitation=r)
        elif loop_gain:
            found = analysis.loop_gain(t, x - y, y, x, segment=segment)
        else:
            found = analysis.frequency_response(
                t, x, y, method=method, excitation=r, segment=segment  # type: ignore[arg-type]
            )  # fmt: skip
    except DataError as error:
        raise DataError(f"{log}: {error}") from None
    if low is not None or high is not None:
        found = found.within(low or 0.0, float("inf") if high is None else high)
    report = report_of(found, log, (input_, output), excitation, loop_gain, level)
    deliver(report, plot=plot, csv=csv, as_json=as_json)
