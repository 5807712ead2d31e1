"""Records of the ball-screw stage for the tests of the identification of friction; each is simulated once."""

from functools import cache

import numpy as np

from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.studies.fsmc_ballscrew.records import record_loop

HARDER = (("plant.friction.coulomb", 1.2 * 6.24), ("plant.friction.static", 1.2 * 9.36))


@cache
def record(kind, changes=()):
    """Time, torque, angle of a record, ``test`` or ``sines``."""
    loop, seconds = record_loop(kind, changes=dict(changes))
    run = loop.run(seconds, record=("output", "feedback"))
    return run.time, run["output"], run["feedback"] / TRAVEL_MM_PER_RAD


def off_percent(fit, **true):
    """By how much each parameter differs from the truth."""
    return {name: 100.0 * abs(getattr(fit.friction, name) / value - 1.0) for name, value in true.items()}


def write_csv(path, time, torque, position, header="time,output,feedback"):
    """A log as a machine writes it."""
    np.savetxt(path, np.column_stack([time, torque, position]), delimiter=",", header=header, comments="", fmt="%.9g")
    return path
