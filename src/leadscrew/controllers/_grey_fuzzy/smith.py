"""Smith predictor around the fuzzy force controller: a model of the lathe takes the delay out of the loop.

    v'' = wn^2 (u - v) - 2 zeta wn v'                       feed servo, over its gain
    m(k) = keep m(k-1) + (1 - keep) gain v(kT)              force without the delay, through the filter of the load cell
    y*   = y + m(k) - m(k - delay)                          what the rules see in place of y
    u(k) = rules on e = r - y* and its change               as in leadscrew.controllers._grey_fuzzy.tfc

``gain`` is the slope of the force at the set-point, ``P F Kv / v``: 488 N/V for 150 N, 1 mm, S45C, 1,200 1/min.
``delay`` is what the chip takes to build up, half a revolution in the mean, and the dead time of the drive; between two
samples it goes by straight line, at most four periods. The servo is discretised exactly for an output that is held
over the period. The model sees the output after its limits. In steady state ``y* = y``: errors of the model do not bias
the force, they cost damping.

Source: O. J. M. Smith, *Closer control of loops with dead time*, Chem. Eng. Prog. 53 (1957); the model of the process
is the study's, for the paper has none.

Bumpless start, incremental only: the model at rest under the output of the moment.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._grey_fuzzy.rule_tables import STANDARD
from leadscrew.controllers._grey_fuzzy.surface import (
    ChangeScale,
    ErrorScale,
    Inference,
    Lower,
    OutputScale,
    Positional,
    Rules,
    Surface,
    Upper,
    before_output,
    driven,
    ready_surface,
)
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Lt, Unit
from leadscrew.util.errors import ValueRefused

MOST = 4.0
"""Longest delay, in periods."""
TINY = 1e-30
"""Below this a state of the model is remembered as 0."""


class FeedModel(NamedTuple):
    """What the controller believes of the lathe near the set-point."""

    gain: Annotated[float, Unit("N/V"), Ge(0), Doc("force per output in steady state")] = 488.0
    rate: Annotated[float, Unit("rad/s"), Gt(0), Le(1e4), Doc("natural frequency of the feed servo, wn")] = 40.0
    damping: Annotated[float, Gt(0), Lt(1), Doc("damping of the feed servo, zeta")] = 0.7
    keep: Annotated[float, Ge(0), Lt(1), Doc("coefficient of the load cell's filter, alpha")] = 0.8
    delay_s: Annotated[float, Unit("s"), Ge(0), Doc("half a spindle revolution and the dead time")] = 0.025


class SmithParams(NamedTuple):
    """Scaling factors, rules, limits, and the model."""

    error_scale: ErrorScale = 25.0
    change_scale: ChangeScale = 5.65
    output_scale: OutputScale = 0.0106
    rules: Rules = STANDARD
    inference: Inference = 0
    positional: Positional = False
    lower: Lower = 0.0
    upper: Upper = 1.0
    model: FeedModel = FeedModel()


class Plan(NamedTuple):
    """The parameters as the step reads them."""

    surface: Surface
    gain: float
    keep: float
    vv: float
    va: float
    av: float
    aa: float
    late0: Annotated[float, Doc("share of the model's force of now in the delayed one")]
    late1: float
    late2: float
    late3: float
    late4: float


class SmithState(NamedTuple):
    """What the controller remembers, and what it saw."""

    feed: Annotated[float, Unit("V"), Doc("believed feed, as the output that would hold it")] = 0.0
    rate: Annotated[float, Unit("V/s"), Doc("its rate of change")] = 0.0
    force: Annotated[float, Unit("N"), Doc("believed filtered force without the delay, m")] = 0.0
    force1: float = 0.0
    force2: float = 0.0
    force3: float = 0.0
    sent: Annotated[float, Unit("V"), Doc("output of the last period, under which the model went on")] = 0.0
    error: Annotated[float, Unit("N"), Doc("error of the force without the delay")] = 0.0
    change: Annotated[float, Unit("N"), Doc("its change in one period")] = 0.0
    output: Annotated[float, Unit("V"), Doc("output; increments add to it")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


def ready(params: SmithParams, dt: float) -> Plan:
    """The model made discrete.

    Raises:
        ValueRefused: limits the wrong way round, or a delay of more than four periods.
    """
    m = params.model
    late = m.delay_s / dt
    if late > MOST:
        raise ValueRefused(f"model.delay_s = {m.delay_s:g} s (smith): allowed are up to {MOST:g} periods of {dt:g} s")
    sigma, beat = m.damping * m.rate, m.rate * math.sqrt(1.0 - m.damping * m.damping)
    shrunk, c, s = math.exp(-sigma * dt), math.cos(beat * dt), math.sin(beat * dt) / beat
    shares = (max(0.0, 1.0 - abs(late - k)) for k in range(5))
    return Plan(
        ready_surface(params), m.gain, m.keep, shrunk * (c + sigma * s), shrunk * s, -shrunk * m.rate * m.rate * s,
        shrunk * (c - sigma * s), *shares,
    )  # fmt: skip


def flushed(x):
    """A number, or 0 where it would soon be denormal."""
    return x if abs(x) > TINY else 0.0


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    error, force = command - feedback, params.gain * output
    before = before_output(params.surface, error, 0.0, output)
    return SmithState(output, 0.0, force, force, force, force, output, error, 0.0, before, 1.0)


@controller(SmithParams, SmithState, prepare=ready, align=align, unit="V", drive="voltage", full_scale=1.0)
def smith(p, s, command, feedback, dt):
    """Fuzzy controller with 49 rules behind a model that takes the delay of the chip out of the loop; a voltage."""
    off = s.feed - s.sent
    feed = flushed(s.sent + p.vv * off + p.va * s.rate)
    rate = flushed(p.av * off + p.aa * s.rate)
    force = flushed(p.keep * s.force + (1.0 - p.keep) * p.gain * feed)
    late = p.late0 * force + p.late1 * s.force + p.late2 * s.force1 + p.late3 * s.force2 + p.late4 * s.force3
    error = command - (feedback + force - late)
    change = (error - s.error) * s.started
    output = driven(p.surface, s.output, error, change)
    return SmithState(feed, rate, force, s.force, s.force1, s.force2, output, error, change, output, 1.0), output
