"""Nonlinear PID with the gain behind the PID: the same gain as :obj:`leadscrew.controllers.npid`, in the other place.

    K   = cosh(alpha min(|e|, e_max))                    e = command - feedback, inside K in the unit of ``alpha``
    u_k = K(e_k) (Kp e_k + Ki sum e_j dt + Kd (e_k - e_(k-1)) / dt)

A variant of equations (2) to (5) of Abdullah et al., *Design and Analysis of Self-tuned Nonlinear PID Controller for XY
Table Ballscrew Drive System*, which has K in front of the PID. In front, the derivative acts on ``f = K(e) e`` and
sees the slope ``K + e dK/de``, up to 5.546 times the gain of the PID with Table I; behind, it sees ``K``, at most
2.352. The proportional part is the same in both places. The integral here is that of the error itself: a load that is
held by the integral is held by ``K`` times it, so the output moves with the error even where the integral stands still.

The limits are those of the voltage: ``lower <= u <= upper``. Gains, filter, anti-windup, all in front of ``K``:
:mod:`leadscrew.controllers._parallel`. A positive output moves the axis in the positive direction. Bumpless start: as
:obj:`leadscrew.controllers.pid`.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import (
    AntiWindup,
    Filter,
    Gains,
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


class NPIDAfterParams(NamedTuple):
    """Gains of the PID, and the nonlinear gain behind it."""

    kp: Kp = 1.32
    ki: Ki = 0.000825
    kd: Kd = 0.006805
    alpha: Annotated[float, Unit("1/error unit"), Ge(0), Doc("growth of the nonlinear gain, (2), Table I")] = 0.5
    e_max: Annotated[float, Unit("error unit"), Gt(0), Doc("error beyond which the gain grows no more, Table I")] = 3.0
    error_unit_per_mm: Annotated[
        float, Unit("error unit/mm"), Gt(0), Doc("unit of the error inside the gain: 1000 for um, 1 for mm")
    ] = 1000.0
    filter_s: Filter = 0.0
    lower: Lower = -math.inf
    upper: Upper = math.inf
    anti_windup: AntiWindup = 1
    tracking_s: Tracking = 0.1


def gain(p, error):
    """``K`` of an error in mm: what multiplies the output of the linear PID."""
    return math.cosh(p.alpha * min(abs(error) * p.error_unit_per_mm, p.e_max))


def curve(p, error):
    """``K(e) e`` of an error in mm, in mm: the proportional part alone; the derivative sees the gain, not its slope."""
    return gain(p, error) * error


def slope(p, error):
    """Slope of :func:`curve`: the local gain of the proportional part, not of the derivative."""
    size = abs(error) * p.error_unit_per_mm
    x = p.alpha * min(size, p.e_max)
    return math.cosh(x) + x * math.sinh(x) if size <= p.e_max else math.cosh(x)


def terms(p, command, feedback):
    """What the three terms act on, and the gain behind them."""
    error = command - feedback
    return Terms(error, error, error, gain(p, error))


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    error = command - feedback
    return aligned(gains(params), error, error, output / gain(params, error))


@controller(NPIDAfterParams, PIDState, prepare=ordered, align=align, unit="V", drive="voltage", full_scale=10.0)
def npid_after(p, s, command, feedback, dt):
    """Nonlinear PID with the gain behind the PID; a voltage."""
    error = command - feedback
    factor = gain(p, error)
    g = Gains(p.kp, p.ki, p.kd, p.filter_s, p.lower / factor, p.upper / factor, p.anti_windup, p.tracking_s)
    after, output = parallel(g, s, error, error, error, dt)
    return after, factor * output
