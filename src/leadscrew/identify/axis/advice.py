"""What to measure next: for each parameter that a log does not tell, the motion that would."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from leadscrew.identify.axis.parameters import NO_OFFSET, WEIGHT
from leadscrew.identify.axis.result import Parameter

ORDER = (
    "mass",
    "coulomb",
    "viscous",
    "offset",
    "static",
    "stribeck_speed",
    "delay_s",
    "backlash",
    "stiffness",
    "damping",
)
NO_LOG_TELLS = (NO_OFFSET, WEIGHT)
"""Notes of parameters that no motion would tell."""
NAMES = {
    "stribeck_speed": "Stribeck speed", "coulomb": "Coulomb friction", "viscous": "viscous friction",
    "static": "static friction", "delay_s": "delay", "stiffness": "stiffness of the bristles",
    "damping": "damping of the bristles",
}  # fmt: skip


def name_of(key: str) -> str:
    """A parameter in words."""
    last = key.split(".")[-1]
    side = next((f" {s}s" for s in ("forward", "backward") if f".{s}." in key), "")
    return NAMES.get(last, last) + side


def advice(
    parameters: Mapping[str, Parameter], top_speed: float, unit: str, both_ways: bool, force_percent: float
) -> list[str]:
    """Sentences, most useful first; ``unit`` is that of the position, ``force_percent`` what the model leaves."""
    unknown = {key.split(".")[-1] for key in missing(parameters)}
    found = []
    if not both_ways:
        found.append(
            "Move both ways: in one direction a constant force and Coulomb friction act alike, and nothing is known of "
            "friction backwards."
        )
    if "mass" in unknown:
        found.append(
            "Accelerate harder, some ten times over: the force of the acceleration should be as large as friction."
        )
    if "viscous" in unknown:
        found.append(
            f"Hold three or more steady speeds for 0.3 s each, from {0.1 * top_speed:.2g} to {top_speed:.2g} {unit}/s, "
            "both ways: viscous friction is the slope between them."
        )
    if unknown & {"coulomb", "offset"} and both_ways:
        found.append("Slide longer at low speed both ways: half of the difference of the drive is Coulomb friction.")
    if unknown & {"static", "stribeck_speed"}:
        found.append(
            f"Creep: some seconds each way at {0.01 * top_speed:.2g} {unit}/s and below, and slow reversals; there "
            "friction rises from Coulomb to static friction."
        )
    if "delay_s" in unknown:
        found.append(
            "Let the drive change fast (short ramps, or a square wave): a delay shows where the drive is steep."
        )
    if unknown & {"stiffness", "damping"}:
        found.append("Reverse slowly from rest, below the break-away force: there the axis moves on its bristles.")
    if force_percent > 5.0:
        found.append(
            f"The model leaves {force_percent:.0f} % of the force: look at the residual against position (a ripple of "
            "the screw or the motor), speed (a form of friction) and time (warming up)."
        )
    return found


def missing(parameters: Mapping[str, Parameter]) -> tuple[str, ...]:
    """Keys that are not identifiable from the log, most important first."""
    keys = [key for key, p in parameters.items() if _asked(key, p)]
    return tuple(sorted(keys, key=lambda k: _place(k.split(".")[-1])))


def _asked(key: str, p: Parameter) -> bool:
    """Whether a motion could tell it: a play behind the encoder shows in no log of that encoder."""
    return not p.identifiable and p.how != "given" and p.note not in NO_LOG_TELLS and key != "backlash"


def _place(name: str, order: Sequence[str] = ORDER) -> int:
    return order.index(name) if name in order else len(order)
