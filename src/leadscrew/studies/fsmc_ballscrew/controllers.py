"""The controllers of the study, by name, for a command and a feedback in mm of the table.

``paper.*`` is what the paper prints, ``corrected.*`` the same with one change: the surface of the sliding mode has no
integral; the fuzzy rules act along s + s_c. Both run in continuous time with the printed gains, which ask for 200 kHz
and more. ``ours.*`` are for a machine: sampled at 4 kHz; ``tuned.*`` are seven laws with gains of equal searches.

In all of them the friction estimate f_hat is driven by the *commanded* speed. That is our reading: the paper writes
f_hat as a function of the state, which with the parameters of Table 2 is unstable (``friction_from``
``measured``; ``measured_undamped`` leaves out the term sigma_1 dz/dt).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from leadscrew import controller_file
from leadscrew.controllers._look_ahead import look_ahead
from leadscrew.controllers._pd_dob import pd_dob
from leadscrew.controllers._sliding.complementary import csmc
from leadscrew.controllers._sliding.continuous import (
    csmc_ideal,
    fsmc_ideal,
    fsmc_printed_ideal,
    smc_ideal,
    smc_integral_ideal,
)
from leadscrew.controllers._sliding.conventional import smc
from leadscrew.controllers._sliding.integral import smc_integral
from leadscrew.controllers._sliding.super_twisting import super_twisting
from leadscrew.controllers._torque_pid import torque_pid
from leadscrew.kernel.block import Block
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.studies import tuned as tuned_gains
from leadscrew.studies.fsmc_ballscrew.tunings import FUZZY, LEARNED
from leadscrew.studies.fsmc_ballscrew.tunings import SCHEDULED as PD_DOB

IDEAL: dict[str, Block] = {
    "paper.smc": smc_integral_ideal,
    "paper.csmc": csmc_ideal,
    "paper.fsmc": fsmc_printed_ideal,
    "corrected.smc": smc_ideal,
    "corrected.fsmc": fsmc_ideal,
}
"""Without sampling."""

SAMPLED: dict[str, Block] = {
    "ours.smc_4khz": smc,
    "ours.csmc_4khz": csmc,
    "ours.smc_integral_4khz": smc_integral,
    **{name: block for name, block in FUZZY.items() if name.startswith("ours.")},
    "ours.super_twisting": super_twisting,
    **PD_DOB,
    **LEARNED,
}
"""At 4 kHz, in rad; :data:`CONTROLLERS` has them in mm."""

LAYER = 6.24 / INERTIA / 4000.0
"""Boundary layer, rad/s, that gives a slope of 4000 1/s where the friction is F_C."""

LAYER_TUNED = 2.0 * 6.24 / INERTIA / 3980.0
FILTER_S = 1.0 / (2.0 * math.pi * 1000.0)
"""Lag of a filter of 1 kHz."""
BARE_PD = pd_dob(
    kp=300.0, kd=0.5, kp_slow=0.0, kd_slow=0.0, observer_rate=0.0, friction=False, travel_per_rad=TRAVEL_MM_PER_RAD
)
"""Holds the stage while its friction is tested: no integral, no friction model."""


def ahead(actuation_delay_s: float, measurement_delay_s: float, **gains: float) -> Block:
    """The scheduled PD with an observer, looking ahead."""
    inner = pd_dob.using(travel_per_rad=TRAVEL_MM_PER_RAD, **gains)
    return look_ahead(inner, actuation_delay_s=actuation_delay_s, measurement_delay_s=measurement_delay_s)


TUNINGS: dict[str, Block] = {
    "ours.pd_test": BARE_PD,
    "ours.smc_layer": smc(layer_rate=0.0, boundary=LAYER, travel_per_rad=TRAVEL_MM_PER_RAD),
    "ours.csmc_layer": csmc(layer_rate=0.0, boundary=2.0 * LAYER, travel_per_rad=TRAVEL_MM_PER_RAD),
    "ours.csmc_tuned": csmc(
        **{"lam": 600.0, "layer_rate": 0.0, "boundary": LAYER_TUNED, "hat.damping": 0.0},
        travel_per_rad=TRAVEL_MM_PER_RAD,
    ),
    "ours.pid": torque_pid(kp=2850.0, ki=590300.0, kd=11.59, filter_s=1.064e-05, travel_per_rad=TRAVEL_MM_PER_RAD),
    "ours.pid_friction": pd_dob(kp_slow=0.0, kd_slow=0.0, travel_per_rad=TRAVEL_MM_PER_RAD),
    "ours.pid_bare": pd_dob(kp_slow=0.0, kd_slow=0.0, friction=False, travel_per_rad=TRAVEL_MM_PER_RAD),
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
"""Settings of this study, in mm of the table. Those for lags and an axial mode were found by CMA-ES over the largest
errors on the paper's three sines from rest, on the machine that they are for, and checked on amplitudes a little
different (``docs/drive_realism.md``). ``delay``: one sample of computation delay; ``late``: that and a scale filtered
at 1 kHz; ``drive``: everything of :mod:`leadscrew.studies.fsmc_ballscrew.drives`; ``1khz``: sampled at 1 kHz."""

_OWN: dict[str, Block] = (
    IDEAL | {name: block(travel_per_rad=TRAVEL_MM_PER_RAD) for name, block in SAMPLED.items()} | TUNINGS
)
FOLDER = Path(__file__).parent / tuned_gains.FOLDER
EQUAL = ("smc", "csmc", "fsmc", "smc_integral", "pid_friction", "pd_dob", "pid_bare")
"""Laws of the equal comparison, by the name of their file in ``tuned``."""
ON_A_DRIVE = ("fsmc", "smc_integral", "pid_friction")
"""Those that are tuned with a delay and with an axial mode as well."""
CASES = {"rigid": EQUAL, "printed": EQUAL, "delay": ON_A_DRIVE, "mode": ON_A_DRIVE}
"""The stages that laws are tuned for: drawn ones, that of Table 2, with a sample of delay, with an axial mode."""


def named(law: str, case: str) -> str:
    """Name of a tuned controller, without ``tuned.``, and of its file; ``case``: the stage that it is tuned for."""
    return law if case == "rigid" else f"{law}_{case}"


def _tuned(name: str) -> Block:
    base = controller_file.read(FOLDER / f"{name}.toml").controller
    return tuned_gains.tuned(FOLDER.parent, name, _OWN[base])


CONTROLLERS: Mapping[str, Block] = _OWN | {
    f"tuned.{name}": _tuned(name) for name in (named(law, case) for case, laws in CASES.items() for law in laws)
}
"""All of them; ``tuned.*`` have the gains of equal searches, see :mod:`leadscrew.studies.fsmc_ballscrew.equal`."""
