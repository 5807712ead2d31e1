"""An identified axis in words: numbers with the unit that suits them, names of parameters, sentences."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from leadscrew.identify.axis.cascade import OBEYS
from leadscrew.report.tables import NOTHING

if TYPE_CHECKING:
    from leadscrew.identify.axis.result import AxisFit, Judged, Parameter

PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))
MODELS = {
    "coulomb": "Coulomb and viscous friction",
    "stribeck": "Coulomb, viscous and static friction (Stribeck)",
    "lugre": "LuGre friction (with pre-sliding)",
}
NAMES = {
    "mass": "moving mass", "offset": "offset", "backlash": "lost motion", "force_per_drive": "force of a unit of drive",
    "delay_s": "delay of the drive", "coulomb": "Coulomb friction", "viscous": "viscous friction",
    "static": "static friction", "stribeck_speed": "Stribeck speed", "stiffness": "pre-sliding stiffness",
    "damping": "pre-sliding damping",
}  # fmt: skip
ENDS_WELL = 2.0
"""Times the error on the training part that the error on the hold-out may be, before a sentence says so."""
FORCE_ENDS_WELL = 1.5
"""The same for the force that inverse dynamics leaves: position adds up what is small, force does not."""
TOO_GOOD = ": the model knows its own data too well, or the axis has changed, so go by the error on unseen data"
NEGLIGIBLE = 0.1
"""Percent of the range of the position below which the error on the hold-out is good whatever the ratio."""
TRADES = 100.0
"""Condition number from which parameters trade with one another."""


def num(value: float | None, digits: int = 4) -> str:
    """A number with some significant digits, a dash for none; of more than four, zeros at the end count."""
    if value is None or not math.isfinite(value):
        return NOTHING
    return f"{value:.{digits}g}" if digits <= 4 else f"{value:#.{digits}g}"


def digits_of(parameter: Parameter) -> int:
    """Significant digits that show a parameter's interval: four, and up to seven where it is narrow."""
    half = 0.5 * (parameter.high - parameter.low)
    if not (math.isfinite(half) and half > 0.0 and parameter.value):
        return 4
    return min(max(4, math.floor(math.log10(abs(parameter.value) / half)) + 2), 7)


def scaled(value: float, unit: str, digits: int = 4) -> str:
    """A value in SI with the prefix that suits it: 3.1e-6 m is ``3.1 um``; a dash for none."""
    if not math.isfinite(value):
        return NOTHING
    factor, prefix = next(((f, p) for f, p in PREFIXES if abs(value) >= f), PREFIXES[-1] if value else PREFIXES[0])
    return f"{value / factor:.{digits}g} {prefix}{unit}"


def display(largest: float, unit: str) -> tuple[float, str]:
    """Factor and unit for the axis of a picture whose largest value is this."""
    factor, prefix = next(((f, p) for f, p in PREFIXES if abs(largest) >= f), PREFIXES[0])
    return 1.0 / factor, f"{prefix}{unit}"


def merged(fit: AxisFit) -> dict[str, Parameter]:
    """The parameters without those of backward motion that repeat the forward ones."""
    rows = dict(fit.parameters)
    for key, other in fit.parameters.items():
        twin = key.replace(".backward.", ".forward.")
        if fit.symmetric and twin != key and twin in rows and rows[twin].value == other.value:
            del rows[key]
    return rows


def name_of(fit: AxisFit, key: str) -> str:
    """What a key stands for: ``Coulomb friction, backward``."""
    *_, last = key.split(".")
    name = "moving inertia" if key == "mass" and fit.position_unit == "rad" else NAMES.get(last, last)
    if key.startswith("friction.forward."):
        return f"{name}, {'both ways' if key not in separate(fit) else 'forward'}"
    return f"{name}, backward" if key.startswith("friction.backward.") else name


def separate(fit: AxisFit) -> set[str]:
    """Keys of friction that are told apart by direction."""
    rows = merged(fit)
    return {k for k in rows if k.replace(".forward.", ".backward.") in rows and ".forward." in k}


def force_unit(fit: AxisFit) -> str:
    """The unit of forces in this fit: N or N m, or the drive's own where its force is not known."""
    found = next((p.unit for k, p in fit.parameters.items() if k.endswith(".coulomb") or k == "offset"), "")
    return found or fit.drive_unit


def state_of(parameter: Parameter) -> str:
    """``fitted``, ``not told``, ``fixed`` or ``given``."""
    return "not told" if parameter.how == "fitted" and not parameter.told else parameter.how


def why(parameter: Parameter) -> str:
    """The note of a parameter, and that it has no interval where a fitted one has none."""
    bare = parameter.how == "fitted" and not (math.isfinite(parameter.low) and math.isfinite(parameter.high))
    return "; ".join(x for x in (parameter.note, "no interval is known" if bare else "") if x)


def length(fit: AxisFit, value: float) -> str:
    """A position or an error of it."""
    return scaled(value, fit.position_unit)


def open_loop(fit: AxisFit) -> tuple[Judged | None, Judged | None]:
    """The stretches ``training`` and ``hold-out``."""
    return fit.judgement("training"), fit.judgement("hold-out")


def sentences(fit: AxisFit) -> list[str]:
    """The result in words, a line each: what was fitted, how good it is on data it has not seen, what is not told."""
    alike = "alike both ways" if fit.symmetric else "by direction"
    said = [*fit.faults, f"{MODELS[fit.model]}, {alike}", fit.method.rstrip("."), *_judged(fit)]
    if fit.condition > TRADES:
        said.append(
            f"condition number {num(fit.condition, 3)}: parameters trade with one another, so their intervals are wide"
        )
    if fit.missing:
        rows = merged(fit)
        said.append(
            f"not told by this log: {', '.join(k for k in fit.missing if k in rows or k not in fit.parameters)}"
        )
    said.append(
        f"known from {length(fit, fit.travel[0])} to {length(fit, fit.travel[1])}, up to "
        f"{scaled(fit.top_speed, f'{fit.position_unit}/s')} and {num(fit.top_acceleration)} "
        f"{fit.position_unit}/s^2; what the model says beyond that is a guess"
    )
    return said


def _judged(fit: AxisFit) -> list[str]:
    seen, unseen = open_loop(fit)
    if unseen is None:
        said = ["no hold-out: every error here is on data that the fit has seen, and says nothing about other data"]
    else:
        said = [
            f"on data that the fit has not seen ({unseen.start_s:g} to {unseen.end_s:g} s) the simulated position is "
            f"off by {length(fit, unseen.rms)} rms, {num(unseen.nrmse_percent, 3)} % of its range"
        ]
        if seen is not None and seen.rms > 0.0:
            said.append(_beside(seen, unseen))
    closed = closed_loop(fit)
    if closed is not None:
        said.append(
            f"under the known controller ({closed.start_s:g} to {closed.end_s:g} s) the simulated position is off by "
            f"{length(fit, closed.rms)} rms; a controller hides faults of a model, so judge the model by the line above"
        )
        left = fit.cascade_left_percent
        if left is not None and left > OBEYS:
            said.append(
                f"the known controller leaves {num(left, 3)} % of the logged drive (allowed are {OBEYS:g} %): it did "
                "not make this log, so its score says nothing; check kp, kv, ki, over and the unit of the command"
            )
    return said


def _beside(seen: Judged, unseen: Judged) -> str:
    """The error on unseen data beside that on the data of the fit; the force left tells what a larger one means."""
    ratio = unseen.rms / seen.rms
    said = f"that is {f'{num(ratio, 3)} times' if ratio >= 1.0 else 'no more than'} the error on the data of the fit"
    if ratio <= ENDS_WELL or unseen.nrmse_percent <= NEGLIGIBLE:
        return said
    forces = f"{num(unseen.force_percent, 3)} % of the force is left there, {num(seen.force_percent, 3)} % here"
    if unseen.force_percent > FORCE_ENDS_WELL * seen.force_percent:
        return f"{said}; {forces}{TOO_GOOD}"
    return f"{said}; {forces}, so small forces add up in the position"


def closed_loop(fit: AxisFit) -> Judged | None:
    """The stretch under the known controller: of the hold-out, or the last one that there is."""
    found = [j for j in fit.judged if j.what.endswith("closed loop")]
    return next((j for j in found if j.what.startswith("hold-out")), found[-1] if found else None)


def notes(fit: AxisFit, findings: Iterable[str] = ()) -> list[str]:
    """What is odd about the log and the fit, each sentence once."""
    return [note for note in dict.fromkeys([*findings, *fit.notes]) if note not in fit.faults]
