"""A tangential knife in fabric, leather or foam: from the offset of its axis to the tangent of the cut.

    g_ss = -(S kappa (f / f_0)^p + A sin 2(phi - phi_g) + B) + n          steady shear, deg; held to 14 tanh(g_ss / 14)
    tau dgamma/dt = g_ss - gamma                                          Kelvin-Voigt shear of the material
    tau_s dx/dt = d - x                                                   tangential axis
    e = g x + gamma,      lateral += sin(e) ds                            deviation of the cut, deg; of its place, mm

A knife of chord ``b`` that follows a curvature ``kappa`` is yawed by up to ``kappa b / 2`` against its own cut; side
load, fibre direction ``phi_g`` and bevel shear the material at its tip, and when it springs back the cut has turned by
``gamma``: ``S = (180 / pi) (b / 2) r_c`` with the ratio ``r_c`` of the stiffness of cutting to that of shear. The
heading ``phi`` and the curvature come with the load (:obj:`leadscrew.disturbances.cut_load`); the axis follows the
heading by itself, and ``d`` is what is added to it. Both lags are integrated exactly over a step.

Four further terms are for tests of robustness, 0 by default: ``softening`` (``kappa / (1 + softening abs(kappa))``),
``four_fold`` (``A_4 sin 4(phi - phi_g)``), ``ripple`` (a sine in the way, of ``ripple_length``) and ``hysteresis`` (a
play of that half-width in the steady shear).

From ``change_at`` on the material is ``changed``.

Source: a reconstruction for the study ``sofnn_tangent``, whose paper gives no process. Materials are believed
values, none is measured.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.block import plant
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit

RADIAN = math.pi / 180.0

TINY = 1e-30
"""Below this a settled state is 0."""

NEVER_MM = 1e9
"""Place of a change that does not come."""


class Material(NamedTuple):
    """How a material answers the blade."""

    shear: Annotated[float, Unit("deg mm"), Ge(0), Doc("turn of the cut at a curvature of 1/mm, S")] = 45.0
    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("time constant of its shear, tau")] = 0.03
    fibre: Annotated[float, Unit("deg"), Doc("amplitude of the effect of the fibre direction, A")] = 1.0
    bias: Annotated[float, Unit("deg"), Doc("constant turn, from the bevel, B")] = 0.3
    exponent: Annotated[float, Ge(0), Le(2), Doc("exponent of the feed, p")] = 0.3
    gain: Annotated[float, Gt(0), Le(2), Doc("turn of the cut by a turn of the blade, g")] = 0.95


MATERIALS: dict[str, Material] = {
    "fabric": Material(),
    "leather": Material(25.0, 0.02, 0.4, 0.8, 0.2, 0.90),
    "foam": Material(90.0, 0.10, 0.2, 0.3, 0.5, 0.75),
}
"""By name."""


class FlexibleCutParams(NamedTuple):
    """Material, blade and axis."""

    material: Material = Material()
    changed: Material = MATERIALS["foam"]
    change_at: Annotated[float, Unit("mm"), Ge(0), Doc("where the material changes")] = NEVER_MM
    feed: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed of the blade along the line, f")] = 50.0
    nominal_feed: Annotated[float, Unit("mm/s"), Gt(0), Doc("speed for which the shear holds, f_0")] = 50.0
    grain_deg: Annotated[float, Unit("deg"), Doc("direction of the fibres, phi_g")] = 0.0
    axis_lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the tangential axis, tau_s")] = 0.02
    max_shear: Annotated[float, Unit("deg"), Gt(0), Doc("largest shear of the material")] = 14.0
    softening: Annotated[float, Unit("mm"), Ge(0), Doc("how fast sharp curves stop to add shear")] = 0.0
    four_fold: Annotated[float, Unit("deg"), Doc("amplitude of a four-fold effect of the direction")] = 0.0
    ripple: Annotated[float, Unit("deg"), Ge(0), Doc("amplitude of a wave along the way")] = 0.0
    ripple_length: Annotated[float, Unit("mm"), Gt(0), Doc("its length")] = 37.0
    hysteresis: Annotated[float, Unit("deg"), Ge(0), Doc("half-width of a play in the steady shear")] = 0.0


class FlexibleCutState(NamedTuple):
    """Shear, axis and cut."""

    shear: Annotated[float, Unit("deg"), Doc("of the material, gamma")] = 0.0
    offset: Annotated[float, Unit("deg"), Doc("of the tangential axis, x")] = 0.0
    held: Annotated[float, Unit("deg"), Doc("steady shear behind the play")] = 0.0
    deviation: Annotated[float, Unit("deg"), Doc("of the cut's tangent, e")] = 0.0
    angle: Annotated[float, Unit("deg"), Doc("tangent of the cut")] = 0.0
    lateral: Annotated[float, Unit("mm"), Doc("of the cut, to the left of the line")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("distance along the line")] = 0.0


class CutLine(NamedTuple):
    """The cut where the blade is."""

    deviation: Annotated[float, Unit("deg"), Doc("tangent of the cut less that of the programme")] = 0.0
    angle: Annotated[float, Unit("deg"), Doc("tangent of the cut")] = 0.0
    lateral: Annotated[float, Unit("mm"), Doc("deviation of the cut, to the left of the line")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("distance along the line")] = 0.0


def seen(s):
    """The cut where the blade is."""
    return CutLine(s.deviation, s.angle, s.lateral, s.travel)


def quiet(x):
    """``x``, or 0 where nothing is left of it."""
    return x if abs(x) > TINY else 0.0


def steady_shear(p, material, load):
    """``g_ss`` before play and limit, deg."""
    bent = load.curvature / (1.0 + p.softening * abs(load.curvature))
    across = 2.0 * RADIAN * (load.heading - p.grain_deg)
    along = 2.0 * math.pi * load.travel / p.ripple_length
    return (
        load.texture
        + p.ripple * math.sin(along)
        - p.four_fold * math.sin(2.0 * across)
        - (
            material.shear * bent * math.pow(p.feed / p.nominal_feed, material.exponent)
            + material.fibre * math.sin(across)
            + material.bias
        )
    )


@plant(FlexibleCutParams, FlexibleCutState, output=seen, unit="deg", drive="position")
def flexible_cut(p, s, u, load, dt):
    """The cut after ``dt``; the load is that of the whole step."""
    late = load.travel >= p.change_at
    material = Material(
        p.changed.shear if late else p.material.shear,
        p.changed.lag_s if late else p.material.lag_s,
        p.changed.fibre if late else p.material.fibre,
        p.changed.bias if late else p.material.bias,
        p.changed.exponent if late else p.material.exponent,
        p.changed.gain if late else p.material.gain,
    )
    asked = steady_shear(p, material, load)
    held = min(max(s.held, asked - p.hysteresis), asked + p.hysteresis)
    steady = p.max_shear * math.tanh(held / p.max_shear)
    shear = quiet(steady + (s.shear - steady) * math.exp(-dt / material.lag_s))
    offset = quiet(u + (s.offset - u) * math.exp(-dt / p.axis_lag_s))
    deviation = material.gain * offset + shear + load.push
    lateral = s.lateral + math.sin(RADIAN * deviation) * p.feed * dt
    return FlexibleCutState(shear, offset, held, deviation, load.heading + deviation, lateral, load.travel)
