"""A tangential knife under the network in which all groups of weights learn."""

from dataclasses import replace

import numpy as np

from leadscrew.controllers._sofnn.network import sofnn_all_weights
from leadscrew.disturbances._cut_load import cut_load
from leadscrew.kernel.loop import Loop
from leadscrew.references._cut_line import cut_line
from tests.controllers.sofnn_loop import T, knife_loop

ALL = {"q_centre": 0.01, "q_certainty": 0.01}
TURNS = 2.0 * np.pi * np.arange(200) / 200.0


# ---- for the table of exports
def all_groups():
    """Round and round a lap of 100 mm: with the tables of a long one the loop would be too large for HAL's memory."""
    bend = 2.0 * np.pi / 100.0
    lap = {"heading": 60.0 * np.sin(TURNS), "curvature": np.radians(60.0 * bend * np.cos(TURNS)), "samples": 200}
    controller = sofnn_all_weights(source="network", passes=2, **ALL)
    loop = knife_loop(controller)
    return Loop(
        reference=replace(cut_line, params=cut_line.params._replace(**lap, again=True)),
        disturbance=replace(cut_load, params=cut_load.params._replace(**lap, again=True)),
        controller=controller,
        period=T,
        metrics={},
        **{name: loop.blocks[name] for name in ("actuator", "plant", "sensor")},
    )
