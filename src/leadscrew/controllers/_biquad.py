"""Biquads: second-order sections on any controller's output, for a resonance of the machine or a noisy output.

    y_k = b0 x_k + m1,    m1 <- b1 x_k - a1 y_k + m2,    m2 <- b2 x_k - a2 y_k          (transposed direct form II)
    H(z) = (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2)

in series, ``section_1`` first. Four kinds of section:

- :class:`Notch`, from ``(s^2 + depth 2 pi width s + w^2) / (s^2 + 2 pi width s + w^2)`` with ``w = 2 pi centre``: gain
  ``depth`` at the centre, 1 far from it; with depth 0 the band below 0.71 is ``width`` wide;
- :class:`LowPass`, from ``w^2 / (s^2 + 2 damping w s + w^2)`` with ``w = 2 pi corner``;
- :class:`LeadLag`, from ``(1 + s / (2 pi zero)) / (1 + s / (2 pi pole))``: more gain at low frequencies where the pole
  is the lower one (a lag), more phase between the two where the zero is (a lead);
- :class:`Coefficients`: b0, b1, b2, a1, a2 as they are.

The first two by Tustin's rule with pre-warping, ``s = w / tan(w dt / 2) (z - 1) / (z + 1)``: gain and phase at the
centre or corner are exact at any period; the third with ``s = 2 / dt (z - 1) / (z + 1)``. The DC gain of
all three is 1.

LinuxCNC's component ``biquad`` computes the same three lines. Its ``n0, n1, n2, d1, d2`` are b0, b1, b2, a1, a2 here
(type 0); its low-pass of ``f0`` and ``Q`` (type 1) is the one of ``damping = 1 / (2 Q)``; its notch (type 2) is the one
of ``width = f0 / Q`` and depth 0. For types 1 and 2 it takes only Q from 0.5 to 2, so a notch of 100 Hz cannot be
narrower than 50 Hz (narrower ones: type 0 with the numbers from here), and it starts from memory 0, with a jump.

A limit of the inner controller's output comes before the sections: they may overshoot it. Bumpless start: the inner
controller is aligned to the output divided by the DC gain, and the sections work around that output from then on.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.controllers._parallel import TINY
from leadscrew.controllers._wrapping import around, same_kind, wrapped
from leadscrew.kernel.block import Block
from leadscrew.kernel.by_position import prepared
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Unit
from leadscrew.util.errors import ValueRefused, entry_point


class Notch(NamedTuple):
    """Takes out what lies around a frequency."""

    centre_hz: Annotated[float, Unit("Hz"), Gt(0), Doc("where it takes out most; below half the sampling rate")] = 100.0
    width_hz: Annotated[float, Unit("Hz"), Gt(0), Doc("width of the band that it takes out")] = 20.0
    depth: Annotated[float, Ge(0), Le(1), Doc("gain at the centre; 0 takes it out whole")] = 0.1


class LowPass(NamedTuple):
    """Takes out what lies above a frequency."""

    corner_hz: Annotated[float, Unit("Hz"), Gt(0), Doc("natural frequency; below half the sampling rate")] = 300.0
    damping: Annotated[float, Gt(0), Doc("damping ratio; 0.707 is Butterworth's")] = 0.7071067811865476


class LeadLag(NamedTuple):
    """Raises the gain on one side of two frequencies; first order."""

    zero_hz: Annotated[float, Unit("Hz"), Gt(0), Doc("frequency of the zero; below half the sampling rate")] = 30.0
    pole_hz: Annotated[float, Unit("Hz"), Gt(0), Doc("frequency of the pole; below half the sampling rate")] = 3.0


class Coefficients(NamedTuple):
    """A section by its numbers; the default lets everything through."""

    b0: Annotated[float, Doc("numerator, z^0; n0 in LinuxCNC")] = 1.0
    b1: Annotated[float, Doc("numerator, z^-1; n1 in LinuxCNC")] = 0.0
    b2: Annotated[float, Doc("numerator, z^-2; n2 in LinuxCNC")] = 0.0
    a1: Annotated[float, Doc("denominator, z^-1; d1 in LinuxCNC")] = 0.0
    a2: Annotated[float, Doc("denominator, z^-2; d2 in LinuxCNC")] = 0.0


Level = Annotated[float, Doc("output around which the sections work; that of the last align")]

Section = Notch | LowPass | LeadLag | Coefficients


def coefficients(section: Section, dt: float) -> Coefficients:
    """The numbers of a section at a period of ``dt`` seconds.

    Raises:
        ValueRefused: a frequency at or above half the sampling rate, an unstable section, or one whose DC gain is 0.
    """
    if isinstance(section, Coefficients):
        if not (abs(section.a2) < 1.0 and abs(section.a1) < 1.0 + section.a2):
            raise ValueRefused(
                f"a1 = {section.a1!r}, a2 = {section.a2!r} (biquad): unstable; |a2| < 1 and |a1| < 1 + a2 are needed"
            )
        if section.b0 + section.b1 + section.b2 == 0.0:
            raise ValueRefused("b0 + b1 + b2 = 0 (biquad): its DC gain is 0, a constant load could not be held")
        return section
    frequencies = {
        key: value
        for key, value in section._asdict().items()
        if key in ("centre_hz", "corner_hz", "zero_hz", "pole_hz")
    }
    for field, frequency in frequencies.items():
        if frequency * dt >= 0.5:
            raise ValueRefused(
                f"{field} = {frequency!r} Hz (biquad): must lie below half the sampling rate, {0.5 / dt:g} Hz at a "
                f"period of {dt!r} s"
            )
    if isinstance(section, LeadLag):
        zero, pole = (1.0 / (math.pi * f * dt) for f in (section.zero_hz, section.pole_hz))
        return Coefficients((1.0 + zero) / (1.0 + pole), (1.0 - zero) / (1.0 + pole), 0.0, (1.0 - pole) / (1.0 + pole))
    frequency = section.centre_hz if isinstance(section, Notch) else section.corner_hz
    w = 2.0 * math.pi * frequency
    k = w / math.tan(0.5 * w * dt)
    if isinstance(section, Notch):
        wide = 2.0 * math.pi * section.width_hz
        above, below = (1.0, section.depth * wide, w * w), (1.0, wide, w * w)
    else:
        above, below = (0.0, 0.0, w * w), (1.0, 2.0 * section.damping * w, w * w)
    (b0, b1, b2), (a0, a1, a2) = (
        (q * k * k + r * k + c, 2.0 * (c - q * k * k), q * k * k - r * k + c) for q, r, c in (above, below)
    )
    return Coefficients(b0 / a0, b1 / a0, b2 / a0, a1 / a0, a2 / a0)


def filtered(c, m, x):
    """``x`` through all sections; ``m`` is their memory, two numbers a section, and is written."""
    y = x
    for i in range(c.shape[0]):
        x = y
        y = c[i, 0] * x + m[2 * i]
        m1, m2 = c[i, 1] * x - c[i, 3] * y + m[2 * i + 1], c[i, 2] * x - c[i, 4] * y
        m[2 * i] = m1 if abs(m1) > TINY else 0.0
        m[2 * i + 1] = m2 if abs(m2) > TINY else 0.0
    return y


@entry_point
def biquad(inner: Block, *sections: Section, name: str = "") -> Block:
    """The controller ``inner``, its output through ``sections`` (one notch of 100 Hz where none is given).

    Its parameters are those of ``inner`` below ``inner.``, and ``section_1.centre_hz`` and so on.

    Raises:
        BlockError: ``inner`` is not a sampled controller with parameters and state, or takes other signals.
        ValueRefused: a section that :func:`coefficients` refuses, when the loop is built.
    """
    part = wrapped(inner, "biquad")
    given = sections or (Notch(),)
    size = 2 * len(given)
    law = part.law
    params_type = around("BiquadParams", inner.params, *((f"section_{i + 1}", type(s)) for i, s in enumerate(given)))
    state_type = around("BiquadState", inner.state, ("memory", np.ndarray), ("level", Level))

    def prepare(params: Any, dt: float) -> Any:
        ready = prepared(inner, dt, params.inner)
        plan_type = around("BiquadPlan", ready, ("table", np.ndarray), ("dc_gain", float), ("rest", np.ndarray))
        table = np.array([coefficients(section, dt) for section in params[1:]])
        dc_gain = np.prod(table[:, :3].sum(axis=1) / (1.0 + table[:, 3:].sum(axis=1)))
        return plan_type(ready, table, float(dc_gain), np.zeros(size))

    def align(params, command, feedback, output):
        """The state from which the next output is ``output``: all sections at rest around it."""
        after = part.align(params.inner, command, feedback, output / params.dc_gain)
        return state_type(after, params.rest, output)

    def sectioned(p, s, command, feedback, dt):
        """The inner controller, its output through the sections."""
        after, u = law(p.inner, s.inner, command, feedback, dt)
        y = s.level + filtered(p.table, s.memory, u - s.level / p.dc_gain)
        return state_type(after, s.memory, s.level), y

    return same_kind(
        sectioned, part, params_type(inner.params, *given), state_type(inner.state, np.zeros(size), 0.0),
        "Its output goes through second-order sections.", prepare=prepare, align=align,
        name=name or f"{inner.name}_biquad",
    )  # fmt: skip
