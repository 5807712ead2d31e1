"""Adaptive inversion of the cutting law: the feed that gives the force, from what feed and force were just now.

    h_f = keep h_f + (1 - keep) (x - x(theta - 1))                   feed per revolution, filtered as the force is
    h   = h_f - (y - y(theta - 1)) / stiffness                       chip thickness: less what tool and work give way
    p   = h^P,      nu = y / (K p) - 1,            the next two lines only if p > 0.002 and y > 5 N
    Pi  := Pi + drift, and + jump if abs(nu) > 0.06
    K   := K (1 + g nu),      Pi := Pi (1 - g),    g = Pi / (Pi + (noise_n / (p K0))^2)
    u   := u + share (n (r / K)^(1/P) / gain - u), held to lower .. upper

``K``, N/mm^P, is specific force times depth of cut, with the prior ``K0`` (``first_k``) and the relative variance
``Pi``, one at the start: a Kalman filter of one state. ``n`` is the spindle speed, from its encoder; ``gain`` the feed
at 1 V. Once ``K`` is known the feed is right whatever the depth, so the loop's gain does not change with it; ``K``
follows the force, so there is no steady error. A feed that a stopped spindle is given is 0.

The prior should lie above the true ``K``: below it the first feed is too large. Without the correction for compliance
(``stiffness`` large) the chip is over-estimated while the force rises, and the force overshoots. ``P`` is believed, not
estimated: :mod:`leadscrew.controllers.constant_force` estimates it.

Source: ours, for the study ``grey_turning``. Reads :class:`~leadscrew.sensors.CutReading`.

Bumpless start: ``K`` is set so that the output is the one of the moment; nothing is learned in the first revolution.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.controllers._force.revolution import Turns, nothing_yet, one_ago, recorded, speed
from leadscrew.controllers._grey_fuzzy.surface import Lower, Upper
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Lt, Unit
from leadscrew.util.errors import ValueRefused

LEAST_P, LEAST_N = 0.002, 5.0
"""Chip to the power of ``P``, and force, below which nothing is learned."""
SURPRISE = 0.06
"""Relative difference from what was expected, from which the estimate is opened."""
TINY = 1e-30

ForceLaw = Annotated[float, Gt(0), Le(1), Doc("P that is believed in: how force grows with chip thickness")]
Stiffness = Annotated[float, Unit("N/mm"), Gt(0), Doc("believed, of tool and work along the feed, per main force")]
FeedGain = Annotated[float, Unit("mm/(min V)"), Gt(0), Doc("feed at 1 V")]
Rpm = Annotated[float, Unit("1/min"), Gt(0), Doc("spindle speed until two readings of its encoder are there")]
Keep = Annotated[float, Ge(0), Lt(1), Doc("coefficient of the force's digital filter")]


class PowerLawInversionParams(NamedTuple):
    """What is believed of material and machine, and how fast it is given up."""

    first_k: Annotated[float, Unit("N/mm^P"), Gt(0), Doc("specific force times depth at the start, K0")] = 2933.2
    exponent: ForceLaw = 0.8
    stiffness: Stiffness = 20000.0
    share: Annotated[float, Gt(0), Le(1), Doc("share of the way to the wanted feed that is gone in a period")] = 0.3
    noise_n: Annotated[float, Unit("N"), Gt(0), Doc("scatter of the filtered force")] = 1.2
    drift: Annotated[float, Ge(0), Doc("relative variance that K gains in a period")] = 2e-4
    jump: Annotated[float, Ge(0), Doc("the same where the force surprises")] = 0.05
    keep: Keep = 0.8
    gain: FeedGain = 150.0
    spindle_rpm: Rpm = 1200.0
    lower: Lower = 0.0
    upper: Upper = 1.0


class PowerLawInversionState(NamedTuple):
    """What is known."""

    turns: Turns = nothing_yet()
    feed: Annotated[float, Unit("mm"), Doc("feed per revolution, filtered")] = 0.0
    k: Annotated[float, Unit("N/mm^P"), Doc("specific force times depth, K; 0 before the first period")] = 0.0
    variance: Annotated[float, Doc("its relative variance, Pi")] = 1.0
    output: Annotated[float, Unit("V"), Doc("output")] = 0.0
    held: Annotated[float, Doc("1 in the first period after a bumpless start, else 0")] = 0.0


class PowerLawInversionPlan(NamedTuple):
    """The parameters as the step reads them, and a history without a reading."""

    first_k: float
    exponent: float
    stiffness: float
    share: float
    noise_n: float
    drift: float
    jump: float
    keep: float
    gain: float
    spindle_rpm: float
    lower: float
    upper: float
    blank: Turns


def ready(params: PowerLawInversionParams, dt: float) -> PowerLawInversionPlan:
    """The parameters, their limits checked.

    Raises:
        ValueRefused: limits the wrong way round.
    """
    if not params.lower < params.upper:
        raise ValueRefused(f"lower = {params.lower:g} V, upper = {params.upper:g} V: the lower limit must be below")
    return PowerLawInversionPlan(*params, nothing_yet(0.0))


def feed_for(force, k, exponent, rpm):
    """The feed in mm/min that gives a force: ``n (F / K)^(1/P)``."""
    return max(rpm, 0.0) * (max(force, 0.0) / k) ** (1.0 / exponent)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    chip = max(params.gain * output / params.spindle_rpm, 1e-6)
    k = max(command.force, LEAST_N) / chip**params.exponent
    return PowerLawInversionState(params.blank, chip, k, 1.0, output, 1.0)


@controller(
    PowerLawInversionParams(), PowerLawInversionState(), prepare=ready, align=align, unit="V", drive="voltage",
    full_scale=1.0,
)  # fmt: skip
def power_law_inversion(p, s, command, feedback, dt):
    """Feed from an estimate of the specific cutting force, by feed per revolution and force; a voltage."""
    rpm = speed(s.turns, feedback.turns, p.spindle_rpm, dt)
    turns = recorded(s.turns, feedback.travel, feedback.turns, feedback.force)
    before = one_ago(turns)
    filtered = p.keep * s.feed + (1.0 - p.keep) * (feedback.travel - before.travel)
    feed = filtered if before.whole > 0.5 else s.feed
    chip = feed - (feedback.force - before.force) / p.stiffness
    power = max(chip, 1e-9) ** p.exponent
    known = s.k if s.k > 0.0 else p.first_k
    learns = before.whole > 0.5 and power > LEAST_P and feedback.force > LEAST_N
    surprise = feedback.force / (known * power) - 1.0
    opened = s.variance + p.drift + (p.jump if abs(surprise) > SURPRISE else 0.0)
    scatter = p.noise_n / (power * p.first_k)
    gain = opened / (opened + scatter * scatter)
    k = known * (1.0 + gain * surprise) if learns else known
    variance = (1.0 - gain) * opened if learns else s.variance
    wanted = feed_for(command.force, k, p.exponent, rpm) / p.gain
    moved = s.output + p.share * (wanted - s.output)
    output = min(max(s.output if s.held > 0.5 else moved, p.lower), p.upper)
    return PowerLawInversionState(turns, feed if abs(feed) > TINY else 0.0, k, variance, output, 0.0), output


power_law_inversion.step.takes_cut = True  # type: ignore[attr-defined]
