"""Claims about the units of Table 1, and errata of the paper that are arithmetic on its own numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.controllers.vud.universe import TABLE_2
from leadscrew.fuzzy.partition_count import equal_sets_for, interpolation_bound
from leadscrew.report.claim import Basis, Claim, Group, Kind, Verdict
from leadscrew.studies.vud_lathe import rules
from leadscrew.studies.vud_lathe.claims_arithmetic import ACCURACY, CURVATURES
from leadscrew.studies.vud_lathe.rules import LABELS
from leadscrew.studies.vud_lathe.tables import FULL_SCALE_MM, Move

RATE_SCALE_MM = 25.87
SCALES = {"r=-190": 25.93, "r=-50": 25.50, "r=50": 25.88, "r=190": 26.03}
WAYS = {"r=-190": 189.5, "r=-50": 50.7, "r=50": 50.1, "r=190": 189.0}
MISMATCH = {"r=-190": (0.0036, 0.0074), "r=-50": (0.0039, 0.0117), "r=50": (None, 0.036), "r=190": (None, 0.084)}
"""Root mean square and largest difference, in units of ec."""
NEAR_MM = 10.0
"""What 'almost reached' is read as, as in the claims about the moves."""


def unit_claims(found: Mapping[str, Move]) -> list[Claim]:
    """All of them."""
    return [*_scales(found), *_mismatch(found), *_errata(found)]


def row(
    name: str, source: str, statement: str, paper: float | str | None, measured: float | str, target: float | str,
    tolerance: float, verdict: Verdict, reason: str, unit: str = "", kind: Kind = "required", sense: str = "=",
    basis: Basis = "paper's data", group: Group = "as printed",
) -> Claim:  # fmt: skip
    """One claim on the paper's data."""
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"vud_lathe.{name}", source, group, basis, statement, paper, value, unit, sense,  # type: ignore[arg-type]
        target, tolerance, kind, verdict, reason,
    )  # fmt: skip


def move_key(name: str) -> str:
    """``r=-190`` as part of a claim's id: ``m190``."""
    return name.replace("r=-", "m").replace("r=", "p")


# ---- section 2 of the digest: units
def _scales(found: Mapping[str, Move]) -> list[Claim]:
    rows = []
    for name, move in found.items():
        key, change, ec = move_key(name), np.diff(move.error), move.rate[1:]
        scale = FULL_SCALE_MM * float(change @ ec) / float(ec @ ec)
        way = RATE_SCALE_MM * float(np.abs(move.printed_rate).sum())
        real = FULL_SCALE_MM * abs(float(move.error[0] - move.error[-1]))
        near = abs(scale - RATE_SCALE_MM) <= 0.02 * RATE_SCALE_MM
        rows += [
            row(f"ec_scale_{key}", "(6)", f"change of the error per row that ec = 1 stands for, move {name}",
                RATE_SCALE_MM, scale, SCALES[name], 0.005, "reproduced with change" if near else "not reproduced",
                "least squares; the paper gives the number as mm/s, the rows are 0.1 s apart", "mm"),
            row(f"ec_way_{key}", "(6)", f"sum of ec times 25.87 mm, move {name}", None, way, WAYS[name], 0.05,
                "cannot be checked", f"the move is {real:.1f} mm long: 25.87 mm is the change per 0.1 s", "mm"),
        ]  # fmt: skip
    largest = max(float(np.abs(m.rate).max()) for m in found.values())
    longest = found["r=-190"]
    opposed = all(float(m.error @ m.duty) < 0.0 for m in found.values())
    rises = all((m.duty.sum() > 0.0) == (m.error[-1] > m.error[0]) for m in found.values())
    rows += [
        row("ec_largest", "(6), step 1", "largest ec of Table 1", 1.0, largest, 0.965, 5e-4,
            "reproduced" if largest >= 0.9995 else "not reproduced",
            "the universe was set by a peak that lies between the rows, or was not logged", "1"),
        row("e_scale", "(5)", "way of the longest move over its first e", FULL_SCALE_MM,
            longest.target_mm / float(longest.error[0]), 190.0, 1e-9, "reproduced", "r = -190 begins with e = -1",
            "mm"),
        row("duty_direction", "(7), Table 1", "a positive duty makes the error rise, that is the position fall", None,
            "yes" if rises else "no", "yes", 0, "cannot be checked",
            "with e = (r - x) / 190 mm in all four moves; the paper says 'forward' and 'backward' only",
            sense="yes/no"),
        row("duty_opposes_error", "(7), Table 1", "the duty has the sign of -e in every move", None,
            "yes" if opposed else "no", "yes", 0, "cannot be checked", "sum of e times duty below 0", sense="yes/no"),
    ]  # fmt: skip
    return rows


def _mismatch(found: Mapping[str, Move]) -> list[Claim]:
    bound = 2.0 * 0.0005 * FULL_SCALE_MM / RATE_SCALE_MM + 0.0005
    rows = []
    for name, move in found.items():
        away = np.abs(np.abs(np.diff(move.error)) * FULL_SCALE_MM / RATE_SCALE_MM - np.abs(move.printed_rate[1:]))
        rms, largest = float(np.sqrt(np.mean(away**2))), float(away.max())
        wanted_rms, wanted = MISMATCH[name]
        key = move_key(name)
        beyond = largest > bound
        rows.append(
            row(f"ec_mismatch_{key}", "Table 1",
                f"largest difference of ec and the change of e between rows, move {name}",
                0.0, largest, wanted, 5e-4 if name in ("r=50", "r=190") else 5e-5,
                "not reproduced" if beyond else "reproduced",
                f"rounding to three digits explains {bound:.4f}; root mean square {rms:.4f}", "1")
        )  # fmt: skip
        if wanted_rms is not None:
            rows.append(
                row(f"ec_mismatch_rms_{key}", "Table 1",
                    f"root mean square of ec against the change of e between rows, move {name}", None, rms, wanted_rms,
                    5e-5, "cannot be checked", f"largest {largest:.4f}", "1")
            )  # fmt: skip
    return rows


# ---- section 5 of the digest: errata that are arithmetic
def _errata(found: Mapping[str, Move]) -> list[Claim]:
    total = sum(CURVATURES)
    low, high = total / (8.0 * 6.0**2), total / (8.0 * 5.0**2)
    equal = max(interpolation_bound(CURVATURES, np.linspace(-1.0, 1.0, 6).tolist()))
    needed = equal_sets_for(CURVATURES, ACCURACY)
    at_7 = max(interpolation_bound(CURVATURES, np.linspace(-1.0, 1.0, needed).tolist()))
    printed_12 = LABELS[rules.SETS.winner(float(TABLE_2[0, 4])).index]
    start = 50.0 / FULL_SCALE_MM
    long = found["r=-190"]
    left = abs(float(np.interp(1.25, long.time_s, long.error)))
    arrived = _first_below(long, 0.01)
    lead = 10.0 * RATE_SCALE_MM / (30.0 * 0.26)
    return [
        row("eq10_accuracy_low", "(10)", "accuracy above which (10) as printed gives at most 6 sets", ACCURACY, low,
            0.0115,
            5e-5, "not reproduced", f"6 sets need an accuracy above {low:.4f} and up to {high:.4f}, not {ACCURACY:g}",
            "1", basis="arithmetic"),
        row("eq10_accuracy_high", "(10)", "accuracy up to which (10) as printed gives 6 sets", ACCURACY, high, 0.0165,
            1e-4, "not reproduced", f"{ACCURACY:g} is {ACCURACY / high:.1f} times as much", "1", basis="arithmetic"),
        row("six_equal_bound", "(10), text", "error that six evenly spaced sets guarantee", ACCURACY, equal, 0.066,
            5e-4,
            "not reproduced", "width 0.4, h^2 / 8 times the sum of the curvatures", "1", basis="arithmetic"),
        row("equal_sets_needed", "(10), text", "evenly spaced sets that guarantee 0.05", 6, needed, 7, 0,
            "not reproduced", f"they guarantee {at_7:.3f}", "sets", basis="arithmetic"),
        row("rule12_in_table2", "(12), Table 2", "Table 2 has the rule (12) as printed: NB, PM -> PB", "PB",
            printed_12,
            "PM", 0, "reproduced" if printed_12 == "PB" else "not reproduced",
            f"Table 2 has {TABLE_2[0, 4]:g} there; with the memberships put right it is NB, PS -> PB, which it has",
            sense="order", basis="arithmetic"),
        row("e_start_50", "Table 1", "first e of the move r=50", float(found["r=50"].error[0]), start, 0.263, 5e-4,
            "not reproduced" if abs(start - found["r=50"].error[0]) > 5e-4 else "reproduced",
            f"50 mm over 190 mm; the printed e is {FULL_SCALE_MM * found['r=50'].error[0]:.2f} mm", "1"),
        row("arrival_table1", "Figure 11, Table 1", "way left at 1.25 s in Table 1's move of -190 mm", 0.0,
            FULL_SCALE_MM * left, 9.0, 0.5,
            "reproduced with change" if FULL_SCALE_MM * left <= NEAR_MM else "not reproduced",
            f"the old servo has almost reached -170 mm then, it is said; so it has if that means {NEAR_MM:.0f} mm",
            "mm"),
        row("arrival_table1_1pct", "Table 1", "when Table 1's move of -190 mm is within 1 %", None, arrived, 1.5, 0.05,
            "cannot be checked", "between two rows, in a straight line", "s"),
        row("speed_lead", "(2), (3), (6)", "feed per turn for 258.7 mm/s at the 7.8 rad/s of (2) and (3)", None,
            2.0 * np.pi * lead, 208.0, 0.5, "cannot be checked",
            f"{lead:.1f} mm/rad; no ball screw has that, so the chain lacks a factor", "mm", "report",
            basis="arithmetic"),
    ]  # fmt: skip


def _first_below(move: Move, band: float) -> float:
    """Time at which the size of e falls to ``band``, in a straight line between rows."""
    size = np.abs(move.error)
    after = int(np.flatnonzero(size > band)[-1]) + 1
    part = (size[after - 1] - band) / (size[after - 1] - size[after])
    return float(move.time_s[after - 1] + part * (move.time_s[after] - move.time_s[after - 1]))
