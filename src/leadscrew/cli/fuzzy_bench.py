"""``leadscrew fuzzy bench``: how fast a system is evaluated on this machine."""

from __future__ import annotations

from importlib import import_module
from typing import Annotated, Any

import typer

from leadscrew.cli.fuzzy_files import SCHEMA_VERSION, File, LeaveOut, system_of
from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.kernel.errors import LeadscrewError, ValueRefused

COLUMNS = ("name", "what", "value", "unit", "ratio", "remark")


def bench(
    file: File,
    points: Annotated[int, typer.Option(metavar="N", help="How many points are evaluated.")] = 100_000,
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Measure how fast a system is evaluated, on every engine and beside other programs."""
    if not 1 <= points <= 100_000_000:
        raise ValueRefused(f"--points {points}: allowed are 1 to 100000000")
    system = system_of(file, leave_out_unknown)
    try:
        measure = import_module("leadscrew.bench.fuzzy_file").bench_file
    except ImportError as error:
        raise LeadscrewError(f"the benchmarks are not in this installation ({error})") from None
    with busy(f"{system.name}, {points} points"):
        rows: list[dict[str, Any]] = measure(system, points)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "points": points,
              "rows": rows})  # fmt: skip
        return
    print_table(COLUMNS, [[_cell(row.get(c)) for c in COLUMNS] for row in rows], right=("value", "ratio"))


def _cell(value: Any) -> str:
    from leadscrew.report.tables import number

    return "" if value is None or value == "" else number(value)
