"""Gain normalisation: increments in proportion to the feed, so that a shallow cut is controlled as fast as a deep one.

    u(k) = clip(u(k-1) + (u(k-1) / u_nominal + floor) du(k), lower, upper)

``du`` is what the inner controller adds. With ``F = K (v / n)^P`` the force answers a change of the feed by
``dF/dv = P F / v``: at the force that is held the loop gain goes with ``1 / v``, and an increment in proportion to
``v`` makes it the same for every depth and material, exactly so without the floor. ``floor`` lets the feed start from
rest; with it the gain at the nominal feed is ``1 + floor`` times the inner controller's. ``du`` is taken after the
inner controller's own limit.

Source: ours, for the study ``grey_turning``. That the gain of a force loop depends on depth and spindle
speed: O. Masory, Y. Koren, *Adaptive control system for turning*, CIRP Annals 29, 1980.

Bumpless start: the output before is set so that the next one is the last one.
"""

from __future__ import annotations

from typing import Annotated, Any

from leadscrew.controllers._force.wrapped import same_kind, takes_cut, wrapped
from leadscrew.controllers._wrapping import around
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.util.errors import BlockError, entry_point

NominalV = Annotated[float, Unit("V"), Gt(0), Doc("output for which the inner controller was tuned")]
Floor = Annotated[float, Ge(0), Doc("share of an increment that counts at rest")]


@entry_point
def gain_normalised(inner: Block, nominal_v: float = 0.2367, floor: float = 0.3, name: str = "") -> Block:
    """The controller ``inner`` with increments scaled by its output; its parameters are below ``inner.``.

    Its state is that of ``inner``, so it can be wrapped again.

    Raises:
        BlockError: ``inner`` is not an incremental controller with a field ``output`` and parameters ``lower``
            and ``upper``.
    """
    part = wrapped(inner, "gain_normalised")
    if not {"lower", "upper"} <= set(getattr(inner.params, "_fields", ())):
        raise BlockError(f"gain_normalised({inner.name}): needs a controller with parameters lower and upper")
    law, with_output = part.law, part.with_output
    params_type = around("GainNormalisedParams", inner.params, ("nominal_v", NominalV), ("floor", Floor))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        own = [(name, float) for name in ("nominal_v", "floor", "lower", "upper")]
        return around("GainNormalisedPlan", ready, *own)(
            ready, params.nominal_v, params.floor, params.inner.lower, params.inner.upper
        )

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        state = part.align(params.inner, command, feedback, output)
        added = output - state.output
        return with_output(state, (output - params.floor * added) / (1.0 + added / params.nominal_v))

    def normalised(p, s, command, feedback, dt):
        """The inner controller, its increment scaled."""
        after, output = law(p.inner, s, command, feedback, dt)
        raw = s.output + (s.output / p.nominal_v + p.floor) * (output - s.output)
        scaled = min(max(raw, p.lower), p.upper)
        return with_output(after, scaled), scaled

    normalised.with_output = with_output  # type: ignore[attr-defined]
    return same_kind(
        normalised, part, params_type(inner.params, nominal_v, floor), inner.state,
        "Its increments grow with its output.", takes_cut(inner), prepare=prepare,
        align=align, name=name or f"{inner.name}_normalised",
    )  # fmt: skip
