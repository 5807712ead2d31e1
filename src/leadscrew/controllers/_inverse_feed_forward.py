"""Inverse-plant feed-forward: any controller, with the voltage added that the commanded motion needs by the model.

    output = inner(r, y) + share (r'' + damping r' + stiffness r) / gain      r, r', r'' at the time t + ahead_s

The model is a plant of second order, inverted; a mass has ``damping = stiffness = 0``. The command is a
:class:`~leadscrew.references.Motion`; ``r''`` is taken as constant over ``ahead_s``. An inner law of numbers gets its
position.

``ahead_s``: the output is held for one period and acts after the dead time, so its middle lies ``dead time + T / 2``
behind the sample.

Feed-forward takes away the following error of a plant that is known, and nothing else. What is left: ``1 - share`` of
it, the same part of it by which the model is wrong, and from the jerk ``j`` about ``ahead_s j / gain`` volt.

A limit of the inner controller's output does not count it. Bumpless start as the inner controller's.
"""

from __future__ import annotations

from typing import Annotated, Any

from leadscrew.controllers._look_ahead import advanced
from leadscrew.controllers._wrapping import around, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import position_of, prepared, whole
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import entry_point

Gain = Annotated[float, Unit("mm/(V s^2)"), Gt(0), Doc("acceleration at 1 V from rest")]
Damping = Annotated[float, Unit("1/s"), Ge(0), Doc("denominator of the model, coefficient of s")]
Stiffness = Annotated[float, Unit("1/s^2"), Ge(0), Doc("denominator of the model, constant coefficient")]
AheadS = Annotated[float, Unit("s"), Ge(0), Le(0.1), Doc("how far ahead the command is read: dead time + T / 2")]
Share = Annotated[float, Ge(0), Le(2), Doc("share of the model's voltage that is added")]


def inverse_voltage(p, command):
    """The voltage for the motion ``ahead_s`` after ``command``, by the model of ``p``."""
    then = advanced(command, p.ahead_s)
    return p.share * (then.acceleration + p.damping * then.velocity + p.stiffness * then.position) / p.gain


@entry_point
def inverse_feed_forward(
    inner: Block,
    *,
    gain: float,
    damping: float = 0.0,
    stiffness: float = 0.0,
    ahead_s: float = 0.0,
    share: float = 1.0,
    name: str = "",
) -> Block:
    """The controller ``inner`` with inverse-plant feed-forward; its parameters are those of ``inner`` below ``inner.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
    """
    part = wrapped(inner, "inverse_feed_forward")
    law = part.law
    passed = whole if part.motion else position_of
    own: list[Any] = [
        ("gain", Gain),
        ("damping", Damping),
        ("stiffness", Stiffness),
        ("ahead_s", AheadS),
        ("share", Share),
    ]
    params_type = around("InverseParams", inner.params, *own)

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        return around("InversePlan", ready, *own)(ready, *params[1:])

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        return part.align(params.inner, passed(command), feedback, output - inverse_voltage(params, command))

    def with_voltage(p, s, command, feedback, dt):
        """The inner controller, and the voltage of the commanded motion."""
        after, u = law(p.inner, s, passed(command), feedback, dt)
        return after, u + inverse_voltage(p, command)

    return same_kind(
        with_voltage, part,
        params_type(inner.params, gain, damping, stiffness, ahead_s, share), inner.state,
        "The voltage of the commanded motion is added.", motion=True, prepare=prepare,
        align=align, name=name or f"{inner.name}_ff",
    )  # fmt: skip
