"""The study's controllers by name: whose each one is, the name says."""

from __future__ import annotations

from leadscrew.controllers.vud import duty_pd, power_law, vud, vud_beta_e
from leadscrew.kernel.block import Block

CONTROLLERS: dict[str, Block] = {
    "paper.vud": vud,
    "corrected.vud_beta_e": vud_beta_e,
    "corrected.vud_beta_e_half": vud_beta_e(output_gain=1.0, output_tau=0.5),
    "ours.original_fit": power_law,
    "ours.pd": duty_pd,
}
"""The printed law; its two corrections; our fit of the servo that it replaced; a plain PD."""
