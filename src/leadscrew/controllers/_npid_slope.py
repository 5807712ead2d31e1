"""Slope-limited nonlinear PID: a gain that grows with the error, and a local loop gain that stays below a limit.

    f   = sign(e) (|e| + (k - 1) (|e| - es atan(|e| / es)))                e = command - feedback
    f'  = 1 + (k - 1) e^2 / (e^2 + es^2)  <=  k
    u_k = Kp f_k + Ki sum f_j dt + Kd (f_k - f_(k-1)) / dt

The law is ours, made for the XY table of Abdullah et al. (*Design and Analysis of Self-tuned Nonlinear PID Controller
for XY Table Ballscrew Drive System*), whose cosh (:obj:`leadscrew.controllers.npid`) has a slope of 5.5 where its gain
is 2.35. A loop under a load or with a following error works around an error other than zero, where its gain is the
slope ``f'``: more of it than the gain margin and it chatters. Here ``k`` limits both: small errors see the gain 1,
large ones ``k``, and none sees a slope beyond ``k``. ``es_um`` is the error at which the slope is half-way.

``k = 1`` is the plain PID. Gains, filter, limit and anti-windup: :mod:`leadscrew.controllers._parallel`. A positive
output moves the axis in the positive direction. Bumpless start: as :obj:`leadscrew.controllers.pid`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import (
    AntiWindup,
    Filter,
    Kd,
    Ki,
    Kp,
    Lower,
    PIDState,
    Terms,
    Tracking,
    Upper,
    aligned,
    gains,
    ordered,
    parallel,
)
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit

MM_PER_UM = 1e-3


class NPIDSlopeParams(NamedTuple):
    """Gains of the PID, and the curve in front of it."""

    kp: Kp = 1.32
    ki: Ki = 0.000825
    kd: Kd = 0.006805
    k: Annotated[float, Ge(1), Doc("gain for large errors, and the largest slope of the curve")] = 2.2
    es_um: Annotated[float, Unit("um"), Gt(0), Doc("error at which the slope is half-way from 1 to k")] = 0.5
    filter_s: Filter = 0.0
    lower: Lower = -math.inf
    upper: Upper = math.inf
    anti_windup: AntiWindup = 1
    tracking_s: Tracking = 0.1


def curve(p, error):
    """``f`` of an error in mm, in mm."""
    knee = p.es_um * MM_PER_UM
    size = abs(error)
    return math.copysign(size + (p.k - 1.0) * (size - knee * math.atan(size / knee)), error)


def slope(p, error):
    """``df/de`` at an error in mm: 1 to ``k``."""
    ratio = error / (p.es_um * MM_PER_UM)
    return p.k - (p.k - 1.0) / (1.0 + ratio * ratio)


def terms(p, command, feedback):
    """What the three terms act on."""
    scaled = curve(p, command - feedback)
    return Terms(scaled, scaled, scaled, 1.0)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    scaled = curve(params, command - feedback)
    return aligned(gains(params), scaled, scaled, output)


@controller(NPIDSlopeParams, PIDState, prepare=ordered, align=align, unit="V", drive="voltage", full_scale=10.0)
def npid_slope(p, s, command, feedback, dt):
    """Slope-limited nonlinear PID: a curve of limited slope in front of a PID; a voltage."""
    scaled = curve(p, command - feedback)
    return parallel(gains(p), s, scaled, scaled, scaled, dt)
