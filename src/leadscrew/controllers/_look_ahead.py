"""Look-ahead: any controller of a motion command, made to know how late its torque acts and its sensor sees.

    r       = (y_r + d y_r' + d^2 / 2 y_r'',  y_r' + d y_r'',  y_r'')       the command when the torque acts
    y       = feedback + tau (y_r' - tau y_r'') + d y_r' + d^2 / 2 y_r''    the same move on, the lag taken away
    output  = inner(r, y)

``d = actuation_delay_s``: computation, plus the lag of the drive. ``tau = measurement_delay_s``: lag of the sensor's
filter. The error that the inner law sees, ``feedback + tau y_r' - tau^2 y_r'' - y_r``, is the one of now, without the
``tau v`` by which a filter bends it; what it knows of the machine (inertia, friction) it uses for the time at which its
torque acts. It predicts the command alone: no lag is taken out of the feedback loop, so gains are to be tuned with it
in place.

The command is a :class:`~leadscrew.references.Motion`; ``y_r''`` is taken to stand still over ``d + tau``. With
both zero it is the inner controller. Bumpless start as the inner controller's.
"""

from __future__ import annotations

from typing import Annotated, Any

from leadscrew.controllers._wrapping import around, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge, Le, Unit
from leadscrew.references._motion import Motion
from leadscrew.util.errors import entry_point

ActsLate = Annotated[float, Unit("s"), Ge(0), Le(0.1), Doc("time until the torque acts, d")]
SeenLate = Annotated[float, Unit("s"), Ge(0), Le(0.1), Doc("lag of the sensor's filter, tau")]


def advanced(command, d):
    """The command a time ``d`` later, at an acceleration that stands still."""
    moved = d * command.velocity + 0.5 * d * d * command.acceleration
    return Motion(command.position + moved, command.velocity + d * command.acceleration, command.acceleration)


def moved_on(command, feedback, d, tau):
    """The feedback without its lag, moved on as the command is."""
    lag = tau * (command.velocity - tau * command.acceleration)
    return feedback + lag + d * command.velocity + 0.5 * d * d * command.acceleration


@entry_point
def look_ahead(inner: Block, name: str = "", actuation_delay_s: float = 0.0, measurement_delay_s: float = 0.0) -> Block:
    """The controller ``inner`` with look-ahead; its parameters are those of ``inner`` below ``inner.``.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
    """
    part = wrapped(inner, "look_ahead")
    law = part.law
    own: list[Any] = [("actuation_delay_s", ActsLate), ("measurement_delay_s", SeenLate)]
    params_type = around("LookAheadParams", inner.params, *own)

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        return around("LookAheadPlan", ready, *own)(ready, params.actuation_delay_s, params.measurement_delay_s)

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``."""
        d, tau = params.actuation_delay_s, params.measurement_delay_s
        return part.align(params.inner, advanced(command, d), moved_on(command, feedback, d, tau), output)

    def looking_ahead(p, s, command, feedback, dt):
        """The inner controller on a command and a feedback moved on to the time when its torque acts."""
        d, tau = p.actuation_delay_s, p.measurement_delay_s
        return law(p.inner, s, advanced(command, d), moved_on(command, feedback, d, tau), dt)

    return same_kind(
        looking_ahead, part, params_type(inner.params, actuation_delay_s, measurement_delay_s), inner.state,
        "It looks ahead.", motion=True, prepare=prepare, align=align, name=name or f"{inner.name}_look_ahead",
    )  # fmt: skip
