"""Gains of the study ``fsmc_ballscrew`` in rad, by the names of its controllers."""

from __future__ import annotations

from leadscrew.controllers import csmc, fsmc, fsmc_printed, pd_dob, pd_learned, smc, smc_integral
from leadscrew.kernel.block import Block

SLIDING: dict[str, Block] = {
    "paper.smc_integral": smc_integral(layer_rate=0.0),
    "corrected.smc": smc(layer_rate=0.0),
    "paper.csmc": csmc(layer_rate=0.0),
    "ours.smc_integral_4khz": smc_integral,
    "ours.smc_4khz": smc,
    "ours.csmc_4khz": csmc,
}
"""By the names of the study: the printed boundary layer, for periods below 6 us, and ours for 4 kHz and above."""


def at_slope(block: Block, lam: float, slope: float, torque: float, ratio: float) -> Block:
    """The block with ``U = torque``, ``S = U / (J slope)`` and ``S_c = ratio S``; ``slope`` in 1/s."""
    scale = torque / (block.params.inertia * slope)
    return block(lam=lam, fuzzy_torque=torque, scale_s=scale, scale_sc=ratio * scale)


FUZZY: dict[str, Block] = {
    "paper.fsmc": fsmc_printed,
    "corrected.fsmc": fsmc,
    "ours.fsmc_4khz": at_slope(fsmc, lam=400.0, slope=7690.0, torque=300.0, ratio=5.2),
    "ours.fsmc_4khz_slow": at_slope(fsmc, lam=150.0, slope=6400.0, torque=120.0, ratio=4.0),
    "ours.fsmc_printed_4khz": at_slope(fsmc_printed, lam=400.0, slope=9600.0, torque=105.0, ratio=2.84),
}
"""By the names of the study: both rule bases for periods below 5 us, and for 4 kHz (``slow``: with the paper's lam)."""

_BY_ANGLE = pd_dob(rate_of_error=False)

SCHEDULED: dict[str, Block] = {
    "ours.pd_dob_fixed": _BY_ANGLE(kp=300.0, kd=0.9, observer_rate=2500.0, kp_slow=0.0, kd_slow=0.0),
    "ours.pd_dob_aggressive": _BY_ANGLE(kp=640.0, kd=0.40, observer_rate=2368.0, kp_slow=3010.0, kd_slow=12.4),
    "ours.pd_dob_robust": _BY_ANGLE,
    "ours.pd_dob": pd_dob,
}
"""For 4 kHz: without a schedule; the best on the nominal stage; one that stands wrong friction and
another friction model; and the same with the error differentiated in place of the angle, the default. None is for a
delay of a sample: put such a one inside :func:`~leadscrew.controllers.look_ahead`."""

LEARNED: dict[str, Block] = {"ours.pd_learned": pd_learned}
"""For 4 kHz and a 10 nm encoder, found by differential evolution over the peaks on the paper's sines with nominal and
20 % changed friction. Not for a drive with a sample of delay or a scale of 50 nm: take ``ours.pd_dob`` there, and where
friction is nothing like LuGre's."""
