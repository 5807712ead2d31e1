"""The study's controllers by name: whose each one is, the name says."""

from __future__ import annotations

from leadscrew.controllers.vud import duty_pd, power_law, vud, vud_beta_e
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
    "ours.pd": duty_pd,
    **VARIANTS,
    **FAST,
}
"""The printed law; its corrections; our fit of the servo that it replaced; a plain PD; the variants."""
