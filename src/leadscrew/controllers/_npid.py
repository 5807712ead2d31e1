"""Nonlinear PID: a gain that grows with the error, in front of a linear PID. Equations (2) to (5).

    e_c = clip(e, -e_max, e_max)                        e = command - feedback
    K   = (exp(alpha e_c) + exp(-alpha e_c)) / 2 = cosh(alpha e_c)                          (2)
    f   = K e                                                                               (4), ``clip_error`` 0
    f   = K e_c                                                                             (4), ``clip_error`` 1
    u_k = Kp f_k + Ki sum f_j dt + Kd (f_k - f_(k-1)) / dt                                  (5)

Source: Abdullah et al., *Design and Analysis of Self-tuned Nonlinear PID Controller for XY Table Ballscrew Drive
System*; gains, ``alpha = 0.5`` and ``e_max = 3``: Table I. The discrete form, filter, limit and anti-windup are those
of :mod:`leadscrew.controllers._parallel` and ours; the paper gives none.

What the paper leaves open, and how it is read here:

- **The unit of the error inside K.** The paper's loop is in mm, but with an error of 1 um in mm K is 1 + 1.3e-7, and
  the controller a plain PID. ``error_unit_per_mm`` turns mm into the unit of ``alpha`` and ``e_max``: 1000 (um, the
  default: our correction) or 1 (mm: as printed). The gains stay in V/mm either way.
- **Where the clip acts.** Only inside K (``clip_error`` 0, the default), or on the error itself (1): then an error
  beyond ``e_max`` is not seen, and a table that falls behind is never caught up.

K(e_max) = 2.352; the slope of f against e (:func:`slope`) is up to cosh x + x sinh x = 5.546 at ``x = alpha e_max``,
and beyond ``e_max`` it is K(e_max). That slope is the local loop gain. A positive output moves the axis in the positive
direction.

Bumpless start: as :obj:`leadscrew.controllers.pid`.
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


class NPIDParams(NamedTuple):
    """Gains of the PID, and the nonlinear gain in front of it."""

    kp: Kp = 1.32
    ki: Ki = 0.000825
    kd: Kd = 0.006805
    alpha: Annotated[float, Unit("1/error unit"), Ge(0), Doc("growth of the nonlinear gain, (2), Table I")] = 0.5
    e_max: Annotated[float, Unit("error unit"), Gt(0), Doc("error beyond which the gain grows no more, Table I")] = 3.0
    error_unit_per_mm: Annotated[
        float,
        Unit("error unit/mm"),
        Gt(0),
        Doc("unit of the error inside the gain: 1000 for um, 1 for mm (as printed)"),
    ] = 1000.0
    clip_error: Annotated[bool, Doc("clip the error itself at e_max, not only inside the gain")] = False
    filter_s: Filter = 0.0
    lower: Lower = -math.inf
    upper: Upper = math.inf
    anti_windup: AntiWindup = 1
    tracking_s: Tracking = 0.1


def gain(p, error):
    """``K`` of an error in mm: equation (2)."""
    return math.cosh(p.alpha * min(abs(error) * p.error_unit_per_mm, p.e_max))


def scaled_error(p, error):
    """``f`` of an error in mm, in mm: equations (2) and (4)."""
    limit = p.e_max / p.error_unit_per_mm
    clipped = min(max(error, -limit), limit)
    return gain(p, error) * (clipped if p.clip_error else error)


curve = scaled_error
"""The static map in front of the linear PID: ``curve(params, error)``, both in mm."""


def slope(p, error):
    """``df/de`` at an error in mm: cosh x + x sinh x with ``x = alpha |e|``, beyond ``e_max`` the gain (clipped: 0)."""
    size = abs(error) * p.error_unit_per_mm
    x = p.alpha * min(size, p.e_max)
    flat = 0.0 if p.clip_error else math.cosh(x)
    return math.cosh(x) + x * math.sinh(x) if size <= p.e_max else flat


def terms(p, command, feedback):
    """What the three terms act on."""
    scaled = scaled_error(p, command - feedback)
    return Terms(scaled, scaled, scaled, 1.0)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    scaled = scaled_error(params, command - feedback)
    return aligned(gains(params), scaled, scaled, output)


@controller(NPIDParams, PIDState, prepare=ordered, align=align, unit="V", drive="voltage", full_scale=10.0)
def npid(p, s, command, feedback, dt):
    """Nonlinear PID of the XY table: a gain that grows with the error, in front of a PID; a voltage."""
    scaled = scaled_error(p, command - feedback)
    return parallel(gains(p), s, scaled, scaled, scaled, dt)
