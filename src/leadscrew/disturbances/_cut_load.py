"""What flexible material does to a blade along the programmed line: where it is, its texture, and pushes.

    n_(k+1) = n_k exp(-ds / length) + size sqrt(1 - exp(-2 ds / length)) w_k,      ds = feed dt

``n`` is the texture of the material: an Ornstein-Uhlenbeck process in arc length, of standard deviation ``size`` and
correlation length ``length``; ``w`` is Gaussian and white. ``step`` is a change of the steady shear from ``step_at``
on, for ``step_for`` seconds; ``push`` one of the cut line itself.

Source: a reconstruction for the study ``sofnn_tangent``, whose paper gives no process.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.block import disturbance
from leadscrew.kernel.noise import normal
from leadscrew.kernel.parameters import Doc, Ge, Gt, Unit
from leadscrew.references._cut_line import ROOM, Again, Curvature, Feed, Heading, Samples, Turn, place_of, sample_of

NEVER_S = 1e9
"""Start of a change that does not come, and length of one that stays."""

TINY = 1e-30
"""Below this a texture that fades is 0."""


class CutLoad(NamedTuple):
    """The line and the material where the blade is."""

    heading: Annotated[float, Unit("deg"), Doc("tangent of the programmed line")] = 0.0
    curvature: Annotated[float, Unit("1/mm"), Doc("its curvature")] = 0.0
    texture: Annotated[float, Unit("deg"), Doc("change of the steady shear")] = 0.0
    push: Annotated[float, Unit("deg"), Doc("change of the cut line's angle at once")] = 0.0
    travel: Annotated[float, Unit("mm"), Doc("distance along the line")] = 0.0


class CutLoadParams(NamedTuple):
    """Line, texture and pushes."""

    heading: Heading = np.zeros(ROOM)
    curvature: Curvature = np.zeros(ROOM)
    samples: Samples = 1
    again: Again = False
    turn: Turn = 0.0
    feed: Feed = 50.0
    size: Annotated[float, Unit("deg"), Ge(0), Doc("standard deviation of the texture")] = 0.25
    length: Annotated[float, Unit("mm"), Gt(0), Doc("correlation length of the texture")] = 3.0
    step: Annotated[float, Unit("deg"), Doc("change of the steady shear")] = 0.0
    push: Annotated[float, Unit("deg"), Doc("change of the angle of the cut")] = 0.0
    step_at: Annotated[float, Unit("s"), Ge(0), Doc("when both come")] = 0.0
    step_for: Annotated[float, Unit("s"), Ge(0), Doc("how long they last")] = NEVER_S


class Texture(NamedTuple):
    """The texture where the blade is."""

    value: Annotated[float, Unit("deg")] = 0.0
    begun: Annotated[float, Doc("0 before the first sample, which is drawn from all textures")] = 0.0


@disturbance(CutLoadParams, Texture)
def cut_load(p, s, t, dt, noise):
    """The line under the blade, with the texture of the material."""
    k = sample_of(t, dt)
    here = place_of(p.samples, p.again, p.turn, k)
    keep = s.begun * math.exp(-p.feed * dt / p.length)
    value = keep * s.value + p.size * math.sqrt(1.0 - keep * keep) * normal(noise, 0)
    after = value if abs(value) > TINY else 0.0
    on = 1.0 if t > p.step_at - 0.5 * dt and t < p.step_at + p.step_for - 0.5 * dt else 0.0
    return Texture(after, 1.0), CutLoad(
        p.heading[here.at] + here.laps, p.curvature[here.at], after + on * p.step, on * p.push, k * p.feed * dt
    )
