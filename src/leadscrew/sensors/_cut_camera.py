"""A camera that looks at the cut behind the blade: the deviation of its tangent, late, with noise, and sometimes lost.

    y_k = e_(k-m) + zero + noise_deg w_k,      m = round(trailing_s / dt)

``e`` is the angle between the tangent of the cut and that of the programmed line *at the place that is seen*, 2 mm
behind the blade: 40 ms at 50 mm/s. From ``lost_from_s`` on, for ``lost_for_s``, the cut is not seen: the last reading
is held, and ``seen`` is 0. The first ``m`` readings are of what came before the line: no deviation.

Source: a reconstruction for the study ``sofnn_tangent``, whose paper does not say how the tangent of the cut is
measured.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import sensor
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Unit
from leadscrew.util.errors import ValueRefused

ROOM = 64
"""Samples that a reading may be late, and one."""

NEVER_S = 1e9


class CutCameraParams(NamedTuple):
    """Place and quality of the camera."""

    trailing_s: Annotated[float, Unit("s"), Ge(0), Doc("time from the blade to where the cut is seen")] = 0.04
    noise_deg: Annotated[float, Unit("deg"), Ge(0), Doc("standard deviation of one reading")] = 0.15
    zero_deg: Annotated[float, Unit("deg"), Doc("error of its zero")] = 0.0
    lost_from_s: Annotated[float, Unit("s"), Ge(0), Doc("when the cut is lost")] = NEVER_S
    lost_for_s: Annotated[float, Unit("s"), Ge(0), Doc("for how long")] = 0.0


class CutCameraPlan(NamedTuple):
    """The parameters, and the delay in samples."""

    late: int
    noise_deg: float
    zero_deg: float
    lost_from_s: float
    lost_for_s: float


class CutCameraState(NamedTuple):
    """What was under the blade, and the last reading."""

    ring: Annotated[np.ndarray, Doc("deviations of the last samples")] = np.zeros(ROOM)
    at: Annotated[int, Doc("place of the next")] = 0
    reading: Annotated[float, Unit("deg"), Doc("last reading")] = 0.0


class SeenCut(NamedTuple):
    """What the control sees of the cut."""

    deviation: Annotated[float, Unit("deg"), Doc("tangent of the cut less that of the programme, where it is seen")] = (
        0.0
    )
    seen: Annotated[float, Doc("1; 0 while the cut is not seen and the deviation is the last that was")] = 1.0


def plan(params: CutCameraParams, dt: float) -> CutCameraPlan:
    """The delay in samples.

    Raises:
        ValueRefused: more than the ring holds.
    """
    delay = params.trailing_s / dt
    late = round(min(delay, ROOM))
    if late >= ROOM:
        raise ValueRefused(
            f"trailing_s = {params.trailing_s!r} (cut_camera): {delay:.6g} samples late; expected {ROOM - 1} or fewer, "
            f"{(ROOM - 1) * dt:.4g} s here"
        )
    return CutCameraPlan(late, *params[1:])


def watched(p, s, deviation, t, dt, noise):
    """The next reading."""
    s.ring[s.at] = deviation
    then = s.at - p.late
    old = s.ring[then if then >= 0 else then + ROOM]
    lost = t > p.lost_from_s - 0.5 * dt and t < p.lost_from_s + p.lost_for_s - 0.5 * dt
    reading = s.reading if lost else old + p.zero_deg + p.noise_deg * normal(noise, 0)
    return CutCameraState(s.ring, s.at + 1 if s.at + 1 < ROOM else 0, reading), SeenCut(reading, 0.0 if lost else 1.0)


@sensor(CutCameraParams, CutCameraState, prepare=plan, unit="deg")
def cut_camera(p, s, actual, t, dt, noise):
    """The deviation of the cut, as a number; a lost cut reads as one at rest."""
    after, reading = watched(p, s, actual.deviation, t, dt, noise)
    return after, reading.deviation


@sensor(CutCameraParams, CutCameraState, prepare=plan)
def cut_reading(p, s, actual, t, dt, noise):
    """The deviation of the cut, and whether it is seen."""
    return watched(p, s, actual.deviation, t, dt, noise)
