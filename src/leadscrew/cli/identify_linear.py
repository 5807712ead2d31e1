"""``leadscrew identify linear``: a transfer function with delay from one log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli import pairs
from leadscrew.cli.output import Json, emit, print_table, progress
from leadscrew.escape import shell
from leadscrew.kernel.errors import ValueRefused


def linear(
    log: Annotated[
        Path,
        typer.Argument(
            metavar="LOG", help="CSV, TSV, Parquet, MATLAB, LinuxCNC halscope, or a folder of simulate --out."
        ),
    ],
    input_: Annotated[
        str | None, typer.Option("--input", metavar="COLUMN", help="What drives the plant; else the log's drive.")
    ] = None,
    output: Annotated[
        str | None, typer.Option("--output", metavar="COLUMN", help="What it answers; else the log's position.")
    ] = None,
    command: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="Of a closed loop: instrument against noise that goes round."),
    ] = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Times; else the log's time.")] = None,
    unit: Annotated[
        list[str] | None, typer.Option(metavar="COLUMN=UNIT", help="Unit of a column, over the file's own.")
    ] = None,
    period: Annotated[float | None, typer.Option(metavar="S", help="From row to row of a log without times.")] = None,
    start: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is earlier.")] = None,
    end: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is later.")] = None,
    order: Annotated[
        str | None,
        typer.Option(
            metavar="POLES[,ZEROS[,AT_0]]", help="Instead of a choice: 3,1,1 is 3 poles, 1 of them at 0, 1 zero."
        ),
    ] = None,
    max_order: Annotated[int, typer.Option(metavar="N", help="Most poles of a candidate.")] = 4,
    max_zeros: Annotated[int, typer.Option(metavar="N", help="Most zeros of a candidate.")] = 2,
    integrators: Annotated[str, typer.Option(metavar="N,N", help="Poles at 0 that are tried: of 0, 1, 2.")] = "0,1",
    delay: Annotated[float | None, typer.Option(metavar="S", help="Known delay; fitted unless given.")] = None,
    max_delay: Annotated[float | None, typer.Option(metavar="S", help="Longest delay; 20 samples.")] = None,
    holdout: Annotated[float, typer.Option(metavar="SHARE", help="Of the log, at its end, to judge by.")] = 0.5,
    margin: Annotated[
        float, typer.Option(metavar="SHARE", help="Error over the least one that buys a simpler model.")
    ] = 0.02,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Machine file: a name of a study.")
    ] = None,
    report: Annotated[Path | None, typer.Option(metavar="DIR", help="A folder: page, pictures, JSON.")] = None,
    as_json: Json = False,
) -> None:
    """Find a transfer function with delay; its order is chosen by simulating a part of the log it has not seen.

    The input is taken as held from sample to sample. Columns are named as in the file, with or without their unit.
    """
    from leadscrew.cli.door import say
    from leadscrew.cli.logs import numbers
    from leadscrew.cli.tune import free
    from leadscrew.identify.linear.fit import identify_linear
    from leadscrew.identify.linear.record import read_linear
    from leadscrew.report import identified_linear as words

    if out is not None and out.suffix != ".toml":
        raise ValueRefused(f"--out {out}: a machine file ends in .toml")
    free([out, report])
    structure = None if order is None else _structure(order)
    tried = tuple(_whole(x, "--integrators", integrators) for x in numbers(integrators, "--integrators"))
    units = pairs.texts("--unit", unit, "COLUMN=UNIT, as in time=ms")
    record = read_linear(log, input_, output, command, time=time, units=units, start=start, end=end, period=period)
    with progress() as tell:
        fit = identify_linear(
            record, structure=structure, max_order=max_order, max_zeros=max_zeros, integrators=tried, delay=delay,
            max_delay=max_delay, holdout=holdout, margin=margin, progress=tell,
        )  # fmt: skip
    if out is not None:
        from leadscrew.identify.linear import result
        from leadscrew.machine.file import write

        made = result.machine(fit, out.stem)
    if report is not None:
        words.write(fit, report)
    if out is not None:
        write(out, made)
    if as_json:
        emit({**words.summary(fit, str(log)), "report": report, "out": out})
        return
    for columns, rows in (
        (words.PARAMETER_COLUMNS, words.parameter_rows(fit)),
        (words.CANDIDATE_COLUMNS, words.candidate_rows(fit)),
        (words.STRETCH_COLUMNS, words.stretch_rows(fit)),
    ):
        print_table(columns, rows, right=[c for c in columns if c in words.NUMBERS])
        typer.echo("")
    for line in words.sentences(fit):
        typer.echo(line)
    for kind, lines in (("note", fit.notes), ("next", fit.advice)):
        for line in lines:
            say(f"leadscrew: {kind}: {line}")
    if report is not None:
        typer.echo(f"\nreport: {report / 'report.html'}")
    if out is not None:
        typer.echo(f"\n{out}: the machine; next: leadscrew simulate {shell(out)}")


def _structure(text: str) -> tuple[int, int, int]:
    from leadscrew.cli.logs import numbers

    given = [_whole(x, "--order", text) for x in numbers(text, "--order")]
    if not 1 <= len(given) <= 3:
        raise ValueRefused(f"--order {text}: expected POLES, POLES,ZEROS or POLES,ZEROS,AT_0, for example 3,1,1")
    poles, zeros, at_zero = (*given, 0, 0)[:3]
    return poles, zeros, at_zero


def _whole(value: float, option: str, text: str) -> int:
    if value != int(value):
        raise ValueRefused(f"{option} {text}: expected whole numbers with commas between them")
    return int(value)
