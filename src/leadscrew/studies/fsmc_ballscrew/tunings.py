"""Settings of the study that belong to no controller's own file: for a drive with lags, and yardsticks.

In mm of the table, as the study's loops command and show. The settings for lags and for an axial mode were found by
CMA-ES over the largest errors on the paper's three sines from rest, on the machine that they are for, then checked on
amplitudes a little different: ``docs/drive_realism.md`` says what they reach.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from leadscrew.controllers.look_ahead import look_ahead
from leadscrew.controllers.pd_dob import pd_dob
from leadscrew.controllers.sliding.complementary import csmc
from leadscrew.controllers.sliding.conventional import smc
from leadscrew.controllers.torque_pid import torque_pid
from leadscrew.kernel.block import Block
from leadscrew.plants.ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD

LAYER = 6.24 / INERTIA / 4000.0
"""Boundary layer, rad/s, that gives a slope of 4000 1/s where the friction is F_C."""

LAYER_TUNED = 2.0 * 6.24 / INERTIA / 3980.0

FILTER_S = 1.0 / (2.0 * math.pi * 1000.0)
"""Lag of a filter of 1 kHz."""


BARE_PD = pd_dob(
    kp=300.0, kd=0.5, kp_slow=0.0, kd_slow=0.0, observer_rate=0.0, friction=False, travel_per_rad=TRAVEL_MM_PER_RAD
)
"""What the stage is held by while its friction is tested: nothing that integrates, nothing that is believed."""

GAINS: Mapping[str, float] = {
    "kp": 390.0, "kd": 0.42, "kp_slow": 400.0, "kd_slow": 8.65, "slow_speed": 0.085, "observer_rate": 2110.0,
}  # fmt: skip
"""For a hat that is right, at 4 kHz: the best of 270 random points over every reversal of the two larger sines that
also keeps the smallest below 50 nm and is stable with a sample of delay."""


def ahead(acts_late_s: float, seen_late_s: float, **gains: float) -> Block:
    """The scheduled PD with an observer, looking ahead."""
    inner = pd_dob(travel_per_rad=TRAVEL_MM_PER_RAD, **gains)
    return look_ahead(inner, acts_late_s=acts_late_s, seen_late_s=seen_late_s)


TUNINGS: dict[str, Block] = {
    "ours.pd_test": BARE_PD,
    "ours.smc_layer": smc(layer_rate=0.0, boundary=LAYER, travel_per_rad=TRAVEL_MM_PER_RAD),
    "ours.csmc_layer": csmc(layer_rate=0.0, boundary=2.0 * LAYER, travel_per_rad=TRAVEL_MM_PER_RAD),
    "ours.csmc_tuned": csmc(
        **{"lam": 600.0, "layer_rate": 0.0, "boundary": LAYER_TUNED, "hat.damping": 0.0},
        travel_per_rad=TRAVEL_MM_PER_RAD,
    ),
    "ours.pid": torque_pid(kp=2850.0, ki=590300.0, kd=11.59, filter_s=1.064e-05, travel_per_rad=TRAVEL_MM_PER_RAD),
    "ours.pd_dob_delay": ahead(
        2.5e-4, 0.0, kp=178.3, kd=0.3906, kp_slow=455.4, kd_slow=11.58, slow_speed=0.03684, observer_rate=913.8,
        low_pass_hz=1630.0,
    ),
    "ours.pd_dob_late": ahead(
        2.5e-4, FILTER_S, kp=163.0, kd=0.4973, kp_slow=576.4, kd_slow=10.38, slow_speed=0.05531, observer_rate=587.0,
        low_pass_hz=1472.0,
    ),
    "ours.pd_dob_drive": ahead(
        4.5e-4, FILTER_S, kp=59.88, kd=0.06412, kp_slow=36.43, kd_slow=0.03495, slow_speed=0.04008,
        observer_rate=377.4, low_pass_hz=241.7,
    ),
    "ours.pd_dob_1khz": ahead(
        0.0, 0.0, kp=91.67, kd=0.08845, kp_slow=1207.0, kd_slow=14.87, slow_speed=0.07475, observer_rate=295.3,
        low_pass_hz=206.3,
    ),
    "ours.pd_dob_drive_1khz": ahead(
        1.2e-3, FILTER_S, kp=166.6, kd=0.04178, kp_slow=153.9, kd_slow=0.01516, slow_speed=0.05755,
        observer_rate=67.31, low_pass_hz=55.9,
    ),
}  # fmt: skip
"""By the names of the study. ``delay``: one sample of computation delay; ``late``: that and a scale filtered at 1 kHz;
``drive``: everything of :mod:`leadscrew.studies.fsmc_ballscrew.driven`; ``1khz``: sampled at 1 kHz."""
