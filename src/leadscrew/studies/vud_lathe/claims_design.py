"""Claims about the design: the rules that Table 1 gives, what completes them, and the design as one procedure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from leadscrew.controllers.vud import vud_beta_e
from leadscrew.controllers.vud.universe import TABLE_2
from leadscrew.design import VudDesign, design_vud
from leadscrew.fuzzy.learning import LearnedRules
from leadscrew.report.claim import Claim
from leadscrew.studies.vud_lathe import rules
from leadscrew.studies.vud_lathe.claims_curvature import curvature_claims
from leadscrew.studies.vud_lathe.claims_units import RATE_SCALE_MM, row, unit_claims
from leadscrew.studies.vud_lathe.rules import LABELS
from leadscrew.studies.vud_lathe.tables import TABLE_1, Move

WINNERS = {
    "NB PS": ("PB", 0.404, None, 0.0), "NM PB": ("PM", 0.696, "PB", 0.410), "NS PS": ("PS", 0.570, "PM", 0.301),
    "NS PM": ("PM", 0.833, None, 0.0), "PS NS": ("NS", 0.576, "NM", 0.302), "PS NM": ("NM", 0.875, None, 0.0),
    "PM NB": ("NM", 0.674, "NB", 0.394), "PB NS": ("NB", 0.404, None, 0.0),
}  # fmt: skip
"""Of the digest: cell, winner and its strength, what it beat and that strength."""
MODES: tuple[tuple[str, Literal["drop", "keep"], rules.Rate, int, int, str], ...] = (
    ("signed_drop", "drop", "signed", 8, 6, "(NS, PM), (PS, NM)"),
    ("signed_keep", "keep", "signed", 9, 6, "(NS, NS), (NS, PM), (PS, NM)"),
    ("printed_keep", "keep", "printed", 9, 5, "(NS, NS), (NS, PM), (PS, PS), (PM, PB)"),
)
SAID = {
    "signed_drop": "ec with its sign, ties left out", "signed_keep": "ec with its sign, ties to the lower set",
    "printed_keep": "ec as printed, ties to the lower set",
}  # fmt: skip


def design_claims(found: Mapping[str, Move]) -> list[Claim]:
    """All of them that need no run."""
    return [*_modes(found), *_winners(rules.learn(found)), *_completion(found), *unit_claims(found),
            *curvature_claims(found), *_whole(design_vud(TABLE_1))]  # fmt: skip


# ---- section 4 of the digest: rules
def _modes(found: Mapping[str, Move]) -> list[Claim]:
    rows = []
    for key, ties, rate, covered, agree, cells in MODES:
        learned = rules.learn(found, ties, rate)
        agreeing, other = learned.agreement(TABLE_2)
        disagree = ", ".join(f"({', '.join(learned.labels(at))})" for at in other)
        weak = ""
        if (2, 2) in learned.cells:
            strength = learned.cells[2, 2].winner.strength
            weak = f"; (NS, NS) comes from rows that are zero or nearly so, strength {strength:.3f}"
        said = SAID[key]
        if key != "signed_drop":
            rows.append(
                row(f"rules_{key}_covered", "Table 1, Table 2", f"cells that Table 1 covers, {said}", 36,
                    learned.covered, covered, 0, "not reproduced",
                    f"{TABLE_2.size - learned.covered} cells get no sample{weak}", "cells")
            )  # fmt: skip
            rows.append(
                row(f"rules_{key}_agree", "Table 2", f"covered cells whose winner is Table 2's, {said}",
                    learned.covered,
                    agreeing, agree, 0, "reproduced" if not other else "not reproduced",
                    f"{len(other)} of {learned.covered} differ", "cells")
            )  # fmt: skip
        rows.append(
            row(f"rules_{key}_differ", "Table 2", f"covered cells whose winner is not Table 2's, {said}", "none",
                disagree or "none", cells, 0, "reproduced" if not other else "not reproduced",
                f"{len(other)} of {learned.covered} covered cells{weak}", sense="order")
        )  # fmt: skip
    left_out = len(rules.learn(found).dropped)
    rows.append(
        row("rules_ties", "Table 1, Figures 6 to 8", "samples in which a value lies exactly between two sets", None,
            left_out, 21, 0, "cannot be checked",
            f"there is no set at zero, so e, ec or duty = 0 belongs to NS and PS alike; {80 - left_out} samples stay",
            "samples")
    )  # fmt: skip
    return rows


def _winners(learned: LearnedRules) -> list[Claim]:
    rows = []
    for name, (label, strength, loser, lost) in WINNERS.items():
        at = (LABELS.index(name.split()[0]), LABELS.index(name.split()[1]))
        cell, cell_text, key = learned.cells[at], f"({name.replace(' ', ', ')})", name.lower().replace(" ", "_")
        winner = LABELS[cell.winner.output]
        printed = LABELS[rules.SETS.winner(float(TABLE_2[at])).index]
        same = winner == printed
        rows += [
            row(f"winner_{key}", "Table 2", f"strongest rule of Table 1 in the cell {cell_text}", printed, winner,
                label,
                0, "reproduced" if same else "not reproduced",
                f"{learned.say(cell.winner)}, {cell.winner.count} of {cell.count} samples"
                + ("" if same else f"; Table 2 has {printed}"), sense="order"),
            row(f"strength_{key}", "(13)", f"strength of the strongest rule in {cell_text}",
                None, cell.winner.strength, strength, 5e-4, "cannot be checked",
                "the paper prints strengths of k = 1 and k = 2 of one move alone"),
        ]  # fmt: skip
        if loser is not None:
            beaten = next((r for r in cell.losers if LABELS[r.output] == loser), None)
            value = float("nan") if beaten is None else beaten.strength
            of_15 = name == "NM PB"
            rows.append(
                row(f"beaten_{key}", "(16)" if of_15 else "(13)",
                    f"strength of the rule {loser} that loses in {cell_text}",
                    lost if of_15 else None, value, lost, 5e-4,
                    "cannot be checked" if not of_15 else
                    "reproduced" if abs(value - lost) <= 5e-4 else "not reproduced",
                    f"beaten by {winner} with {cell.winner.strength:.3f}")
            )  # fmt: skip
    return rows


def _completion(found: Mapping[str, Move]) -> list[Claim]:
    done = rules.rebuild(rules.learn(found))
    seeds = {**done.seeds, **done.dropped}
    text = "; ".join(f"({LABELS[i]}, {LABELS[j]}) {seeds[i, j].level}" for i, j in sorted(seeds))
    kept, lost = seeds[2, 3].count, seeds[2, 4].count
    points = np.array([[rules.SETS.centres[i], rules.SETS.centres[j]] for i, j in sorted(done.seeds)])
    values = [rules.SETS.centres[len(LABELS) // 2 + done.seeds[at].level - 1] for at in sorted(done.seeds)]
    slope_e, slope_ec = np.linalg.lstsq(points, np.array(values), rcond=None)[0]
    where = "Table 2"
    prior = "the damping by ec in Table 2 is prior knowledge, not data"
    return [
        row("seeds", where, "levels of the rules after folding the two directions together", None, text,
            "(NB, PS) 3; (NM, PB) 2; (NS, PS) 1; (NS, PM) 2", 0, "cannot be checked",
            "levels 1, 2, 3 are 0.33, 0.67, 1", sense="order"),
        row("seed_samples_ns_ps", where, "samples behind the seed (NS, PS)", None, kept, 47, 0, "cannot be checked",
            "it stays", "samples"),
        row("seed_samples_ns_pm", where, "samples behind the seed (NS, PM)", None, lost, 4, 0, "cannot be checked",
            f"it asks for more than (NS, PS), which has {kept} samples, and is dropped for monotony", "samples"),
        row("seed_plane_e", where, "weight of e in the plane through the rules from data", None, slope_e, -1.0, 1e-9,
            "cannot be checked", f"the data alone asks for duty = {slope_e:.3g} e; {prior}", "1"),
        row("seed_plane_ec", where, "weight of ec in the plane through the rules from data", None, slope_ec, 0.0, 1e-9,
            "cannot be checked", prior, "1"),
    ]  # fmt: skip


# ---- the design as one procedure
def _whole(made: VudDesign) -> list[Claim]:
    learned, compared = made.rules.learned, made.rules.compared
    assert compared is not None
    numbers = design_vud(TABLE_1, levels=rules.MAGNITUDES, rate_scale_mm=RATE_SCALE_MM).controller().params
    same = all(np.array_equal(a, b) for a, b in zip(numbers, vud_beta_e.params, strict=True))
    where = "section IV.b, leadscrew design vud"
    return [
        row("design_covered", where, "cells that the design's rules cover from Table 1", 36, learned.covered, 8, 0,
            "not reproduced", f"{learned.total - learned.covered} cells are filled by completion", "cells"),
        row("design_agree", where, "of these, cells with Table 2's consequent", learned.covered, compared.agree, 6, 0,
            "reproduced" if compared.agree == learned.covered else "not reproduced",
            f"{learned.covered - compared.agree} covered cells differ", "cells"),
        row("design_conflicts", where, "cells in which samples of Table 1 disagree", None, len(learned.conflicts), 4,
            0,
            "cannot be checked", "settled by strength, as in the paper, which gives no number", "cells"),
        row("design_equal", where, "cells of the design's table after completion that are Table 2's", 36,
            compared.equal,
            36, 0, "reproduced with change" if compared.equal == 36 else "not reproduced",
            f"with {', '.join(made.rules.steps)}, which is prior knowledge", "cells"),
        row("design_controller", where, "the designed controller is the corrected one, number by number", None,
            "yes" if same else "no", "yes", 0, "cannot be checked",
            "with Table 2's 0.333 and 0.677 as consequents and 25.87 mm as scale of ec", sense="yes/no", group="ours"),
    ]  # fmt: skip


SETTLING = {"fig11a_step_m50": 0.989, "fig11b_step_m170": 1.576}
"""Of the digest, with the centres 0.33 and 0.67 as consequents."""


def designed_claims(loops: Any) -> list[Claim]:
    """Of the digest's sections 2 and 5, those that need a run."""
    return [*_settling(loops), _peak(loops.run("ours.original_fit", "step_m190"))]


def _peak(run: Any) -> Claim:
    """Why Table 1 may stop at ec = 0.965: its rows are 0.1 s apart, a peak may lie between them."""
    error = run["command"] - run["feedback"]
    sampled = float(np.abs(np.diff(error[::100])).max())
    peak = float(np.abs(error[100:] - error[:-100]).max())
    return row(
        "ec_peak", "(6), Table 1",
        "largest change of the error between samples 0.1 s apart, over the largest in any 0.1 s",
        None, sampled / peak, 0.965, 0.005, "cannot be checked",
        f"our stand-in on the move r=-190: {sampled:.2f} mm and {peak:.2f} mm; Table 1 reaches 0.965 of "
        "its universe, so 25.87 mm may be a peak between the rows",
        "1", "report", basis="reconstructed plant", group="ours",
    )  # fmt: skip


def _settling(loops: Any) -> list[Claim]:
    """The controller that the design makes of Table 1 without a hint, run: consequents 0.33 and 0.67."""
    table = design_vud(TABLE_1, rate_scale_mm=RATE_SCALE_MM).rules.table
    rows = []
    for (scenario, wanted), way in zip(SETTLING.items(), ("-50", "-170"), strict=True):
        loop = loops.get("corrected.vud_beta_e", scenario)
        printed, ours = (
            found.run(4.0).metrics["settling_2um"] for found in (loop, loop.using({"controller.rules": table}))
        )
        rows.append(
            row(f"design_2um_m{way[1:]}", "Table 2, section V",
                f"within 2 um of {way} mm with consequents 0.33 and 0.67",
                None, ours, wanted, 1.5e-3, "cannot be checked",
                f"{printed:.3f} s with Table 2's 0.333 and 0.677: the paper's two sets of numbers differ by "
                f"{1000.0 * (ours - printed):.0f} ms", "s", basis="reconstructed plant", group="as corrected")
        )  # fmt: skip
    return rows
