"""``leadscrew bench``: how fast, beside others, on this machine."""

from __future__ import annotations

from importlib import import_module
from typing import Annotated

import typer

from leadscrew.cli.options import Json
from leadscrew.cli.output import deliver, progress
from leadscrew.figures.table import number
from leadscrew.report.report import Report, TextTable, head


def bench(
    quick: Annotated[bool, typer.Option("--quick", help="Fewer repetitions.")] = False,
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="PART", help="This part; may be repeated.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure the engines beside C, SciPy, python-control and PathSim, and the panel in a browser."""
    from leadscrew.kernel.parameters import nearest
    from leadscrew.util.errors import LeadscrewError, NameUnknown

    try:
        benches = import_module("leadscrew.bench")
    except ImportError as error:
        raise LeadscrewError(f"the benchmarks are not in this installation ({error})") from None
    for part in only or ():
        if part not in benches.PARTS:
            raise NameUnknown(f"--only {part!r}: the bench has no such part{nearest(part, list(benches.PARTS))}")
    with progress() as report:
        rows = benches.run(quick=quick, progress=report, parts=tuple(only) if only else benches.PARTS)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    cells = [["" if row.get(c) is None else number(row[c]) for c in columns] for row in rows]
    deliver(Report({**head("bench"), "rows": rows}, [TextTable(columns, cells)]), as_json=as_json)
