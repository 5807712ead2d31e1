"""Claims about the paper's data: what Table 1 says of the rules, of the units, and of the plant."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from leadscrew.controllers.vud.universe import TABLE_2
from leadscrew.identify.gain import HOLDS, GainFit, fit_gain
from leadscrew.report.claim import Claim, Kind, Verdict
from leadscrew.studies.vud_lathe import rules
from leadscrew.studies.vud_lathe.tables import FULL_SCALE_MM, Move

LAGS_S = (0.0008, 0.0015, 0.017)
"""The lags of (2) and (3)."""
RATE_SCALE_MM = 25.87
SPEEDS = {"linear": 288.8, "previous": 293.9, "current": 283.3}
FIT_PERCENT = {"r=-190": 1.45, "r=-50": 12.5, "r=50": 14.2, "r=190": 1.41}


def gain_fits(found: Mapping[str, Move]) -> dict[str, GainFit]:
    """The speed at full duty from Table 1, under each assumption about the duty between its samples."""
    records = {name: move.record() for name, move in found.items()}
    return {hold: fit_gain(records, LAGS_S, hold) for hold in HOLDS}


def data_claims(found: Mapping[str, Move]) -> list[Claim]:
    """All of them."""
    return [*_rules(found), *_units(found), *_gain(found)]


def _claim(
    name: str,
    source: str,
    statement: str,
    paper: float | str | None,
    measured: float | str,
    target: float | str,
    tolerance: float,
    verdict: Verdict,
    reason: str,
    unit: str = "",
    kind: Kind = "required",
    sense: str = "=",
) -> Claim:
    value = measured if isinstance(measured, str) else float(measured)
    return Claim(
        f"vud_lathe.{name}", source, "as printed", "paper's data", statement, paper, value, unit, sense,  # type: ignore[arg-type]
        target, tolerance, kind, verdict, reason,
    )  # fmt: skip


def _rules(found: Mapping[str, Move]) -> list[Claim]:
    learned = rules.learn(found)
    agreeing, _ = learned.agreement(TABLE_2)
    data_only = rules.rebuild(learned, add_growth_level=False)
    full = rules.rebuild(learned)
    beaten = learned.cells[1, 5]
    missing = TABLE_2.size - learned.covered
    names = ", ".join(f"({', '.join(learned.labels(cell))})" for cell in learned.agreement(TABLE_2)[1])
    return [
        _claim("sample_count", "after (16)", "rules before conflicts are settled", 80, learned.samples, 80, 0,
               "reproduced", "k = 1 ... 20 of four moves", "rules"),
        _claim("table2_covered", "Table 1, Table 2", "cells of Table 2 that Table 1 covers", 36, learned.covered, 8, 0,
               "not reproduced", f"{missing} cells get no sample; {len(learned.dropped)} of the samples lie exactly "
               "between two sets and are left out (kept, they cover one cell more)", "cells"),
        _claim("table2_complete", "after (16)", "the 80 rules give a complete base", "yes",
               "yes" if missing == 0 else "no", "no", 0, "not reproduced",
               f"{missing} of 36 cells are not in the data; they need symmetry, monotonicity and prior knowledge",
               sense="yes/no"),
        _claim("table2_agree", "Table 2", "covered cells whose winner is that of Table 2", "all", agreeing, 6, 0,
               "not reproduced", f"of {learned.covered}; the data disagrees in {names}", "cells"),
        _claim("table2_conflict_15", "(15)", "the rule of (15) is overruled by a stronger one", "yes",
               "yes" if beaten.winner.output == 4 else "no", "yes", 0, "reproduced",
               f"{learned.say(beaten.winner)} beats {learned.say(beaten.losers[0])}, as Table 2 has it",
               sense="yes/no"),
        _claim("table2_symmetry_only", "Table 2", "cells rebuilt from data, symmetry and monotonicity alone", 36,
               rules.equal_cells(data_only), 24, 0, "not reproduced",
               "the damping half of the table (error growing) is not in the data", "cells"),
        _claim("table2_rebuilt", "Table 2", "cells rebuilt with one level more where the error grows", 36,
               rules.equal_cells(full), 36, 0, "reproduced with change",
               "the extra level is prior knowledge, named as a step of its own", "cells"),
    ]  # fmt: skip


def _units(found: Mapping[str, Move]) -> list[Claim]:
    ratio = [
        float(np.sum(np.abs(m.printed_rate)) * RATE_SCALE_MM / (FULL_SCALE_MM * abs(m.error[0] - m.error[-1])))
        for m in found.values()
    ]
    positive = [m for m in found.values() if m.target_mm > 0.0]
    falls = all(np.sum(m.printed_rate) > 0.0 and m.error[-1] < m.error[0] for m in positive)
    return [
        _claim("ec_unit", "(6), step 1", "way of a move over the sum of its ec times 25.87 mm, mean of four", "mm/s",
               float(np.mean(ratio)), 1.0, 0.02, "not reproduced",
               "the printed unit is mm/s; the sums fit the ways only if 25.87 mm is the change per 0.1 s (258.7 mm/s)"),
        _claim("ec_sign", "Table 1", "ec has the sign of de/dt in the columns r = 50 and r = 190", "yes",
               "no" if falls else "yes", "no", 0, "not reproduced", "ec is printed positive while e falls; we turn it",
               sense="yes/no"),
    ]  # fmt: skip


def _gain(found: Mapping[str, Move]) -> list[Claim]:
    fits = gain_fits(found)
    main = fits["linear"]
    short = [abs(g) for name, g in main.gain_alone.items() if name in ("r=-50", "r=50")]
    more = 100.0 * (sum(short) / len(short) / abs(main.gain) - 1.0)
    rows = [
        _claim(f"gain_{hold}", "(2), (3), Table 1", f"speed at full duty, {text}", None, -fit.gain, SPEEDS[hold], 0.5,
               "cannot be checked", "the paper prints no speed; 7.8 rad/s at full duty and no screw", "mm/s",
               "required" if hold == "linear" else "report")
        for (hold, fit), text in zip(
            fits.items(), ("duty linear between samples", "duty held", "duty already the next one"), strict=True)
    ]  # fmt: skip
    rows += [
        _claim(f"gain_fit_{name.replace('r=-', 'm').replace('r=', 'p')}", "Table 1",
               f"misfit of the move {name} with the common speed", None, main.nrmse_percent[name], expected, 0.1,
               "cannot be checked",
               f"one linear gain fits the long moves; the short ones ask for {more:.0f} % more", "%")
        for name, expected in FIT_PERCENT.items()
    ]  # fmt: skip
    lead = -main.gain / (30.0 * 0.26)
    rows.append(
        _claim("gain_lead", "(2), (3)", "feed per radian that the gains 30 and 0.26 and Table 1 imply", None, lead,
               37.0, 0.1, "cannot be checked",
               f"{2 * np.pi * lead:.0f} mm a turn: no ball screw has that, so 30 x 0.26 is not rad/s per duty, or the "
               "chain lacks a factor", "mm/rad", "report")
    )  # fmt: skip
    return rows
