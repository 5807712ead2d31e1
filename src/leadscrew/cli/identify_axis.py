"""``leadscrew identify axis``: mass, friction, offset, delay and lost motion of an axis from its log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli import pairs
from leadscrew.cli.options import Columns, End, Gear, Json, Lead, MachineFile, Period, Start, Units
from leadscrew.cli.output import busy, deliver, free, progress
from leadscrew.kernel import validate
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import shell

if TYPE_CHECKING:
    from leadscrew.identify.axis.result import AxisFit
    from leadscrew.logs.arrays import AxisLog
    from leadscrew.report.report import File

MODELS = ["auto", "coulomb", "stribeck", "lugre"]
GAINS = ("kp", "kv", "ki", "max_drive", "over")
REFINE = ["auto", "none", "open", "windows", "closed"]


def axis(
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="CSV, TSV, Parquet, .mat, halscope, or a folder of simulate --out.")
    ],
    out: MachineFile = None,
    report: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A folder for page, pictures, JSON and machine file.")
    ] = None,
    column: Columns = None,
    unit: Units = None,
    period: Period = None,
    start: Start = None,
    end: End = None,
    force_per_drive: Annotated[
        float | None,
        typer.Option(metavar="X", help="Force of one unit of the drive: N/V, N m/A; negative if turned."),
    ] = None,
    lead: Lead = None,
    gear: Gear = 1.0,
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
    validate.one_of("--model", model, MODELS)
    validate.one_of("--refine", refine, REFINE)
    if not 0.0 <= holdout <= 0.8:
        raise ValueRefused(f"--holdout {holdout:g}: allowed range is [0, 0.8], a share of the log")
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
    from leadscrew.report.identified_axis import report_of

    deliver(report_of(fit, read.findings, _files(fit, read, options["cascade"], how, out, report)), as_json=as_json)


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


def _files(
    fit: AxisFit, log: AxisLog, cascade: Any, how: dict[str, Any], out: Path | None, report: Path | None
) -> list[File]:
    """The report and the machine file."""
    from leadscrew import machine
    from leadscrew.report import identified_axis as page
    from leadscrew.report.report import File

    name = (out or report or Path(log.source)).stem

    def of(folder: Path) -> machine.MachineFile:
        """The machine, whose file lies in ``folder``."""
        from leadscrew.machine.scenarios import of_log

        source = Path(log.source)
        moves = of_log(source, folder, **how) if log.command is not None and source.is_file() else None
        return machine.from_axis(fit, name, _gains(cascade), moves)

    def draw(folder: Path) -> None:
        with busy(f"{folder}: drawing"):
            page.write(fit, folder, lambda path: machine.write(path, of(folder)), [f.sentence for f in log.findings])

    next_ = "" if out is None else f"; next: leadscrew simulate {shell(out)} -c ours.cascade_model -s move"
    return [
        File("report", report, "the report: report.html, pictures, JSON, machine file", draw),
        File("out", out, f"the machine{next_}", lambda path: machine.write(path, of(path.parent))),
    ]
