"""``leadscrew log FILE``: what a log holds, which column is what, and what is wrong with it, before any fit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.exit_codes import REFUSED
from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.cli.pairs import texts
from leadscrew.util.errors import DataError

if TYPE_CHECKING:
    from leadscrew.logs.axis_file import Seen
    from leadscrew.logs.finding import Finding
    from leadscrew.logs.table import Table

SCHEMA_VERSION = 1


def log(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="CSV, TSV, Parquet, MATLAB (.mat), LinuxCNC halscope or halsampler, or a folder of simulate --out.",
        ),
    ],
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ROLE=HEADER", help="Column of time, drive, position, command or velocity; guessed unless given."
        ),
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ROLE=UNIT", help="Unit of that column: mm, ms, V, '5e-8 m' for counts; over the file's own."
        ),
    ] = None,
    period: Annotated[
        float | None, typer.Option(metavar="S", help="Seconds from row to row, where the file has no times.")
    ] = None,
    start: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is before.")] = None,
    end: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is after.")] = None,
    force_per_drive: Annotated[
        float | None,
        typer.Option(metavar="N", help="N or N m for one unit of the drive; for the plausibility of units."),
    ] = None,
    lead: Annotated[
        float | None, typer.Option(metavar="MM", help="Travel of one screw revolution: a torque becomes a force.")
    ] = None,
    gear: Annotated[
        float, typer.Option(metavar="N", help="With --lead: motor revolutions for one of the screw.")
    ] = 1.0,
    as_json: Json = False,
) -> None:
    """Show what a log of an axis holds: columns, units, sampling, and what is wrong with it.

    Exit code 2 where the log is refused, 0 with warnings. The file is only read.
    """
    from leadscrew.logs import look_at, read_table
    from leadscrew.logs.finding import Finding
    from leadscrew.logs.roles import ROLES
    from leadscrew.logs.summary import as_dict

    roles = ", ".join(ROLES)
    told = texts("--column", column, f"ROLE=HEADER with a role of {roles}, for example position=qm")
    units = texts("--unit", unit, f"ROLE=UNIT with a role of {roles}, for example position=mm")
    with busy(f"reading {file}"):
        table = read_table(file)
        seen: Seen | None = None
        try:
            seen = look_at(file, told, units, start, end, force_per_drive, period, table, lead, gear)
            findings = seen.findings
        except DataError as error:
            # What the file holds is shown all the same: it tells which column to name.
            findings = [Finding("columns", "refused", str(error).removeprefix(f"{file}: "))]
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, **as_dict(table, seen), "findings": [f._asdict() for f in findings]})
    else:
        _print(file, table, seen, findings)
    if any(f.severity == "refused" for f in findings):
        raise typer.Exit(REFUSED)


def _print(file: Path, table: Table, seen: Seen | None, findings: Sequence[Finding]) -> None:
    from leadscrew.logs.summary import columns_of, sentences, table_rows

    typer.echo(f"{file}: {table.form}, {table.rows} rows")
    for note in table.notes:
        typer.echo(f"  {note}")
    typer.echo("")
    rows = table_rows(columns_of(table, None if seen is None else seen.columns))
    print_table(("column", "unit", "role", "from", "to", ""), rows, right=("from", "to"))
    if table.constants:
        typer.echo("")
        typer.echo("constants: " + ", ".join(f"{name} = {value:.8g}" for name, value in table.constants.items()))
    if seen is not None and seen.log is not None:
        typer.echo("")
        for line in sentences(seen):
            typer.echo(line)
    typer.echo("")
    for finding in sorted(findings, key=lambda f: ("refused", "warning", "note").index(f.severity)):
        typer.echo(f"{finding.severity}: {finding.sentence}")
    if not findings:
        typer.echo("nothing is wrong with it that shows in a log")
