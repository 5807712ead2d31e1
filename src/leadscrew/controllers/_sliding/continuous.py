"""The sliding-mode laws without sampling: what the papers' equations describe.

Position and speed are known exactly and at every instant, ``xi' = e``, and the believed bristles are integrated along
with the stage. A loop of such a controller has ``period=None`` and a plant that shows a :class:`Seen`, see
:func:`seen_in_mm`. The laws, their parameters and units are those of the sampled blocks; ``pieces``, ``speed_filter_s``
and ``max_torque`` are not used, for there is no period and no limit.

    z_hat' = v - abs(v) z_hat / g_hat(v),    v by ``friction_from``: commanded or measured speed
    F_hat  = s0 z_hat + s1 z_hat' + s2 v     (2: without s1 z_hat'; 0: nothing)

Source: Shams and Safdari (2010), equations (6) to (16). That f_hat takes the commanded speed (``commanded``) is
our reading; the letter of the paper is 3.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

from leadscrew.controllers._sliding import complementary, conventional, integral
from leadscrew.controllers._sliding.fuzzy import RULES, FsmcParams, fuzzy_law, fuzzy_sliding, sliding_system
from leadscrew.controllers._sliding.stage import SlidingParams, View, layer_slope, switching_gain
from leadscrew.friction.lugre import bristle_rate, friction, steady_bristle
from leadscrew.fuzzy.engine import engine
from leadscrew.fuzzy.system import System
from leadscrew.kernel.block import Block, make
from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD


class Seen(NamedTuple):
    """What an ideal sensor sees."""

    position: float = 0.0
    velocity: float = 0.0


class IdealState(NamedTuple):
    """Integral of the error, and what the controller believes of the bristles."""

    xi: float = 0.0
    bristle: float = 0.0


def seen(p, s):
    """Position and speed of a stage with ``travel_per_rad``, ``angle`` and ``speed``."""
    return Seen(p.travel_per_rad * s.angle, p.travel_per_rad * s.speed)


def seen_in_mm(plant: Block) -> Block:
    """The plant as the laws of this module see it, in mm of the table."""
    return replace(plant(travel_per_rad=TRAVEL_MM_PER_RAD), output=seen, jacobian=None, unit="mm")


def ideal_view(p, s, command, feedback):
    """What a law sees, and the rate of the believed bristles."""
    target_speed = command.velocity / p.travel_per_rad
    speed = feedback.velocity / p.travel_per_rad
    angle = feedback.position / p.travel_per_rad
    e = angle - command.position / p.travel_per_rad
    v = target_speed if p.friction_from == 1 else speed
    rate = bristle_rate(p.hat, v, s.bristle)
    held = friction(p.hat, v, s.bristle, rate if p.friction_from != 2 else 0.0)
    gain = switching_gain(p, speed)
    believed = held if p.friction_from > 0 else 0.0
    acceleration = command.acceleration / p.travel_per_rad
    return View(
        angle, speed, e, speed - target_speed, s.xi, acceleration, believed, 0.0, gain, layer_slope(p, gain)
    ), rate  # fmt: skip


def _linear(law: Any, name: str, doc: str, **changes: Any) -> Block:
    def without_sampling(p, s, command, feedback):
        """Derivatives of xi and of the believed bristles, and the torque."""
        now, rate = ideal_view(p, s, command, feedback)
        return IdealState(now.e, rate), now.friction + p.inertia * law(p, now)

    params = SlidingParams(travel_per_rad=TRAVEL_MM_PER_RAD)._replace(**changes)
    return make(
        "controller", without_sampling, params, IdealState(), continuous=True, name=name, doc=doc, unit="N m",
        drive="torque",
    )  # fmt: skip


smc_ideal = _linear(conventional.law, "smc_ideal", "Conventional sliding mode without sampling; a torque.")
smc_integral_ideal = _linear(
    integral.law, "smc_integral_ideal", "Sliding mode with an integral surface without sampling; a torque."
)
csmc_ideal = _linear(
    complementary.law, "csmc_ideal", "Complementary sliding mode without sampling; a torque.", eta=20.0
)


def fuzzy_ideal(system: System, name: str) -> Block:
    """Fuzzy sliding mode without sampling, by any system that :func:`fuzzy_sliding` takes."""
    sampled = fuzzy_sliding(system, name)
    law = fuzzy_law(engine(system))

    def without_sampling(p, s, command, feedback):
        """Derivatives of xi and of the believed bristles, and the torque."""
        now, rate = ideal_view(p.stage, s, command, feedback)
        return IdealState(now.e, rate), now.friction + p.stage.inertia * law(p, now).u

    params: FsmcParams = sampled.params._replace(travel_per_rad=TRAVEL_MM_PER_RAD)
    return make(
        "controller", without_sampling, params, IdealState(), prepare=sampled.prepare, continuous=True, name=name,
        doc=f"{system.doc or 'Fuzzy sliding mode'} Without sampling.", unit="N m", drive="torque",
    )  # fmt: skip


fsmc_ideal = fuzzy_ideal(
    sliding_system(RULES["corrected"], "fsmc_ideal", "Fuzzy sliding mode, rules along s + s_c; a torque."),
    "fsmc_ideal",
)
fsmc_printed_ideal = fuzzy_ideal(
    sliding_system(RULES["printed"], "fsmc_printed_ideal", "Fuzzy sliding mode with the paper's rules; a torque."),
    "fsmc_printed_ideal",
)


def in_motion(block: Block, speed: float) -> Block:
    """The controller with its bristles at steady sliding at ``speed`` (rad/s), which a run that starts there needs."""
    return block.starting(bristle=steady_bristle(block.params.hat, speed))
