"""Filters as controllers of their own, to be connected by :func:`~leadscrew.controllers._series.series`.

    y_k = b0 e_k + m1,    m1 <- b1 e_k - a1 y_k + m2,    m2 <- b2 e_k - a2 y_k,      e = command - feedback

A filter passes the error through :class:`~leadscrew.controllers._biquad.Notch` or
:class:`~leadscrew.controllers._biquad.LowPass`; equations, units and limits: :obj:`leadscrew.controllers.biquad`. The
DC gain of all is 1. Behind another controller the error is its output. Bumpless start: at rest around the output.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from leadscrew.controllers._biquad import Coefficients, LeadLag, LowPass, Notch, coefficients
from leadscrew.controllers._parallel import TINY
from leadscrew.kernel.block import controller
from leadscrew.kernel.parameters import Doc


class FilterState(NamedTuple):
    """Memory of a section in transposed direct form II."""

    m1: Annotated[float, Doc("what the next output adds")] = 0.0
    m2: Annotated[float, Doc("what the one after that adds")] = 0.0


def flushed(x):
    """A number, or 0 where it would soon be denormal."""
    return x if abs(x) > TINY else 0.0


def filtered(p, s, e):
    """Next state and output of a section with the input ``e``."""
    y = p.b0 * e + s.m1
    return FilterState(flushed(p.b1 * e - p.a1 * y + s.m2), flushed(p.b2 * e - p.a2 * y)), y


def align(params: Coefficients, command: float, feedback: float, output: float) -> FilterState:
    """The state from which the next output is ``output``, at rest."""
    return FilterState(output - params.b0 * output, params.b2 * output - params.a2 * output)


@controller(Notch, FilterState, prepare=coefficients, align=align)
def notch(p, s, command, feedback):
    """Passes the error, but for a band around one frequency."""
    return filtered(p, s, command - feedback)


@controller(LowPass, FilterState, prepare=coefficients, align=align)
def low_pass(p, s, command, feedback):
    """Passes the error below a corner frequency."""
    return filtered(p, s, command - feedback)


@controller(LeadLag, FilterState, prepare=coefficients, align=align)
def lead_lag(p, s, command, feedback):
    """Raises the gain of the error on one side of two frequencies."""
    return filtered(p, s, command - feedback)


FILTERS = (notch.step, low_pass.step, lead_lag.step)
"""Steps whose output at rest is their error."""
