"""The fuzzy sliding mode of the stage in continuous time: ideal speed, bristles at steady sliding at the start."""

from dataclasses import replace
from typing import NamedTuple

from leadscrew.controllers._sliding.fuzzy import RULES, fuzzy_law, sliding_system
from leadscrew.controllers._sliding.stage import View
from leadscrew.friction.lugre import HAT, LuGre, bristle_rate, friction, steady_bristle
from leadscrew.fuzzy.engine import engine
from leadscrew.kernel.block import make
from leadscrew.kernel.loop import Loop
from leadscrew.plants._ballscrew_stage import ballscrew_stage
from tests.controllers.stage_loop import both, command, start_speed


class IdealState(NamedTuple):
    xi: float = 0.0
    bristle: float = 0.0


def ideal(block, law, start=0.0):
    """The law of a block of fuzzy_sliding as a continuous controller; f_hat from 1: commanded, 2: measured speed."""

    def fuzzy_ideal(p, s, command, feedback):
        """Derivatives of xi and the bristles, and the torque."""
        e = feedback.angle - command.position
        commanded = p.stage.friction_from == 1
        v = command.velocity if commanded else feedback.speed
        rate = bristle_rate(p.stage.hat, v, s.bristle)
        held = friction(p.stage.hat, v, s.bristle, rate if commanded else 0.0)
        now = View(
            feedback.angle, feedback.speed, e, feedback.speed - command.velocity, s.xi, command.acceleration, held,
            0.0, 0.0, 0.0,
        )  # fmt: skip
        return IdealState(e, rate), held + p.stage.inertia * law(p, now).u

    return make(
        "controller", fuzzy_ideal, block.params, IdealState(0.0, start), prepare=block.prepare, continuous=True,
        doc="Fuzzy sliding mode without sampling.",
    )  # fmt: skip


def rules_law(rules="corrected"):
    """The law of one of the rule bases."""
    return fuzzy_law(engine(sliding_system(RULES[rules])))


def continuous_fuzzy(block, name, law, sample, rtol=1e-6, atol=1e-11):
    """A loop on one of the sines that starts in steady sliding, on the command."""
    v = start_speed(name)
    plant = ballscrew_stage.starting(speed=v, bristle=steady_bristle(LuGre(), v))
    return Loop(
        reference=command(name), controller=ideal(block, law, steady_bristle(HAT, v)),
        plant=replace(plant, output=both, jacobian=None), period=None, sample=sample, metrics={}, rtol=rtol, atol=atol,
    )  # fmt: skip
