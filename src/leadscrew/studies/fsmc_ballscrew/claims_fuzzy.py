"""Claims about the fuzzy controller: surface, direction of the rules, scales, and what a bounded output holds."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np

from leadscrew.controllers.sliding.continuous import fuzzy_ideal
from leadscrew.controllers.sliding.fuzzy import RULES, sliding_system
from leadscrew.friction.lugre import HAT, LuGre
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.plants.ballscrew_stage import INERTIA
from leadscrew.report.claim import Claim
from leadscrew.studies.fsmc_ballscrew import algebra
from leadscrew.studies.fsmc_ballscrew.attraction import SYSTEMS, hold
from leadscrew.studies.fsmc_ballscrew.claims_readings import WORDS, row
from leadscrew.studies.fsmc_ballscrew.runs import Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.tracking import sine_run, tracked

SURFACE = (
    (0.2, 0.0, -0.120690), (0.2, 0.2, -0.279412), (0.5, 0.5, -0.5), (1.0, 1.0, -1.0), (1.0, 0.0, -0.5), (0.5, -0.5,
    0.0), (0.3, -0.2, -0.044326),
)  # fmt: skip
"""Inputs over their scales, and K of the corrected rules by a fine numeric centroid."""

SLOPE = 120.0 / (INERTIA * 0.65)
"""Of the law inside, U / (J S), 1/s."""

MATLAB = sliding_system(RULES["corrected"], "fsmc_101", "Fuzzy sliding mode, centroid on 101 points; a torque.")
MATLAB = replace(MATLAB, outputs=(replace(MATLAB.outputs[0], integration="trapezoid", resolution=100),))
ON_101_POINTS = fuzzy_ideal(MATLAB, "fsmc_101_ideal")
"""The corrected rules with the centroid that Matlab's toolbox takes, of which the paper says that it was used."""


def scales(torque: float, ratio: float, slope: float = SLOPE) -> dict[str, float]:
    """Parameters of a fuzzy law with ``U = torque``, this slope, and ``S_c = ratio S``."""
    s = torque / (INERTIA * slope)
    return {"controller.fuzzy_torque": torque, "controller.scale_s": s, "controller.scale_sc": ratio * s}


def fuzzy_claims(loops: Loops) -> list[Claim]:
    """Surface, rules, dead corner, integral action, bounded torque, friction from the measured speed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DivergenceWarning)
        return [*_surface(), *_direction(), *_corner(loops), *_integral(loops), *_torque(loops), *_resolution(loops),
                *_state_driven(loops)]  # fmt: skip


def _k(rules: str, s: float, s_c: float) -> float:
    return float(SYSTEMS[rules](s=s, s_c=s_c)["k"])


def _surface() -> list[Claim]:
    return [
        row(f"fuzzy_surface_{number}", "Figures 8, 9", "as corrected", f"K({s:g}, {s_c:g}), corrected rules", None,
            _k("corrected", s, s_c), "", "=", known, 6e-7, "cannot be checked",
            "the paper prints no value; closed-form centroid", basis="arithmetic")
        for number, (s, s_c, known) in enumerate(SURFACE)
    ]  # fmt: skip


def _direction() -> list[Claim]:
    x = np.linspace(-1.2, 1.2, 49)
    turned = SYSTEMS["corrected"].many(s=x[:, None], s_c=-x[None, :])
    apart = float(np.abs(SYSTEMS["printed"].many(s=x[:, None], s_c=x[None, :]) - turned).max())
    rows = [
        row("fuzzy_mirror", "rules 1 to 9", "as printed", "difference of the printed K from the corrected K(s, -s_c)",
            None, apart, "", "=", 0.0, 1e-12, "cannot be checked", "one table is the other with s_c turned round",
            basis="arithmetic")
    ]  # fmt: skip
    small = 1e-6
    for rules, along, across in (("printed", 0.0, -2.0), ("corrected", -2.0, 0.0)):
        group = "as printed" if rules == "printed" else "as corrected"
        for name, sign, known in (("sum", 1.0, along), ("difference", -1.0, across)):
            found = _k(rules, small, sign * small) / small
            acts = abs(found) > 1.0
            rows.append(
                row(f"fuzzy_{rules}_{name}", "(15), (17), rules 1 to 9", group,  # type: ignore[arg-type]
                    f"slope of the {rules} K where s and s_c are {'equal' if sign > 0 else 'opposite'}",
                    -2.0 if sign > 0 else 0.0, found, "", "=", known, 1e-5,
                    "not reproduced" if rules == "printed" else "reproduced with change",
                    f"{'acts' if acts else 'does nothing'} along s {'+' if sign > 0 else '-'} s_c; the complementary "
                    f"law, "
                    "on which the text says that it is built, acts along s + s_c", basis="arithmetic")
            )  # fmt: skip
    gains = np.geomspace(1.0, 1e6, 25)
    rates = [float(np.abs(algebra.printed_rules_poles(g).real + 150.0).max()) for g in gains]
    slowest = float(algebra.corrected_rules_poles(SLOPE).real.max())
    return [
        *rows,
        row("fuzzy_printed_poles", "rules 1 to 9", "as printed",
            "real part of the linear poles under the printed rules, its distance from -lam over gains of 1 to 1e6 1/s",
            None, max(rates), "1/s", "<=", 0.01, 0.0, "cannot be checked",
            "no gain adds damping: the other terms of u give all there is; the corrected rules have a pole at "
            f"{-slowest:.2g} 1/s below 0 instead, the slow integral", basis="arithmetic"),
    ]  # fmt: skip


def _corner(loops: Loops) -> list[Claim]:
    rows = []
    known = {"sine_wide": (76.0, 0.101), "sine_slow": (192.0, 0.131)}
    for scenario, (away, near) in known.items():
        for name, wider, digest in (("equal", 1.0, away), ("wide", 20.0, near)):
            changes = scales(120.0 * wider, 1.0)
            run = loops.run("corrected.fsmc", scenario, changes=changes)
            largest = 1e3 * float(np.abs(run["true_error"]).max())
            words = (
                "equal scales of 0.65 rad/s" if wider == 1.0 else "equal scales, universe 20 times as wide, same slope"
            )
            rows.append(
                row(f"fuzzy_dead_corner_{name}_{scenario}", "rules, Figure 10", "as corrected",
                    f"largest error on {WORDS[scenario]} mm, corrected rules, {words}", None, largest, "um", "=",
                    digest, 0.02 * digest, "cannot be checked",
                    "lam^2 xi takes s and s_c to opposite ends, where K is 0" if wider == 1.0 else "no corner is met")
            )  # fmt: skip
    equal = {"controller.scale_sc": 0.65}
    for scenario, digest in (("sine_slow", 0.19), ("sine_wide", 0.21), ("sine_fast", 0.23)):
        run = sine_run(loops, "paper.fsmc", scenario, changes=equal)
        largest = tracked(run, scenario).largest
        rows.append(
            row(f"fuzzy_printed_equal_{scenario}", "rules, Figure 10", "as printed",
                f"largest error on {WORDS[scenario]} mm, printed rules, equal scales", None, largest, "um", "=", digest,
                0.005, "cannot be checked",
                f"limit cycle: the torque travels {tracked(run, scenario).variation:.0f} N m a second at least, and "
                f"the "
                "largest error depends on where one starts to count", "report")
        )  # fmt: skip
    return rows


def _integral(loops: Loops) -> list[Claim]:
    rows = [
        row(f"fuzzy_hold_{rules}_{ratio:g}", "Figure 10, rules", "as printed" if rules == "printed" else "as corrected",
            f"torque that the {rules} rules can hold at rest on the target, S_c = {ratio:g} S, U = 120 N m", None,
            120.0 * hold(rules, ratio), "N m", "=", digest, 0.05, "cannot be checked",
            "largest U K on s = -s_c, where only the integral is left", basis="arithmetic")
        for rules, ratio, digest in (("corrected", 1.0, 0.0), ("corrected", 4.0, 42.63), ("printed", 4.0, 120.0))
    ]  # fmt: skip
    for scenario in ("sine_slow", "sine_wide", "sine_fast"):
        fuzzy = tracked(sine_run(loops, "corrected.fsmc", scenario), scenario).largest
        csmc = tracked(sine_run(loops, "paper.csmc", scenario), scenario).largest
        rows.append(
            row(f"fuzzy_integral_{scenario}", "section 6", "as corrected",
                f"largest error of FSMC with S_c = 4 S in that of CSMC, {WORDS[scenario]} mm", 1.0, fuzzy / csmc, "",
                "<=", 1.0 / 3.0, 0.0, "reproduced with change",
                f"{fuzzy:.3f} against {csmc:.3f} um: K sees lam^2 xi when S_c > S; with equal scales it is far worse")
        )  # fmt: skip
    return rows


def _torque(loops: Loops) -> list[Claim]:
    rows = []
    cases = (
        (30.0, 4.0, 0.05, ">=", 9.0, "required"), (30.0, 16.0, 0.05, ">=", 9.0, "required"),
        (60.0, 4.0, 0.05, "<=", 1e-3, "required"), (60.0, 4.0, 0.02, ">=", 7.0, "required"),
        (60.0, 16.0, 0.02, ">=", 7.0, "report"), (120.0, 4.0, 0.05, "<=", 1e-3, "required"),
        (120.0, 16.0, 0.05, "<=", 1e-3, "required"), (120.0, 4.0, 0.02, "<=", 1e-3, "required"),
        (120.0, 16.0, 0.02, "<=", 1e-3, "required"),
    )  # fmt: skip
    for torque, ratio, seconds, sense, target, kind in cases:
        changes = scales(torque, ratio) | {"reference.duration": seconds}
        run = loops.run("corrected.fsmc", "step_quintic", changes=changes)
        left = 1e3 * abs(float(run["true_error"][-1]))
        stays = left > 1.0
        held = torque * hold("corrected", ratio)
        rows.append(
            row(f"fuzzy_torque_{torque:g}_ratio_{ratio:g}_{1e3 * seconds:g}ms", "section 4.4", "as corrected",
                f"error left by 1 mm in {1e3 * seconds:g} ms, U = {torque:g} N m, S_c = {ratio:g} S", 0.0, left, "um",
                sense, target, 0.0, "not reproduced" if stays else "reproduced with change",  # type: ignore[arg-type]
                f"the rules hold {held:.1f} N m at rest, friction and F_hat move up to "
                f"{np.abs(run['output']).max():.0f}" + (": the stage is left in the dead corner" if stays else ""),
                kind)  # type: ignore[arg-type]
        )  # fmt: skip
    return rows


def _resolution(loops: Loops) -> list[Claim]:
    exact = tail_um(loops.run("corrected.fsmc", "sine_fast", 2.0))[0]
    rough = tail_um(loops.get(ON_101_POINTS, "sine_fast").run(2.0, record=("true_error",)))[0]
    return [
        row("fuzzy_resolution", "section 5", "as corrected",
            "change of the largest error on sin 2 pi t mm by a centroid on 101 points in place of the exact one", None,
            1e3 * abs(rough - exact), "nm", "<=", 0.5, 0.0, "cannot be checked",
            f"{1e3 * rough:.3f} and {1e3 * exact:.3f} nm: Matlab's default is as good"),
    ]  # fmt: skip


def _state_driven(loops: Loops) -> list[Claim]:
    push, damping = HAT.viscous - LuGre().viscous, 3.0 * 150.0 * INERTIA
    rows = [
        row("fuzzy_state_viscous", "Table 2, (10)", "as printed",
            "viscous friction compensated beyond the true one, in the damping of u, 3 lam J", None, push / damping, "",
            ">=", 1.0, 0.0, "cannot be checked",
            f"{push:g} against {damping:.3f} N m s/rad: where K is at its limit the loop is unstable",
            basis="arithmetic")
    ]  # fmt: skip
    cases = ((60.0, 4.0, SLOPE), (120.0, 4.0, SLOPE), (120.0, 16.0, SLOPE), (240.0, 4.0, SLOPE), (240.0, 16.0, SLOPE),
             (240.0, 8.0, SLOPE / 2.0))  # fmt: skip
    for torque, ratio, slope in cases:
        changes = scales(torque, ratio, slope) | {"controller.friction_from": 2}
        run = loops.run("corrected.fsmc", "step_raw", changes=changes, bound=1e5)
        lost = run.diverged is not None
        left = 1e3 * abs(float(run["true_error"][-1]))
        stable = torque > 200.0 and ratio > 4.0
        half = "" if slope == SLOPE else ", half the slope"
        rows.append(
            row(f"fuzzy_state_step_{torque:g}_ratio_{ratio:g}", "section 4.4", "as corrected",
                f"a raw step of 1 mm with f-hat from the measured speed (no sigma1 z'), U = {torque:g} N m, "
                f"S_c = {ratio:g} S{half}", "stable", "diverges" if lost else "stable", "", "yes/no",
                "stable" if stable else "diverges", 0.0, "not reproduced" if lost else "reproduced with change",
                "a bounded output does not guarantee stability" if lost else f"{left:.2f} um left after 0.6 s")
        )  # fmt: skip
    return rows
