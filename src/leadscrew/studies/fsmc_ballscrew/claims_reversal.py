"""What the paper says of the error where the direction changes: section 6, Figures 12 to 14."""

from __future__ import annotations

from collections.abc import Iterator

from leadscrew.report.claim import Claim, Sense
from leadscrew.studies.fsmc_ballscrew.naming import FIGURE, WAY, said
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.fsmc_ballscrew.tracking import elsewhere, place_of_largest, reversal, sine_run


def reversal_claims(loops: Loops) -> Iterator[Claim]:
    """Errors peak where the direction changes, and under FSMC are damped in less than 0.1 s."""
    first = {"sine_wide": 0.015, "sine_fast": 0.008}
    stays: dict[str, tuple[Sense, float, float]] = {
        "sine_slow": ("=", 0.27, 0.027), "sine_wide": ("<=", 0.1, 0.0), "sine_fast": ("<=", 0.1, 0.0)
    }  # fmt: skip
    place: dict[str, tuple[Sense, float, float]] = {
        "sine_slow": (">=", 0.05, 0.0), "sine_wide": ("=", 0.5, 0.05), "sine_fast": ("=", 0.5, 0.05)
    }  # fmt: skip
    law = "corrected.fsmc"
    for scenario in SINES:
        run = sine_run(loops, law, scenario)
        found, source = reversal(run, scenario), f"{FIGURE[scenario]}, section 6"
        about = (
            f"{found.peak:.1f} nm at the peak, {found.after:.1f} nm of lag after it, and a swing past that of "
            f"{100.0 * found.swing:.0f} % of the peak"
        )
        if scenario in first:
            yield said(
                f"recovery_first_{scenario}", source, "as corrected",
                f"time until the error is first back within 10 % of its peak, FSMC, {WAY[scenario]}", 0.1, found.first,
                "s", "<=", first[scenario], 0.0, found.first < 0.1, about,
            )  # fmt: skip
        yield said(
            f"recovery_{scenario}", source, "as corrected",
            f"time until the error stays within 10 % of its peak, FSMC, {WAY[scenario]}", 0.1, found.settled, "s",
            *stays[scenario], found.settled < 0.1, about,
        )  # fmt: skip
        other = elsewhere(run, scenario) / found.peak
        yield said(
            f"peaks_fsmc_{scenario}", source, "as corrected",
            f"largest error away from reversals over the peak at one, FSMC, {WAY[scenario]}", "none but at reversals",
            other, "1", "<=", 0.3, 0.0, other < 0.1, "the integral lags behind the viscous torque as that changes"
            if scenario == "sine_fast" else "small, and before the reversal" if scenario == "sine_slow" else about,
        )  # fmt: skip
        found_at = place_of_largest(sine_run(loops, "paper.csmc", scenario), scenario)
        yield said(
            f"peaks_csmc_{scenario}", source, "as printed",
            f"where CSMC's error is largest, from one reversal (0) to the next (1), {WAY[scenario]}", 0.0, found_at,
            "1", *place[scenario], found_at < 0.05, "creeping, the error follows the Stribeck curve"
            if scenario == "sine_slow" else
            "at full speed, where the believed viscous torque is farthest off: sigma_2 1.2 against 0.4",
        )  # fmt: skip
