"""The study's controllers by name: whose each one is, the name says."""

from __future__ import annotations

from leadscrew.controllers.vud import duty_pd, duty_pid, power_law, vud, vud_beta_e
from leadscrew.controllers.vud.family import BETA_E, vud_family
from leadscrew.kernel.block import Block
from leadscrew.studies.vud_lathe.fast import FAST
from leadscrew.studies.vud_lathe.variants import VARIANTS

CONTROLLERS: dict[str, Block] = {
    "paper.vud": vud,
    "corrected.vud_beta_e": vud_beta_e,
    "corrected.vud_beta_e_half": vud_beta_e(output_gain=1.0, output_tau=0.5),
    "corrected.vud_beta_e_filtered": vud_family(**BETA_E, filter_s=0.005),
    "ours.original_fit": power_law,
    "ours.original_p": power_law(exponent=1.0, gain=2.73),
    "ours.original_pid": duty_pid(kp=0.0139, ki=0.00086, kd=0.0, filter_s=0.0005, anti_windup=1),
    "ours.pd": duty_pd,
    **VARIANTS,
    **FAST,
}
"""The printed law and its corrections; three fits of the servo that it replaced; a plain PD; variants; the fast ones.

The P and PID fits hold for 209 mm/s at full duty, where they fit Table 1 best (see ``original.py``).
"""
