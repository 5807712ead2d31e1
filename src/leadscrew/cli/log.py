"""``leadscrew log FILE``: what a log holds, which column is what, and what is wrong with it, before any fit."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.options import Columns, End, Gear, Json, Lead, Period, Start, Units
from leadscrew.cli.output import busy, deliver
from leadscrew.cli.pairs import texts
from leadscrew.util.errors import DataError

if TYPE_CHECKING:
    from leadscrew.logs.axis_file import Seen


def log(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="CSV, TSV, Parquet, MATLAB (.mat), LinuxCNC halscope or halsampler, or a folder of simulate --out.",
        ),
    ],
    column: Columns = None,
    unit: Units = None,
    period: Period = None,
    start: Start = None,
    end: End = None,
    force_per_drive: Annotated[
        float | None,
        typer.Option(metavar="N", help="N or N m for one unit of the drive; for the plausibility of units."),
    ] = None,
    lead: Lead = None,
    gear: Gear = 1.0,
    as_json: Json = False,
) -> None:
    """Show what a log of an axis holds: columns, units, sampling, and what is wrong with it.

    Exit code 2 where the log is refused, 0 with warnings. The file is only read.
    """
    from leadscrew.logs import look_at, read_table
    from leadscrew.logs.finding import Finding
    from leadscrew.logs.roles import ROLES
    from leadscrew.report.log import report_of

    roles = ", ".join(ROLES)
    columns = texts("--column", column, f"ROLE=HEADER with a role of {roles}, for example position=qm")
    units = texts("--unit", unit, f"ROLE=UNIT with a role of {roles}, for example position=mm")
    with busy(f"reading {file}"):
        table = read_table(file)
        seen: Seen | None = None
        try:
            seen = look_at(file, columns, units, start, end, force_per_drive, period, table, lead, gear)
            findings = seen.findings
        except DataError as error:
            # What the file holds is shown all the same: it tells which column to name.
            findings = [Finding("columns", "refused", str(error).removeprefix(f"{file}: "))]
    deliver(report_of(file, table, seen, findings), as_json=as_json)
