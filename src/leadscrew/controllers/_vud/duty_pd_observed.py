"""A PD controller behind the observer of :mod:`leadscrew.controllers._vud.fast`: no rules, no universes.

With the predicted ``stop`` and the slow part ``v`` of the speed at which the error grows, both as there:

    rho = clip(-kp ((command - stop) + t_d v), -1, 1)

It knows what ``vud_fast`` knows, so their difference is what the rules and their contraction are worth. Ours; settings
and how they were found: ``leadscrew.studies.vud_lathe.controllers``.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.controllers._vud.fast import predicted
from leadscrew.controllers._vud.fast_observer import Chain, ChainParams, ChainState, corrected, moved, ready_chain
from leadscrew.controllers._vud.universe import held
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit


class DutyPDObservedParams(NamedTuple):
    """Gains, braking, and the believed chain."""

    kp: Annotated[float, Unit("1/mm"), Ge(0), Doc("duty per millimetre of error of the predicted stop")] = 1.0
    t_d: Annotated[float, Unit("s"), Ge(0), Doc("weight of the slow part of the speed")] = 0.001
    braking: Annotated[float, Gt(0), Le(1), Doc("b: duty against the motion that the prediction counts on")] = 0.83
    chain: ChainParams = ChainParams()


class DutyPDObservedState(NamedTuple):
    """Error and speed, and the observer."""

    error: Annotated[float, Unit("mm"), Doc("of the predicted stop")] = 0.0
    speed: Annotated[float, Unit("mm/s"), Doc("slow part, at which the error grows")] = 0.0
    rho: Annotated[float, Doc("duty")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0
    chain: ChainState = ChainState()


class DutyPDObserved(NamedTuple):
    """The parameters as the step reads them."""

    kp: float
    t_d: float
    braking: float
    lag: float
    chain: Chain


def ready(params: DutyPDObservedParams, dt: float) -> DutyPDObserved:
    """The parameters as the step reads them.

    Raises:
        ValueRefused: two lags of the chain that are the same.
    """
    chain = ready_chain(params.chain, dt)
    return DutyPDObserved(params.kp, params.t_d, params.braking, params.chain.mechanical_lag_s, chain)


@controller(
    DutyPDObservedParams(), DutyPDObservedState(), prepare=ready, unit="1", drive="duty", full_scale=1.0, sense=-1
)
def duty_pd_observed(p, s, command, feedback, dt):
    """The duty against the error of the predicted stop and the slow part of the speed."""
    now = corrected(p.chain, s.chain, feedback, s.started)
    ahead = predicted(p, now)
    error = command - ahead.stop
    rho = held(-p.kp * (error + p.t_d * ahead.speed), 1.0)
    return DutyPDObservedState(error, ahead.speed, rho, 1.0, moved(p.chain, now, rho, dt)), rho
