"""``leadscrew design``: ``vud`` from a log of the old controller; ``npid``, ``rejection`` from a plant and limits."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.options import ControllerFile, Json, Plot
from leadscrew.cli.output import busy, deliver, free
from leadscrew.figures.table import number
from leadscrew.report.report import File, Report, TextTable, head
from leadscrew.util.errors import BlockError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    from leadscrew.design.npid_axis import Gains, TableAxis, Work
    from leadscrew.kernel.block import Block
    from leadscrew.study_data import Study


STUDY = "npid_xytable"
CONTROLLER = "the controller; a name wherever a controller is named"


def npid(
    out: ControllerFile = None,
    law: Annotated[str, typer.Option(help="slope: gain and slope have one bound; cosh: the paper's.")] = "slope",
    retune: Annotated[
        float | None, typer.Option(metavar="MS", help="Retune the PID first, at this peak of sensitivity.")
    ] = None,
    kp: Annotated[float, typer.Option(metavar="V/MM", help="Of the PID.")] = 1.32,
    ki: Annotated[float, typer.Option(metavar="V/(MM S)", help="Of the PID.")] = 0.000825,
    kd: Annotated[float, typer.Option(metavar="V S/MM", help="Of the PID.")] = 0.006805,
    gain: Annotated[float, typer.Option(help="Axis: gain / (s^2 + damping s + stiffness), mm/V.")] = 69380.0,
    damping: Annotated[float, typer.Option(help="Of the axis, 1/s.")] = 144.8,
    stiffness: Annotated[float, typer.Option(help="Of the axis, 1/s^2.")] = 166.3,
    dead_time: Annotated[float, typer.Option(metavar="MS", help="From the sample to the voltage.")] = 0.775,
    rate: Annotated[float, typer.Option(metavar="HZ", help="Of the loop.")] = 2000.0,
    amplitude: Annotated[float, typer.Option(metavar="MM", help="Of the motion, a sine of 0.7 Hz.")] = 1.0,
    encoder: Annotated[float, typer.Option(metavar="UM", help="A count of the encoder.")] = 0.5,
    noise: Annotated[float, typer.Option(metavar="UM", help="Of a reading, before it is counted.")] = 0.1,
    budget: Annotated[
        float | None,
        typer.Option(
            metavar="MV", help="Change of the voltage a period at rest, rms; 1.2 times the PID's unless given."
        ),
    ] = None,
    tracking: Annotated[float, typer.Option(help="Weight of the following error; a force line has 1.")] = 1.0,
    m1: Annotated[float, typer.Option(help="Factor from the gain to its limit at rest.")] = 1.1,
    m2: Annotated[float, typer.Option(help="Factor from the slope to its limit under command and load.")] = 1.1,
    as_paper: Annotated[
        bool, typer.Option("--as-paper", help="Walk the paper's own procedure first, and put it beside this one.")
    ] = False,
    plot: Plot = None,
    study: Annotated[str, typer.Option(help="Study of the axis that the controller file names.")] = STUDY,
    as_json: Json = False,
) -> None:
    """Design a nonlinear PID: the smallest error within a proof of stability and a noise budget; says what binds.

    It is judged at the force lines of Table II, at 1000, 2000 and 3000 1/min. The file is a name wherever a controller
    is named: simulate, certify, tune, export.
    """
    from leadscrew import controller_file, names, resolve
    from leadscrew.design.npid import design_npid
    from leadscrew.design.npid_axis import Gains, TableAxis
    from leadscrew.report.npid_design import report_of

    if not rate > 0.0:
        raise ValueRefused(f"--rate {rate!r} Hz: must be positive")
    home = resolve.study(names.absolute(study))
    free([out, plot])
    axis = TableAxis(gain, damping, stiffness, 1e-3 * dead_time, 1.0 / rate)
    gains = Gains(kp, ki, kd)
    work = table_2_work(amplitude, encoder, noise, tracking)
    with busy("designing"):
        found = design_npid(axis, work, gains, law=law, retune_ms=retune, m1=m1, m2=m2, budget_mv=budget)  # type: ignore[arg-type]
        walked = paper_of(axis, gains) if as_paper else None
        if out is not None:
            runs_in(home, found.controller(), study)

    def write(path: Path) -> None:
        controller_file.write(path, found.controller_file(names.absolute(study)))

    deliver(report_of(found, walked, [File("out", out, CONTROLLER, write)]), plot=plot, as_json=as_json)


def table_2_work(amplitude: float, encoder: float, noise: float, tracking: float) -> Work:
    """The force lines that make Table II's PID column, one case a spindle speed."""
    from leadscrew.design.npid_axis import Case, Work
    from leadscrew.studies.npid_xytable.calibration import volts
    from leadscrew.studies.npid_xytable.table2 import BASE_HZ, LINES_HZ, PID_UM

    cases = tuple(Case(f"{rpm} 1/min", volts(um), rpm / 60.0) for rpm, um in PID_UM.items())
    return Work(cases, LINES_HZ, amplitude, BASE_HZ, encoder, noise, tracking_weight=tracking)


def runs_in(home: Study, block: Block, named: str) -> None:
    """Tries the controller's first period in the first loop of a study.

    Raises:
        ValueRefused: it cannot run there; says why.
    """
    import warnings

    from leadscrew.kernel.units import UnitWarning

    for scenario in list(home.scenarios)[:1]:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", UnitWarning)
                _ = home.loop(block, scenario).signals
        except (BlockError, UnitWarning) as error:
            raise ValueRefused(
                f"--study {named}: the designed controller cannot run in this study: {error}; nothing is written"
            ) from None


def paper_of(axis: TableAxis, gains: Gains) -> Any:
    """The paper's procedure on this axis."""
    from leadscrew.design.npid_paper import paper_design

    return paper_design(axis, gains)


GOAL = "mean row of Table II, um"


def rejection(
    law: Annotated[str, typer.Argument(help="pid, npid, npid_split, pid_low_pass or pid_lag.")],
    rest: Annotated[
        float | None, typer.Option(metavar="MV", help="Change of the output at rest, rms a sample, at most.")
    ] = None,
    work: Annotated[
        float | None, typer.Option(metavar="MV", help="Change of the output at work, rms a sample, at most.")
    ] = None,
    ms: Annotated[float, typer.Option(help="Peak of the sensitivity around every error, at most.")] = 1.6,
    feed_forward: Annotated[
        bool, typer.Option("--feed-forward", help="With the inverse plant as feed-forward, which knows the plant.")
    ] = False,
    amplitude: Annotated[float, typer.Option(metavar="MM", help="Of the motion, a sine of 0.7 Hz.")] = 1.0,
    budget: Annotated[int, typer.Option(metavar="N", help="Settings to try.")] = 3000,
    seed: Annotated[int, typer.Option(help="Of the search.")] = 1,
    out: ControllerFile = None,
    as_json: Json = False,
) -> None:
    """Tune a law of the XY table for the smallest rows of Table II; the same search and bounds for every law.

    Each is proved stable on the twelve plants of the robustness box. What is printed was measured under phases of the
    forces that the search did not see. Exit code 1 where a bound is missed there.
    """
    from leadscrew import catalogue, controller_file, resolve
    from leadscrew._version import __version__
    from leadscrew.kernel.parameters import nearest
    from leadscrew.studies.lab import Lab
    from leadscrew.studies.npid_xytable.search import LAWS, searched

    if law not in LAWS:
        raise NameUnknown(f"there is no law {law!r}{nearest(law, list(LAWS))}; there are {', '.join(LAWS)}")
    if rest is None and work is None:
        raise ValueRefused("say how active the drive may be: --rest MV, --work MV, or both")
    for name, value in (("--rest", rest), ("--work", work), ("--amplitude", amplitude), ("--ms", ms - 1.0)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise ValueRefused(f"{name}: must be {'above 1' if name == '--ms' else 'positive'}")
    if budget < 8:
        raise ValueRefused(f"--budget {budget}: a search needs 8 settings at least")
    free([out])
    limits = {"rest": math.inf if rest is None else rest, "work": math.inf if work is None else work}
    with busy("tuning"):
        found = searched(
            Lab(resolve.study(STUDY)), law, feed_forward=feed_forward, rest_mv=limits["rest"],
            work_mv=limits["work"], ms=ms, amplitude_mm=amplitude, budget=budget, seed=seed,
        )  # fmt: skip
    words = ["leadscrew", "design", "rejection", law]
    words += [f"--{key}={value:g}" for key, value in limits.items() if math.isfinite(value)]
    words += [f"--ms={ms:g}", f"--amplitude={amplitude:g}", f"--budget={budget}", f"--seed={seed}"]
    words += ["--feed-forward"] if feed_forward else []
    measured = {
        GOAL: found.row_um, "Ms": found.ms, "change of the output at rest, mV": found.rest_mv,
        "change of the output at work, mV": found.work_mv,
    }  # fmt: skip
    bounds = [f"Ms<={ms:g}", "proved on the robustness box"]
    bounds += [f"change of the output at {key}, mV<={value:g}" for key, value in limits.items() if math.isfinite(value)]
    tuning = {
        "made_by": "leadscrew design rejection", "leadscrew": __version__, "command": shlex.join(words),
        "minimise": [GOAL], "subject_to": bounds, "budget": budget, "seed": seed, "holds": found.holds,
        "at_an_end": list(found.ends), "held_out": measured,
    }  # fmt: skip
    base = law if law in catalogue.BLOCKS and not feed_forward else f"ours.{law}{'_ff' if feed_forward else ''}"
    file = controller_file.ControllerFile(STUDY, base, found.parameters, tuning)
    rows = [[key, number(value)] for key, value in (measured | found.parameters).items()]
    ends = [f"at an end of its range: {', '.join(found.ends)}"] if found.ends else []
    report = Report(
        {**head("design rejection"), "controller": base, "parameters": found.parameters, **tuning},
        parts=[TextTable(["", base], rows, [False, True]), *ends],
        verdict=f"{'bounds kept' if found.holds else 'A BOUND IS MISSED'}: {'; '.join(bounds)}",
        files=[File("", out, CONTROLLER, lambda path: controller_file.write(path, file))],
        code=0 if found.holds else MISSED,
    )
    deliver(report, as_json=as_json)


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
    out: ControllerFile = None,
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
    study: Annotated[str, typer.Option(help="Study of the axis that the controller file names.")] = "vud_lathe",
    most: Annotated[int, typer.Option(help="Lines of a list before it is cut.")] = 60,
    as_json: Json = False,
) -> None:
    """Design a VUD fuzzy controller from a log of the old one; says at each step what is data and what is not.

    The file is a name wherever a controller is named: simulate, tune, export.
    """
    from leadscrew import controller_file, names, resolve
    from leadscrew.design import Factors, design_vud
    from leadscrew.report.vud_design import report_of

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

    def write(path: Path) -> None:
        controller_file.write(path, found.controller_file(names.absolute(study)))

    deliver(report_of(found, most, [File("out", out, CONTROLLER, write)]), as_json=as_json)


def _numbers(option: str, text: str | None) -> list[float] | None:
    if text is None:
        return None
    try:
        return [float(x) for x in text.split(",")]
    except ValueError:
        raise ValueRefused(f"{option} {text!r}: expected numbers with commas between them") from None
