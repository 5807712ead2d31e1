"""``leadscrew positioning``: a measured positioning test, evaluated, drawn, and turned into a compensation table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from leadscrew.cli.output import Json, emit
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import shell


def positioning(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A CSV file: target_mm, direction, run, deviation_um or position_mm.")
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="A folder for the report: page, picture, JSON.")
    ] = None,
    compensation: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write LinuxCNC's screw-compensation table.")
    ] = None,
    kind: Annotated[
        int | None, typer.Option("--type", help="COMP_FILE_TYPE of the table: 0 positions (the default), 1 trims.")
    ] = None,
    unit: Annotated[str | None, typer.Option(help="LINEAR_UNITS of the machine: mm (the default) or inch.")] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Write a made test to FILE instead, to see what a file looks like.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Accuracy and repeatability of an axis from measured positions, as in ISO 230-2.

    FILE has one line for each approach of a target: the target (target_mm), the direction of the approach (+ or -), the
    number of the run, and how far off it ended (deviation_um) or where (position_mm).
    """
    if example:
        if out is not None or compensation is not None or kind is not None or unit is not None or as_json:
            raise ValueRefused("--example only writes FILE; leave the other options for the evaluation of it")
        _write_example(file)
        return
    if compensation is None and (kind is not None or unit is not None):
        given = "--type" if kind is not None else "--unit"
        raise ValueRefused(f"{given} is about the table that --compensation FILE writes")
    from leadscrew.analysis.positioning import read_positioning
    from leadscrew.export.screw_compensation import screw_compensation
    from leadscrew.report import positioning as report
    from leadscrew.util.atomic import atomic_write

    test = read_positioning(file)
    table = None if compensation is None else screw_compensation(test, kind or 0, unit or "mm")
    if out is not None:
        report.write(test, file.name, out)
    if compensation is not None and table is not None:
        atomic_write(table, compensation)
    if as_json:
        written = {"report": out, "compensation": compensation}
        emit({**report.summary(test, str(file)), **written})
        return
    _show(test, report)
    if out is not None:
        typer.echo(f"\nreport: {out / 'report.html'}")
    if compensation is not None:
        from leadscrew.export.screw_compensation import ini_lines

        typer.echo(f"\n{compensation}: {len(test.targets_mm)} points; in the INI file of LinuxCNC")
        typer.echo(ini_lines(compensation.name, kind or 0).rstrip())


def _show(test: Any, report: Any) -> None:
    from leadscrew.cli.exit_codes import say
    from leadscrew.cli.output import print_table

    print_table(report.TARGET_COLUMNS, report.target_rows(test), right=report.TARGET_COLUMNS)
    typer.echo("")
    print_table(report.RESULT_COLUMNS, report.result_rows(test), right=report.RESULT_COLUMNS[2:5])
    typer.echo("")
    for line in report.sentences(test):
        typer.echo(line)
    for note in test.notes():
        say(f"leadscrew: note: {note}")


def _write_example(file: Path) -> None:
    from leadscrew.analysis.positioning import example
    from leadscrew.util.atomic import atomic_write
    from leadscrew.util.errors import DataError

    if file.exists():
        raise DataError(f"{file} exists already; --example overwrites nothing")
    atomic_write(example(), file)
    typer.echo(f"{file}: a made test; next: leadscrew positioning {shell(file)}")
