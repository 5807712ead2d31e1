"""``leadscrew positioning``: a measured positioning test, evaluated, drawn, and turned into a compensation table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.options import Example, Folder, Json
from leadscrew.cli.output import deliver, write_example
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import shell


def positioning(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A CSV file: target_mm, direction, run, deviation_um or position_mm.")
    ],
    out: Folder = None,
    compensation: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write LinuxCNC's screw-compensation table.")
    ] = None,
    kind: Annotated[
        int | None, typer.Option("--type", help="COMP_FILE_TYPE of the table: 0 positions (the default), 1 trims.")
    ] = None,
    unit: Annotated[str | None, typer.Option(help="LINEAR_UNITS of the machine: mm (the default) or inch.")] = None,
    example: Example = False,
    as_json: Json = False,
) -> None:
    """Accuracy and repeatability of an axis from measured positions, as in ISO 230-2.

    FILE has one line for each approach of a target: the target (target_mm), the direction of the approach (+ or -), the
    number of the run, and how far off it ended (deviation_um) or where (position_mm).
    """
    if example:
        if out is not None or compensation is not None or kind is not None or unit is not None or as_json:
            raise ValueRefused("--example only writes FILE; leave the other options for the evaluation of it")
        from leadscrew.analysis.positioning import example as content

        write_example(file, content(), "an example of a test", f"leadscrew positioning {shell(file)}")
        return
    if compensation is None and (kind is not None or unit is not None):
        given = "--type" if kind is not None else "--unit"
        raise ValueRefused(f"{given} is about the table that --compensation FILE writes")
    from leadscrew.analysis.positioning import read_positioning
    from leadscrew.export.screw_compensation import ini_lines, screw_compensation
    from leadscrew.report.positioning import report_of
    from leadscrew.report.report import File
    from leadscrew.util.atomic import atomic_write

    test = read_positioning(file)
    then, table = "", ""
    if compensation is not None:
        table = screw_compensation(test, kind or 0, unit or "mm")
        then = f"in the INI file of LinuxCNC:\n{ini_lines(compensation.name, kind or 0).rstrip()}"
    what = f"{len(test.targets_mm)} points of compensation"
    files = [File("compensation", compensation, what, lambda path: atomic_write(table, path))]
    deliver(report_of(test, str(file), files, then), out=out, as_json=as_json)
