"""A tangential knife in fabric on a wavy line of its own, without a study."""

from dataclasses import replace

import numpy as np

from leadscrew.actuators._saturation import saturation
from leadscrew.controllers._sofnn import fnn
from leadscrew.disturbances._cut_load import cut_load
from leadscrew.kernel.loop import Loop
from leadscrew.plants._flexible_cut import flexible_cut
from leadscrew.references._cut_line import along, cut_line
from leadscrew.sensors._cut_camera import cut_reading
from leadscrew.studies.sofnn_tangent.tunings import TUNINGS

T = 0.01
WAY = 0.5 * np.arange(900)
"""mm: a sample each at 50 mm/s."""
HEADING, CURVATURE = 60.0 * np.sin(WAY / 40.0), np.radians(1.5 * np.cos(WAY / 40.0))
STRAIGHT = np.zeros(900), np.zeros(900)
QUIET = {"disturbance.size": 0.0, "sensor.noise_deg": 0.0}


def knife_loop(controller, heading=HEADING, curvature=CURVATURE, again=False, **more):
    """The knife; ``again``: lap after lap."""
    laps = {"again": again}
    return Loop(
        reference=along(cut_line, heading, curvature, **laps),
        disturbance=along(cut_load, heading, curvature, **laps),
        controller=controller,
        actuator=saturation(lower=-15.0, upper=15.0),
        plant=flexible_cut,
        sensor=cut_reading,
        period=T,
        metrics={},
        **more,
    )


def state_of(live):
    """The controller's state, a copy."""
    return live.program.plan.state.unpack(live.state[0].copy(), live.state[1].copy()).controller


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


# ---- for the table of exports
def small(controller):
    """The knife on a lap of 503 samples, over and over: the tables of a whole line are too large for HAL's memory."""
    lap = {"heading": HEADING[:503], "curvature": CURVATURE[:503], "samples": 503, "again": True}
    loop = knife_loop(controller)
    parts = {name: loop.blocks[name] for name in ("actuator", "plant", "sensor")}
    return Loop(
        reference=replace(cut_line, params=cut_line.params._replace(**lap)),
        disturbance=replace(cut_load, params=cut_load.params._replace(**lap)),
        controller=controller,
        period=T,
        metrics={},
        **parts,
    )


def network_that_learns():
    return small(TUNINGS["ours.sofnn_tuned"])


def network_of_the_paper():
    """The performance network, stored targets, the inner loop of step (7)."""
    return small(TUNINGS["paper.sofnn_pnn"](passes=5, tolerance=1e-3))


def network_by_lms():
    return small(TUNINGS["ours.sofnn_nlms"])


def rules_that_learn():
    return small(TUNINGS["ours.sofc_tuned"])


def fixed_network():
    return small(fnn)
