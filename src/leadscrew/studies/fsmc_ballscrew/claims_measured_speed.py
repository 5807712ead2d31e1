"""Claims about rest with f_hat from the measured speed, and about the printed rules with equal scales."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.report.claim import Claim
from leadscrew.studies.fsmc_ballscrew.naming import KEY, SAID, WAY, near, unsaid
from leadscrew.studies.fsmc_ballscrew.runs import SAMPLE_S, Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.fsmc_ballscrew.tracking import SAMPLES, at_rest, settled_run, sine_run, tracked

REST: dict[str, tuple[str, float, float, float | None, float]] = {
    "corrected.smc": ("constant", 0.17, 0.005, None, 0.0), "paper.csmc": ("limit cycle", 0.13, 0.005, None, 0.0),
    "corrected.fsmc": ("limit cycle", 0.092, 0.002, 300.0, 15.0),
    "paper.smc": ("limit cycle", 0.11, 0.005, 430.0, 15.0),
}  # fmt: skip
"""The digest's torque at rest, largest error in um with its tolerance, and variation in N m/s with its tolerance."""


def rest_claims(loops: Loops) -> Iterator[Claim]:
    """At rest, with f_hat from the measured speed, without the bristles' damping."""
    for law, (kind, target, tolerance, variation, within) in REST.items():
        rest = at_rest(settled_run(loops, law))
        way = f"at rest after {WAY['step_quintic']}, {SAID[law]}, f_hat from the measured speed"
        name = f"{KEY[law]}_rest_measured_speed"
        shape = "constant" if rest.swing < 1e-3 else "limit cycle"
        yield unsaid(f"{name}_error", law, "step_quintic", f"largest error {way}", rest.error, "um", target, tolerance)
        yield unsaid(f"{name}_kind", law, "step_quintic", f"torque {way}", shape, "", kind, sense="yes/no")
        if law == "corrected.smc":
            yield unsaid(f"{name}_torque", law, "step_quintic", f"mean torque {way}", rest.mean, "N m", -6.42,
                         0.02 * 6.42)  # fmt: skip
        if variation is not None:
            yield unsaid(f"{name}_variation", law, "step_quintic", f"total variation of the torque a second {way}",
                         rest.variation, "N m/s", variation, within)  # fmt: skip


def equal_scales_claims(loops: Loops) -> Iterator[Claim]:
    """The printed rules, with s and s_c over the same scale."""
    law, equal = "paper.fsmc", {"controller.scale_sc": 0.65}
    for scenario, target in zip(SINES, (0.19, 0.21, 0.23), strict=True):
        plain = tracked(sine_run(loops, law, scenario), scenario)
        found = tracked(sine_run(loops, law, scenario, changes=equal), scenario)
        way = f"{SAID[law]}, equal scales, on {WAY[scenario]}"
        yield unsaid(
            f"fsmc_equal_{scenario}_max", law, scenario, f"largest error, {way}", found.largest, "um", target,
            near(target), kind="report",
            reason=f"a limit cycle, within 4 % the same in every period: {found.largest:.3f} um; why the digest has "
            f"{target:g} is not known",
        )  # fmt: skip
        yield unsaid(
            f"fsmc_equal_{scenario}_worse", law, scenario, f"largest error, {way}, over that with S_c = 4 S",
            found.largest / plain.largest, "1", 3.0, 0.0, ">=", "both rule bases need unequal scales",
        )  # fmt: skip
        yield unsaid(
            f"fsmc_equal_{scenario}_chatter", law, scenario, f"variation of the torque, {way}, over that with "
            "S_c = 4 S", found.variation / plain.variation, "1", 3.0, 0.0, ">=",
            f"the limit cycle: {found.variation:.0f} against {plain.variation:.1f} N m/s, sampled every "
            f"{1e3 * SAMPLES.get(scenario, SAMPLE_S):g} ms",
        )  # fmt: skip
    for scenario in SINES[1:]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DivergenceWarning)
            run = sine_run(loops, law, scenario, changes=equal | {"controller.friction_from": 2})
        yield unsaid(f"fsmc_equal_{scenario}_measured_speed", law, scenario, f"{SAID[law]}, equal scales, on "
                     f"{WAY[scenario]}, f_hat from the measured speed", "diverges" if run.diverged else "holds", "",
                     "diverges", sense="yes/no")  # fmt: skip
