"""Scaling factors of the study ``grey_turning``, by name. The paper prints none: all of them are the study's.

``FACTORS`` are for a period of 20 ms and a force filtered with 0.8, in N, N a sample, V. How each was found is said
there; ``plant F`` and ``plant N`` are the study's two lathes, the slower one N. Fitted means: fitted to the paper's
printed results, so that meeting these with them proves nothing.
"""

from __future__ import annotations

from typing import NamedTuple

from leadscrew.controllers._force import constant_force, depth_feed_forward, gain_normalised, power_law_inversion
from leadscrew.controllers._grey_fuzzy.gpfc import gpfc
from leadscrew.controllers._grey_fuzzy.pi_incremental import pi_incremental
from leadscrew.controllers._grey_fuzzy.smith import smith
from leadscrew.controllers._grey_fuzzy.tfc import tfc
from leadscrew.grey.predictors import FIR, GM, LINE, TWO_POINT
from leadscrew.kernel.block import Block


class Factors(NamedTuple):
    """The scaling factors S1, S2, S3 of a controller."""

    error: float
    change: float
    output: float

    @property
    def kp(self) -> float:
        """Gain of the PI that the rules are inside, V/N."""
        return self.output / self.change

    @property
    def ki(self) -> float:
        """Gain of its sum, V/N a sample."""
        return self.output / self.error


FACTORS: dict[str, Factors] = {
    "s6": Factors(4.2, 1.35, 0.00307),  # fitted to 5.1 (Figs 6 and 7) on plant F
    "s9": Factors(28.0, 15.4, 0.0214),  # fitted to 5.2 (Figs 9 and 10) together with plant F
    "s9_half": Factors(28.0, 15.4, 0.0107),  # s9 at half the gain
    "stfc": Factors(32.0, 7.07, 0.00926),  # the best TFC on plant F
    "sg": Factors(104.0, 30.1, 0.0413),  # the best GPFC of reading B on plant F with a gain margin of 2.5
    "s6n": Factors(8.2, 1.6, 0.0025),  # fitted to 5.1 on plant N
    "sbn": Factors(36.0, 7.5, 0.007),  # well tuned for plant N
    "rough": Factors(14.0, 30.0, 0.0107),  # mis-scaled: the error's range halved, the change's doubled (Fig 11)
    "edge_n": Factors(6.2, 0.96, 0.0029),  # at the edge of a limit cycle on plant N
    "stfc_n": Factors(95.7, 18.2, 0.0164),  # the best TFC on plant N, by ITAE and overshoot
    "smith_f": Factors(25.0, 5.65, 0.0106),  # behind the Smith predictor on plant F, by ITAE and overshoot
    "smith_n": Factors(29.3, 6.17, 0.00675),  # the same on plant N
}
"""By name: in N, N a sample, V."""

PREDICTORS = {"two_point": TWO_POINT, "line": LINE, "fir": FIR, "gm_raw": GM}
"""Other predictors for which there is a tuning, by their number in :mod:`leadscrew.grey.predictors`."""

SMITH_N = {"model.rate": 20.0, "model.delay_s": 0.045}
"""What the Smith predictor has to know of plant N: a slower servo, and its dead time besides half a revolution."""

SPINDLE = {"error_scale": 60.0, "change_scale": 20.0, "output_scale": 0.12, "upper": 10.0}
"""Spindle speed, incremental; the error in 1/min."""
DEPTH = {
    "error_scale": 0.05, "change_scale": 0.02, "output_scale": 0.15, "positional": True, "lower": -10.0, "upper": 10.0,
}  # fmt: skip
"""Depth of cut, positional, because the radial axis integrates; the error in mm."""


def at(block: Block, factors: Factors, **more: object) -> Block:
    """A fuzzy controller with these scaling factors."""
    return block(error_scale=factors.error, change_scale=factors.change, output_scale=factors.output, **more)


def _tunings() -> dict[str, Block]:
    found: dict[str, Block] = {}
    for name, factors in FACTORS.items():
        if name.startswith("smith"):
            continue
        found[f"corrected.tfc_{name}"] = at(tfc, factors)
        found[f"corrected.gpfc_b_{name}"] = at(gpfc, factors, reading="predicted_error")
        found[f"corrected.gpfc_a_{name}"] = at(gpfc, factors, reading="measured_error")
        found[f"ours.pi_{name}"] = pi_incremental(kp=factors.kp, ki=factors.ki)
        for other, code in PREDICTORS.items():
            found[f"ours.{other}_{name}"] = at(gpfc, factors, predictor=code)
    found["ours.smith_f"] = at(smith, FACTORS["smith_f"])
    found["ours.smith_n"] = at(smith, FACTORS["smith_n"], **SMITH_N)
    found["paper.gpfc_printed_s9"] = at(gpfc, FACTORS["s9"], predictor="gm11_printed")
    found["ours.spindle_tfc"], found["ours.spindle_gpfc"] = tfc.using(**SPINDLE), gpfc.using(**SPINDLE)
    found["ours.depth_tfc"], found["ours.depth_gpfc"] = tfc.using(**DEPTH), gpfc.using(**DEPTH)
    return found


TUNINGS: dict[str, Block] = _tunings()
"""Ready controllers: ``corrected.`` the paper's with our factors, ``paper.`` its literal equation, ``ours.`` others.

``corrected.tfc_s6``, ``corrected.gpfc_b_s6`` and ``corrected.gpfc_a_s6`` (readings B and A), the same for each name of
:data:`FACTORS`; ``ours.pi_s6`` the PI of the same gains; ``ours.two_point_s6``, ``ours.line_s6``, ``ours.fir_s6`` and
``ours.gm_raw_s6`` reading B with another predictor; ``ours.smith_f``
and ``ours.smith_n`` the Smith predictor; ``ours.spindle_tfc`` and ``ours.depth_tfc`` the other two axes.
"""

TFC = TUNINGS["corrected.tfc_stfc"]
"""What is wrapped: the TFC that is tuned best for plant F."""

PREVIEW_N_S = 0.125
"""Lag of plant N's servo, its dead time, half a revolution and half a period."""

FORCE: dict[str, Block] = {
    "ours.tfc_ff": depth_feed_forward(TFC),
    "ours.gain_normalised": gain_normalised(TFC),
    "ours.inversion": power_law_inversion,
    "ours.inversion_cautious": power_law_inversion(first_k=3.0 * 2256.3, stiffness=12000.0),
    "ours.constant_force": constant_force,
    "ours.constant_force_n": constant_force(preview_s=PREVIEW_N_S, lead=0.5, lead_lag_s=0.04),
}
"""Laws that know the programme or learn the cutting law; ``_n``: for plant N. The depth is believed to change at once;
where it goes through a radial servo, set ``radial.gain`` and ``radial.lag_s``."""
