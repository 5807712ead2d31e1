"""The moire fringe of two gratings, and the data of the ruler: Long, Yuan, Xu, Du (2014), section III and (1).

Two equal gratings of pitch ``w`` whose lines cross at the angle ``theta`` show fringes of width

    W = w / (2 sin(theta / 2))  ~  w / theta  =  k_w w              (1)

so a slide that moves by one pitch moves the fringe by ``W``: the fringe magnifies the pitch ``k_w`` times. The short
form is too narrow by ``1 - 2 sin(theta/2) / theta``, about ``theta^2 / 24``.

The paper calls ``w`` "the number of grating grooves per mm". Equation (1) gives a width only if ``w`` is the pitch in
millimetres, the inverse of that number; here it is the pitch.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from leadscrew.kernel.parameters import Doc, Gt, Unit
from leadscrew.util.errors import ValueRefused


class ReflectionGrating(NamedTuple):
    """The paper's ruler: a reflection grating on stainless steel (section III). Data, no model."""

    lines_per_mm: Annotated[float, Unit("1/mm"), Gt(0), Doc("pairs of gap and stripe; section III")] = 100.0
    least_gap_mm: Annotated[float, Unit("mm"), Gt(0), Doc("between the two gratings, to avoid friction; III a")] = 0.03
    largest_gap_mm: Annotated[float, Unit("mm"), Gt(0), Doc("between the two gratings; III a")] = 0.06
    subdivision: Annotated[int, Gt(0), Doc("counts a pitch, made by the frequency multiplier; III, end")] = 16
    lag_s: Annotated[float, Unit("s"), Gt(0), Doc("lag of the reader, (4)")] = 0.006

    @property
    def pitch_mm(self) -> float:
        """Length of one pair of lines, mm; the paper's "grating gap" of 0.01 mm."""
        return 1.0 / self.lines_per_mm

    @property
    def resolution_mm(self) -> float:
        """Length of one count, mm; 0.625 um."""
        return self.pitch_mm / self.subdivision

    def fringe_rate_hz(self, speed_mm_s: float) -> float:
        """Pitches, and so periods of the signals, per second at a speed of the slide."""
        return abs(speed_mm_s) / self.pitch_mm

    def count_rate_hz(self, speed_mm_s: float) -> float:
        """Counts per second at a speed of the slide."""
        return abs(speed_mm_s) / self.resolution_mm


GRATING = ReflectionGrating()
"""The ruler of section III as printed."""


def _angle(angle_rad: float) -> float:
    if not 0.0 < angle_rad <= math.pi:
        raise ValueRefused(f"angle_rad = {angle_rad!r} (angle between two gratings): allowed range is (0, pi]")
    return angle_rad


def magnification(angle_rad: float) -> float:
    """Fringe width over pitch, ``1 / (2 sin(angle/2))``: 573 at 0.1 degrees.

    Raises:
        ValueRefused: an angle outside (0, pi].
    """
    return 1.0 / (2.0 * math.sin(0.5 * _angle(angle_rad)))


def small_angle_magnification(angle_rad: float) -> float:
    """``k_w = 1 / angle``, the short form of (1).

    Raises:
        ValueRefused: an angle outside (0, pi].
    """
    return 1.0 / _angle(angle_rad)


def fringe_width(pitch_mm: float, angle_rad: float) -> float:
    """Width of the fringe in mm, (1) in full, for a pitch in mm and the angle between the gratings.

    Raises:
        ValueRefused: a pitch that is not above 0, an angle outside (0, pi].
    """
    if not pitch_mm > 0.0 or math.isinf(pitch_mm):
        raise ValueRefused(f"pitch_mm = {pitch_mm!r} (grating): allowed range is (0, inf) mm")
    return pitch_mm * magnification(angle_rad)


def small_angle_error(angle_rad: float) -> float:
    """How much too narrow the short form ``w / theta`` is, relative to the fringe: ``1 - 2 sin(theta/2) / theta``.

    Raises:
        ValueRefused: an angle outside (0, pi].
    """
    return 1.0 - small_angle_magnification(angle_rad) / magnification(angle_rad)
