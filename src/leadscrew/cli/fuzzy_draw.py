"""``leadscrew fuzzy surface`` and ``activity``: an output over two inputs; the rules along a recorded run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.fuzzy_files import (
    PICTURES,
    SCHEMA_VERSION,
    File,
    LeaveOut,
    known,
    numbers,
    save_figure,
    suffix_of,
    system_of,
)
from leadscrew.cli.fuzzy_run import RunInputs, recorded_inputs
from leadscrew.cli.fuzzy_tables import save_table
from leadscrew.cli.output import Json, busy, emit, print_table

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.fuzzy.explanation import Use
    from leadscrew.fuzzy.system import System


def surface(
    file: File,
    out: Annotated[
        Path,
        typer.Option("--out", "-o", metavar="FILE", help="A picture (.png, .svg, .pdf) or the table (.csv, .fld)."),
    ],
    x: Annotated[str | None, typer.Option(metavar="INPUT", help="The first input unless given.")] = None,
    y: Annotated[str | None, typer.Option(metavar="INPUT", help="The next input unless given.")] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="INPUT=VALUE", help="Holds an input that is not drawn; the middle unless given."),
    ] = None,
    output: Annotated[str | None, typer.Option(help="What a picture shows; the first output unless given.")] = None,
    points: Annotated[int, typer.Option(metavar="N", help="Points along each input.")] = 101,
    kind: Annotated[str, typer.Option(help="Of a picture: map, 3d or both.")] = "both",
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Draw or tabulate the outputs over the universes of two inputs, or of the only one."""
    from leadscrew.report import fuzzy as pictures

    suffix = suffix_of(out, (*PICTURES, ".csv", ".fld"), "--out")
    system = system_of(file, leave_out_unknown)
    if output is not None:
        known(output, [o.name for o in system.outputs], "output")
    with busy(f"{system.name}, {points} points an input"):
        made = pictures.surface(system, x, y, numbers(at or [], "--at"), points)
        if suffix in PICTURES:
            save_figure(pictures.surface_figure(made, output=output, kind=kind), out)
        else:
            save_table(*made.rows(), out)
    drawn = [v.name for v in (made.x, made.y) if v is not None]
    gaps = int((made.output(output)[1] != made.output(output)[1]).sum())
    size = made.values[..., 0].size
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "out": str(out),
              "inputs": drawn, "held": made.held, "output": made.output(output)[0].name, "points": size,
              "without_value": gaps})  # fmt: skip
        return
    held = "".join(f", {n} = {v:g}" for n, v in made.held.items())
    typer.echo(f"{out}: {made.output(output)[0].name} over {' and '.join(drawn)}{held}; {size} points")
    if gaps:
        typer.echo(f"{gaps} of {size} points have no value")


def activity(
    file: File,
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="A recorded run: .csv, .parquet, or a folder of leadscrew simulate --out."),
    ],
    maps: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="INPUT=COLUMN",
            help="Where an input comes from; a column of its own name unless given. Also INPUT=SCALE*COLUMN, "
            "and change(COLUMN), the difference to the row before, or rate(COLUMN), that over time.",
        ),
    ] = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Seconds; the column 'time' if there is one.")] = (
        None
    ),
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="A picture (.png, .svg, .pdf) or the strengths (.csv)."),
    ] = None,
    leave_out_unknown: LeaveOut = False,
    as_json: Json = False,
) -> None:
    """Which rules a recorded run used, for how long and how strongly, and which never fired."""
    from leadscrew.fuzzy.explanation import activity as strengths_of
    from leadscrew.fuzzy.explanation import usage

    if out is not None:
        suffix_of(out, (*PICTURES, ".csv"), "--out")
    system = system_of(file, leave_out_unknown)
    found = recorded_inputs(run, [v.name for v in system.inputs], maps or [], time)
    with busy(f"{system.name}, {len(found.time)} rows"):
        strengths = strengths_of(system, found.points)
        uses = usage(system, found.time, strengths)
        if out is not None:
            _write(system, found, strengths, out)
    silent = float((~(strengths > 0.0).any(axis=1)).mean())
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(file), "system": system.name, "run": str(run),
              "rows": len(found.time), "map": found.said, "unit": found.unit or "rows", "no_rule_fires": silent,
              "rules": [vars(u) for u in uses], "out": None if out is None else str(out)})  # fmt: skip
        return
    print_uses(system, uses, found, silent)
    if out is not None:
        typer.echo(f"\n{out}: {len(found.time)} rows")


def _write(system: System, found: RunInputs, strengths: np.ndarray, out: Path) -> None:
    import numpy as np

    if out.suffix.casefold() == ".csv":
        names = ["time" if found.unit else "row", *(v.name for v in system.inputs)]
        names += [f"rule {i + 1}" for i in range(strengths.shape[1])]
        save_table(names, np.column_stack([found.time, found.points, strengths]), out)
        return
    from leadscrew.report.fuzzy import activity_figure

    save_figure(activity_figure(system, found.time, found.points, unit=found.unit), out)


def print_uses(system: System, uses: tuple[Use, ...], found: RunInputs, silent: float) -> None:
    """The rules by how long they fired, then those that never did."""
    unit = found.unit or "rows"
    fired = sorted((u for u in uses if u.seconds > 0.0), key=lambda u: (-u.seconds, -u.mean))
    typer.echo(f"{system.name}: {len(fired)} of {len(uses)} rules fired in {len(found.time)} rows")
    typer.echo(f"from {', '.join(f'{k} = {v}' for k, v in found.said.items())}")
    if silent:
        typer.echo(f"no rule fired in {100.0 * silent:.3g} % of the rows")
    if fired:
        typer.echo()
        columns = ["rule", f"fired / {unit}", "% of the run", "mean strength", "strongest", f"at / {unit}", ""]
        rows = [[str(u.number), f"{u.seconds:.4g}", f"{100.0 * u.part:.1f}", f"{u.mean:.3g}", f"{u.strongest:.3g}",
                 f"{u.at:.4g}", u.text] for u in fired]  # fmt: skip
        print_table(columns, rows, right=columns[:-1])
    for words, which in (("never fired", True), ("switched off", False)):
        never: list[Any] = [u for u in uses if not u.seconds and u.enabled == which]
        if never:
            typer.echo(f"\n{words}: {len(never)}")
            for use in never:
                typer.echo(f"{use.number:>4}  {use.text}")
