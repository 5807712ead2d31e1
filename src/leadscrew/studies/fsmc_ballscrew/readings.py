"""Other readings of the paper's laws than the five of the study, in continuous time and held over a period.

All are one law with eight numbers, in rad (``sat`` inside [-1, 1], ``K`` and ``F_hat`` as in
:mod:`leadscrew.controllers._sliding.stage`):

    u = y_r'' - u_rate lam e' - u_e lam^2 e - u_xi lam^3 xi - K sat(slope / K (s_rate e' + s_e lam e + s_xi lam^2 xi))
    T = F_hat + J u

Source: Shams and Safdari (2010), equations (8) to (15).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from leadscrew.controllers._sliding.continuous import IdealState, ideal_view, in_motion, seen
from leadscrew.controllers._sliding.fuzzy import RULES, FsmcParams, fsmc, fuzzy_law, sliding_system
from leadscrew.controllers._sliding.stage import SlidingParams, sat
from leadscrew.friction.lugre import LuGre, bristle_after
from leadscrew.fuzzy.engine import engine
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.parameters import Doc
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.studies.fsmc_ballscrew.scenarios import SCENARIOS, command, sliding, start_speed
from leadscrew.studies.lab import Lab

if TYPE_CHECKING:
    from leadscrew.kernel.loop import Loop


class Weights(NamedTuple):
    """Terms of ``u``, what the switching term acts on, and how the bound F~ is read."""

    u_rate: Annotated[float, Doc("of lam e'")] = 1.0
    u_e: Annotated[float, Doc("of lam^2 e")] = 0.0
    u_xi: Annotated[float, Doc("of lam^3 xi")] = 0.0
    s_rate: Annotated[float, Doc("of e'")] = 1.0
    s_e: Annotated[float, Doc("of lam e")] = 1.0
    s_xi: Annotated[float, Doc("of lam^2 xi")] = 0.0
    signed: Annotated[Literal["off", "on"] | int, Doc("F~ is sign(y') times itself, so 0 at rest")] = 0


CONVENTIONAL = Weights()
LITERAL = Weights(3.0, 3.0, 1.0, 1.0, 2.0, 1.0)
SLOTINE = Weights(2.0, 1.0, 0.0, 1.0, 2.0, 1.0)
COMPLEMENTARY = Weights(3.0, 3.0, 1.0, 2.0, 2.0, 0.0)
"""Literal: (8) and (10), after Liang and Su, ``s' + lam s = v_c``. Slotine: the same surface, ``s' = v_c``."""


class ReadingParams(NamedTuple):
    """The law, and what every law of the stage has."""

    weights: Weights = Weights()
    stage: SlidingParams = SlidingParams(travel_per_rad=TRAVEL_MM_PER_RAD)

    @property
    def hat(self) -> LuGre:
        """What is believed of the friction."""
        return self.stage.hat


def wanted(p, now):
    """``u``."""
    w, lam = p.weights, p.stage.lam
    s = w.s_rate * now.rate + lam * (w.s_e * now.e + lam * w.s_xi * now.xi)
    full = p.stage.eta if w.signed > 0 and now.speed == 0.0 else now.gain
    known = lam * (w.u_rate * now.rate + lam * (w.u_e * now.e + lam * w.u_xi * now.xi))
    return now.acceleration - known - full * sat(s * now.slope / now.gain)


def _ideal(p, s, command, feedback):
    """Derivatives of xi and of the believed bristles, and the torque."""
    now, rate = ideal_view(p.stage, s, command, feedback)
    return IdealState(now.e, rate), now.friction + p.stage.inertia * wanted(p, now)


def after_period(p, s, now, command, dt):
    """``xi`` and the believed bristles a period later; ``p``: SlidingParams."""
    commanded = p.friction_from == 1
    v = command.velocity / p.travel_per_rad if commanded else now.speed
    a = command.acceleration / p.travel_per_rad if commanded else 0.0
    return IdealState(s.xi + now.e * dt, bristle_after(p.hat, v + 0.5 * a * dt, s.bristle, dt))


def _held(p, s, command, feedback, dt):
    """The same law held over a period: speed seen exactly, F_hat that of the sample."""
    now, _ = ideal_view(p.stage, s, command, feedback)
    return after_period(p.stage, s, now, command, dt), now.friction + p.stage.inertia * wanted(p, now)


reading = make(
    "controller", _ideal, ReadingParams(), IdealState(), continuous=True, name="reading", unit="N m", drive="torque",
    doc="Sliding mode by any reading of the paper, without sampling; a torque.",
)  # fmt: skip
held_reading = make(
    "controller", _held, ReadingParams(), IdealState(), name="held_reading", unit="N m", drive="torque",
    doc="Sliding mode by any reading of the paper, held over a period; a torque.",
)  # fmt: skip


def held_fuzzy(rules: str = "corrected") -> Block:
    """Fuzzy sliding mode held over a period: position and speed seen exactly, F_hat that of the sample."""
    law: Any = fuzzy_law(engine(sliding_system(RULES[rules])))

    def held(p, s, command, feedback, dt):
        """``xi`` and the believed bristles a period later, and the torque."""
        now, _ = ideal_view(p.stage, s, command, feedback)
        torque = now.friction + p.stage.inertia * law(p, now).u
        return after_period(p.stage, s, now, command, dt), torque

    params: FsmcParams = fsmc.params._replace(travel_per_rad=TRAVEL_MM_PER_RAD)
    return make(
        "controller", held, params, IdealState(), prepare=fsmc.prepare, name="held_fsmc", unit="N m", drive="torque",
        doc="Fuzzy sliding mode held over a period; a torque.",
    )  # fmt: skip


HELD_FUZZY = held_fuzzy()
"""The corrected rules, with the scales for continuous time."""


def read_as(weights: Weights, eta: float, held: bool = False, friction_from: int = 1) -> Block:
    """A reading as a block, in mm; continuous, or ``held`` over a period."""
    block = held_reading if held else reading
    stage = block.params.stage._replace(eta=eta, friction_from=friction_from)
    return replace(block, params=ReadingParams(weights, stage))


def held_loop(lab: Lab, block: Block, period: float, scenario: str = "sine_fast") -> Loop:
    """A held law on a sine, position and speed seen exactly, from steady sliding on the command."""
    from leadscrew.kernel.loop import Loop

    move = SCENARIOS[scenario].params
    speed = start_speed(move)
    plant = replace(ballscrew_stage(travel_per_rad=TRAVEL_MM_PER_RAD), output=seen)
    loop = Loop(
        reference=command(move), controller=in_motion(block, speed), plant=sliding(plant, speed), period=period,
        method="rodas", rtol=1e-4, atol=1e-10, metrics={}, bound=1e6,
    )  # fmt: skip
    loop.adopt_program(lab.once(("program", loop.compiled_from()), lambda: loop))
    return loop
