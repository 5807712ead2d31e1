"""``leadscrew design npid``: a nonlinear PID with the smallest error that its proof and the drive's noise allow."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.kernel.errors import BlockError, ValueRefused

if TYPE_CHECKING:
    from leadscrew.design.npid_axis import Gains, TableAxis, Work
    from leadscrew.kernel.block import Block
    from leadscrew.studies.study import Study

SCHEMA_VERSION = 1
PLOTS = (".png", ".svg", ".pdf")
STUDY = "npid_xytable"


def npid(
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Controller file.")] = None,
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
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw it (.png, .svg, .pdf).")] = None,
    study: Annotated[str, typer.Option(help="Whose axis the controller file names.")] = STUDY,
    as_json: Json = False,
) -> None:
    """Design a nonlinear PID: the smallest error within a proof of stability and a noise budget; says what binds.

    It is judged at the force lines of Table II, at 1000, 2000 and 3000 1/min. The file is a name wherever a controller
    is named: simulate, certify, tune, export.
    """
    from leadscrew import catalogue, controller_file, userfile
    from leadscrew.cli.tune import free
    from leadscrew.design.npid import design_npid
    from leadscrew.design.npid_axis import Gains, TableAxis

    if out is not None and out.suffix != ".toml":
        raise ValueRefused(f"--out {out}: a controller file ends in .toml")
    if plot is not None and plot.suffix not in PLOTS:
        raise ValueRefused(f"--plot {plot}: expected {', '.join(PLOTS)}")
    if not rate > 0.0:
        raise ValueRefused(f"--rate {rate!r} Hz: must be positive")
    home = catalogue.study(userfile.absolute(study))
    free([out, plot])
    axis = TableAxis(gain, damping, stiffness, 1e-3 * dead_time, 1.0 / rate)
    gains = Gains(kp, ki, kd)
    work = table_2_work(amplitude, encoder, noise, tracking)
    with busy("designing"):
        found = design_npid(axis, work, gains, law=law, retune_ms=retune, m1=m1, m2=m2, budget_mv=budget)  # type: ignore[arg-type]
        walked = paper_of(axis, gains) if as_paper else None
        rows = None if walked is None else _compared(walked, found)
        if out is not None:
            runs_in(home, found.controller(), study)
        if plot is not None:
            _draw(found, as_paper).savefig(plot, dpi=150)
        if out is not None:
            controller_file.write(out, found.controller_file(userfile.absolute(study)))
    if as_json:
        paper = None if walked is None else {**walked.as_dict(), "compared": rows}
        emit(
            {
                "schema_version": SCHEMA_VERSION,
                **found.as_dict(),
                "paper": paper,
                "out": None if out is None else str(out),
            }
        )
        return
    if walked is not None and rows is not None:
        typer.echo(f"THE PAPER'S PROCEDURE\n\n{walked.report()}\n\nOURS\n")
    typer.echo(found.report())
    if rows is not None:
        typer.echo()
        print_table(["", "the paper's, error in um", "ours"], rows)
    for kept, what in ((out, "the controller; a name wherever a controller is named"), (plot, "the drawing")):
        if kept is not None:
            typer.echo(f"\n{kept}: {what}")


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
    for scenario in list(home.scenarios)[:1]:
        try:
            _ = home.loop(block, scenario).signals
        except BlockError as error:
            why = str(error)
            if any(_commands_motions(home, other, scenario) for other in list(home.controllers)[:1]):
                why = (
                    f"its commands (scenario {scenario}) are motions, with velocity and acceleration, and {block.name} "
                    "takes a number"
                )
            raise ValueRefused(
                f"--study {named}: the designed controller cannot run in this study: {why}; nothing is written"
            ) from None


def _commands_motions(home: Study, controller: str, scenario: str) -> bool:
    from leadscrew.references.motion import Motion

    return isinstance(home.loop(controller, scenario).signals["command"], Motion)


def paper_of(axis: TableAxis, gains: Gains) -> Any:
    """The paper's procedure on this axis."""
    from leadscrew.design.npid_paper import paper_design

    return paper_design(axis, gains)


def _compared(walked: Any, found: Any) -> list[list[str]]:
    from leadscrew.design.npid_paper import compared

    return [list(r) for r in compared(walked, found).rows]


def _draw(found: Any, as_paper: bool) -> Any:
    from leadscrew.report import npid_design

    if not as_paper:
        return npid_design.design_map(found)
    from leadscrew.design.npid_paper import spectra

    return npid_design.as_paper(found, spectra(found))
