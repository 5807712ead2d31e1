"""Sixty ball-screw axes for the identification of friction, drawn with fixed seeds, and their friction tests.

An axis is *suitably excited* where the slow row of the test breaks it away both ways and passes its Stribeck speed
slowly enough for the scale to count: here ``2 a kp = 3 F_C`` with ``F_S`` of 1.2 to 1.8 ``F_C``, and Stribeck speeds of
0.5 to 8 mrad/s, at which the scale counts every 3 to 50 samples.
"""

import numpy as np

from leadscrew.plants._ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.references._friction_test import ROWS, friction_test
from leadscrew.studies.fsmc_ballscrew.records import record_loop

AXES = 60
FULL_N_M = 6.24
"""Coulomb friction that the test's own amplitudes are made for."""


def drawn(k):
    """Parameters of the ``k``-th axis, by name; most of them log-uniform."""
    random = np.random.default_rng([2026, k])

    def between(low, high):
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    coulomb, stiffness = between(3.0, 12.0), between(4e4, 3e5)
    return {
        "stiffness": stiffness,
        "damping": stiffness * between(1.5e-3, 6e-3),
        "viscous": between(0.1, 1.0),
        "coulomb": coulomb,
        "static": coulomb * random.uniform(1.2, 1.8),
        "stribeck_speed": between(5e-4, 8e-3),
        "inertia": between(2.2e-4, 8e-4),
    }


def axis_log(axis):
    """Time, torque, angle of the friction test, its amplitudes in proportion to the Coulomb friction."""
    size = axis["coulomb"] / FULL_N_M
    scaled = friction_test([(size * a, f, n) for a, f, n in ROWS]).params
    changes = {"plant.inertia" if k == "inertia" else f"plant.friction.{k}": v for k, v in axis.items()}
    loop, seconds = record_loop("test", changes=changes)
    run = loop.using({"reference.amplitude": scaled.amplitude}).run(seconds, record=("output", "feedback"))
    return run.time, run["output"], run["feedback"] / TRAVEL_MM_PER_RAD
