"""Friction feed-forward: any controller, with the friction of the commanded motion added as a voltage.

    output = inner(r, y) + share F                 at the commanded motion of the time t + ahead_s
    z'     = v - abs(v) z / (z_s r(v)),   F = F_C z / z_s                 bristles, ``presliding_um`` > 0
    F      = F_C r(v) tanh(v / smooth_mm_s)                               no bristles, ``presliding_um`` = 0
    r(v)   = 1 + (F_S / F_C - 1) exp(-(v / v_s)^2)

``v`` is the commanded speed, the bristles those of :mod:`leadscrew.plants.xy_table_lugre` (LuGre without ``sigma_1``),
stepped by the exact solution at the speed of the middle of the period. Coulomb friction without bristles would leap
where the axis turns round; ``tanh`` spreads the leap over the speeds below ``smooth_mm_s``.

The friction of the *measured* speed would be feedback, and can make a loop unstable; that of the commanded one cannot.
It is as good as the axis follows and as the friction is known. ``ahead_s``: dead time and half a period, as in
:obj:`leadscrew.controllers.inverse_feed_forward`, whose feed-forward it completes: that one is without friction.

The command is a :class:`~leadscrew.references.Motion`; an inner law of numbers gets its position. Model: C.
Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, IEEE Trans. Automatic Control 40 (3), 1995. The paper of the XY
table (Abdullah et al.) measures no friction; the defaults are the middle level of the study. Bumpless start: bristles
as in steady motion at the commanded speed.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from leadscrew.controllers._inverse_feed_forward import AheadS
from leadscrew.controllers._look_ahead import advanced
from leadscrew.controllers._wrapping import around, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import position_of, prepared, whole
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import entry_point

FAR = 700.0
"""Exponents are cut here."""

Friction = Annotated[float, Unit("mV"), Ge(0), Doc("friction in fast sliding, F_C")]
Presliding = Annotated[float, Unit("um"), Ge(0), Doc("deflection at which friction reaches F_C, z_s; 0: no bristles")]
Ratio = Annotated[float, Ge(1), Doc("largest friction at rest over F_C, F_S / F_C")]
Fall = Annotated[float, Unit("mm/s"), Gt(0), Doc("speed of the fall to F_C, v_s")]
Smooth = Annotated[float, Unit("mm/s"), Gt(0), Doc("speed over which the leap of friction is spread, without bristles")]
FrictionShare = Annotated[float, Ge(0), Le(2), Doc("share of the friction that is added")]
Bristle = Annotated[float, Doc("share of F_C that the bristles bear")]


def curve(p, v):
    """``r(v)``: friction in steady sliding over F_C."""
    ratio = v / p.stribeck_mm_s
    return 1.0 + (p.static_ratio - 1.0) * math.exp(-min(ratio * ratio, FAR))


@entry_point
def friction_feed_forward(
    inner: Block,
    friction_mv: float = 20.0,
    presliding_um: float = 5.0,
    static_ratio: float = 1.2,
    stribeck_mm_s: float = 1.0,
    smooth_mm_s: float = 0.05,
    ahead_s: float = 1.025e-3,
    share: float = 1.0,
    name: str = "",
) -> Block:
    """The controller ``inner`` with friction feed-forward; its parameters are those of ``inner`` below ``inner.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
    """
    part = wrapped(inner, "friction_feed_forward")
    law = part.law
    passed = whole if part.motion else position_of
    own: list[Any] = [
        ("friction_mv", Friction), ("presliding_um", Presliding), ("static_ratio", Ratio), ("stribeck_mm_s", Fall),
        ("smooth_mm_s", Smooth), ("ahead_s", AheadS), ("share", FrictionShare),
    ]  # fmt: skip
    params_type = around("FrictionParams", inner.params, *own)
    state_type = around("FrictionState", inner.state, ("bent", Bristle))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        plan_type = around(
            "FrictionPlan", ready, ("volt", float), ("rate", float), ("static_ratio", float), ("stribeck_mm_s", float),
            ("smooth_mm_s", float), ("bristles", bool), ("ahead_s", float), ("middle_s", float),
        )  # fmt: skip
        bristles = params.presliding_um > 0.0
        return plan_type(
            ready, 1e-3 * params.share * params.friction_mv, 1e3 / params.presliding_um if bristles else 0.0,
            params.static_ratio, params.stribeck_mm_s, params.smooth_mm_s, bristles, params.ahead_s,
            params.ahead_s - 0.5 * dt,
        )  # fmt: skip

    def steady(p, v):
        """Friction of steady sliding at ``v`` over F_C, its leap at rest spread."""
        return curve(p, v) * math.tanh(v / p.smooth_mm_s)

    def bent_after(p, bent, v, dt):
        """Bristles a period later at the speed ``v``."""
        most = curve(p, v)
        slipped = -math.expm1(-min(p.rate * abs(v) / most * dt, FAR))
        return bent + (math.copysign(most, v) - bent) * slipped

    def resting(p, v):
        """Bristles of steady motion at ``v``."""
        return (1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0) * curve(p, v) if p.bristles else 0.0

    def added(p, bent, command, dt):
        """Friction over F_C, from the bristles of the period before."""
        v = advanced(command, p.middle_s).velocity
        return bent_after(p, bent, v, dt) if p.bristles else steady(p, advanced(command, p.ahead_s).velocity)

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        v = advanced(command, params.middle_s).velocity
        bent = resting(params, v)
        known = bent if params.bristles else steady(params, advanced(command, params.ahead_s).velocity)
        return state_type(part.align(params.inner, passed(command), feedback, output - params.volt * known), bent)

    def with_friction(p, s, command, feedback, dt):
        """The inner controller and the friction of the commanded motion."""
        after, u = law(p.inner, s.inner, passed(command), feedback, dt)
        known = added(p, s.bent, command, dt)
        return state_type(after, known if p.bristles else 0.0), u + p.volt * known

    return same_kind(
        with_friction, part,
        params_type(inner.params, friction_mv, presliding_um, static_ratio, stribeck_mm_s, smooth_mm_s, ahead_s, share),
        state_type(inner.state, 0.0), "The friction of the commanded motion is added.", motion=True, prepare=prepare,
        align=align, name=name or f"{inner.name}_friction",
    )  # fmt: skip
