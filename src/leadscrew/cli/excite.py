"""``leadscrew excite``: a test move whose log tells what is missing, inside safe limits, with its recorder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.options import Json, Plot
from leadscrew.cli.output import deliver, free, note, progress
from leadscrew.util.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.identify.excite.belief import Belief
    from leadscrew.identify.excite.files import Machine
    from leadscrew.identify.excite.move import Limits

UNITS = {"mm": ("m", 1e-3), "m": ("m", 1.0), "deg": ("rad", 0.017453292519943295), "rad": ("rad", 1.0)}


def excite(
    fit: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FIT]", help="Machine file, or what identify axis --json printed: values, limits, what is missing."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Folder for move, program, recorder.")
    ] = None,
    tell: Annotated[
        str | None,
        typer.Option(metavar="NAME,..", help="mass, friction, offset, delay, stribeck, presliding, backlash, or keys."),
    ] = None,
    guess: Annotated[
        list[str] | None, typer.Option(metavar="KEY=VALUE", help="Believed value, SI; a factor of two off is no harm.")
    ] = None,
    travel: Annotated[str | None, typer.Option(metavar="FROM,TO", help="Allowed positions.")] = None,
    top_speed: Annotated[float | None, typer.Option(metavar="V", help="Allowed speed, unit/s.")] = None,
    top_acceleration: Annotated[float | None, typer.Option(metavar="A", help="Allowed acceleration, unit/s^2.")] = None,
    jerk: Annotated[float | None, typer.Option(metavar="J", help="Allowed jerk, unit/s^3; 0: any.")] = None,
    duration: Annotated[float, typer.Option(metavar="S", help="Longest test.")] = 60.0,
    unit: Annotated[str | None, typer.Option(help="Of travel, speed, encoder: mm, m, deg or rad.")] = None,
    encoder_step: Annotated[float | None, typer.Option(metavar="X", help="Of the measured position.")] = None,
    noise: Annotated[float | None, typer.Option(metavar="X", help="Of the measured position, rms.")] = None,
    force_noise: Annotated[
        float | None,
        typer.Option(metavar="F", help="Force that a model leaves, rms; 2 % of Coulomb friction unless a fit says it."),
    ] = None,
    period: Annotated[
        float | None, typer.Option(metavar="S", help="Of the recorder; 0.001 unless a fit says it.")
    ] = None,
    by_direction: Annotated[
        bool, typer.Option("--by-direction", help="Friction of its own for each direction.")
    ] = False,
    target: Annotated[
        float | None, typer.Option(metavar="PERCENT", help="Half of every 95 % interval, of the value; else 5 to 30.")
    ] = None,
    axis: Annotated[
        str | None, typer.Option(metavar="LETTER", help="Axis of the program; X, or A where positions are angles.")
    ] = None,
    signals: Annotated[
        str | None, typer.Option(metavar="CMD,FB,OUT", help="HAL signals of command, feedback and drive.")
    ] = None,
    drive_unit: Annotated[
        str | None, typer.Option(help="Of the drive's signal, for the header of the log; V unless FIT says it.")
    ] = None,
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Propose a test move that tells what is missing of an axis: predicted intervals, program, recorder, safe limits.

    Limits and values come from FIT where options do not say them. The move keeps every limit in every sample.
    """
    from leadscrew.identify.excite import files
    from leadscrew.identify.excite.design import propose
    from leadscrew.report.excite import report_of

    machine = files.checked(_machine(axis or "X", signals, drive_unit or "V"))
    free([out, plot])
    options = {"travel": travel, "speed": top_speed, "acceleration": top_acceleration, "jerk": jerk}
    limits, belief = _asked(fit, tell, guess, options, unit, duration)
    belief = _sensor(belief, encoder_step, noise, force_noise, period, by_direction, unit)
    machine = replace(
        machine, axis=axis or ("A" if belief.unit == "rad" else "X"), drive_unit=drive_unit or belief.drive_unit or "V"
    )
    with progress() as bar:
        found = propose(limits, belief, target, bar)
    if out is not None:
        files.write(found, out, machine)
    deliver(report_of(found, out), plot=plot, as_json=as_json)


def _machine(axis: str, signals: str | None, drive_unit: str) -> Machine:
    from leadscrew.identify.excite.files import Machine

    if signals is None:
        return Machine(axis, drive_unit=drive_unit)
    names = [n.strip() for n in signals.split(",")]
    if len(names) != 3:
        raise ValueRefused(f"--signals {signals!r}: expected three names, of command, feedback and drive")
    command, feedback, output = names
    return Machine(axis, command, feedback, output, drive_unit)


def _asked(
    fit: Path | None, tell: str | None, guess: list[str] | None, options: dict[str, str | float | None],
    unit: str | None, duration: float,
) -> tuple[Limits, Belief]:  # fmt: skip
    from leadscrew.cli.fuzzy_files import numbers
    from leadscrew.identify.excite.belief import USUAL, Belief, belief_of, keys_of, values_of
    from leadscrew.identify.excite.move import Limits
    from leadscrew.kernel import validate

    if unit is not None:
        validate.one_of("--unit", unit, list(UNITS))
    known = numbers(guess or [], "--guess")
    wanted = None if tell is None else [t.strip() for t in tell.split(",") if t.strip()]
    if fit is None:
        kind, scale = UNITS[unit or "mm"]
        missing = [f"--{'top-' if n in ('speed', 'acceleration') else ''}{n}"
                   for n in ("travel", "speed", "acceleration") if options[n] is None]  # fmt: skip
        if missing:
            raise ValueRefused(f"{', '.join(missing)}: needed where no fit says what the axis may do")
        belief = Belief(
            values_of(known), 0.0, 1e-3, unit=kind, force_unit="N" if kind == "m" else "N m",
            wanted=keys_of(USUAL if wanted is None else wanted),
        )  # fmt: skip
        limits = Limits(0.0, 0.0, 0.0, 0.0)
    else:
        belief, limits = belief_of(fit, wanted, known)
        scale = _scale(unit, belief.unit)
    low, high = (limits.low, limits.high) if options["travel"] is None else _travel(str(options["travel"]), scale)
    given = {n: scale * float(v) for n, v in options.items() if n != "travel" and v is not None}
    if fit is not None and not given and options["travel"] is None:
        note(f"travel, speed and acceleration are those that the log of {fit} has shown; --travel, --top-speed and "
             "--top-acceleration allow more")  # fmt: skip
    return limits._replace(low=low, high=high, duration=duration, **given), belief


def _scale(unit: str | None, kind: str) -> float:
    chosen = unit or ("mm" if kind == "m" else "deg")
    if UNITS[chosen][0] != kind:
        raise ValueRefused(f"--unit {chosen}: the fit is in {kind}")
    return UNITS[chosen][1]


def _travel(text: str, scale: float) -> tuple[float, float]:
    try:
        low, high = (scale * float(x) for x in text.split(","))
    except ValueError:
        raise ValueRefused(f"--travel {text!r}: expected FROM,TO, two numbers, for example --travel 0,300") from None
    return low, high


def _sensor(
    belief: Belief, step: float | None, noise: float | None, force: float | None, period: float | None,
    by_direction: bool, unit: str | None,
) -> Belief:  # fmt: skip
    from leadscrew.kernel import validate

    scale = _scale(unit, belief.unit)
    if step is not None:
        belief = replace(belief, noise=scale * validate.positive("--encoder-step", step, "") / 12.0**0.5)
    if noise is not None:
        belief = replace(
            belief,
            noise=max(belief.noise if step is not None else 0.0, scale * validate.positive("--noise", noise, "")),
        )
    if period is not None:
        belief = replace(belief, period=validate.positive("--period", period, "s"))
    if by_direction:
        belief = replace(belief, symmetric=False)
    if force is None and not belief.force_noise:
        force = 0.02 * max(belief.side("coulomb", True), belief.side("coulomb", False))
    if force is not None:
        if not 0.0 <= force < float("inf"):
            raise ValueRefused(f"--force-noise {force!r}: allowed range is [0, inf)")
        belief = replace(belief, force_noise=force)
    return belief
