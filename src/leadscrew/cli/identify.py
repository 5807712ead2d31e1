"""``leadscrew identify``: an axis, its LuGre friction, or a cutting force law, from logged data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from leadscrew.cli import pairs
from leadscrew.cli.identify_axis import axis
from leadscrew.cli.options import (
    Columns,
    ControllerFile,
    End,
    Example,
    Folder,
    Json,
    MachineFile,
    Period,
    Start,
    TimeColumn,
    Trust,
    Units,
)
from leadscrew.cli.output import busy, deliver, free, progress, write_example
from leadscrew.cli.pairs import texts
from leadscrew.figures.table import number
from leadscrew.report.report import File, Part, Report, TextTable, head
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import shell

if TYPE_CHECKING:
    from leadscrew.analysis.cutting_force import Kienzle
    from leadscrew.identify.friction_file import FrictionFit
    from leadscrew.identify.linear.servo_gain import ServoGain


def cutting_force(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="CSV or Parquet, a row a cut: feed, depth, main cutting force.")
    ],
    out: Folder = None,
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
    example: Example = False,
    as_json: Json = False,
) -> None:
    """Fit laws of the main cutting force (power law, Kienzle, chip and edge), and say what the table cannot tell.

    Known columns: feed or f, depth or ap, force, Fc or F; units in the header, as in feed (mm/rev), or --unit.
    """
    if example:
        from leadscrew.identify.cutting_force_table import EXAMPLE

        _alone(out is not None or as_json or any((column, unit, at, beside)))
        write_example(file, EXAMPLE, "published cuts", f"leadscrew identify cutting-force {shell(file)}")
        return
    from leadscrew.identify.cutting_force_table import read_force_table
    from leadscrew.kernel import validate

    if spindle_rpm is not None:
        validate.positive("--spindle-rpm", spindle_rpm, "1/min")
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
        from leadscrew.report.cutting_force import report_of, settings

        fit = fit_forces(table, method=method, kappa_deg=kappa, exponent=exponent)  # type: ignore[arg-type]
        drawn = draw(fit, bootstrap) if bootstrap else None
    found = report_of(fit, file, beside=other, cuts=cuts, drawn=drawn)
    if out is not None and settings(fit):
        cut = out / "cut.toml"
        found = replace(found, files=[File("", cut, f"next: leadscrew simulate {shell(cut)}")])
    deliver(found, out=out, as_json=as_json)


def _alone(more: bool) -> None:
    if more:
        raise ValueRefused("--example only writes FILE; leave the other options for the fit of it")


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


def friction_force(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Log with time, friction force and position or velocity, both ways.")
    ],
    out: Folder = None,
    force: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured friction force.")] = None,
    position: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured position.")] = None,
    velocity: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured velocity.")] = None,
    normal: Annotated[str | None, typer.Option(metavar="COLUMN", help="Measured normal force.")] = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Time.")] = None,
    column: Columns = None,
    unit: Units = None,
    period: Period = None,
    sign: Annotated[
        str, typer.Option(metavar="auto|1|-1", help="1: a positive force resists a positive speed; auto: by its work.")
    ] = "auto",
    load: Annotated[
        str, typer.Option(metavar="auto|force|coefficient", help="Coefficient times normal force, or force alone.")
    ] = "auto",
    holdout: Annotated[
        float, typer.Option(metavar="SHARE", help="Of the samples, at the end: judged, not fitted. 0 to 0.8.")
    ] = 0.5,
    start: Start = None,
    end: End = None,
    example: Example = False,
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
        from leadscrew.identify.friction_force.example import example_text

        _alone(out is not None or as_json or bool(named) or bool(unit))
        what = "an example, with a known friction"
        write_example(file, example_text(), what, f"leadscrew identify friction-force {shell(file)}")
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

    free([out])
    said = texts("--unit", units, "ROLE=UNIT, as in force=mN")
    record = read_force_record(file, columns=columns, units=said, sign=sign, start=start, end=end, period=period)
    with progress() as bar:
        fit = identify_friction_force(
            record, holdout=holdout, load=load,  # type: ignore[arg-type]  # checked there
            progress=lambda what, done: bar(f"{file}: {what}", done),
        )  # fmt: skip
    from leadscrew.report.friction_force import report_of

    found = report_of(fit, file)
    if out is not None:
        found = replace(found, files=[File("", out / "friction.toml", "a [set] table with plant.friction")])
    deliver(found, out=out, as_json=as_json)


def _sign(text: str) -> Literal["auto", 1, -1]:
    known: dict[str, Literal["auto", 1, -1]] = {"auto": "auto", "1": 1, "+1": 1, "-1": -1}
    if text not in known:
        raise ValueRefused(f"--sign {text}: allowed are auto, 1 and -1")
    return known[text]


def linear(
    log: Annotated[
        Path,
        typer.Argument(
            metavar="LOG", help="CSV, TSV, Parquet, MATLAB, LinuxCNC halscope, or a folder of simulate --out."
        ),
    ],
    input_: Annotated[
        str | None, typer.Option("--input", metavar="COLUMN", help="What drives the plant; else the log's drive.")
    ] = None,
    output: Annotated[
        str | None, typer.Option("--output", metavar="COLUMN", help="What it answers; else the log's position.")
    ] = None,
    command: Annotated[
        str | None,
        typer.Option(metavar="COLUMN", help="Of a closed loop: instrument against noise that goes round."),
    ] = None,
    time: Annotated[str | None, typer.Option(metavar="COLUMN", help="Times; else the log's time.")] = None,
    unit: Annotated[
        list[str] | None, typer.Option(metavar="COLUMN=UNIT", help="Unit of a column, over the file's own.")
    ] = None,
    period: Period = None,
    start: Start = None,
    end: End = None,
    order: Annotated[
        str | None,
        typer.Option(
            metavar="POLES[,ZEROS[,AT_0]]", help="Instead of a choice: 3,1,1 is 3 poles, 1 of them at 0, 1 zero."
        ),
    ] = None,
    max_order: Annotated[int, typer.Option(metavar="N", help="Most poles of a candidate.")] = 4,
    max_zeros: Annotated[int, typer.Option(metavar="N", help="Most zeros of a candidate.")] = 2,
    integrators: Annotated[str, typer.Option(metavar="N,N", help="Poles at 0 that are tried: of 0, 1, 2.")] = "0,1",
    delay: Annotated[float | None, typer.Option(metavar="S", help="Known delay; fitted unless given.")] = None,
    max_delay: Annotated[float | None, typer.Option(metavar="S", help="Longest delay; 20 samples.")] = None,
    holdout: Annotated[float, typer.Option(metavar="SHARE", help="Of the log, at its end, to judge by.")] = 0.5,
    margin: Annotated[
        float, typer.Option(metavar="SHARE", help="Error over the least one that buys a simpler model.")
    ] = 0.02,
    out: MachineFile = None,
    report: Annotated[Path | None, typer.Option(metavar="DIR", help="A folder: page, pictures, JSON.")] = None,
    as_json: Json = False,
) -> None:
    """Find a transfer function with delay; its order is chosen by simulating a part of the log it has not seen.

    The input is taken as held from sample to sample. Columns are named as in the file, with or without their unit.
    """
    from leadscrew.cli.logs import numbers
    from leadscrew.identify.linear.fit import identify_linear
    from leadscrew.identify.linear.record import read_linear
    from leadscrew.identify.linear.result import machine
    from leadscrew.machine.file import write
    from leadscrew.report.identified_linear import report_of

    free([out, report])
    structure = None if order is None else _structure(order)
    tried = tuple(_whole(x, "--integrators", integrators) for x in numbers(integrators, "--integrators"))
    units = pairs.texts("--unit", unit, "COLUMN=UNIT, as in time=ms")
    record = read_linear(log, input_, output, command, time=time, units=units, start=start, end=end, period=period)
    with progress() as bar:
        fit = identify_linear(
            record, structure=structure, max_order=max_order, max_zeros=max_zeros, integrators=tried, delay=delay,
            max_delay=max_delay, holdout=holdout, margin=margin, progress=bar,
        )  # fmt: skip
    files = []
    if out is not None:
        found, next_ = machine(fit, out.stem), f"the machine; next: leadscrew simulate {shell(out)}"
        files = [File("out", out, next_, lambda path: write(path, found))]
    deliver(report_of(fit, log, files or [File("out", None, "")]), out=report, as_json=as_json)


def _structure(text: str) -> tuple[int, int, int]:
    from leadscrew.cli.logs import numbers

    given = [_whole(x, "--order", text) for x in numbers(text, "--order")]
    if not 1 <= len(given) <= 3:
        raise ValueRefused(f"--order {text}: expected POLES, POLES,ZEROS or POLES,ZEROS,AT_0, for example 3,1,1")
    poles, zeros, at_zero = (*given, 0, 0)[:3]
    return poles, zeros, at_zero


def _whole(value: float, option: str, text: str) -> int:
    if value != int(value):
        raise ValueRefused(f"{option} {text}: expected whole numbers with commas between them")
    return int(value)


def servo_gain(
    logs: Annotated[
        list[Path], typer.Argument(metavar="LOG...", help="One move a file, or several in one with --split.")
    ],
    input_: Annotated[str, typer.Option("--input", metavar="COLUMN", help="What drives the plant.")] = "output",
    position: Annotated[str, typer.Option(metavar="COLUMN", help="Measured position.")] = "feedback",
    time: Annotated[str, typer.Option(metavar="COLUMN", help="Times, or counts of samples with --unit.")] = "time",
    split: Annotated[
        str | None, typer.Option(metavar="COLUMN", help="A new move begins where this column changes.")
    ] = None,
    lag: Annotated[list[float] | None, typer.Option(metavar="S", help="A known lag; once for each.")] = None,
    hold: Annotated[
        str, typer.Option(help="Input between samples: linear, previous (held), or current (already the later one).")
    ] = "linear",
    unit: Annotated[
        list[str] | None,
        typer.Option(metavar="COLUMN=UNIT", help="Where its header says none; '-190 mm' scales and turns."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the gain K of position = K / (s (T1 s + 1) (T2 s + 1) ...) input, and how far the moves agree on it."""
    from leadscrew.identify.linear.servo_gain import servo_gain as fit_all

    found = fit_all(
        logs, input_, position, time=time, split=split, lags_s=lag or (), hold=hold,
        units=pairs.texts("--unit", unit, "COLUMN=UNIT, as in time='0.1 s'"),
    )  # fmt: skip
    deliver(_servo_gain(found), as_json=as_json)


def _servo_gain(found: ServoGain) -> Report:
    rows = [
        [m.name, number(m.samples), number(m.gain_alone), number(m.nrmse_percent, 3), number(m.travel)]
        for m in found.moves
    ]
    lags = ", ".join(f"{x:g}" for x in found.lags_s) or "none"
    others = ", ".join(f"{name} {number(value)}" for name, value in found.other_holds.items())
    return Report(
        {**head("identify servo-gain"), **found.as_dict()},
        parts=[
            TextTable(("move", "samples", "gain alone", "misfit (%)", "travel"), rows, [False, *[True] * 4]),
            f"gain {number(found.gain)} {found.unit}; lags {lags} s; input between samples: {found.hold}",
            f"the moves' own gains differ by {number(found.spread_percent, 3)} % of it",
            f"with the input otherwise between samples: {others}",
        ],
        notes=found.notes,
    )


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
    out: ControllerFile = None,
    time: TimeColumn = "time",
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
        str, typer.Option("--controller", "-c", help="Controller with the believed friction that the file sets.")
    ] = "ours.pd_dob",
    study: Annotated[str, typer.Option(help="Study of that controller.")] = "fsmc_ballscrew",
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
        of_force(log, out, force, time, position, velocity, normal, as_json)
        return
    if velocity is not None or normal is not None:
        raise ValueRefused("--velocity and --normal go with --force, the column of a measured friction force")
    from leadscrew import controller_file, names, resolve
    from leadscrew.identify.friction_file import controller_with, identify_file

    home = names.absolute(study)
    if out is not None:
        resolve.study(home)
    free([out])
    with progress() as bar:
        found = identify_file(
            log, time=time, torque=torque, position=position, travel_per_rad=travel_per_rad, inertia=inertia,
            delay=delay, progress=lambda what, done: bar(f"{log}: {what}", done),
        )  # fmt: skip

    def write(path: Path) -> None:
        controller_file.write(path, controller_with(found, home, controller, str(log)))

    deliver(_friction(found, log, out, write), as_json=as_json)


def _friction(found: FrictionFit, log: Path, out: Path | None, write: Callable[[Path], object]) -> Report:
    from leadscrew.identify.friction_file import table_rows

    parts: list[Part] = [
        TextTable(("parameter", "value", "standard error", "share", ""), table_rows(found)),
        f"{found.sliding.windows} windows of sliding, {found.pieces} stand-stills; {found.simulations} simulations",
        f"position, log minus model: {found.rms:.2g} rad rms, noise {found.noise:.2g}; condition number "
        f"{found.condition:.2g}",
        "the residuals are white and no larger than the noise"
        if found.consistent
        else f"not quite LuGre, and the standard errors are too small: {found.residuals.why_not}",
    ]
    unknown = [name for name, known in found.identifiable.items() if not known]
    if unknown:
        kept = "" if out is None else f"; {out} keeps the controller's own"
        parts.append(
            f"not identifiable from this log: {', '.join(unknown)}{kept}; a log in which the axis creeps to a slip and "
            "stops, both ways, as in the move friction_test, determines them"
        )
    what = "the controller; a name wherever a controller is named"
    data = {**head("identify friction"), "log": str(log), **found.as_dict()}
    return Report(data, parts, files=[File("out", out, what, write)])
