"""What a force controller believes of the depth of cut: its programme, ahead of time, through the radial servo.

    a(k) = mean of the programme over [t + preview_s - T, t + preview_s]
    lag_s dv/dt = gain (a - b) - v,      db/dt = v                  exact over a period; gain = 0: b = a

``b(k)`` is the depth that is believed at ``t + preview_s``. The command of a machine control
(:class:`~leadscrew.references.CutCommand`) says how deep it cuts, how deep after the next change and
when that is, so a preview is legal as long as it is shorter than the time between two changes. A change within a period
counts by its share of it. A preview shorter than a period sees a change up to half a period late.

**In the air**, where programme and ``depth_error`` leave less than ``air``, no force tells anything, so the feed must
not run up. It is set for the depth that comes next, else for the last one that was cut (:func:`aimed`); where neither
is known the output is at most ``air_feed``, until the believed depth is :data:`NEAR` of the one aimed at. A change to
less than ``min_depth`` is not acted upon before it is commanded: the tool still cuts.

Source: ours; the radial servo as in :obj:`leadscrew.plants.turning`, from which the depth
feed-forward of the study ``grey_turning`` has its numbers.
"""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.plants._turning.process import RadialServo

NEAR = 0.95
"""Share of the depth aimed at from which the tool counts as in the cut."""
TINY = 1e-30
"""Below this a speed that decays is 0."""

PreviewS = Annotated[
    float, Unit("s"), Ge(0), Le(10), Doc("how far ahead the depth is taken: lag of the feed and half a revolution")
]
DepthError = Annotated[float, Unit("mm"), Doc("believed depth less programmed depth")]
MinDepth = Annotated[float, Unit("mm"), Gt(0), Doc("shallower cuts count as this deep")]
Air = Annotated[float, Unit("mm"), Gt(0), Doc("shallower is air, not a cut")]
AirFeed = Annotated[float, Unit("V"), Ge(0), Doc("most in the air while no depth of cut is known")]


class Follower(NamedTuple):
    """The radial servo over one period, exact: coefficients of depth, speed and programme."""

    depth_depth: float
    depth_speed: float
    depth_asked: float
    speed_depth: float
    speed_speed: float
    speed_asked: float


class Depth(NamedTuple):
    """A believed depth and its speed."""

    depth: Annotated[float, Unit("mm"), Doc("believed depth of cut")] = 0.0
    speed: Annotated[float, Unit("mm/s"), Doc("its speed")] = 0.0


def follower(radial: RadialServo, dt: float) -> Follower:
    """The radial servo that is believed in, over one period."""
    if radial.gain == 0.0:
        return Follower(0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    import numpy as np

    from leadscrew.plants._linear import hold_matrices

    stiffness, damping = radial.gain / radial.lag_s, 1.0 / radial.lag_s
    a, b = hold_matrices(np.array([[0.0, 1.0], [-stiffness, -damping]]), np.array([0.0, stiffness]), dt)
    rows: Any = np.column_stack([a, b]).tolist()
    return Follower(*rows[0], *rows[1])


def programmed(command, from_s, dt):
    """Mean depth that the programme asks for between ``from_s`` and ``from_s + dt`` seconds from now, mm."""
    share = min(max((from_s + dt - command.change_in_s) / dt, 0.0), 1.0)
    return command.depth + share * (command.next_depth - command.depth)


def aimed(command, from_s, dt, error, least, air, last):
    """The depth for which the feed is set, mm: of the cut ahead; in the air the next one, else ``last``."""
    to = command.next_depth + error
    cut = programmed(command, from_s, dt) if to >= least else command.depth
    return cut if command.depth + error >= air else command.next_depth if to >= air else last


def followed(f, s, asked):
    """The believed depth one period later."""
    speed = f.speed_depth * s.depth + f.speed_speed * s.speed + f.speed_asked * asked
    return Depth(
        f.depth_depth * s.depth + f.depth_speed * s.speed + f.depth_asked * asked, speed if abs(speed) > TINY else 0.0
    )


def cutting(depth, error, least):
    """The depth that counts, mm."""
    return max(depth + error, least)
