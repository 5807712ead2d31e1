"""``leadscrew identify friction-force``: friction models from a measured friction force and its motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import typer

from leadscrew.cli.output import Json, emit, progress
from leadscrew.cli.pairs import texts
from leadscrew.escape import shell
from leadscrew.kernel.errors import ValueRefused


def friction_force(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Log with time, friction force and position or velocity, both ways.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="A folder for the report: page, picture, JSON, friction.toml."),
    ] = None,
    force: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured friction force.")] = None,
    position: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured position.")] = None,
    velocity: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured velocity.")] = None,
    normal: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured normal force.")] = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Time.")] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(metavar="ROLE=HEADER", help="The same as --force HEADER and so on: force=Fx."),
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option(metavar="ROLE=UNIT", help="Unit of a column, over its header's: force=mN.")
    ] = None,
    period: Annotated[
        float | None, typer.Option(metavar="S", help="Seconds from row to row, for a log without a column of times.")
    ] = None,
    sign: Annotated[
        str, typer.Option(metavar="auto|1|-1", help="1: a positive force resists a positive speed; auto: by its work.")
    ] = "auto",
    load: Annotated[
        str, typer.Option(metavar="auto|force|coefficient", help="Coefficient times normal force, or force alone.")
    ] = "auto",
    holdout: Annotated[
        float, typer.Option(metavar="SHARE", help="Of the samples, at the end: judged, not fitted. 0 to 0.8.")
    ] = 0.5,
    start: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is earlier.")] = None,
    end: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is later.")] = None,
    example: Annotated[
        bool, typer.Option("--example", help="Write a made log with a known friction to FILE instead.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Fit Coulomb and viscous friction, Stribeck map, Dahl, LuGre and Maxwell slip to a measured friction force.

    No mass is needed: the measured motion drives the models. Columns are known by usual names: time, friction,
    position, velocity, normal; units by the header, as in Position [mm], or by --unit.
    """
    columns = {"time": time, "force": force, "position": position, "velocity": velocity, "normal": normal}
    named = {role: name for role, name in columns.items() if name is not None}
    for role, name in texts("--column", column, "ROLE=HEADER, as in force=Fx").items():
        if named.setdefault(role, name) != name:
            raise ValueRefused(f"--column {role}={name}, and --{role} {named[role]}: name one column")
    if example:
        _write_example(file, out is not None or as_json or bool(named) or bool(unit))
        return
    run(file, out, named, unit or [], sign=_sign(sign), load=load, holdout=holdout, start=start, end=end,
        period=period, as_json=as_json)  # fmt: skip


def of_force(
    log: Path, out: Path | None, force: str, time: str, position: str, velocity: str | None, normal: str | None,
    as_json: bool,
) -> None:  # fmt: skip
    """What ``leadscrew identify friction --force`` does; its own default names are those of a drive's log."""
    given = {"force": force, "time": time, "position": position, "velocity": velocity, "normal": normal}
    drive = {"time": "time", "position": "feedback"}
    run(log, out, {k: v for k, v in given.items() if v is not None and drive.get(k) != v}, [], as_json=as_json)


def run(
    file: Path, out: Path | None, columns: dict[str, str], units: Sequence[str], *,
    sign: Literal["auto", 1, -1] = "auto", load: str = "auto", holdout: float = 0.5, start: float | None = None,
    end: float | None = None, period: float | None = None, as_json: bool = False,
) -> None:  # fmt: skip
    """Fits, writes the folder where one is asked for, and prints."""
    from leadscrew.identify.friction_force import identify_friction_force, read_force_record

    if out is not None and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise ValueRefused(f"--out {out} exists already; choose another folder or remove it")
    said = texts("--unit", units, "ROLE=UNIT, as in force=mN")
    record = read_force_record(file, columns=columns, units=said, sign=sign, start=start, end=end, period=period)
    with progress() as bar:
        fit = identify_friction_force(
            record, holdout=holdout, load=load,
            progress=lambda what, done: bar(f"{file}: {what}", done),
        )  # fmt: skip
        from leadscrew.report import friction_force as report

        if out is not None:
            report.write(fit, out)
    if as_json:
        emit({**report.summary(fit), "file": str(file), "report": out})
        return
    from leadscrew.cli.door import say
    from leadscrew.cli.output import print_table

    print_table(report.MODEL_COLUMNS, report.model_rows(fit), right=report.MODEL_COLUMNS[1:])
    typer.echo("")
    print_table(report.VALUE_COLUMNS, report.value_rows(fit.chosen), right=report.VALUE_COLUMNS[1:4])
    typer.echo("")
    for line in report.sentences(fit):
        typer.echo(line)
    for line in fit.advice:
        typer.echo(f"what to measure next: {line}")
    for note in fit.notes:
        say(f"leadscrew: note: {note}")
    if out is not None:
        typer.echo(f"\nreport: {out / 'report.html'}; {out / 'friction.toml'}: a [set] table with plant.friction")


def _write_example(file: Path, more: bool) -> None:
    from leadscrew.identify.friction_force.example import example_text
    from leadscrew.kernel.errors import DataError
    from leadscrew.newfile import save

    if more:
        raise ValueRefused("--example only writes FILE; leave the other options for the fit of it")
    if file.exists():
        raise DataError(f"{file} exists already; --example overwrites nothing")
    save(example_text(), file)
    typer.echo(f"{file}: a made log; next: leadscrew identify friction-force {shell(file)}")


def _sign(text: str) -> Literal["auto", 1, -1]:
    known: dict[str, Literal["auto", 1, -1]] = {"auto": "auto", "1": 1, "+1": 1, "-1": -1}
    if text not in known:
        raise ValueRefused(f"--sign {text}: allowed are auto, 1 and -1")
    return known[text]
