"""A tangential knife on a line that sways, under the controllers beside the network.

The line is a formula: two tables of 2048 places each for the reference and the load would not fit into HAL's memory.
"""

import math
from typing import NamedTuple

import numpy as np

from leadscrew import disturbance, reference
from leadscrew.actuators._saturation import saturation
from leadscrew.controllers._tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers._tangent.curvature_network import curvature_network
from leadscrew.controllers._tangent.tangent_dob import tangent_dob
from leadscrew.controllers._tangent.taught_offset import taught_alone, taught_offset
from leadscrew.disturbances._cut_load import CutLoad
from leadscrew.kernel.loop import Loop
from leadscrew.plants._flexible_cut import flexible_cut
from leadscrew.references._cut_line import TangentCommand
from leadscrew.references._step import step
from leadscrew.sensors._cut_camera import cut_camera, cut_reading

T = 0.01


class Sway(NamedTuple):
    """How far to either side, deg, over which way, mm; speed, mm/s."""

    size: float = 90.0
    length: float = 30.0
    feed: float = 50.0


def heading(p, way):
    return p.size * math.sin(way / p.length)


def curvature(p, way):
    return math.pi / 180.0 * p.size / p.length * math.cos(way / p.length)


@reference(Sway())
def sway(p, t, dt):
    way, then = p.feed * t, p.feed * (t + dt)
    return TangentCommand(0.0, heading(p, way), curvature(p, way), heading(p, then), curvature(p, then), way)


@disturbance(Sway())
def sway_load(p, t):
    way = p.feed * t
    return CutLoad(heading(p, way), curvature(p, way), 0.0, 0.0, way)


def knife(controller, noise=0.0, size=90.0, **options):
    """The loop; no texture, and no noise unless asked for."""
    whole = getattr(controller.step, "takes_cut_line", False)
    camera = cut_reading if whole else cut_camera
    parts = {
        "reference": sway(size=size) if whole else step(target=0.0),
        "controller": controller,
        "plant": flexible_cut,
        "sensor": camera(noise_deg=noise),
        "actuator": saturation(lower=-15.0, upper=15.0),
        "disturbance": sway_load(size=size),
        "period": T,
    }
    return Loop(**(parts | options))


def taught():
    return knife(taught_offset(tangent_dob, 1.5 * np.sin(np.arange(200) * 0.05)), noise=0.15)


def by_table():
    return knife(taught_alone(1.5 * np.sin(np.arange(150) * 0.05), laps=1), noise=0.15)


def fed_forward():
    return knife(curvature_feed_forward, noise=0.15)


def by_rules():
    return knife(curvature_network, noise=0.15)


def observed():
    return knife(tangent_dob, noise=0.15)
