"""``leadscrew design vud``: a controller from a log of the one that it replaces, step by step; other designs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.design_npid import npid
from leadscrew.cli.design_rejection import rejection
from leadscrew.cli.output import Json, busy, emit
from leadscrew.kernel.errors import ValueRefused

SCHEMA_VERSION = 1

app = typer.Typer(no_args_is_help=True, help="Design a controller: from logged data, or from a plant and its limits.")
app.command("npid")(npid)
app.command("rejection")(rejection)


@app.callback()
def _design() -> None:
    """Design a controller: from logged data, or from a plant and its limits."""


@app.command("vud")
def vud(
    log: Annotated[
        list[Path],
        typer.Argument(
            metavar="LOG...",
            help="CSV with k, r, e, ec, rho; or signals time, command, feedback, output (CSV, Parquet, or a folder of "
            "simulate --out), one file a move.",
        ),
    ],
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Controller file.")] = None,
    interval: Annotated[float, typer.Option(metavar="S", help="Between samples, to which ec refers.")] = 0.1,
    error_scale: Annotated[
        float | None, typer.Option(metavar="MM", help="What e = 1 is; the log's unless given.")
    ] = None,
    rate_scale: Annotated[
        float | None, typer.Option(metavar="MM", help="What ec = 1 is, per interval; the log's unless given.")
    ] = None,
    curvature: Annotated[
        str | None,
        typer.Option(metavar="EE,CC", help="Second derivatives in place of an estimate; the paper: 1.96,1.35."),
    ] = None,
    most_condition: Annotated[
        float, typer.Option(metavar="N", help="Condition number up to which an estimate is believed.")
    ] = 30.0,
    accuracy: Annotated[float, typer.Option(help="Of equation (10), in duty.")] = 0.05,
    reading: Annotated[
        str | None, typer.Option(help="Take the number of sets from (10), read as half, full or intervals.")
    ] = None,
    sets: Annotated[int | None, typer.Option(metavar="N", help="That many evenly spaced sets instead.")] = None,
    centres: Annotated[
        str | None, typer.Option(metavar="A,B,...", help="These centres instead; the printed six unless given.")
    ] = None,
    complete: Annotated[
        list[str] | None,
        typer.Option(
            metavar="STEP",
            help="Fill cells without data: servo, servo_growth, antisymmetric, monotone, nearest; repeat for several.",
        ),
    ] = None,
    levels: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...", help="Consequents, small to big; the centres unless given (Table 2: 0.333,0.677,1)."
        ),
    ] = None,
    law: Annotated[str, typer.Option(help="vud_beta_e, or vud as printed, which creeps.")] = "vud_beta_e",
    tau: Annotated[float, typer.Option(help="Exponent of the factors.")] = 0.9,
    floor: Annotated[float, typer.Option(help="Smallest factor.")] = 1e-4,
    output_tau: Annotated[float, typer.Option(help="Exponent of the output's factor (vud_beta_e).")] = 0.6,
    output_gain: Annotated[float, typer.Option(help="Gain of the output's factor (vud_beta_e).")] = 1.5,
    study: Annotated[str, typer.Option(help="Whose axis the controller file names.")] = "vud_lathe",
    most: Annotated[int, typer.Option(help="Lines of a list before it is cut.")] = 60,
    as_json: Json = False,
) -> None:
    """Design a VUD fuzzy controller from a log of the old one; says at each step what is data and what is not.

    The file is a name wherever a controller is named: simulate, tune, export.
    """
    from leadscrew import controller_file, names, resolve
    from leadscrew.cli.tune import free
    from leadscrew.design import Factors, design_vud

    if out is not None and out.suffix != ".toml":
        raise ValueRefused(f"--out {out}: a controller file ends in .toml")
    if out is not None:
        resolve.study(names.absolute(study))
    free([out])
    with busy(f"{', '.join(map(str, log))}: designing"):
        found = design_vud(
            log, interval_s=interval, error_scale_mm=error_scale, rate_scale_mm=rate_scale,
            curvature=_numbers("--curvature", curvature), most_condition=most_condition, accuracy=accuracy,
            reading=reading, sets=sets, centres=_numbers("--centres", centres),  # type: ignore[arg-type]
            complete=complete or None, levels=_numbers("--levels", levels),
            factors=Factors(law, tau, floor, output_tau, output_gain),  # type: ignore[arg-type]
        )  # fmt: skip
        if out is not None:
            controller_file.write(out, found.controller_file(names.absolute(study)))
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, **found.as_dict(), "out": None if out is None else str(out)})
        return
    typer.echo(found.report(most))
    if out is not None:
        typer.echo(f"\n{out}: the controller; a name wherever a controller is named")


def _numbers(option: str, text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(x) for x in text.split(",")]
    except ValueError:
        raise ValueRefused(f"{option} {text!r}: expected numbers with commas between them") from None
