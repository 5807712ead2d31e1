"""The paper's errata, numbered as in section 8 of the project's digest: each shown by a number."""

from __future__ import annotations

import math
import warnings

import numpy as np

from leadscrew.friction.lugre import HAT, LuGre, Stribeck, level
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.plants.ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.report.claim import Claim
from leadscrew.studies.fsmc_ballscrew import algebra
from leadscrew.studies.fsmc_ballscrew.attraction import SYSTEMS
from leadscrew.studies.fsmc_ballscrew.claims_fuzzy import scales
from leadscrew.studies.fsmc_ballscrew.claims_readings import WORDS, row
from leadscrew.studies.fsmc_ballscrew.claims_robust_continuous import exact_error_um, fuzzy_slope
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.tracking import reversal, sine_run, tracked

TABLE_KG = 62.4
"""Table 1: maximum mass of table and work."""

GRAVITY = 9.81

BALL_BAR_FIGURES = {
    15: "Kakino et al., 1993", 16: "Kakino et al., 1993", 17: "Kakino et al., 1993", 18: "Kakino et al., 1993",
    19: "BS ISO 230-4, 1996", 20: "Kakino et al., 1993", 21: "BS ISO 230-4, 1996",
}  # fmt: skip
"""Whose the figures of section 7 are, by their captions."""

SINES = ("sine_slow", "sine_wide", "sine_fast")


def errata_claims(loops: Loops) -> list[Claim]:
    """Errata 1 to 15."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DivergenceWarning)
        return [*_rules(loops), *_surface(loops), *_formulas(), *_parameters(loops), *_stability(loops),
            *_running(loops),
                *_validation()]  # fmt: skip


def _largest(loops: Loops, law: str, scenario: str, **options: object) -> float:
    return tracked(sine_run(loops, law, scenario, **options), scenario).largest


def _rules(loops: Loops) -> list[Claim]:
    k = {name: float(SYSTEMS[name](s=1.0, s_c=1.0)["k"]) for name in ("printed", "corrected")}
    rows = [
        row("erratum_01_rules", "rules 3, 7; (15)", "as printed", "printed K where s and s_c are both at their scale",
            0.0, k["printed"], "", "=", 0.0, 1e-12, "reproduced",
            f"(15) acts along s + s_c and is largest there; so are the corrected rules, {k['corrected']:g}",
            basis="arithmetic")
    ]  # fmt: skip
    known = {"sine_slow": 0.019, "sine_wide": 0.044, "sine_fast": 0.058}
    for scenario in SINES:
        printed, corrected = (_largest(loops, law, scenario) for law in ("paper.fsmc", "corrected.fsmc"))
        rows.append(
            row(f"erratum_01_works_{scenario}", "rules 1 to 9", "as printed",
                f"largest error on {WORDS[scenario]} mm, printed rules, S_c = 4 S", None, printed, "um", "=",
                known[scenario], max(1e-3, 0.02 * known[scenario]), "cannot be checked",
                f"corrected rules {corrected:.4f} um: both work, the printed ones as a fuzzy PI")
        )  # fmt: skip
    return rows


def _surface(loops: Loops) -> list[Claim]:
    literal, conventional, csmc = (
        _largest(loops, law, "sine_fast") for law in ("paper.smc", "corrected.smc", "paper.csmc")
    )
    ordered = "SMC worse" if literal > csmc else "CSMC worse"
    step = 1e3 * abs(float(loops.run("paper.smc", "step_raw")["true_error"][-1]))
    return [
        row("erratum_02_order", "(8), (11), Figure 14", "as printed",
            "which of the printed SMC and CSMC has the larger error on sin 2 pi t mm", "SMC worse", ordered, "",
            "order", "CSMC worse", 0.0, "not reproduced" if ordered != "SMC worse" else "reproduced",
            f"{literal:.3f} against {csmc:.3f} um; with the conventional surface SMC has {conventional:.3f}"),
        row("erratum_02_steady", "(8), Figure 11", "as printed",
            "error left by the printed SMC, step of 1 mm, at 0.6 s",
            "steady state error exists", step, "um", "<=", 1e-3, 0.0, "not reproduced",
            "its surface has an integral, which leaves none"),
    ]  # fmt: skip


def _formulas() -> list[Claim]:
    of_e, of_rate = algebra.tight_bounds()
    return [
        row("erratum_03_speed", "(13)", "as printed", "|e'| that |s| <= phi allows beyond (13)", 0.0,
            100.0 * (of_rate / 2.0 - 1.0), "%", "=", 13.5, 0.05, "not reproduced",
            f"the constant is {of_rate:.4f}, not 2; for e it is {of_e:.4f}, not 1", basis="arithmetic"),
        row("erratum_04_binomials", "(10)", "as printed", "error of the binomials of (10), n = 2, 3, 4", 0.0,
            max(algebra.binomial_error(n) for n in (2, 3, 4)), "", "=", 0.0, 1e-15, "reproduced",
            "right as printed, in the form of Liang and Su; x_d in (10) must be y_r, no x_d is defined",
            basis="arithmetic"),
        row("erratum_05_growth", "(10), Table 2", "as printed",
            "growth of a stuck stage under f-hat of the measured speed, sigma1-hat included", None,
            algebra.feedback_growth(), "1/s", ">=", 8e5, 0.0, "cannot be checked",
            f"damping of -{HAT.damping - LuGre().damping:.0f} N m s/rad: ill-posed with Table 2", basis="arithmetic"),
        row("erratum_09_lead", "Table 1", "as printed", "lead pitch, 10 mm / (2 x 3.14)", 1.5923, 10.0 / (2.0 * 3.14),
            "mm/rad", "=", TRAVEL_MM_PER_RAD, 1e-4, "reproduced with change",
            f"pi as 3.14, and cut off; 10 mm / (2 pi) is {10.0 / (2.0 * math.pi):.5f}",
            basis="arithmetic"),
    ]  # fmt: skip


def _parameters(loops: Loops) -> list[Claim]:
    true, bound = LuGre(), Stribeck()
    dominant = max(
        abs(a / b - 1.0)
        for a, b in ((HAT.coulomb, true.coulomb), (HAT.static, true.static), (bound.coulomb, true.coulomb),
                     (bound.static, true.static))
    )  # fmt: skip
    exact = max(exact_error_um(loops, law) for law in ("corrected.smc", "paper.csmc", "corrected.fsmc"))
    force = true.coulomb / (1e-3 * TRAVEL_MM_PER_RAD)
    slow, fast = level(true, 0.1 * true.stribeck_speed), level(true, 5.0 * true.stribeck_speed)
    return [
        row("erratum_06_known", "Table 2", "as printed",
            "uncertainty of F_C and F_S in Table 2, of which the robustness is claimed", "uncertain enough", dominant,
            "", "=", 0.0, 1e-12, "not reproduced",
            "the columns of f-hat and F~ (headed with hats) have the true values: friction's main part is known "
            "exactly",
            basis="paper's data"),
        row("erratum_06_exact", "Table 2", "as corrected",
            "largest error of the three laws on sin 2 pi t mm with all of Table 2 believed as it is", None, 1e3 * exact,
            "nm", "<=", 0.1, 0.0, "cannot be checked",
            "all that they are tested against is sigma0, sigma1, sigma2, v_s"),
        row("erratum_07_damping", "Table 2", "as printed", "damping ratio of the stuck stage, over that of the source",
            None, algebra.stick_damping(true, INERTIA) / algebra.stick_damping(true, 1.0), "", "=", 52.0, 0.05,
            "cannot be checked", "26 against 0.5: numbers in N/m on 1 kg, taken for N m/rad on 0.00037 kg m^2",
            basis="arithmetic"),
        row("erratum_07_stribeck", "Table 2", "as printed", "Stribeck speed at the table", None,
            1e3 * TRAVEL_MM_PER_RAD * true.stribeck_speed, "um/s", "=", 1.59, 0.005, "cannot be checked",
            "1 mm/s in the source", basis="arithmetic"),
        row("erratum_08_force", "Table 2", "as printed", "Coulomb friction at the table", None, force, "N", "=", 3919.0,
            0.5, "cannot be checked", f"{TABLE_KG:g} kg weigh {TABLE_KG * GRAVITY:.0f} N", basis="paper's data"),
        row("erratum_08_mu", "Table 2", "as printed", "friction coefficient that this would be", None,
            force / (TABLE_KG * GRAVITY), "", "=", 6.4, 0.05, "cannot be checked", "no guide has one above 1",
            basis="paper's data"),
        row("erratum_08_digits", "Tables 1, 2", "as printed", "mass in kg over F_C in N m", None,
            TABLE_KG / true.coulomb, "", "=", 10.0, 1e-9, "cannot be checked",
            "F_C 'selected arbitrarily' has the digits of the mass", basis="paper's data"),
        row("erratum_10_static", "section 2.2.1, Table 2", "as printed", "F_S / F_C, where the text says mu_s = mu_k",
            1.0, true.static / true.coulomb, "", "=", 1.5, 1e-9, "not reproduced",
            "static friction exceeds dynamic, as the text says elsewhere", basis="paper's data"),
        row("erratum_10_low_speed", "section 2.2.2, (3)", "as printed",
            "friction at 5 v_s in that at v_s / 10, where the text says that it increases with low speed", ">= 1",
            fast / slow, "", "<=", 0.7, 0.0, "not reproduced",
            f"(3) falls from {slow:.2f} to {fast:.2f} N m; in (3) v_v must be v_s, in (6) f-hat stands for delta f, "
            "and the integral's lower limit and the place of number (5) are lost", basis="paper's data"),
    ]  # fmt: skip


def _stability(loops: Loops) -> list[Claim]:
    corner = loops.run("corrected.fsmc", "sine_wide", changes=scales(120.0, 1.0))
    away = 1e3 * float(np.abs(corner["true_error"]).max())
    state = scales(120.0, 4.0) | {"controller.friction_from": 2}
    lost = loops.run("corrected.fsmc", "step_raw", changes=state, bound=1e5).diverged
    sliding = 6.24 / INERTIA
    rates = {
        "SMC": (sliding + 120.0) / 0.1 / 2.0, "CSMC": 2.0 * (sliding + 20.0) / 0.1 / 2.0, "FSMC": fuzzy_slope() / 2.0,
    }  # fmt: skip
    return [
        row("erratum_11_corner", "section 4.4", "as corrected", "largest error on 5 sin t mm with equal scales",
            "the stability of fuzzy controller would be guaranteed", away, "um", ">=", 50.0, 0.0, "not reproduced",
            "the corner where K is 0; a bounded output guarantees nothing"),
        row("erratum_11_diverges", "section 4.4", "as corrected",
            "raw step, f-hat from the measured speed, U = 120 N m",
            "stable", "diverges" if lost is not None else "stable", "", "yes/no", "diverges", 0.0,
            "not reproduced" if lost is not None else "reproduced",
            f"{lost}" if lost is not None else "it did not"),
        row("erratum_12_rate", "section 6", "as printed",
            "slowest sampling with which the printed gains are stable, the largest of the three laws", None,
            1e-3 * max(rates.values()), "kHz", ">=", 200.0, 0.0, "cannot be checked",
            ", ".join(f"{name} {1e-3 * rate:.0f}" for name, rate in rates.items())
            + " kHz in sliding; SMC and CSMC half as much again in stick; no rate or solver is given",
            basis="arithmetic"),
    ]  # fmt: skip


def _running(loops: Loops) -> list[Claim]:
    raw = float(np.abs(loops.run("corrected.smc", "step_raw", 0.05, sample=1e-5)["output"]).max())
    smooth = float(np.abs(loops.run("corrected.smc", "step_quintic")["output"]).max())
    rest = float(loops.run("corrected.fsmc", "step_raw")["output"][-1])
    slow = reversal(sine_run(loops, "corrected.fsmc", "sine_slow"), "sine_slow")
    wide = reversal(sine_run(loops, "corrected.fsmc", "sine_wide"), "sine_wide")
    return [
        row("erratum_13_step", "section 4.2, Figure 11", "as printed",
            "largest torque of SMC on the bare step of Figure 11, in that on the same move in 50 ms", None,
            raw / smooth, "", ">=", 3.0, 0.0, "cannot be checked",
            f"{raw:.0f} against {smooth:.0f} N m: y_r must be twice differentiable, by section 4.2, and is not"),
        row("erratum_14_torque", "after Figure 11", "as corrected", "torque of FSMC at rest after the step of 1 mm",
            0.0, rest, "N m", "=", -6.76, 0.01 * 6.76, "not reproduced",
            "the bristles stay bent and must be held; only with f-hat from the measured speed is the mean zero"),
        row("erratum_14_damped_slow", "after Figure 14", "as corrected",
            "time after a reversal until the error of FSMC stays within 10 % of its peak, 0.01 sin t mm", 0.1,
            slow.settled, "s", ">=", 0.1, 0.0, "not reproduced",
            f"presliding lasts longer there; on 5 sin t mm it is {1e3 * wide.settled:.1f} ms, as said"),
    ]  # fmt: skip


def _validation() -> list[Claim]:
    own = [number for number, source in BALL_BAR_FIGURES.items() if not source]
    return [
        row("erratum_15_ball_bar", "section 8", "as printed",
            "figures of section 7 that show the authors' own ball-bar data, by their captions",
            "validated by comparison with ball-bar experiments", float(len(own)), "", "=", 0.0, 0.0, "not reproduced",
            f"all {len(BALL_BAR_FIGURES)} are taken from Kakino (1993) or ISO 230-4 (1996), and the text names no "
            "measurement", basis="paper's data"),
    ]  # fmt: skip
