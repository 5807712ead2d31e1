"""A plain PID controller of the lathe axis, in duty: what the integral of a servo drive does for it, and to it.

    rho = -clip(kp e + ki sum e dt + kd D(e), -max_duty, max_duty),    e = command - feedback

``D`` is the backward difference over the period behind a lag of ``filter_s`` by backward Euler, and 0 in the first
period, which has no earlier error. Order of computation, limit and both anti-windup rules:
:mod:`leadscrew.controllers._parallel`. Minus: a positive duty moves the slide towards negative ``x``.

At the limit of the duty ``anti_windup`` ``clamping`` holds the integral, ``back-calculation`` brings it back. The axis
is an integrator itself, so whatever the integral has gathered on the way is paid back by overshoot: with
back-calculation faster than the approach it arrives empty, with clamping the slide overshoots by a millimetre and
more. The integral takes away what a constant drift leaves of the error; in a dead zone it hunts, as every integral
does there.

Gains: ours, by differential evolution on the steps of the nominal axis to -50 and -170 mm (seed 1, 80 generations
of 75): within 2 um after 0.29 and 0.71 s.

Bumpless start: the integral is preset so that the next output is the last one.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.controllers._parallel import AntiWindup, Gains, PIDState, Tracking, aligned, parallel
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit


class DutyPIDParams(NamedTuple):
    """Gains, filter and limit."""

    kp: Annotated[float, Unit("1/mm"), Ge(0), Doc("duty per millimetre of error")] = 0.3605
    ki: Annotated[float, Unit("1/(mm s)"), Ge(0), Doc("duty per millimetre and second")] = 6.847
    kd: Annotated[float, Unit("s/mm"), Ge(0), Doc("duty per millimetre a second")] = 0.004228
    filter_s: Annotated[float, Unit("s"), Ge(0), Doc("lag of the derivative, by backward Euler; 0 for none")] = (
        0.0004869
    )
    max_duty: Annotated[float, Gt(0), Le(1), Doc("largest size of the duty")] = 1.0
    anti_windup: AntiWindup = 2
    tracking_s: Tracking = 0.006977


class DutyPIDState(NamedTuple):
    """What the PID remembers, and whether it has seen an error."""

    pid: PIDState = PIDState()
    rho: Annotated[float, Doc("duty")] = 0.0
    started: Annotated[float, Doc("0 before the first period, then 1")] = 0.0


def gains(p):
    """The gains as the parallel law takes them."""
    return Gains(p.kp, p.ki, p.kd, p.filter_s, -p.max_duty, p.max_duty, p.anti_windup, p.tracking_s)


def align(params, command, feedback, output):
    """The state from which the next output is ``output``."""
    error = command - feedback
    return DutyPIDState(aligned(gains(params), error, error, -output), output, 1.0)


@controller(DutyPIDParams, DutyPIDState, align=align, unit="1", drive="duty", full_scale=1.0, sense=-1)
def duty_pid(p, s, command, feedback, dt):
    """The duty against the error, its integral and its filtered derivative."""
    error = command - feedback
    last = s.pid.last if s.started > 0.0 else error
    before = PIDState(s.pid.integral, last, s.pid.slope, s.pid.aligned)
    after, push = parallel(gains(p), before, error, error, error, dt)
    return DutyPIDState(after, -push, 1.0), -push
