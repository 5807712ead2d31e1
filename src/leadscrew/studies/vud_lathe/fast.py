"""Our fastest VUD controllers: the block ``vud_fast`` with what :mod:`leadscrew.studies.vud_lathe.fast_search` found.

Each is the best of one search, rounded to four digits, and can be found again: ``search`` with the arguments that stand
beside it. Candidates times runs: 9,680 x 2, 6,710 x 48 and 2,860 x 48.
"""

from __future__ import annotations

from leadscrew.controllers.vud.fast import vud_fast
from leadscrew.kernel.block import Block

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
    "ours.vud_fast_robust": vud_fast(
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
    "ours.vud_fast_limited": vud_fast(
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
