"""What the paper says of its controllers in words (sections 4 and 6), turned into numbers.

Sliding mode, ``SMC``, is read twice: with the integral surface of (8) as printed, and conventional, without it, as the
paper's sentences ask for. The printed fuzzy rules are ``paper.fsmc``, the derived ones ``corrected.fsmc``.
"""

from __future__ import annotations

from collections.abc import Iterator

from leadscrew.report.claim import Claim, Group, Sense
from leadscrew.studies.fsmc_ballscrew.claims_bounds import bounds_claims
from leadscrew.studies.fsmc_ballscrew.claims_reversal import reversal_claims
from leadscrew.studies.fsmc_ballscrew.naming import FIGURE, KEY, SAID, WAY, listed, said, whose, worst_first
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES
from leadscrew.studies.fsmc_ballscrew.tracking import Tracked, at_rest, settled_run, sine_run, tracked

TRIOS: dict[Group, tuple[str, str, str]] = {
    "as corrected": ("corrected.smc", "paper.csmc", "corrected.fsmc"),
    "as printed": ("paper.smc", "paper.csmc", "paper.fsmc"),
}
SHORT = {law: key.split("_")[0].upper() for law, key in KEY.items()}
STEPS = ("step_raw", "step_quintic")
SAYS_ORDER = "SMC > CSMC > FSMC"


def paper_claims(loops: Loops) -> list[Claim]:
    """Every qualitative claim about the laws in continuous time."""
    return [
        *_order(loops), *_halves(loops), *_steps(loops), *_rest(loops), *reversal_claims(loops), *_chatter(loops),
        *_growth(loops), *bounds_claims(loops),
    ]  # fmt: skip


def _sine(loops: Loops, law: str, scenario: str) -> Tracked:
    return tracked(sine_run(loops, law, scenario), scenario)


def _left(loops: Loops, law: str, scenario: str) -> float:
    """True error at the end of a step's run, um."""
    return 1e3 * float(abs(loops.run(law, scenario)["true_error"][-1]))


def _order(loops: Loops) -> Iterator[Claim]:
    """SMC has the largest error, FSMC the smallest."""
    for group, laws in TRIOS.items():
        for scenario in (*STEPS, *SINES):
            found = {
                SHORT[law]: _left(loops, law, scenario) if scenario in STEPS else _sine(loops, law, scenario).largest
                for law in laws
            }
            measured = worst_first(found)
            target = SAYS_ORDER if group == "as corrected" else "CSMC > SMC > FSMC"
            what = "error 0.6 s after" if scenario in STEPS else "largest error on"
            yield said(
                f"order_{group.split()[1]}_{scenario}", f"{FIGURE[scenario]}, section 6", group,
                f"order of the {what} {WAY[scenario]}", SAYS_ORDER, measured, "", "order", target, 0.0,
                measured == SAYS_ORDER, listed(found, "um") + (
                    "" if group == "as corrected" else ": the integral of (8) makes SMC better than CSMC"),
                "report" if target != SAYS_ORDER and scenario in STEPS else "required",
            )  # fmt: skip


def _halves(loops: Loops) -> Iterator[Claim]:
    """Complementary sliding mode is at least twice as precise; fuzzy sliding mode best."""
    for scenario in (*SINES, "step_quintic"):
        smc, literal, csmc, fsmc = (
            _left(loops, law, scenario) if scenario in STEPS else _sine(loops, law, scenario).largest
            for law in ("corrected.smc", "paper.smc", "paper.csmc", "corrected.fsmc")
        )
        ratio = smc / csmc
        yield said(
            f"half_{scenario}", "(16), section 4.3", "as corrected", f"error of SMC over that of CSMC, {WAY[scenario]}",
            2.0, ratio, "1", "=", 2.0, 0.4, ratio >= 1.98,
            f"conventional surface: {smc:.3f} against {csmc:.3f} um; with the printed integral {literal:.3g} um",
        )  # fmt: skip
        yield said(
            f"half_integral_{scenario}", "(16), section 4.3", "as printed",
            f"error of SMC with the integral surface over that of CSMC, {WAY[scenario]}", 2.0, literal / csmc, "1",
            "<=", 0.6, 0.0, literal / csmc >= 1.98, f"{literal:.3g} against {csmc:.3f} um",
        )  # fmt: skip
        if scenario in SINES:
            yield said(
                f"fsmc_third_{scenario}", "section 6, section 8", "as corrected",
                f"largest error of FSMC over that of CSMC, {WAY[scenario]}", "significantly better", fsmc / csmc, "1",
                "<=", 1.0 / 3.0, 0.0, fsmc < csmc, f"{fsmc:.4f} against {csmc:.3f} um",
            )  # fmt: skip


def _steps(loops: Loops) -> Iterator[Claim]:
    """SMC keeps a steady error, CSMC and FSMC eliminate it. An error below 1 nm is gone."""
    gone_um = 1e-3
    targets: dict[str, tuple[str, Sense, float, float]] = {
        "corrected.smc": ("a steady error", "=", 0.274, 0.0055), "paper.smc": ("a steady error", "<=", 1e-6, 0.0),
        "paper.csmc": ("eliminated", "=", 0.125, 0.0025), "corrected.fsmc": ("eliminated", "<=", 1e-6, 0.0),
        "paper.fsmc": ("eliminated", "<=", 1e-6, 0.0),
    }  # fmt: skip
    why = {
        "corrected.smc": "held by static friction inside the boundary layer",
        "paper.smc": "the integral of (8) removes it",
        "paper.csmc": "s + s_c has no integral; that of (10) is slow: more than two minutes",
        "corrected.fsmc": "S_c > S lets the rules see the integral", "paper.fsmc": "s - s_c holds the integral",
    }  # fmt: skip
    for law, (says, sense, target, tolerance) in targets.items():
        left = _left(loops, law, "step_quintic")
        raw = _left(loops, law, "step_raw")
        yield said(
            f"step_{KEY[law]}", "Figure 11, section 6", whose(law),
            f"error 0.6 s after {WAY['step_quintic']}, {SAID[law]}", says, left, "um", sense, target, tolerance,
            (left > gone_um) == (says != "eliminated"), f"{why[law]}; after the bare step {raw:.2g} um",
        )  # fmt: skip


def _rest(loops: Loops) -> Iterator[Claim]:
    """The torque at rest: a bent spring under SMC and CSMC, zero and oscillating under FSMC."""
    source = "Figure 11 (b), (d), (f), section 6"
    for law in ("corrected.smc", "paper.csmc"):
        run = loops.run(law, "step_quintic", record=("true_error", "output", "plant.bristle"))
        torque, spring = float(run["output"][-1]), 1e5 * float(run["plant.bristle"][-1])
        yield said(
            f"rest_{KEY[law]}", source, whose(law), f"torque at rest over that of the bent bristles, {SAID[law]}",
            "not zero: a spring", torque / spring, "1", "=", 1.0, 0.001, abs(torque) > 0.1,
            f"{torque:.2f} N m hold bristles bent by {1e6 * spring / 1e5:.1f} urad",
        )  # fmt: skip
    for law in ("corrected.fsmc", "paper.fsmc"):
        held = at_rest(loops.run(law, "step_quintic"))
        yield said(
            f"rest_{KEY[law]}", source, whose(law), f"size of the torque at rest, {SAID[law]}", 0.0, abs(held.mean),
            "N m", ">=", 6.0, 0.0, abs(held.mean) < 0.1, "the bristles stay bent, and the rules bring the error to "
            "zero, not the torque",
        )  # fmt: skip
        yield said(
            f"rest_oscillation_{KEY[law]}", source, whose(law), f"oscillation of the torque at rest, {SAID[law]}",
            "oscillates", held.swing, "N m", "<=", 0.001, 0.0, held.swing > 0.01, "with f_hat from the command",
        )  # fmt: skip
    free = at_rest(settled_run(loops, "corrected.fsmc"))
    reading = "with f_hat from the measured speed, without the bristles' damping"
    yield said(
        "rest_fsmc_measured_speed", source, "as corrected", f"mean torque at rest, FSMC {reading}", 0.0, free.mean,
        "N m", "=", 0.0, 0.1, abs(free.mean) < 0.1, f"a mean over whole cycles of a torque of +-{free.swing:.1f} N m",
    )  # fmt: skip
    yield said(
        "rest_oscillation_fsmc_measured_speed", source, "as corrected", f"oscillation of the torque at rest, FSMC "
        f"{reading}", "oscillates", free.swing, "N m", "=", 4.6, 0.05, free.swing > 0.01,
        f"a limit cycle of {1e3 * free.error:.0f} nm, {free.variation:.0f} N m/s",
    )  # fmt: skip


def _chatter(loops: Loops) -> Iterator[Claim]:
    """SMC's torque chatters, CSMC's less, FSMC's is smooth."""
    for scenario in SINES:
        found = {SHORT[law]: _sine(loops, law, scenario).variation for law in TRIOS["as corrected"]}
        measured, source = worst_first(found), f"{FIGURE[scenario]} (b), (d), (f), section 6"
        yield said(
            f"smooth_{scenario}", source, "as corrected", f"order of the torque's variation, {WAY[scenario]}",
            SAYS_ORDER, measured, "", "order", SAYS_ORDER, 0.0, measured == SAYS_ORDER, listed(found, "N m/s"),
        )  # fmt: skip
        for name in ("SMC", "CSMC"):
            ratio = found[name] / found["FSMC"]
            chatters = ratio > 1.5
            sticks = name == "SMC" and scenario == "sine_slow"
            yield said(
                f"chatter_{name.lower()}_{scenario}", source, "as corrected" if name == "SMC" else "as printed",
                f"variation of {name}'s torque over FSMC's, {WAY[scenario]}", "chatter", ratio, "1",
                ">=" if sticks else "<=", 3.0 if sticks else 1.15, 0.0, chatters,
                "the stage sticks and slips" if chatters else "no chatter without sampling",
            )  # fmt: skip


def _growth(loops: Loops) -> Iterator[Claim]:
    """SMC and CSMC cannot follow the fast sine; FSMC's error does not grow drastically."""
    asked: dict[str, tuple[Sense, float, float]] = {
        "corrected.smc": ("=", 1.16, 0.0232), "paper.csmc": ("=", 1.16, 0.0232), "corrected.fsmc": ("<=", 1.5, 0.0)
    }  # fmt: skip
    for law, row in asked.items():
        wide, fast = (_sine(loops, law, s).largest for s in ("sine_wide", "sine_fast"))
        ratio, fuzzy = fast / wide, law == "corrected.fsmc"
        yield said(
            f"growth_{KEY[law]}", "Figures 13 and 14, section 6", whose(law),
            f"largest error on {WAY['sine_fast']} over that on {WAY['sine_wide']}, {SAID[law]}",
            "does not grow drastically" if fuzzy else "cannot be tracked properly", ratio, "1", *row,
            ratio < 2.0 if fuzzy else ratio > 2.0,
            f"from {wide:.3g} to {fast:.3g} um; strong growth needs sampling",
        )  # fmt: skip
