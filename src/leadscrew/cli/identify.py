"""``leadscrew identify``: an axis, its LuGre friction, or a cutting force law, from logged data."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.identify_axis import axis
from leadscrew.cli.identify_cutting_force import cutting_force
from leadscrew.cli.identify_friction_force import friction_force
from leadscrew.cli.identify_linear import linear
from leadscrew.cli.identify_servo_gain import servo_gain
from leadscrew.cli.output import Json, emit, print_table, progress
from leadscrew.cli.subject import Trust
from leadscrew.kernel.errors import ValueRefused

SCHEMA_VERSION = 1

app = typer.Typer(no_args_is_help=True, help="Find a model's parameters in logged data.")


@app.callback()
def _identify() -> None:
    """Find a model's parameters in logged data."""


app.command("axis")(axis)
app.command("cutting-force")(cutting_force)
app.command("friction-force")(friction_force)
app.command("linear")(linear)
app.command("servo-gain")(servo_gain)


@app.command("friction")
def friction(
    log: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Log of one move: CSV, Parquet, or a folder of simulate --out; evenly sampled, with reversals.",
        ),
    ],
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Controller file.")] = None,
    time: Annotated[str, typer.Option(metavar="COLUMN", help="Times; in s unless the header names a unit.")] = "time",
    torque: Annotated[str, typer.Option(metavar="COLUMN", help="Commanded torque in N m.")] = "output",
    position: Annotated[str, typer.Option(metavar="COLUMN", help="Measured position.")] = "feedback",
    travel_per_rad: Annotated[
        float | None,
        typer.Option(
            metavar="X",
            help="Position per radian: 1.5923 for mm of the paper's table; a folder's own, else 1 unless given.",
        ),
    ] = None,
    inertia: Annotated[
        float | None, typer.Option(metavar="KG_M2", help="At the screw; from the log unless given.")
    ] = None,
    delay: Annotated[int, typer.Option(metavar="N", help="Periods from a logged torque to its act.")] = 0,
    controller: Annotated[
        str, typer.Option("--controller", "-c", help="Whose believed friction the file sets.")
    ] = "ours.pd_dob",
    study: Annotated[str, typer.Option(help="Whose controller that is.")] = "fsmc_ballscrew",
    force: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="Measured friction force: then as identify friction-force, -o a folder."),
    ] = None,
    velocity: Annotated[str | None, typer.Option(metavar="COLUMN", help="With --force: measured velocity.")] = None,
    normal: Annotated[str | None, typer.Option(metavar="COLUMN", help="With --force: measured normal force.")] = None,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Identify LuGre friction (and inertia) from one log, with standard errors and what the log cannot determine.

    The controller file holds the identifiable parameters; it is a name wherever a controller is named: simulate, tune,
    export.
    """
    if force is not None:
        from leadscrew.cli.identify_friction_force import of_force

        of_force(log, out, force, time, position, velocity, normal, as_json)
        return
    if velocity is not None or normal is not None:
        raise ValueRefused("--velocity and --normal go with --force, the column of a measured friction force")
    from leadscrew import controller_file, names, resolve
    from leadscrew.cli.tune import free
    from leadscrew.identify.friction_file import controller_with, identify_file, table_rows

    if out is not None and out.suffix != ".toml":
        raise ValueRefused(f"--out {out}: a controller file ends in .toml")
    if out is not None:
        resolve.study(names.absolute(study))
    free([out])
    with progress() as report:
        found = identify_file(
            log, time=time, torque=torque, position=position, travel_per_rad=travel_per_rad, inertia=inertia,
            delay=delay, progress=lambda what, done: report(f"{log}: {what}", done),
        )  # fmt: skip
    if out is not None:
        controller_file.write(out, controller_with(found, names.absolute(study), controller, str(log)))
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "log": str(log), **found.as_dict(),
              "out": None if out is None else str(out)})  # fmt: skip
        return
    print_table(("parameter", "value", "standard error", "share", ""), table_rows(found), right=("value",))
    typer.echo("")
    typer.echo(
        f"{found.sliding.windows} windows of sliding, {found.pieces} stand-stills; {found.simulations} simulations"
    )
    typer.echo(
        f"position, log minus model: {found.rms:.2g} rad rms, noise {found.noise:.2g}; condition number "
        f"{found.condition:.2g}"
    )
    typer.echo(
        "the residuals are white and no larger than the noise" if found.consistent
        else f"not quite LuGre, and the standard errors are too small: {found.residuals.why_not}"
    )  # fmt: skip
    unknown = [name for name, known in found.identifiable.items() if not known]
    if unknown:
        kept = "" if out is None else f"; {out} keeps the controller's own"
        typer.echo(
            f"not identifiable from this log: {', '.join(unknown)}{kept}; a log in which the axis creeps to a slip and "
            "stops, both ways, as in the move friction_test, determines them"
        )
    if out is not None:
        typer.echo(f"\n{out}: the controller; a name wherever a controller is named")
