"""The study's controllers by name: whose each one is, the name says.

``paper.vud`` is the printed law to the letter. Variants change one thing of it each; all but four of them are one
block with other parameters (:mod:`leadscrew.controllers._vud.family`), so they share one compiled program. A factor of
"one" is ``|x|^0 + 0.0001`` there; that 0.01 % shows in the fourth digit of what is still on its way at 2 s. The fast
ones are the best of one search each, rounded to four digits, and can be found again: ``search`` of
:mod:`leadscrew.studies.vud_lathe.fast_search` with the arguments that stand beside them.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from leadscrew.controllers._vud import duty_pd, duty_pd_observed, duty_pid, power_law, vud, vud_beta_e
from leadscrew.controllers._vud.family import BETA_E, vud_family
from leadscrew.controllers._vud.fast import vud_fast
from leadscrew.controllers._vud.printed import vud_incremental, vud_integral_factor
from leadscrew.controllers._vud.scaled import ROBUST, vud_scaled
from leadscrew.kernel.block import Block
from leadscrew.studies.tuned import tuned

FIXED = {"output_from": "none", "e_kind": "none", "ec_tau": 0.0}
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
        vud_family(output_from="none"),
        "No output factor: no creep, but a limit cycle of millimetres.",
    ),
    "corrected.vud_beta_product": (
        vud_family(output_from="product"),
        "Output factor from the product of e and ec: hardly leaves its place.",
    ),
    "corrected.vud_beta_mean": (
        vud_family(output_from="mean", output_tau=0.6),
        "Output factor from the mean of |e|^0.6 and |ec|^0.6: arrives, overshoots.",
    ),
    "corrected.vud_beta_max": (
        vud_family(output_from="maximum", output_tau=0.7),
        "Output factor from the larger of |e| and |ec|, to the 0.7: arrives, overshoots.",
    ),
    "corrected.vud_beta_e_tau9": (
        vud_family(output_from="error"),
        "Output factor from the error with the printed exponent: slow at the end.",
    ),
    "ours.fuzzy_plain": (
        vud_family.using(**FIXED),
        "The rules alone, no universe contracts: steady and slow.",
    ),
    "ours.fuzzy_plain_scaled": (
        vud_family.using(**FIXED, error_gain=20.0, rate_gain=2.0),
        "The rules alone, inputs scaled by 20 and 2: quick, overshoots.",
    ),
    "ours.vud_alpha_only": (
        vud_family(output_from="none", e_tau=0.4, ec_tau=0.4),
        "No output factor, inputs contracted with exponent 0.4: hardly overshoots, slow at the end.",
    ),
    "ours.vud_exponential": (
        vud_family(output_from="none", e_kind="exponential", ec_kind="exponential"),
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

GAIN_DOUBT = 0.15
"""The learning observers start from a speed at full duty that is right within 15 %, the spread of Table 1's moves."""

LIMITS = {"speed_limit_mm_s": 258.0, "brake_limit": 0.69}
"""Just below the limits of ``lathe_servo_limited``: 258.7 mm/s, and ``(7.5 A x 6.4 ohm - 258 / 289 x 30 V) / 30 V =
0.707``, the reverse duty that drives the peak current against the back-EMF at that speed."""


def _learning(**chain: float) -> dict[str, float]:
    return {f"chain.{name}": value for name, value in {"gain_doubt": GAIN_DOUBT, **chain}.items()}


FAST: dict[str, Block] = {
    # search(linear, {}, robust=False, seed=3, generations=120)
    "ours.vud_fast": vud_fast(
        error_full_scale_mm=1.147,
        speed_full_scale_mm_s=49.62,
        e_tau=0.686,
        e_floor=0.03689,
        ec_tau=0.9523,
        ec_floor=0.241,
        output_gain=2.047,
        braking=0.8444,
    ),
    # search(linear, {"chain.gain_doubt": GAIN_DOUBT}, robust=True, seed=1, generations=60)
    "ours.vud_fast_robust": vud_fast.using(
        error_full_scale_mm=0.9345,
        speed_full_scale_mm_s=40.73,
        e_tau=0.627,
        e_floor=0.07116,
        ec_tau=0.7644,
        ec_floor=0.4938,
        output_gain=2.568,
        braking=0.8426,
        **_learning(walk_mm=5.214e-4, timing_s=6.031e-5, forget=0.1338),
    ),
    # search(limited, {**LIMITS, "chain.gain_doubt": GAIN_DOUBT}, robust=True, seed=2, generations=25)
    "ours.vud_fast_limited": vud_fast.using(
        error_full_scale_mm=3.066,
        speed_full_scale_mm_s=78.6,
        e_tau=0.7114,
        e_floor=0.07858,
        ec_tau=0.3687,
        ec_floor=0.3284,
        output_gain=3.493,
        braking=0.5972,
        **LIMITS,
        **_learning(walk_mm=6.099e-4, timing_s=1.501e-4, forget=0.02062),
    ),
}
"""For the nominal axis, its gain known; for any gain within 15 %; the same for the motor with limits."""

CONSTANT = vud_fast(
    error_full_scale_mm=0.3123,
    speed_full_scale_mm_s=65.15,
    e_tau=0.0,
    e_floor=0.09392,
    ec_tau=0.0,
    ec_floor=0.0125,
    output_gain=4.282,
    braking=0.8504,
)
"""The nominal setting with universes that do not contract: search(linear, {"e_tau": 0.0, "ec_tau": 0.0}, robust=False,
seed=2, generations=120), 3,420 candidates. It tells what is the observer's and what the contraction's."""

FOLDER = Path(__file__).parent
EQUALS: dict[str, Block] = {
    f"ours.{name}{kind}": tuned(FOLDER, f"{name}{kind}", block, f"{doc}: {plants}.")
    for name, block, doc in (
        ("pd_tuned", duty_pd, "A plain PD, as well tuned as the rules"),
        ("vud_tuned", vud_scaled, "The rules on error and change, as well tuned as the PD"),
        ("pd_observed", duty_pd_observed, "A plain PD behind the observer"),
        ("vud_observed", vud_fast, "The rules behind the observer"),
    )
    for kind, plants in (("", "on the nominal axis"), ("_robust", "on axes of 259 to 334 mm/s"))
}
"""Rules and PD with the same measurements, tuned by the same search; the second pair has more information: an observer
that knows the chain of the axis."""

CONTROLLERS: dict[str, Block] = {
    "paper.vud": vud,
    "corrected.vud_beta_e": vud_beta_e,
    "corrected.vud_beta_e_half": vud_beta_e(output_gain=1.0, output_tau=0.5),
    "corrected.vud_beta_e_filtered": vud_family.using(**BETA_E, filter_s=0.005),
    "ours.original_fit": power_law,
    "ours.original_p": power_law(exponent=1.0, gain=2.73),
    "ours.original_pid": duty_pid(kp=0.0139, ki=0.00086, kd=0.0, filter_s=0.0005, anti_windup="clamping"),
    "ours.pd": duty_pd,
    **VARIANTS,
    **FAST,
    **EQUALS,
}
"""The printed law and its corrections; three fits of the servo that it replaced; a plain PD; variants; the fast ones;
rules and PD tuned alike.

The P and PID fits hold for 209 mm/s at full duty, where they fit Table 1 best (see ``original.py``).
"""
