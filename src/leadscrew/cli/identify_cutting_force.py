"""``leadscrew identify cutting-force``: force laws of turning from a table of cuts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.output import Json, busy, emit
from leadscrew.cli.pairs import texts
from leadscrew.escape import shell
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.analysis.cutting_force import Kienzle


def cutting_force(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="CSV or Parquet, a row a cut: feed, depth, main cutting force.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="A folder for the report: page, picture, JSON, cut.toml."),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(metavar="WHAT=HEADER", help="Header of a column: feed, depth, force, feed_force, spindle, ..."),
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option(metavar="WHAT=UNIT", help="Unit of a column, where its header says none.")
    ] = None,
    method: Annotated[str, typer.Option(help="Of the power law: log-log, relative or absolute.")] = "log-log",
    kappa: Annotated[float, typer.Option(metavar="DEG", help="Cutting edge angle, for Kienzle's notation.")] = 90.0,
    exponent: Annotated[
        float | None, typer.Option(metavar="P", help="The exponent, where the table has one feed only.")
    ] = None,
    spindle_rpm: Annotated[
        float | None, typer.Option(metavar="RPM", help="Spindle speed, for feeds in mm/min without such a column.")
    ] = None,
    at: Annotated[
        list[str] | None, typer.Option(metavar="FEED,DEPTH", help="Say the force of this cut too, mm/rev and mm.")
    ] = None,
    beside: Annotated[
        str | None, typer.Option(metavar="KC11,MC", help="Errors of a law from elsewhere on the same cuts.")
    ] = None,
    bootstrap: Annotated[int, typer.Option(metavar="N", help="Intervals from N draws of residuals too.")] = 0,
    usual_kc: Annotated[
        str, typer.Option(metavar="LOW,HIGH", help="Specific force in N/mm2 outside which a unit is taken as wrong.")
    ] = "500,10000",
    example: Annotated[
        bool, typer.Option("--example", help="Write eight published cuts to FILE instead, to see what a file is like.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Fit laws of the main cutting force (power law, Kienzle, chip and edge), and say what the table cannot tell.

    Known columns: feed or f, depth or ap, force, Fc or F; units in the header, as in feed (mm/rev), or --unit.
    """
    if example:
        _write_example(file, out is not None or as_json or any((column, unit, at, beside)))
        return
    from leadscrew.identify.cutting_force_table import read_force_table
    from leadscrew.kernel import door

    if spindle_rpm is not None:
        door.positive("--spindle-rpm", spindle_rpm, "1/min")
    cuts = [_pair("--at", text, "FEED,DEPTH") for text in at or []]
    low, high = _pair("--usual-kc", usual_kc, "LOW,HIGH")
    if not low < high:
        raise ValueRefused(f"--usual-kc {usual_kc}: expected LOW,HIGH with LOW below HIGH")
    other = None if beside is None else _other(beside, kappa)
    table = read_force_table(
        file, columns=texts("--column", column, "WHAT=HEADER"), units=texts("--unit", unit, "WHAT=UNIT"),
        spindle_rpm=spindle_rpm, usual_kc=(low, high),
    )  # fmt: skip
    with busy(f"{file}: laws"):
        from leadscrew.identify.cutting_force import bootstrap as draw
        from leadscrew.identify.cutting_force import fit_forces
        from leadscrew.report import cutting_force as report

        fit = fit_forces(table, method=method, kappa_deg=kappa, exponent=exponent)  # type: ignore[arg-type]
        drawn = draw(fit, bootstrap) if bootstrap else None
        more = {"beside": other, "cuts": cuts, "drawn": drawn}
        if out is not None:
            report.write(fit, file.name, out, **more)  # type: ignore[arg-type]
    if as_json:
        emit({**report.summary(fit, str(file), **more), "report": out})  # type: ignore[arg-type]
        return
    from leadscrew.cli.door import say
    from leadscrew.cli.output import print_table

    tables: list[tuple[Sequence[str], list[list[str]]]] = [
        (report.LAW_COLUMNS, report.law_rows(fit, drawn)),
        (report.FIT_COLUMNS, report.fit_rows(fit, other)),
        (report.ROW_COLUMNS, report.cut_rows(fit)),
        *([(report.AT_COLUMNS, report.at_rows(fit, cuts))] if cuts else []),
    ]
    for columns, rows in tables:
        print_table(columns, rows, right=[c for c in columns if c in report.NUMBERS])
        typer.echo("")
    for line in report.sentences(fit):
        typer.echo(line)
    typer.echo(report.for_simulation(fit, "--set "))
    for note in fit.notes:
        say(f"leadscrew: note: {note}")
    if out is not None:
        then = f"; next: leadscrew simulate {out / 'cut.toml'}" if report.settings(fit) else ""
        typer.echo(f"\nreport: {out / 'report.html'}{then}")


def _write_example(file: Path, more: bool) -> None:
    from leadscrew.identify.cutting_force_table import EXAMPLE
    from leadscrew.kernel.errors import DataError
    from leadscrew.newfile import save

    if more:
        raise ValueRefused("--example only writes FILE; leave the other options for the fit of it")
    if file.exists():
        raise DataError(f"{file} exists already; --example overwrites nothing")
    save(EXAMPLE, file)
    typer.echo(f"{file}: published cuts; next: leadscrew identify cutting-force {shell(file)}")


def _pair(option: str, text: str, expected: str) -> tuple[float, float]:
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        first = second = -1.0
    if not (0.0 < first < float("inf") and 0.0 < second < float("inf")):
        raise ValueRefused(f"{option} {text}: expected {expected}, two numbers above 0")
    return first, second


def _other(text: str, kappa: float) -> Kienzle:
    from leadscrew.analysis.cutting_force import Kienzle

    try:
        kc11, mc = (float(part) for part in text.split(","))
    except ValueError:
        kc11 = mc = -1.0
    if not (0.0 < kc11 < float("inf") and -1.0 < mc < 1.0):
        raise ValueRefused(f"--beside {text}: expected KC11,MC, N/mm2 above 0 and a number between -1 and 1")
    if not 0.0 < kappa <= 90.0:
        raise ValueRefused(f"--kappa {kappa:g}: allowed range is (0, 90] degrees")
    return Kienzle(kc11, mc, kappa)
