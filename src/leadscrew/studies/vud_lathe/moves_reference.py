"""Machine-like commands for controllers that take a position alone: the planned move without its derivatives."""

from __future__ import annotations

from leadscrew.kernel.block import reference
from leadscrew.references.s_curve import SCurveParams, plan_s_curve, s_curve
from leadscrew.references.trapezoid import TrapezoidParams, plan_trapezoid, trapezoid


@reference(TrapezoidParams(), prepare=plan_trapezoid, unit="mm")
def trapezoid_position(p, t):
    """The position of :func:`leadscrew.references.trapezoid.trapezoid`."""
    motion = trapezoid(p, t)
    return motion.position


@reference(SCurveParams(), prepare=plan_s_curve, unit="mm")
def s_curve_position(p, t):
    """The position of :func:`leadscrew.references.s_curve.s_curve`."""
    motion = s_curve(p, t)
    return motion.position
