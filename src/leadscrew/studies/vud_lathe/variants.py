"""Variants of the printed law by name, one change each: what makes it creep, what makes it hunt, what makes it quick.

All but four are one block with other parameters (:mod:`leadscrew.controllers.vud.family`), so they share one compiled
program. A factor of "one" is written here as in the prototypes behind this study, ``|x|^0 + 0.0001``; that 0.01 % shows
in the fourth digit of what is still on its way at 2 s.
"""

from __future__ import annotations

from dataclasses import replace

from leadscrew.controllers.vud.family import BELL, ERROR, MAXIMUM, MEAN, ONE, PRODUCT, UNITY, vud_family
from leadscrew.controllers.vud.incremental import vud_incremental
from leadscrew.controllers.vud.integral_factor import vud_integral_factor
from leadscrew.controllers.vud.scaled import ROBUST, vud_scaled
from leadscrew.kernel.block import Block

FIXED = {"output_from": UNITY, "e_kind": ONE, "ec_tau": 0.0}
"""No universe contracts."""

_SET: dict[str, tuple[Block, str]] = {
    "corrected.vud_raw_rate": (
        vud_family(ec_tau=0.0, rate_interval_s=0.001),
        "ec as the plain difference of two periods, not contracted: quick, overshoots.",
    ),
    "corrected.vud_no_rate": (
        vud_family(rate_gain=0.0),
        "ec ignored: quick, overshoots by a quarter of a millimetre.",
    ),
    "corrected.vud_rate_kept": (
        vud_family(ec_tau=0.0),
        "ec as printed, its universe not contracted: arrives, but slowly.",
    ),
    "corrected.vud_rate_reversed": (
        vud_family(rate_gain=-1.0),
        "ec with the other sign: swings by millimetres and never settles.",
    ),
    "corrected.vud_beta_one": (
        vud_family(output_from=UNITY),
        "No output factor: no creep, but a limit cycle of millimetres.",
    ),
    "corrected.vud_beta_product": (
        vud_family(output_from=PRODUCT),
        "Output factor from the product of e and ec: hardly leaves its place.",
    ),
    "corrected.vud_beta_mean": (
        vud_family(output_from=MEAN, output_tau=0.6),
        "Output factor from the mean of |e|^0.6 and |ec|^0.6: arrives, overshoots.",
    ),
    "corrected.vud_beta_max": (
        vud_family(output_from=MAXIMUM, output_tau=0.7),
        "Output factor from the larger of |e| and |ec|, to the 0.7: arrives, overshoots.",
    ),
    "corrected.vud_beta_e_tau9": (
        vud_family(output_from=ERROR),
        "Output factor from the error with the printed exponent: slow at the end.",
    ),
    "ours.fuzzy_plain": (
        vud_family(**FIXED),
        "The rules alone, no universe contracts: steady and slow.",
    ),
    "ours.fuzzy_plain_scaled": (
        vud_family(**FIXED, error_gain=20.0, rate_gain=2.0),
        "The rules alone, inputs scaled by 20 and 2: quick, overshoots.",
    ),
    "ours.vud_alpha_only": (
        vud_family(output_from=UNITY, e_tau=0.4, ec_tau=0.4),
        "No output factor, inputs contracted with exponent 0.4: hardly overshoots, slow at the end.",
    ),
    "ours.vud_exponential": (
        vud_family(output_from=UNITY, e_kind=BELL, ec_kind=BELL),
        "No output factor, alpha = 1 - 0.9 exp(-5 x^2): hardly overshoots, slow at the end.",
    ),
    "ours.vud_incremental": (
        vud_incremental(gain=0.1),
        "The rules' answer added to the duty: one integrator too many, never settles.",
    ),
    "ours.vud_integral_factor": (
        vud_integral_factor,
        "Output factor integrates the error (Li): comes near, then hunts.",
    ),
    "ours.vud_opt": (
        vud_scaled,
        "No output factor, scales and floors by a search on the nominal axis: quick and still.",
    ),
    "ours.vud_opt_robust": (
        vud_scaled(**ROBUST._asdict()),
        "The same by a search over axes of 259 to 334 mm/s with grating errors and backlash: quick on all.",
    ),
}

VARIANTS: dict[str, Block] = {name: replace(block, doc=line) for name, (block, line) in _SET.items()}
"""Blocks by the name that the study gives them, each with a line of its own on what it is."""
