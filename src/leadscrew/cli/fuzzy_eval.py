"""``leadscrew fuzzy eval``: a system at a point, with the rules that say so, or at the points of a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.fuzzy_files import (
    SCHEMA_VERSION,
    File,
    LeaveOut,
    known,
    numbers,
    suffix_of,
    system_of,
)
from leadscrew.cli.fuzzy_tables import save_table, table_of, text_table
from leadscrew.cli.output import Json, busy, emit
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.fuzzy.system import System


def eval_(
    file: File,
    values: Annotated[
        list[str] | None, typer.Argument(metavar="INPUT=VALUE", help="A value for every input: e=0.1 de=-0.2.")
    ] = None,
    explain: Annotated[bool, typer.Option("--explain", help="Also say which rules fire and what each does.")] = False,
    points: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A .csv or .parquet whose columns are the inputs.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Where to write the table: .csv or .parquet.")
    ] = None,
    engine: Annotated[str, typer.Option(help="llvm, c or python.")] = "llvm",
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Evaluate a system at a point, or at all points of a file."""
    from leadscrew.kernel.engines import ENGINES

    known(engine, ENGINES, "engine")
    if points is None:
        if out is not None:
            raise ValueRefused(f"--out {out}: a table comes from --points FILE only")
        _at_point(file, system_of(file, leave_out_unknown), values or [], explain, engine, as_json)
        return
    if values or explain:
        raise ValueRefused("--points takes its values from a file: no INPUT=VALUE and no --explain")
    if out is not None:
        suffix_of(out, (".csv", ".parquet"), "--out")
    _at_points(file, system_of(file, leave_out_unknown), points, out, engine, as_json)


def _at_point(file: Path, system: System, values: list[str], explain: bool, engine: str, as_json: bool) -> None:
    from leadscrew.fuzzy.evaluate import compiled
    from leadscrew.fuzzy.explanation import explain as explained

    inputs = numbers(values, "")
    with busy(f"{system.name} on {engine}"):
        outputs = compiled(system, engine)(**inputs)
    why = explained(system, inputs) if explain else None
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "engine": engine,
              "inputs": inputs, "outputs": outputs, "units": {o.name: o.unit for o in system.outputs},
              "explanation": None if why is None else why.as_dict()})  # fmt: skip
        return
    if why is not None:
        typer.echo(str(why))
        return
    for output in system.outputs:
        typer.echo(f"{output.name} = {outputs[output.name]!r} {output.unit}".rstrip())


def _at_points(file: Path, system: System, points: Path, out: Path | None, engine: str, as_json: bool) -> None:
    import numpy as np

    from leadscrew.fuzzy.evaluate import compiled

    names = [v.name for v in system.inputs]
    with busy(f"{points}: {system.name} on {engine}"):
        given = table_of(points, names)
        x = np.column_stack([given[n] for n in names])
        y = compiled(system, engine).many(x).reshape(len(x), -1)
        outputs = [o.name for o in system.outputs]
        if out is not None:
            save_table([*names, *outputs], np.column_stack([x, y]), out)
    if as_json:
        found = {n: y[:, i] for i, n in enumerate(outputs)} if out is None else None
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "engine": engine,
              "points": len(x), "out": None if out is None else str(out), "outputs": found})  # fmt: skip
    elif out is None:
        typer.echo(text_table([*names, *outputs], np.column_stack([x, y])), nl=False)
    else:
        typer.echo(f"{out}: {len(x)} points, {', '.join(outputs)}")
