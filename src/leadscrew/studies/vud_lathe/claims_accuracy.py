"""Claims about what makes the accuracy: sensor or controller, over 200 drawn axes each (digest section 9)."""

from __future__ import annotations

import numpy as np

from leadscrew.report.claim import Claim, Group, Kind, Verdict
from leadscrew.studies.vud_lathe.accuracy import (
    DRAWS,
    LEADS_UM_PER_300_MM,
    SEED,
    Errors,
    Spread,
    errors_um,
    spread,
    two_by_two,
)
from leadscrew.studies.vud_lathe.runs import STEPS, Loops

KEY = {STEPS[0]: "m50", STEPS[1]: "m170"}
WAY = {STEPS[0]: "-50", STEPS[1]: "-170"}
SENSORS = ("encoder", "grating")

DIGEST: dict[str, tuple[str, tuple[float, float, float, float]]] = {
    "ours.original_fit": ("original", (2.8, 9.8, 3.7, 3.8)),
    "corrected.vud_beta_e": ("beta_e", (4.1, 11.0, 0.22, 0.43)),
    "corrected.vud_raw_rate": ("raw_rate", (4.5, 11.3, 0.32, 0.94)),
    "ours.vud_opt": ("opt", (3.4, 8.8, 0.58, 0.57)),
    "ours.pd": ("pd", (3.6, 8.7, 0.23, 0.25)),
}
"""95th percentiles of the digest: encoder at -50 and -170 mm, grating at -50 and -170 mm."""
SHARE = 0.10
"""How near the issue wants ours: within 10 %."""
OUTSIDE = ("ours.vud_opt_robust", "ours.vud_fast_robust", "corrected.vud_beta_e_filtered")
"""Controllers that the digest did not have, on the grating alone."""
GOALS_UM = {"encoder": 10.0, "grating": 2.0}
"""What the paper says of the old system and of the new one."""

LATER_S = 2.25
"""When the slowest axes under A+ stand."""


def accuracy_errors(loops: Loops) -> Errors:
    """Every error that the claims and the picture need, by controller, sensor and scenario."""
    found = dict(two_by_two(loops, tuple(DIGEST)))
    for controller in OUTSIDE:
        for scenario in STEPS:
            found[controller, "grating", scenario] = errors_um(loops, controller, scenario, "grating")
    return found


def accuracy_claims(loops: Loops, errors: Errors) -> list[Claim]:
    """All of them."""
    return [*_table(errors), *_later(loops, errors), *_two_by_two(errors), *_outside(errors), *_screws(loops)]


def _claim(
    name: str,
    group: Group,
    statement: str,
    paper: float | str | None,
    measured: float | str,
    target: float | str | None,
    tolerance: float,
    verdict: Verdict,
    reason: str,
    kind: Kind = "required",
    sense: str = "=",
    unit: str = "um",
) -> Claim:
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"vud_lathe.{name}", "Figure 12, section VI", group, "reconstructed plant", statement, paper, value, unit,
        sense, target, tolerance, kind, verdict, reason,  # type: ignore[arg-type]
    )  # fmt: skip


def _group(controller: str) -> Group:
    return "as corrected" if controller.startswith("corrected") else "ours"


def _table(errors: Errors) -> list[Claim]:
    rows = []
    for controller, (short, numbers) in DIGEST.items():
        cells = [(sensor, scenario) for sensor in SENSORS for scenario in STEPS]
        for (sensor, scenario), expected in zip(cells, numbers, strict=True):
            found = spread(errors[controller, sensor, scenario])
            near = abs(found.p95 - expected) <= SHARE * expected
            rows.append(
                _claim(f"spread_{short}_{sensor}_{KEY[scenario]}", _group(controller),
                       f"{controller} on the {sensor}, {WAY[scenario]} mm: error after 2 s, 95 % of {DRAWS} axes below",
                       None, found.p95, expected, SHARE * expected, "cannot be checked",
                       f"largest {found.largest:.2f} um; draws by seed {SEED}; the paper gives no spread"
                       + ("" if near else f"; the digest has {expected:g}: its draws are not printed"),
                       "required" if short == "original" or sensor == "encoder" else "report")
            )  # fmt: skip
    return rows


def _later(loops: Loops, errors: Errors) -> list[Claim]:
    """Why A+ is worse at -170 mm here than in the digest: at 2 s some axes have not come out of the play yet."""
    controller, at = "corrected.vud_beta_e", spread(errors["corrected.vud_beta_e", "grating", STEPS[1]])
    later = spread(errors_um(loops, controller, STEPS[1], "grating", after_s=LATER_S))
    return [
        _claim("spread_beta_e_grating_later", "as corrected",
               f"{controller} on the grating, -170 mm: error after {LATER_S:g} s, 95 % of {DRAWS} axes below", None,
               later.p95, 0.5, 0.0, "cannot be checked",
               f"{at.p95:.2f} um after 2 s: the last axes are just coming out of the play then", sense="<="),
    ]  # fmt: skip


def _both(errors: Errors, controller: str, sensor: str) -> Spread:
    return spread(np.maximum(*(errors[controller, sensor, s] for s in STEPS)))


def _two_by_two(errors: Errors) -> list[Claim]:
    old, new = "ours.original_fit", "corrected.vud_beta_e"
    cell = {(c, s): _both(errors, c, s) for c in (old, new) for s in SENSORS}
    pd = _both(errors, "ours.pd", "grating")
    neither = "yes" if min(cell[old, "grating"].p95, cell[new, "encoder"].p95) > GOALS_UM["grating"] else "no"
    both = cell[new, "grating"]
    ruler_um, law_um = cell[old, "grating"].p95, cell[new, "encoder"].p95
    as_good = "yes" if pd.p95 <= both.p95 else "no"
    return [
        _claim("goal_old_system", "ours", "old controller on the encoder: 95 % of the axes within 10 um", "yes",
               "yes" if cell[old, "encoder"].p95 <= GOALS_UM["encoder"] else "no", "yes", 0.0,
               "reproduced with change", f"{cell[old, 'encoder'].p95:.1f} um with a screw of grade 3; see the rows of "
               "worse screws", sense="yes/no", unit=""),
        _claim("goal_neither_alone", "as corrected",
               "new sensor alone and new controller alone both miss 2 um", "yes", neither, "yes", 0.0,
               "reproduced with change", f"{ruler_um:.1f} um with the ruler alone, {law_um:.1f} um with the controller "
               "alone (95 % of the axes); the first is the hunting of our stand-in inside the play", sense="yes/no",
               unit=""),
        _claim("goal_both", "as corrected", "both together: 95 % of the axes within", GOALS_UM["grating"], both.p95,
               GOALS_UM["grating"], 0.0, "reproduced with change", f"largest {both.largest:.2f} um, both moves; the "
               "ruler's own scale, Abbe and mounting errors are not in it", sense="<="),
        _claim("goal_pd_as_good", "ours", "a plain PD on the same grating is as good", None, as_good, "yes", 0.0,
               "cannot be checked", f"{pd.p95:.2f} um against {both.p95:.2f} um: the accuracy is the sensor's",
               sense="yes/no", unit=""),
    ]  # fmt: skip


def _outside(errors: Errors) -> list[Claim]:
    rows = []
    for controller in OUTSIDE:
        found = _both(errors, controller, "grating")
        rows.append(
            _claim(f"spread_{controller.split('.')[1]}", _group(controller),
                   f"{controller} on the grating, both moves: error after 2 s, 95 % of {DRAWS} axes below", None,
                   found.p95, 0.5, 0.0, "cannot be checked", f"largest {found.largest:.2f} um",
                   "required" if controller == "corrected.vud_beta_e_filtered" else "report", sense="<=")
        )  # fmt: skip
    return rows


def _screws(loops: Loops) -> list[Claim]:
    rows = []
    for lead, expected in zip(LEADS_UM_PER_300_MM[1:], (15.7, 30.0), strict=True):
        found = spread(errors_um(loops, "ours.original_fit", STEPS[1], "encoder", lead))
        rows.append(
            _claim(f"spread_screw_{lead:.0f}", "ours",
                   f"old controller on the encoder, -170 mm, screw of {lead:.0f} um in 300 mm: 95 % of the axes below",
                   10.0, found.p95, expected, SHARE * expected, "not reproduced",
                   "the old system's 10 um needs a screw of grade 3 or one that is compensated", "report")
        )  # fmt: skip
    return rows
