"""Fuzzy sliding mode: a Mamdani system of two inputs in place of the switching term.

    s   = e' + 2 lam e + lam^2 xi,      s_c = e' - lam^2 xi                                          (8), (14)
    u   = y_r'' - 3 lam e' - 3 lam^2 e - lam^3 xi + (U / J) K(s / S, s_c / S_c)                      (10), section 4.4
    T   = F_hat + J u

``K`` in [-1, 1]: inputs held inside [-1, 1], sets N, Z, P with peaks at -1, 0, 1; output sets NB, NS, ZO, PS, PB with
peaks at -1, -0.5, 0, 0.5, 1 and feet 0.5 to each side; minimum, maximum, centroid (exact, in closed form). Near 0 the
corrected K is ``-0.75 s / S`` where only s is not 0, ``-2 s / S`` where ``s_c / S_c`` is as large, 0 where it is the
opposite. Any other fuzzy system of s and s_c: :func:`fuzzy_sliding`.

Source: Shams and Safdari (2010), Figs 8 to 10 and the nine rules after them, after C. Y. Liang and J. P. Su (2003). The
figures' scales are not known: ``S = 0.65, S_c = 2.6 rad/s, U = 120 N m`` are ours.

Rule bases, :data:`RULES`: ``printed`` acts along ``s - s_c = 2 lam (e + lam xi)``: a fuzzy PI, damped by the other
terms of u only. ``corrected`` acts along ``s + s_c = 2 (e' + lam e)``, as (15) of the complementary law does, of which
the text says that the fuzzy law is built on it; one is the other with s_c turned round. ``S_c > S`` lets K see the
integral as well; with ``S_c = S`` the corrected K is 0 where s and s_c are large and opposite, which is where a large
integral takes them, and the stage stays away by tens of um. ``without_dead_corner`` (ours) follows s there.

The defaults are for periods below 5 us, as the paper's gains are; others for 4 kHz are the study's. ``max_torque``
must leave room for ``F_S``: K is bounded, so is what it can hold. The readings of f_hat and the sampled form:
:mod:`leadscrew.controllers._sliding.stage`.

Bumpless start: ``xi = -2 e / lam``, so that ``s = 0``, and bristles preset so that the first output is the last one;
from rest, and as far as static friction holds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, cast

from leadscrew.controllers._sliding.fields import (
    Inertia,
    Lam,
    MaxTorque,
    Pieces,
    SpeedFilter,
    Travel,
    stage_params,
)
from leadscrew.controllers._sliding.integral import equivalent, surface
from leadscrew.controllers._sliding.stage import FrictionFrom, SlidingParams, ended, holding, standing, view
from leadscrew.friction.lugre import HAT, LuGre
from leadscrew.fuzzy.build import mamdani, triangles
from leadscrew.fuzzy.engine import Engine, engine
from leadscrew.fuzzy.system import Input, Output, System
from leadscrew.fuzzy.tables import Tables
from leadscrew.kernel.block import Block, make
from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.plants._ballscrew_stage import INERTIA
from leadscrew.util.errors import ValueRefused

RULES = {
    "printed": """
            N   Z   P
        N   ZO  PS  PB
        Z   NS  ZO  PS
        P   NB  NS  ZO
    """,
    "corrected": """
            N   Z   P
        N   PB  PS  ZO
        Z   PS  ZO  NS
        P   ZO  NS  NB
    """,
    "without_dead_corner": """
            N   Z   P
        N   PB  PS  PS
        Z   PS  ZO  NS
        P   NS  NS  NB
    """,
}
"""Rule bases: s down the side, s_c along the top. The printed one is rules 1 to 9 of the paper, the last one ours."""


def sliding_system(rules: str, name: str = "fsmc", doc: str = "") -> System:
    """The fuzzy system of Figs 8 and 9 with a table of rules: s down the side, s_c along the top, as :data:`RULES`.

    Raises:
        DataError: a table that cannot be read.
    """
    sets = triangles("N Z P", -1.0, 1.0)
    inputs = [Input(of, -1.0, 1.0, sets, lock_range=True) for of in ("s", "s_c")]
    output = Output("k", -1.5, 1.5, triangles("NB NS ZO PS PB", -1.0, 1.0, shoulders=False))
    return mamdani(name, inputs, output, rules, doc=doc)


class FsmcParams(NamedTuple):
    """Numbers and scales of the fuzzy system, and what the controller believes of the stage."""

    tables: Tables
    lam: Lam = 150.0
    scale_s: Annotated[float, Unit("rad/s"), Gt(0), Doc("s that is 1 to the fuzzy system, S")] = 0.65
    scale_sc: Annotated[float, Unit("rad/s"), Gt(0), Doc("s_c that is 1 to the fuzzy system, S_c")] = 2.6
    fuzzy_torque: Annotated[float, Unit("N m"), Gt(0), Doc("torque of the fuzzy output 1, U")] = 120.0
    inertia: Inertia = INERTIA
    travel_per_rad: Travel = 1.0
    speed_filter_s: SpeedFilter = 0.0
    max_torque: MaxTorque = 0.0
    friction_from: FrictionFrom = 1
    pieces: Pieces = 20
    hat: LuGre = HAT


class FsmcState(NamedTuple):
    """What the controller remembers, and what it saw."""

    angle: Annotated[float, Unit("rad"), Doc("measured angle, y")] = 0.0
    speed: Annotated[float, Unit("rad/s"), Doc("measured speed, y'")] = 0.0
    xi: Annotated[float, Unit("rad s"), Doc("integral of the error")] = 0.0
    bristle: Annotated[float, Unit("rad"), Doc("believed deflection of the bristles")] = 0.0
    friction: Annotated[float, Unit("N m"), Doc("F_hat")] = 0.0
    s: Annotated[float, Doc("s over its scale")] = 0.0
    s_c: Annotated[float, Doc("s_c over its scale")] = 0.0
    k: Annotated[float, Doc("output of the fuzzy system, K")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


class Law(NamedTuple):
    """``s`` and ``s_c`` over their scales, ``K``, and the wanted acceleration ``u``."""

    s: float
    s_c: float
    k: float
    u: float


def complement(p, now):
    """``s_c``, (14)."""
    return now.rate - p.lam * p.lam * now.xi


def fuzzy_law(made: Engine) -> Callable[..., Any]:
    """``law(p, now) -> Law``, where ``p`` is what :func:`fuzzy_sliding` prepares for the same system."""
    infer = made.infer

    def law(p, now):
        """(10) with the fuzzy term."""
        s = surface(p.stage, now) / p.scale_s
        s_c = complement(p.stage, now) / p.scale_sc
        k = infer(p.plan, s, s_c)
        return Law(s, s_c, k, equivalent(p.stage, now) + p.fuzzy_acceleration * k)

    return law


def fuzzy_sliding(system: System, name: str = "fsmc") -> Block:
    """The controller of a fuzzy system whose inputs are s and s_c, in this order, and whose output is K.

    Its numbers are parameters (``tables``), as those of :func:`leadscrew.fuzzy.controller`; other rules make another
    block.

    Raises:
        ValueRefused: another number of inputs or outputs, or something that cannot be evaluated.
    """
    if len(system.inputs) != 2 or len(system.outputs) != 1:
        raise ValueRefused(
            f"system {system.name} has {len(system.inputs)} inputs and {len(system.outputs)} outputs; fuzzy sliding "
            "mode takes two inputs, s and s_c, and one output"
        )
    made = engine(system)
    law = fuzzy_law(made)
    fields = [("stage", SlidingParams), ("scale_s", float), ("scale_sc", float), ("fuzzy_acceleration", float)]
    plan_type = cast(Any, NamedTuple("FsmcPlan", [*fields, ("plan", made.plan_type)]))

    def prepare(params: FsmcParams, dt: float) -> Any:
        push = params.fuzzy_torque / params.inertia
        return plan_type(stage_params(params), params.scale_s, params.scale_sc, push, made.prepared(params.tables))

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``, at rest, with ``s = 0``."""
        now = standing(params.stage, command, feedback, -2.0 / params.stage.lam)
        found = law(params, now)
        held = holding(params.stage, now, 0.0, output - params.stage.inertia * found.u)
        return FsmcState(held.angle, held.speed, held.xi, held.bristle, 0.0, found.s, found.s_c, found.k, 0.0)

    def fuzzy_sliding_mode(p, s, command, feedback, dt):
        """Fuzzy sliding mode, for a stage with LuGre friction; a torque."""
        now = view(p.stage, s, command, feedback, dt)
        found = law(p, now)
        after, torque = ended(p.stage, s, now, found.s, found.u)
        return FsmcState(
            after.angle, after.speed, after.xi, after.bristle, after.friction, found.s, found.s_c, found.k, 1.0
        ), torque

    return make(
        "controller", fuzzy_sliding_mode, FsmcParams(made.numbers), FsmcState(), prepare=prepare, align=align,
        name=name, doc=system.doc, unit="N m", drive="torque",
    )  # fmt: skip


fsmc = fuzzy_sliding(
    sliding_system(RULES["corrected"], doc="Fuzzy sliding mode, rules along s + s_c, for a stage with LuGre friction.")
)
fsmc_printed = fuzzy_sliding(
    sliding_system(RULES["printed"], "fsmc_printed", "Fuzzy sliding mode with the paper's rules, along s - s_c."),
    "fsmc_printed",
)
