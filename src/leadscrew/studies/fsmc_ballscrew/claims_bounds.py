"""The guaranteed precision, equations (13) and (16), in both units that the paper's gains can be in."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from leadscrew.plants.ballscrew_stage import TRAVEL_MM_PER_RAD
from leadscrew.report.claim import Claim
from leadscrew.studies.fsmc_ballscrew.controllers import CONTROLLERS
from leadscrew.studies.fsmc_ballscrew.naming import KEY, SAID, said, whose
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.fsmc_ballscrew.tracking import sine_run, tracked


def bounds_claims(loops: Loops) -> Iterator[Claim]:
    """(13) and (16): |e| <= phi / lam and |e'| <= 2 phi; for CSMC half of both. phi in rad/s, and in mm/s."""
    lam, phi = 150.0, 0.1
    for law, part, equation in (
        ("corrected.smc", 1.0, "(13)"),
        ("paper.smc", 1.0, "(13)"),
        ("paper.csmc", 0.5, "(16)"),
    ):
        runs = {s: sine_run(loops, law, s) for s in SINES}
        e = max(tracked(run, s).largest for s, run in runs.items()) / (1e3 * TRAVEL_MM_PER_RAD)
        rate = max(_rate(run) for run in runs.values())
        for key, what, value, bound, unit in (
            ("e", "|e|", e, part * phi / lam, "rad"), ("rate", "|e'|", rate, part * 2.0 * phi, "rad/s")
        ):  # fmt: skip
            yield said(
                f"bound_{key}_{KEY[law]}", equation, whose(law), f"{what} over its bound, the worst of three sines, "
                f"{SAID[law]}", 1.0, value / bound, "1", "<=", 1.0, 0.0, value <= bound,
                f"{value:.3g} of {bound:.3g} {unit}" + ("; not guaranteed for the integral surface, whose constant is "
                "2.27 and not 2" if law == "paper.smc" and key == "rate" else ""),
            )  # fmt: skip
    for law, part, equation in (("corrected.smc", 1.0, "(13)"), ("paper.csmc", 0.5, "(16)")):
        worst, bound = max(_in_mm(loops, law, s) for s in SINES), 1e3 * part * phi / lam
        yield said(
            f"bound_e_{KEY[law]}_in_mm", equation, whose(law), f"|e| over its bound, the worst of three sines, phi and "
            f"eta read in mm, {SAID[law]}", 1.0, worst / bound, "1", "<=", 1.0, 0.0, worst <= bound,
            f"{worst:.3g} of {bound:.3g} um",
        )  # fmt: skip


def _in_mm(loops: Loops, law: str, scenario: str) -> float:
    """Largest error with phi in mm/s and eta in mm/s^2, um."""
    p = CONTROLLERS[law].params
    changes = {"controller.boundary": p.boundary / TRAVEL_MM_PER_RAD, "controller.eta": p.eta / TRAVEL_MM_PER_RAD}
    return tracked(sine_run(loops, law, scenario, changes=changes), scenario).largest


def _rate(run: Any) -> float:
    """Largest rate of the error after three tenths of a run, rad/s."""
    late = run["time"] > 0.3 * run["time"][-1]
    return float(np.abs((run["actual.velocity"] - run["command.velocity"])[late]).max()) / TRAVEL_MM_PER_RAD
