"""The axis put through a positioning test of ISO 230-2, behind the encoder on the motor and behind the grating.

One sequence with reversals, as on a machine: beyond the lower end, up through all targets, beyond the upper end, down
through all targets, five times. Every approach is a step of the command from where the last one ended; the true
position of the table is read 2 s later, which is when the paper starts to show its errors. Nothing is reset between
approaches or runs: play, sensor, controller and noise go on. The paper did no such test: targets, screw and ruler
(machine ``screw`` of :mod:`leadscrew.studies.vud_lathe.scenarios`) and the warming are ours.

Runs differ by three things: the ruler's noise; where within a count and within the play an approach ends; and the
screw, fixed at 0, which warms from the start of the test by ``WARMING_K (1 - exp(-t / WARMING_S))``, in a step at each
reversal.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from leadscrew.analysis.positioning import Correction, Positioning, correction, positioning
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.vud_lathe.scenarios import STEPS

TARGETS_MM = (-176.3, -132.8, -88.1, -41.4, 3.7, 46.9, 92.2, 137.6, 178.4)
"""Nine on 355 mm, at unequal distances and phases of the 10 mm lead; within the 190 mm of Table 1."""
OVERRUN_MM = 185.0
"""Where the direction turns: beyond the last target on both sides."""
RUNS = 5
READ_S = 2.0
"""From the step to the reading."""
WARMING_K, WARMING_S = 1.0, 100.0
"""How much warmer the screw becomes, and how fast: ours, for a test of 200 s after a cold start."""
CONTROLLER = "corrected.vud_beta_e"


def way() -> list[tuple[int, bool, float]]:
    """The sequence of one run: number of the target (-1: overrun), upwards or not, position."""
    up = [(i, True, x) for i, x in enumerate(TARGETS_MM)]
    down = [(i, False, x) for i, x in reversed(list(enumerate(TARGETS_MM)))]
    return [(-1, False, -OVERRUN_MM), *up, (-1, True, OVERRUN_MM), *down]


@measure
def run_test(lab: Lab, sensor: str, controller: str = CONTROLLER, compensated: bool = False) -> Positioning:
    """The test behind a sensor (``encoder`` or ``grating``), evaluated.

    ``compensated``: with the screw compensation that the test behind the encoder gives, as LinuxCNC adds it to the
    command.
    """
    table: Correction | None = correction(run_test(lab, "encoder")) if compensated else None
    loop = lab.loop(controller, STEPS["m50"].scenario, machine="screw", sensor=sensor)
    live = loop.start()
    periods = round(READ_S / loop.period)
    ends = np.zeros((2, len(TARGETS_MM), RUNS))
    for run in range(RUNS):
        for number, upwards, target in way():
            added = 0.0 if table is None else float(table.at(target, upwards))
            live.set("reference.target", target + added)
            if number < 0:
                live.set("plant.warming_K", WARMING_K * -math.expm1(-live.time / WARMING_S))
            live.advance(periods, every=0)
            if number >= 0:
                ends[0 if upwards else 1, number, run] = table_mm(live)
    deviations = 1000.0 * (ends - np.array(TARGETS_MM)[:, None])
    return positioning(TARGETS_MM, deviations[0], deviations[1])


def table_mm(live: Any) -> float:
    """Where the table truly is: nut and what the screw adds."""
    at = live.values()
    return float(at["plant.nut"] + at["plant.rest"])
