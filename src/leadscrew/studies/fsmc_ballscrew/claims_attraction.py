"""Claims about where the fuzzy law comes back from: moonshot 6, proved as far as it can be, and measured."""

from __future__ import annotations

import warnings

import numpy as np

from leadscrew.friction.lugre import LuGre
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.report.claim import Claim
from leadscrew.studies.fsmc_ballscrew.attraction import (
    HOME_UM,
    LOADS,
    STEPS_MM,
    UNKNOWN,
    WITHOUT_DEAD_CORNER,
    Region,
    hold,
    largest_load,
    reach,
    region,
    ultimate_band,
    ultimate_error_um,
)
from leadscrew.studies.fsmc_ballscrew.claims_readings import WORDS, row
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.tracking import SAMPLES, SECONDS, sine_run, tracked

U = 120.0
"""Fuzzy torque, N m."""

SCALE = 0.65
"""S, rad/s."""


def attraction_claims(loops: Loops) -> list[Claim]:
    """What is proved for a bounded unknown torque, and what the whole stage does."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DivergenceWarning)
        return [*_proved(), *_measured(loops), *_still_good(loops)]


def _proved() -> list[Claim]:
    share = UNKNOWN / U
    found = {rules: reach(rules, share) for rules in ("without_dead_corner", "corrected", "printed")}
    globally = found["without_dead_corner"] < 1.0
    others = all(np.isnan(found[rules]) for rules in ("corrected", "printed"))
    rows = [
        row("attraction_everywhere", "section 4.4", "ours",
            "for D <= 18.72 N m, |s| falls from every start to a part of its scale; rules without the dead corner",
            "the stability of fuzzy controller would be guaranteed", found["without_dead_corner"], "S", "<=", 1.0, 0.0,
            "reproduced with change" if globally else "not reproduced",
            f"there -K >= {share:.3f} = D / U for every s_c, on a grid of 401 by 801 and between its points; with U = "
            f"{U:g} N m; the damping sigma1 z' of the true bristles is not in D", "moonshot", "arithmetic"),
        row("attraction_not_the_others", "section 4.4", "as printed",
            "whether the same holds of the printed and of the corrected rules", "guaranteed",
            "no" if others else "yes", "", "yes/no", "no", 0.0, "not reproduced" if others else "reproduced",
            "each has a corner with K = 0", "moonshot", "arithmetic"),
        row("attraction_needed_torque", "section 4.4", "ours",
            "least U that guarantees it, in D: without the dead corner K never falls below a half outside S", None,
            1.0 / hold("without_dead_corner", 1.0), "", "=", 2.0, 1e-9, "cannot be checked",
            f"U > {2.0 * UNKNOWN:.2f} N m for friction alone; U >= F~ is not enough", "moonshot", "arithmetic"),
    ]  # fmt: skip
    for ratio in (4.0, 16.0):
        band = ultimate_band("without_dead_corner", ratio, share)
        rows.append(
            row(f"attraction_final_{ratio:g}", "(13), (16)", "ours",
                f"error that is never exceeded in the end, proved, S_c = {ratio:g} S", None, ultimate_error_um(band),
                "um", "<=", 5.0, 0.0, "cannot be checked",
                f"|s| <= {band:.3f} S; 0.7358 of it over lam; the runs below leave a hundredth of this",
                "moonshot", "arithmetic")
        )  # fmt: skip
    return rows


def _measured(loops: Loops) -> list[Claim]:
    rows = []
    static = LuGre().static
    for rules, known in (("without_dead_corner", 100.0), ("corrected", 100.0), ("printed", 100.0)):
        found = region(loops, rules)
        limit = U * hold("without_dead_corner", 4.0) - static
        inside = np.array(LOADS) <= limit
        share = 100.0 * float(found.returned[:, inside].mean())
        group = {"printed": "as printed", "corrected": "as corrected"}.get(rules, "ours")
        rows.append(
            row(f"attraction_share_{rules}", "section 4.4", group,  # type: ignore[arg-type]
                f"of {found.returned[:, inside].size} starts ({STEPS_MM[0]:g} to {STEPS_MM[-1]:g} mm away, loads up to "
                f"{limit:.1f} N m) those that are back within {HOME_UM:g} um after 0.5 s, {rules} rules, S_c = 4 S",
                "guaranteed", share, "%", "=", known, 1e-9,
                "not reproduced" if share < 100.0 else "reproduced with change" if rules != "printed" else "reproduced",
                _words(found), "moonshot" if rules == "without_dead_corner" else "report")
        )  # fmt: skip
    for ratio in (1.0, 4.0):
        found = region(loops, "without_dead_corner", ratio)
        load = largest_load(found)
        rows.append(
            row(f"attraction_load_{ratio:g}", "section 4.4", "ours",
                f"largest load from which every start comes back, S_c = {ratio:g} S", None, load, "N m", "=",
                U * hold("without_dead_corner", ratio) - static, LOADS[1], "cannot be checked",
                "U / 2 less static friction, to the 5 N m of the grid: what the proof asks for is what the stage needs",
                "moonshot")
        )  # fmt: skip
    return rows


def _words(found: Region) -> str:
    near = [e for e, back in zip(STEPS_MM, found.returned[:, 0], strict=True) if not back]
    far = found.returned[-1]
    lost = [load for load, back in zip(LOADS, far, strict=True) if not back]
    first = (
        f"from {STEPS_MM[-1]:g} mm lost at {lost[0]:g} N m and more" if lost else "none lost from the farthest start"
    )
    unloaded = f"; without load lost from {', '.join(f'{e:.3g}' for e in near)} mm" if near else ""
    worst = found.left_um[np.isfinite(found.left_um)].max()
    return f"{first}{unloaded}; the farthest end of all {len(LOADS)} loads is {worst:.0f} um away"


def _still_good(loops: Loops) -> list[Claim]:
    rows = []
    for scenario in ("sine_slow", "sine_wide", "sine_fast"):
        options = {"sample": SAMPLES[scenario]} if scenario in SAMPLES else {}
        signals = ("true_error", "output")
        run = loops.get(WITHOUT_DEAD_CORNER, scenario, **options).run(SECONDS[scenario], record=signals)
        whole = tracked(run, scenario).largest
        cornered = tracked(sine_run(loops, "corrected.fsmc", scenario), scenario).largest
        rows.append(
            row(f"attraction_error_{scenario}", "section 6", "ours",
                f"change of the largest error on {WORDS[scenario]} mm by the rules without the dead corner, S_c = 4 S",
                None, 1e3 * abs(whole - cornered), "nm", "<=", 1.0, 0.0, "cannot be checked",
                f"{whole:.4f} um, corrected rules {cornered:.4f}: nothing is paid for it", "moonshot")
        )  # fmt: skip
    return rows
