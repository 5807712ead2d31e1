"""Nonlinear PID in two paths: small errors go to a quiet PID, what is beyond to a firm one.

    small = es atan(e / es),    large = e - small,    e = command - feedback

    u = PID_quiet(small) + PID_firm(large)
    PID(x) = kp x + ki sum x dt + kd D(x),          D: backward difference behind a lag of filter_s, each path its own

``small`` has the slope 1 at rest and none far out, ``large`` the slope ``e^2 / (e^2 + es^2)``, 0 to 1: at every error
the loop around it is that of ``(1 - s) PID_quiet + s PID_firm`` with an ``s`` between 0 and 1. So noise of less than
``es`` is answered with the gains of the quiet path, and forces that push the axis further with those of the firm one.
Where one gain for all errors (:obj:`leadscrew.controllers.npid_slope`) can only be larger or smaller, the two paths may
differ in their filters too, and that is what a loop needs that is to be firm without being louder at rest.

The law is ours. With the quiet loop closed, the firm path is a Lur'e system around ``large``, whose slope lies in
[0, 1]: :mod:`leadscrew.studies.npid_xytable.split_law` proves it under every load and command.

``lower`` and ``upper`` limit the output; the integral of both stands while the output is at its limit and would be
driven further out. A positive output moves the axis in the positive direction. Bumpless start: the integral is preset
so that the next output is the last one.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import TINY, Filter, Kd, Ki, Kp, Lower, Upper, ordered
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Gt, Unit

MM_PER_UM = 1e-3


class Path(NamedTuple):
    """Gains of one path."""

    kp: Kp = 0.358
    ki: Ki = 42.5
    kd: Kd = 0.0022
    filter_s: Filter = 0.00205


class NPIDSplitParams(NamedTuple):
    """The two paths, and the error that parts them."""

    quiet: Path = Path(0.358, 42.5, 0.0022, 0.00205)
    firm: Path = Path(0.85, 145.0, 0.0048, 0.000178)
    es_um: Annotated[float, Unit("um"), Gt(0), Doc("error that is shared evenly, as its slope counts")] = 0.722
    lower: Lower = -math.inf
    upper: Upper = math.inf


class NPIDSplitState(NamedTuple):
    """What both paths remember."""

    integral: Annotated[float, Unit("V"), Doc("integral terms of both paths")] = 0.0
    small: Annotated[float, Unit("mm"), Doc("small part of the last error")] = 0.0
    large: Annotated[float, Unit("mm"), Doc("large part of the last error")] = 0.0
    quiet_slope: Annotated[float, Unit("V"), Doc("derivative term of the quiet path")] = 0.0
    firm_slope: Annotated[float, Unit("V"), Doc("derivative term of the firm path")] = 0.0
    aligned: Annotated[float, Doc("1 in the first period after a bumpless start, else 0")] = 0.0


def parted(p, error):
    """The small part of an error in mm."""
    knee = p.es_um * MM_PER_UM
    return knee * math.atan(error / knee)


def lagged(path, slope, change, dt):
    """The derivative term of a path."""
    found = (path.filter_s * slope + path.kd * change) / (path.filter_s + dt)
    return found if abs(found) > TINY else 0.0


def paths(p, s, small, large, dt):
    """Both paths and their sum: next state and output."""
    growth = p.quiet.ki * small + p.firm.ki * large
    integral = s.integral + (1.0 - s.aligned) * growth * dt
    quiet = lagged(p.quiet, s.quiet_slope, small - s.small, dt)
    firm = lagged(p.firm, s.firm_slope, large - s.large, dt)
    raw = p.quiet.kp * small + p.firm.kp * large + integral + quiet + firm
    output = min(max(raw, p.lower), p.upper)
    kept = s.integral if (raw - output) * growth > 0.0 else integral
    return NPIDSplitState(kept, small, large, quiet, firm, 0.0), output


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    error = command - feedback
    small = parted(params, error)
    large = error - small
    integral = output - params.quiet.kp * small - params.firm.kp * large
    return NPIDSplitState(integral, small, large, 0.0, 0.0, 1.0)


@controller(NPIDSplitParams, NPIDSplitState, prepare=ordered, align=align, unit="V", drive="voltage", full_scale=10.0)
def npid_split(p, s, command, feedback, dt):
    """Nonlinear PID in two paths: small errors to a quiet PID, what is beyond to a firm one; a voltage."""
    error = command - feedback
    small = parted(p, error)
    return paths(p, s, small, error - small, dt)
