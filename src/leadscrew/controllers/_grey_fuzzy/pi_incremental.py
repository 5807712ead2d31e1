"""Incremental PI controller, what the fuzzy controllers are inside their rules.

    u(k) = clip(u(k-1) + Kp (e(k) - e(k-1)) + Ki e(k), lower, upper),      e(k) = r(k) - y(k)

``Ki`` is a sample: it goes with the period. No difference in the first period. Clamping the output is the anti-windup.
A TFC of the scaling factors S1, S2, S3 has ``Kp = S3 / S2`` and ``Ki = S3 / S1``; unlike there, the increment here does
not saturate.

Bumpless start: the output before is set so that the next one is the last one.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.controllers._grey_fuzzy.surface import Lower, Upper
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.util.errors import ValueRefused


class PiIncrementalParams(NamedTuple):
    """Gains and limits."""

    kp: Annotated[float, Unit("V/N"), Ge(0), Doc("output per change of the error")] = 0.00131
    ki: Annotated[float, Unit("V/N"), Ge(0), Doc("output per error, a sample")] = 0.00029
    lower: Lower = 0.0
    upper: Upper = 1.0


class PiIncrementalState(NamedTuple):
    """What the controller remembers."""

    error: Annotated[float, Unit("N"), Doc("error, e")] = 0.0
    output: Annotated[float, Unit("V"), Doc("output; increments add to it")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


def ready(params: PiIncrementalParams, dt: float) -> PiIncrementalParams:
    """The parameters, their limits checked.

    Raises:
        ValueRefused: limits the wrong way round.
    """
    if not params.lower < params.upper:
        raise ValueRefused(f"lower = {params.lower:g} V, upper = {params.upper:g} V: the lower limit must be below")
    return params


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    error = command - feedback
    return PiIncrementalState(error, output - params.ki * error, 1.0)


@controller(
    PiIncrementalParams(), PiIncrementalState(), prepare=ready, align=align, unit="V", drive="voltage", full_scale=1.0
)
def pi_incremental(p, s, command, feedback, dt):
    """PI controller that adds to its output, held to its limits; a voltage."""
    error = command - feedback
    raw = s.output + p.kp * (error - s.error) * s.started + p.ki * error
    output = min(max(raw, p.lower), p.upper)
    return PiIncrementalState(error, output, 1.0), output
