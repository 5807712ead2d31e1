"""``leadscrew identify axis``: mass, friction, offset, delay and lost motion of an axis from its log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli import pairs
from leadscrew.cli.output import Json, busy, emit, print_table, progress
from leadscrew.kernel import validate
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import shell

if TYPE_CHECKING:
    from leadscrew.identify.axis.result import AxisFit
    from leadscrew.logs.arrays import AxisLog

MODELS = ["auto", "coulomb", "stribeck", "lugre"]
GAINS = ("kp", "kv", "ki", "max_drive", "over")
REFINE = ["auto", "none", "open", "windows", "closed"]


def axis(
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="CSV, TSV, Parquet, .mat, halscope, or a folder of simulate --out.")
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Machine file: a name of a study.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A folder for page, pictures, JSON and machine file.")
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(metavar="ROLE=HEADER", help="Column of time, drive, position, command or velocity."),
    ] = None,
    unit: Annotated[
        list[str] | None, typer.Option(metavar="ROLE=UNIT", help="Unit of that column; over the file's own.")
    ] = None,
    period: Annotated[
        float | None, typer.Option(metavar="S", help="Sampling period, for a log without a column of time.")
    ] = None,
    start: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is before.")] = None,
    end: Annotated[float | None, typer.Option(metavar="S", help="Leave out what is after.")] = None,
    force_per_drive: Annotated[
        float | None,
        typer.Option(metavar="X", help="Force of one unit of the drive: N/V, N m/A; negative if turned."),
    ] = None,
    lead: Annotated[
        float | None,
        typer.Option(
            metavar="MM",
            help="Travel of one screw revolution: a drive in N m becomes a force, without losses; --force-per-drive is "
            "then the motor's N m for one unit of the drive.",
        ),
    ] = None,
    gear: Annotated[
        float, typer.Option(metavar="N", help="With --lead: motor revolutions for one of the screw.")
    ] = 1.0,
    symmetric: Annotated[
        bool | None,
        typer.Option(
            "--symmetric/--by-direction", help="Friction alike both ways, or not; decided by the training part else."
        ),
    ] = None,
    model: Annotated[str, typer.Option(help=f"Friction: {', '.join(MODELS)}.")] = "auto",
    holdout: Annotated[
        float, typer.Option(metavar="SHARE", help="Share of the log, at its end, that the fit does not see; 0: none.")
    ] = 0.5,
    delay: Annotated[
        float | None, typer.Option(metavar="S", help="From the logged drive to its act; from the log unless given.")
    ] = None,
    given: Annotated[
        list[str] | None, typer.Option(metavar="KEY=VALUE", help="A parameter that is known, SI: mass=95.1.")
    ] = None,
    refine: Annotated[str, typer.Option(help=f"Refinement by simulation: {', '.join(REFINE)}.")] = "auto",
    cascade: Annotated[
        str | None,
        typer.Option(
            metavar="kp=X,kv=Y",
            help="Controller that made the log, 1/s and drive s/m (and ki 1/s, max_drive, over): closed-loop error.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Identify mass, friction, offset, delay and lost motion of an axis, and judge the model on data it has not seen.

    The machine file is a name wherever a study is named: simulate, tune, compare, ballbar, export.
    """
    from leadscrew.cli.tune import free

    validate.one_of("--model", model, MODELS)
    validate.one_of("--refine", refine, REFINE)
    if not 0.0 <= holdout <= 0.8:
        raise ValueRefused(f"--holdout {holdout:g}: allowed range is [0, 0.8], a share of the log")
    if out is not None and out.suffix != ".toml":
        raise ValueRefused(f"--out {out}: a machine file ends in .toml")
    options: dict[str, Any] = {
        "symmetric": symmetric, "model": model, "holdout": holdout, "delay": delay, "refine": refine,
        "given": pairs.values("--given", given, "KEY=VALUE, as in mass=95.1"),
        "cascade": _cascade(cascade),
    }  # fmt: skip
    law = options["cascade"]
    if law is not None and law.kv * (force_per_drive or 1.0) < 0.0:
        raise ValueRefused(
            f"--cascade kv = {law.kv:g}: must have the sign of --force-per-drive ({force_per_drive or 1.0:g}), or the "
            "loop runs away"
        )
    columns = pairs.texts("--column", column, "ROLE=HEADER, as in position=qm")
    units = pairs.texts("--unit", unit, "ROLE=UNIT, as in position=mm")
    free([out, report])
    with busy(f"{log}: reading"):
        from leadscrew.logs import read_axis_log

        read = read_axis_log(
            log,
            columns=columns,
            units=units,
            start=start,
            end=end,
            force_per_drive=force_per_drive,
            period=period,
            lead_mm=lead,
            gear=gear,
        )
    with progress() as bar:
        from leadscrew.identify.axis.fit import identify_axis

        fit = identify_axis(read, **options, progress=lambda what, done: bar(f"{log}: {what}", done))
    how = {"columns": columns, "units": units, "start": start, "end": end, "period": period}
    _write(fit, read, options["cascade"], how, out, report)
    _show(fit, read, out, report, as_json)


def _cascade(text: str | None) -> Any:
    if text is None:
        return None
    from leadscrew.identify.axis.cascade import Cascade

    expected = f"kp=X,kv=Y, kp in 1/s and kv in drive s/m, and if need be {', '.join(GAINS[2:])}"
    found: dict[str, Any] = pairs.values("--cascade", text.split(","), expected)
    if not {"kp", "kv"} <= set(found) <= set(GAINS):
        raise ValueRefused(f"--cascade {text}: expected {expected}")
    if "over" in found:
        found["over"] = validate.whole("--cascade over", found["over"], 1, 8)
    return Cascade(**found)


def _gains(cascade: Any) -> dict[str, float] | None:
    """Gains for the machine file: its ``ki`` is that of the drive, not of the speed, and its drive is never turned."""
    kv = 0.0 if cascade is None else abs(cascade.kv)
    return None if cascade is None else {"kp": cascade.kp, "kv": kv, "ki": kv * cascade.ki}


def _write(
    fit: AxisFit, log: AxisLog, cascade: Any, how: dict[str, Any], out: Path | None, report: Path | None
) -> None:
    """The machine file and the report."""
    if out is None and report is None:
        return
    from leadscrew import machine
    from leadscrew.report import identified_axis as page

    name = (out or report or Path(log.source)).stem

    def found(folder: Path) -> machine.MachineFile:
        """The machine, whose file lies in ``folder``."""
        from leadscrew.machine.scenarios import of_log

        source = Path(log.source)
        asked = of_log(source, folder, **how) if log.command is not None and source.is_file() else None
        return machine.from_axis(fit, name, _gains(cascade), asked)

    if report is not None:
        with busy(f"{report}: drawing"):
            said = [f.sentence for f in log.findings]
            page.write(fit, report, lambda path: machine.write(path, found(report)), said)
    if out is not None:
        machine.write(out, found(out.parent))


def _show(fit: AxisFit, log: AxisLog, out: Path | None, report: Path | None, as_json: bool) -> None:
    from leadscrew.cli.exit_codes import say
    from leadscrew.report import identified_axis as tables
    from leadscrew.report.identified_axis import notes, sentences

    if as_json:
        findings = [f._asdict() for f in log.findings]
        emit({**tables.summary(fit), "findings": findings, "out": out, "report": report})
        return
    blocks = [
        (tables.PARAMETER_COLUMNS, tables.parameter_rows(fit, False)),
        (tables.SCORE_COLUMNS, tables.score_rows(fit)),
    ]
    if fit.compared:
        headers, rows = tables.compared_table(fit)
        blocks.append((tuple(headers), rows))
    for columns, rows in blocks:
        print_table(columns, rows, right=[c for c in columns if c in tables.NUMBERS])
        typer.echo("")
    for line in (*sentences(fit), *tables.reason_lines(fit)):
        typer.echo(line)
    for line in fit.advice:
        typer.echo(f"to measure next: {line}")
    for note in notes(fit, (f.sentence for f in log.findings)):
        say(f"leadscrew: note: {note}")
    if report is not None:
        typer.echo(f"\nreport: {report / 'report.html'}")
    if out is not None:
        typer.echo(f"\n{out}: the machine; next: leadscrew simulate {shell(out)} -c ours.cascade_model -s move")
