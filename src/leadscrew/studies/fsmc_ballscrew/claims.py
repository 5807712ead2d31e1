"""What the paper says, in its order. ``as printed`` follows it to the letter; the note says what ``corrected`` changes.

Of the controllers that is: the surface of the sliding mode is e' + lam e, without the integral of (8), and the fuzzy
rules act along s + s_c. In both columns the friction estimate f_hat is driven by the commanded speed, which is our
reading, and the scales of Figure 10 are ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from leadscrew.analysis.circular.synthetic import BallBar
from leadscrew.friction.lugre import TABLE_2, LuGre
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.studies.claims import Measured, Test, at_least, at_most, claim, within
from leadscrew.studies.fsmc_ballscrew import equal, laws
from leadscrew.studies.fsmc_ballscrew.attraction import HOME_UM, LOADS, STEPS_MM, TORQUE, UNKNOWN, hold, reach, region
from leadscrew.studies.fsmc_ballscrew.backlash import (
    GAP_UM,
    HARD,
    MOTOR,
    SOFT,
    TABLE,
    free_change_of_flank_deg,
    impact,
    radius_and_rate,
    reversals_with,
)
from leadscrew.studies.fsmc_ballscrew.circles import (
    CIRCLES,
    FAR_DEG,
    FEEDS_UM_S,
    HZ,
    IDEAL,
    LEAST_UM,
    NEAR_DEG,
    PID,
    SLOW_FSMC,
    both,
    circle_of,
    creep,
    glitch,
    jumps_um,
    radius_um,
    slow_circle,
    trend,
)
from leadscrew.studies.fsmc_ballscrew.friction_experiments import loop_area, peak_after_rest, peak_friction
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES, STEPS, sine_of
from leadscrew.studies.fsmc_ballscrew.tracking import (
    AtRest,
    at_rest,
    elsewhere,
    error_um,
    largest_um,
    left_um,
    place_of_largest,
    rate_rad_s,
    reversal,
    settled_run,
    sine_run,
    tracked,
)
from leadscrew.studies.lab import Lab, measure

CORRECTED = {"SMC": "corrected.smc", "CSMC": "paper.csmc", "FSMC": "corrected.fsmc"}
PRINTED = {"SMC": "paper.smc", "CSMC": "paper.csmc", "FSMC": "paper.fsmc"}
ORDER = "SMC > CSMC > FSMC"
GONE_UM = 0.001
"""A steady error of less is eliminated."""
ZERO_N_M = 0.1
"""A torque of less is zero beside the 6.24 N m of Coulomb friction."""
ONLY_SURFACE = "corrected: surface without the integral of (8)"
BOTH_CHANGES = "corrected: SMC without the integral of (8), rules along s + s_c"
RULES = "corrected: rules along s + s_c"
BOTH_SINES = {"wide": SINES["sine_wide"], "fast": SINES["sine_fast"]}


def um(value: float) -> str:
    """A length for a note."""
    return f"{value:.3g} µm"


# ---- measures
def worst_first(values: Mapping[str, float]) -> str:
    """The names in the order of their values, the largest first."""
    return " > ".join(sorted(values, key=lambda k: values[k], reverse=True))


@measure
def errors_um(lab: Lab, scenario: str) -> tuple[dict[str, float], dict[str, float]]:
    """Errors by law, as printed and corrected: the largest on a sine, what a step leaves."""
    printed, corrected = (
        {name: error_um(lab, law, scenario) for name, law in trio.items()} for trio in (PRINTED, CORRECTED)
    )
    return printed, corrected


def variations(lab: Lab, scenario: str) -> tuple[dict[str, float], dict[str, float]]:
    """Variation of the torque a second by law, as printed and corrected, N m/s."""
    printed, corrected = (
        {name: tracked(lab, law, scenario).variation for name, law in trio.items()} for trio in (PRINTED, CORRECTED)
    )
    return printed, corrected


def resting(lab: Lab, law: str) -> AtRest:
    """What goes on after 1 mm in 50 ms."""
    return at_rest(lab.run(law, "step_quintic"))


def share_of_bound(lab: Lab, law: str, half: float = 1.0) -> tuple[float, float]:
    """Largest |e| and |e'| on the three sines over (13), or over half of it, (16)."""
    e = max(tracked(lab, law, s).largest for s in SINES) / (1e3 * TRAVEL_MM_PER_RAD)
    rate = max(rate_rad_s(sine_run(lab, law, s)) for s in SINES)
    return e / (half * laws.PHI / laws.LAM), rate / (half * 2.0 * laws.PHI)


def share_in_mm(lab: Lab, law: str, half: float = 1.0) -> float:
    """The first of them with phi in mm/s and eta in mm/s^2."""
    p = lab.study.controllers[law].params
    changes = {"controller.boundary": p.boundary / TRAVEL_MM_PER_RAD, "controller.eta": p.eta / TRAVEL_MM_PER_RAD}
    worst = max(tracked(lab, law, s, changes=changes).largest for s in SINES)
    return worst / (1e3 * half * laws.PHI / laws.LAM)


def what_becomes(lab: Lab, law: str, changes: Mapping[str, float | str], bound: float) -> str:
    """Whether a law survives the bare step of 1 mm."""
    return "diverges" if lab.run(law, "step_raw", changes=changes, bound=bound).diverged else "arrives"


def returned_percent(lab: Lab, rules: str) -> float:
    """Share of the starts that end on the target, of those with loads that half of U can hold."""
    inside = np.array(LOADS) <= TORQUE * hold("without_dead_corner", 4.0) - LuGre().static
    return 100.0 * float(region(lab, rules).returned[:, inside].mean())


# ---- 2.1: backlash
@claim(
    "2.1",
    "backlash 1",
    says="hysteresis",
    unit="um",
    basis="reconstructed plant",
    over=BOTH_SINES,
    holds=at_least(LEAST_UM),
)
def backlash_is_hysteresis(lab, sine):
    """Backlash is mechanical hysteresis: table behind its command on the way, motor encoder, {case}"""
    found = reversals_with(lab, "ours.pd_dob", sine.scenario, "play", MOTOR)
    return Measured(found.offset_um, note=f"half of the play of {GAP_UM:g} µm, in either direction")


@claim(
    "2.1, Figure 2",
    "backlash 2",
    says="vibrates",
    unit="1",
    basis="reconstructed plant",
    over=BOTH_SINES,
    holds=at_least(1.0),
)
def impact_vibrates(lab, sine):
    """Almost elastic impact causes transient vibration: settling after a reversal over that of a soft one, {case}"""
    hard, soft = (1e3 * impact(lab, sine.scenario, e).settled_s for e in (HARD, SOFT))
    return Measured(hard / soft, note=f"{hard:.1f} ms with a restitution of {HARD:g}, {soft:.1f} ms with {SOFT:.2f}")


@claim(
    "2.1", "backlash 3", says="90", unit="degrees", basis="reconstructed plant", over=BOTH_SINES, holds=at_least(90.0)
)
def dead_band_covers_the_reversal(lab, sine):
    """The dead band covers the point of zero speed, 90° after the largest: phase at the other flank, {case}"""
    _, rate = radius_and_rate(sine.scenario)
    crossed = impact(lab, sine.scenario, HARD).crossing_s
    return Measured(
        free_change_of_flank_deg(lab, sine.scenario),
        90.0 + math.degrees(rate * crossed),
        note="corrected: guide friction stops the table there; without it the table flies on when the screw slows down",
    )


# ---- 2.2: friction in words
STATIC, DYNAMIC = LuGre().static, LuGre().coulomb


@claim("2.2.1", "friction 1", says="greater", unit="1", basis="paper's data", holds=at_least(1.0 + 1e-9))
def static_is_greater(lab):
    """Static friction is greater than dynamic: F_S over F_C in Table 2"""
    return Measured(STATIC / DYNAMIC)


@claim("2.2.1", "friction 2", says="1", unit="1", basis="paper's data")
def equal_coefficients(lab):
    """Typically μ_s = μ_k: F_S over F_C in Table 2"""
    return Measured(STATIC / DYNAMIC, note="the text asks for static above dynamic friction a paragraph earlier")


@claim("2.2.1", "friction 3", says="grows", unit="N", basis="printed plant", holds=at_least(0.001))
def friction_ages(lab):
    """Static friction depends on the duration of contact: break-away after 10 s of rest less that after 1 s, 1 kg"""
    short, long = (peak_after_rest(lab, rest) for rest in (1.0, 10.0))
    return Measured(long - short, note=f"{long:.4f} N both: (1) to (3) do not age; grows: by 1 mN or more")


@claim("2.2.2", "friction 6", says="none without it", unit="um", basis="printed plant", holds=at_most(LEAST_UM))
def no_stick_slip_without_a_negative_slope(lab):
    """A negative slope is the prerequisite of stick-slip: error peak to peak at 1 µm/s with F_S = F_C, FSMC at 4 kHz"""
    flat, falling = (creep(lab, SLOW_FSMC, 1.0, falling=falls).peak_to_peak_um for falls in (False, True))
    return Measured(None, flat, note=f"corrected: rules along s + s_c, sampled; with the F_S of Table 2 {um(falling)}")


@claim("2.2.2", "friction 7", says="rises", unit="N m s/rad", basis="printed plant", holds=at_least(0.0))
def friction_at_low_speed(lab):
    """At very low speed friction rises with speed: its slope at half the Stribeck speed"""
    slope = laws.friction_slope(0.5 * LuGre().stribeck_speed)
    return Measured(slope, note="by (3) it falls there, which is the Stribeck effect of the paragraph before")


@claim("2.2.2", "friction 7", says="falls", unit="N m s/rad", basis="printed plant", holds=at_most(0.0))
def friction_at_high_speed(lab):
    """At high speed friction falls: its slope at 1 rad/s"""
    return Measured(laws.friction_slope(1.0), note="by (2) it rises with σ₂: the surfaces never separate in the model")


# ---- 2.3: the model
@claim("2.3", "friction 9", basis="arithmetic")
def g_falls_with_speed(lab):
    """G(v) falls monotonically with speed, up to 10 rad/s"""
    return Measured(laws.g_falls())


@claim("2.3", "intro 2", "friction 10", says="variable", unit="%", basis="printed plant", holds=at_least(1.0))
def break_away_varies(lab):
    """The break-away force varies: its fall from a rise of 1 N/s to one of 50 N/s, 1 kg"""
    slow, fast = peak_friction(lab, 1.0), peak_friction(lab, 50.0)
    return Measured(100.0 * (1.0 - fast / slow), note=f"from {slow:.4f} to {fast:.4f} N; varies: by 1 % or more")


@claim("2.3", "intro 2", "friction 10", says="hysteresis", unit="1", basis="printed plant", holds=at_least(1.0))
def friction_has_hysteresis(lab):
    """The model leads to hysteresis: area of friction against speed at 25 rad/s over that at 1 rad/s, 1 kg"""
    return Measured(loop_area(25.0) / loop_area(1.0), note="friction lags the speed, and the more the faster it swings")


# ---- 3: the stage
@claim("3", "stage 1", says="dominates", unit="1", basis="printed plant", holds=at_least(10.0))
def friction_dominates(lab):
    """Friction dominates the system: F_C over the largest torque for acceleration on sin 2πt mm"""
    sine = sine_of("sine_fast")
    torque = INERTIA * sine.amplitude_mm * sine.rate_rad_s**2 / TRAVEL_MM_PER_RAD
    return Measured(DYNAMIC / torque, note=f"{torque:.4f} N·m; dominates: at least ten times as large")


@claim("Table 1", "table 1", says="1.5923", unit="mm/rad", basis="fitted")
def lead(lab):
    """Lead pitch: a lead of 10 mm, which the paper does not name, by 2π"""
    with_3_14 = 10.0 / (2.0 * 3.14)
    return Measured(
        with_3_14,
        math.floor(1e4 * with_3_14) / 1e4,
        note=f"with π as 3.14, and, corrected, cut off; 10 mm / (2π) is {5.0 / math.pi:.5f}",
    )


# ---- 4.2: sliding mode
@claim("(10)", "equation 10", says="0", unit="1", basis="arithmetic")
def binomials(lab):
    """Error of the binomials of (10) against (d/dt + λ)^(n+1) ξ, n = 2, 3, 4"""
    return Measured(
        max(laws.binomial_error(n) for n in (2, 3, 4)), note="s' + λs = Δf + v_c, the form of Liang and Su; x_d is y_r"
    )


@claim("(12), (15)", "equation 12", says="0", unit="1", basis="arithmetic", holds=at_most(1e-12))
def layer_is_reached(lab):
    """The layer of (15) is reached: V' = −λ (s + s_c)² + (s + s_c)(Δf + v_c) for V = (s² + s_c²)/2, relative error"""
    return Measured(laws.lyapunov_residual(), note="V' by the chain rule at 1,000 random states, to rounding")


BOUND_13: dict[str, tuple[int, str]] = {"e": (0, "1"), "rate": (1, "2")}


@claim("(13)", "equation 13", unit="1", basis="arithmetic", over=BOUND_13)
def constants_of_13(lab, which):
    """Largest λ|e|/φ or |e'|/φ that |s| ≤ φ allows"""
    at, says = which
    found = laws.tight_bounds()[at]
    note = "2/e: (13) holds for e and is loose" if at == 0 else "2 + 2/e²: (13) does not hold for e'"
    return Measured(found, says=says, holds=at_most(float(says)), note=note)


@claim("(13)", "equation 13", says="1", unit="1", basis="printed plant", over={"e": 0, "rate": 1}, holds=at_most(1.0))
def smc_keeps_its_bound(lab, at):
    """SMC keeps (13): largest |e| or |e'| on the three sines over its bound, φ in rad/s"""
    printed, corrected = (share_of_bound(lab, law)[at] for law in ("paper.smc", "corrected.smc"))
    return Measured(printed, corrected, note=ONLY_SURFACE)


@claim("(13)", "equation 13", says="1", unit="1", basis="printed plant", holds=at_most(1.0))
def smc_keeps_its_bound_in_mm(lab):
    """SMC keeps (13) with φ and η read in mm: largest |e| over its bound"""
    return Measured(None, share_in_mm(lab, "corrected.smc"), note=ONLY_SURFACE)


# ---- 4.3: complementary sliding mode
@claim("(16)", "equation 16", says="1", unit="1", basis="printed plant", over={"e": 0, "rate": 1}, holds=at_most(1.0))
def csmc_keeps_its_bound(lab, at):
    """CSMC keeps (16): largest |e| or |e'| on the three sines over its bound, φ in rad/s"""
    return Measured(share_of_bound(lab, "paper.csmc", 0.5)[at])


@claim("(16)", "equation 16", says="1", unit="1", basis="printed plant", holds=at_most(1.0))
def csmc_keeps_its_bound_in_mm(lab):
    """CSMC keeps (16) with φ and η read in mm: largest |e| over its bound"""
    return Measured(share_in_mm(lab, "paper.csmc", 0.5))


@claim("after (16)", "half", says="50", unit="%", basis="arithmetic", holds=at_least(50.0), key=True)
def half_of_the_tight_bound(lab):
    """(16) is half of the tight bound of the printed surface: CSMC is at least 50 % more precise"""
    return Measured(
        100.0 * (1.0 - 0.5 / laws.tight_bounds()[0]), note="50 % against φ/λ, the bound of a surface without integral"
    )


@claim(
    "after (16)",
    "half",
    says="2",
    unit="1",
    basis="printed plant",
    over={**SINES, "step_quintic": STEPS["step_quintic"]},
    holds=at_least(2.0),
)
def csmc_halves_the_error(lab, move):
    """{case}: CSMC is at least 50 % more precise, error of SMC over that of CSMC"""
    printed, corrected = errors_um(lab, move.scenario)
    return Measured(
        printed["SMC"] / printed["CSMC"],
        corrected["SMC"] / corrected["CSMC"],
        note=f"{um(corrected['SMC'])} against {um(corrected['CSMC'])}; {ONLY_SURFACE}: "
        f"{100.0 * (1.0 - corrected['CSMC'] / corrected['SMC']):.1f} % more precise",
    )


# ---- 4.4: fuzzy sliding mode
@claim("(17), rules", "equation 17", says="acts", unit="1", basis="arithmetic", holds=at_most(-1.0))
def rules_act_along_the_sum(lab):
    """The rules act along s + s_c, as the CSMC that they are built on: slope of K where s and s_c are equal"""
    printed, corrected = (laws.surface(rules, 1e-6, 1e-6) / 1e-6 for rules in ("printed", "corrected"))
    return Measured(printed, corrected, note="rules 3 and 7 are zero there; corrected: s_c turned round in all nine")


@claim("(17), rules", "equation 17", says="0", unit="1", basis="arithmetic", holds=within(0.0, 1e-6))
def rules_ignore_the_difference(lab):
    """The rules do nothing along s − s_c: slope of K where s and s_c are opposite"""
    printed, corrected = (laws.surface(rules, 1e-6, -1e-6) / 1e-6 for rules in ("printed", "corrected"))
    return Measured(printed, corrected, note=f"{RULES}; zero: to rounding of K")


@claim("4.4", "stability", basis="arithmetic")
def stable_from_every_start(lab):
    """The fuzzy controller is stable: |s| falls from every start for an unknown torque of twice the stiction"""
    printed, corrected, ours = (
        bool(reach(rules, UNKNOWN / TORQUE) < 1.0) for rules in ("printed", "corrected", "without_dead_corner")
    )
    return Measured(printed, corrected, ours, note="each has a corner with K = 0; ours: rules without that corner")


@claim("4.4", "stability", says="100", unit="%", basis="printed plant")
def stable_under_load(lab):
    """The fuzzy controller is stable: starts of 1 µm to 100 mm with loads up to 50 N·m that come back within 0.5 s"""
    found = [returned_percent(lab, rules) for rules in ("printed", "corrected", "without_dead_corner")]
    return Measured.of(
        found,
        note=f"to {HOME_UM:g} µm, {len(STEPS_MM)} starts, S_c = 4 S; {RULES}, with a dead corner; ours: without it",
    )


@claim("4.4", "stability", says="stable", unit="um", basis="printed plant", holds=at_most(10.0))
def stable_with_equal_scales(lab):
    """The fuzzy controller is stable: largest error on 5 sin t mm with S_c = S"""
    printed, corrected = (
        1e3 * float(np.abs(lab.run(law, "sine_wide", changes=laws.scales(120.0, 1.0))["true_error"]).max())
        for law in ("paper.fsmc", "corrected.fsmc")
    )
    return Measured(
        printed, corrected, note="stable: stays within 10 µm; the corrected rules lose the stage in their dead corner"
    )


@claim("4.4", "stability", says="arrives", basis="printed plant")
def stable_with_the_measured_speed(lab):
    """The fuzzy controller is stable: bare step with f̂ from the measured speed, without σ₁ dz/dt, U = 120 N·m"""
    changes = laws.scales(120.0, 4.0) | {"controller.friction_from": "measured_undamped"}
    printed, corrected = (what_becomes(lab, law, changes, 1e5) for law in ("paper.fsmc", "corrected.fsmc"))
    return Measured(
        printed, corrected, note="a bounded output guarantees nothing: σ₂ is believed three times too large"
    )


@claim("4.4, (10)", "stability", says="arrives", basis="printed plant", key=True)
def stable_by_the_letter(lab):
    """f̂ by the letter, σ₁ dz/dt of the measured speed included: the fuzzy controller is stable on a bare step"""
    printed, corrected = (
        what_becomes(lab, law, {"controller.friction_from": "measured"}, 1e3)
        for law in ("paper.fsmc", "corrected.fsmc")
    )
    growth = 1e6 / laws.feedback_growth()
    return Measured(printed, corrected, note=f"σ̂₁ is twice σ₁: a stuck stage runs away, e-fold every {growth:.1f} µs")


@claim("4.4", "no information", says="0", unit="um", basis="printed plant", holds=at_most(GONE_UM))
def no_information_is_needed(lab):
    """No information about uncertainties is needed: error left by 1 mm in 50 ms with U = 30 N·m"""
    return Measured(None, fuzzy_torque_um(lab, 30.0, 4.0, 0.05), note="U has to exceed what friction may ask for")


@measure
def fuzzy_torque_um(lab: Lab, torque: float, ratio: float, seconds: float) -> float:
    """Error left by 1 mm in some time with ``U = torque``, ``S_c = ratio S``, um."""
    changes = laws.scales(torque, ratio) | {"reference.duration": seconds}
    return 1e3 * abs(float(lab.run("corrected.fsmc", "step_quintic", changes=changes)["true_error"][-1]))


# ---- 5: parameters
@claim(
    "Table 2", "table 2", "bound F", says="0", basis="paper's data", over={"sigma0": "stiffness", "sigma1": "damping"}
)
def bound_is_the_difference(lab, name):
    """F~ covers what f̂ misses: its {case} less the difference of f̂ and plant"""
    plant, hat, tilde = (getattr(TABLE_2[column], name) for column in ("plant", "hat", "tilde"))
    return Measured(hat - plant - tilde)


@claim(
    "Table 2",
    "table 2",
    "bound F",
    says="covers",
    unit="1",
    basis="paper's data",
    over={"sigma2": "viscous", "vs": "stribeck_speed"},
    holds=at_least(1.0),
)
def bound_covers_the_difference(lab, name):
    """F~ covers what f̂ misses: its {case} over the difference of f̂ and plant"""
    plant, hat, tilde = (getattr(TABLE_2[column], name) for column in ("plant", "hat", "tilde"))
    return Measured(tilde / (hat - plant))


@claim(
    "5, Table 2",
    "robust hats",
    says="uncertain enough",
    unit="1",
    basis="paper's data",
    holds=at_least(0.01),
    key=True,
)
def friction_is_uncertain(lab):
    """F_C and F_S are uncertain enough to show robustness: their largest relative error in f̂ and F~"""
    plant = TABLE_2["plant"]
    off = [
        abs(getattr(TABLE_2[column], name) / getattr(plant, name) - 1.0)
        for column in ("hat", "tilde")
        for name in ("coulomb", "static")
    ]
    return Measured(max(off), note="the main part of the friction is known exactly; see robustness")


# ---- 6: the step, Figure 11
@claim(
    "6, Figures 11 to 14",
    "title",
    "step 1",
    "conclusion 1",
    says=ORDER,
    basis="printed plant",
    over={**STEPS, **SINES},
    key=True,
)
def order_of_errors(lab, move):
    """{case}: SMC has the largest error, FSMC the smallest"""
    printed, corrected = errors_um(lab, move.scenario)
    values = ", ".join(f"{law} {um(value)}" for law, value in corrected.items())
    return Measured(worst_first(printed), worst_first(corrected), note=f"{values}; {BOTH_CHANGES}")


STEADY = Test("steady error", lambda value: value > GONE_UM)


@claim(
    "6, Figure 11", "step 2", "intro 1", says="steady error", unit="um", basis="printed plant", over=STEPS, holds=STEADY
)
def smc_leaves_an_error(lab, move):
    """SMC leaves a steady error: 0.6 s after {case}"""
    printed, corrected = (left_um(lab, law, move.scenario) for law in ("paper.smc", "corrected.smc"))
    return Measured(printed, corrected, note=f"the printed surface has an integral; {ONLY_SURFACE}; error: over 1 nm")


@claim("6, Figure 11", "step 2", says="eliminated", unit="um", basis="printed plant", holds=at_most(GONE_UM), key=True)
def csmc_eliminates_it(lab):
    """CSMC eliminates it: 0.6 s after 1 mm in 50 ms"""
    return Measured(
        left_um(lab, "paper.csmc", "step_quintic"),
        note="s + s_c has no integral, that of (10) takes minutes against the bristles; eliminated: 1 nm or less",
    )


@claim("6, Figure 11", "step 2", says="eliminated", unit="um", basis="printed plant", holds=at_most(GONE_UM))
def fsmc_eliminates_it(lab):
    """FSMC eliminates it: 0.6 s after 1 mm in 50 ms"""
    printed, corrected = (left_um(lab, law, "step_quintic") for law in ("paper.fsmc", "corrected.fsmc"))
    return Measured(printed, corrected, note="the rules see the integral; eliminated: 1 nm or less")


@claim(
    "6, Figure 11 (b), (d)",
    "step 3",
    says="1",
    unit="1",
    basis="printed plant",
    over={"smc": "SMC", "csmc": "CSMC"},
    holds=within(1.0, 0.001),
)
def rest_is_a_spring(lab, name):
    """{case} holds the friction's spring at rest: torque over that of the bristle deflection, to a thousandth"""

    def ratio(law: str) -> float:
        run = lab.run(law, "step_quintic")
        return float(run["output"][-1] / (LuGre().stiffness * run["plant.bristle"][-1]))

    if name == "CSMC":
        return Measured(ratio("paper.csmc"))
    return Measured(ratio("paper.smc"), ratio("corrected.smc"), note=ONLY_SURFACE)


SPEEDS = {"commanded": "Commanded", "measured": "Measured"}
"""Speed that drives f̂."""


def fsmc_at_rest(lab: Lab, speed: str) -> tuple[AtRest | None, AtRest]:
    """FSMC at rest, as printed and corrected; with f̂ from the measured speed corrected alone."""
    if speed == "Measured":
        return None, at_rest(settled_run(lab, "corrected.fsmc"))
    return resting(lab, "paper.fsmc"), resting(lab, "corrected.fsmc")


@claim(
    "6, Figure 11 (f)",
    "step 4",
    says="0",
    unit="N m",
    basis="printed plant",
    over=SPEEDS,
    holds=at_most(ZERO_N_M),
    key=True,
)
def fsmc_torque_at_rest(lab, speed):
    """{case} f̂: FSMC sets the control to zero at rest, size of its mean torque"""
    printed, corrected = fsmc_at_rest(lab, speed)
    return Measured(
        printed and abs(printed.mean),
        abs(corrected.mean),
        note="the bristles stay deflected and must be held"
        if printed
        else "the mean of a limit cycle; zero: below 0.1 N·m",
    )


@claim(
    "6, Figure 11 (f)",
    "step 4",
    "intro 1",
    says="oscillates",
    unit="N m",
    basis="printed plant",
    over=SPEEDS,
    holds=at_least(0.01),
)
def fsmc_oscillates_at_rest(lab, speed):
    """{case} f̂: the control of FSMC oscillates at rest, half of its peak to peak"""
    printed, corrected = fsmc_at_rest(lab, speed)
    note = f"a limit cycle of {1e3 * corrected.error:.0f} nm" if printed is None else "it is at rest"
    return Measured(printed and printed.swing, corrected.swing, note=f"{note}; {RULES}; oscillates: 10 mN·m or more")


# ---- 6: the sines, Figures 12 to 14
@claim(
    "6, Figures 12 to 14 (b)",
    "sine 1",
    says="chatter",
    unit="1",
    basis="printed plant",
    over=SINES,
    holds=at_least(1.5),
)
def smc_chatters(lab, move):
    """SMC's torque fluctuates and chatters: its variation over FSMC's, {case}"""
    printed, corrected = variations(lab, move.scenario)
    return Measured(
        printed["SMC"] / printed["FSMC"],
        corrected["SMC"] / corrected["FSMC"],
        note="no chatter without sampling but on the slow sine, where the stage sticks and slips; chatters: 1.5 times",
    )


@claim("6, Figure 14", "sine 2", says="not followed", unit="1", basis="printed plant", holds=at_least(2.0))
def smc_cannot_follow(lab):
    """SMC cannot follow the fast sine: largest error on sin 2πt mm over that on 5 sin t mm"""
    fast, wide = errors_um(lab, "sine_fast"), errors_um(lab, "sine_wide")
    return Measured.of(
        (f["SMC"] / w["SMC"] for f, w in zip(fast, wide, strict=True)),
        note=f"not followed: twice the error or more; {ONLY_SURFACE}; sampled at 4 kHz it fails",
    )


@claim("6, Figures 12 to 14 (c)", "sine 3", says="0", unit="1", basis="printed plant", over=SINES, holds=at_most(0.05))
def csmc_peaks_at_reversals(lab, move):
    """CSMC's error peaks at reversals: where it is largest, from one (0) to the next (1), {case}"""
    return Measured(
        place_of_largest(sine_run(lab, "paper.csmc", move.scenario), move.scenario),
        note="largest where the believed viscous torque is farthest off, at full speed, or on the Stribeck curve; "
        "at a reversal: within a twentieth of the way",
    )


@claim(
    "6, Figures 12 to 14 (d)",
    "sine 3",
    says="chatter",
    unit="1",
    basis="printed plant",
    over=SINES,
    holds=at_least(1.5),
)
def csmc_chatters(lab, move):
    """CSMC's torque fluctuates and chatters: its variation over FSMC's, {case}"""
    printed, corrected = variations(lab, move.scenario)
    return Measured(
        printed["CSMC"] / printed["FSMC"],
        corrected["CSMC"] / corrected["FSMC"],
        note=f"no chatter without sampling; {RULES}; chatters: 1.5 times",
    )


@claim("6, Figure 14", "sine 4", says="not followed", unit="1", basis="printed plant", holds=at_least(2.0))
def csmc_cannot_follow(lab):
    """CSMC cannot follow the fast sine: largest error on sin 2πt mm over that on 5 sin t mm"""
    fast, wide = (errors_um(lab, s)[0]["CSMC"] for s in ("sine_fast", "sine_wide"))
    return Measured(fast / wide, note=f"from {um(wide)} to {um(fast)}; not followed: twice the error or more")


@claim("6, Figures 12 to 14 (e)", "sine 5", says="0", unit="1", basis="printed plant", over=SINES, holds=at_most(0.1))
def fsmc_errs_at_reversals_only(lab, move):
    """FSMC errs at reversals only: largest error elsewhere over the peak at a reversal, {case}"""
    runs = (sine_run(lab, law, move.scenario) for law in ("paper.fsmc", "corrected.fsmc"))
    return Measured.of(
        (elsewhere(run, move.scenario) / reversal(run, move.scenario).peak for run in runs),
        note=f"the integral lags the viscous torque; {RULES}; only: a tenth of the peak or less elsewhere",
    )


@claim(
    "6, Figures 12 to 14 (e)",
    "sine 5",
    says="0.1",
    unit="s",
    basis="printed plant",
    over=SINES,
    holds=at_most(0.1),
)
def fsmc_damps_the_peak(lab, move):
    """FSMC damps it in less than 0.1 s: time until the error stays within a tenth of its peak, {case}"""
    printed, corrected = (
        reversal(sine_run(lab, law, move.scenario), move.scenario) for law in ("paper.fsmc", "corrected.fsmc")
    )
    note = f"{corrected.peak:.1f} nm at the peak; {RULES}"
    return Measured(printed.settled, corrected.settled, note=note)


@claim("6, Figures 12 to 14 (f)", "sine 5", "conclusion 1", says=ORDER, basis="printed plant", over=SINES)
def order_of_the_torques(lab, move):
    """FSMC's torque is the smoothest: order of the variation of the torque, {case}"""
    printed, corrected = variations(lab, move.scenario)
    values = ", ".join(f"{law} {value:.3g}" for law, value in corrected.items())
    return Measured(worst_first(printed), worst_first(corrected), note=f"{values} N·m/s; {BOTH_CHANGES}")


@claim(
    "6, Figure 14",
    "sine 6",
    "conclusion 1",
    says="not drastically",
    unit="1",
    basis="printed plant",
    holds=at_most(2.0),
)
def fsmc_follows(lab):
    """FSMC's error does not grow drastically: largest error on sin 2πt mm over that on 5 sin t mm"""
    fast, wide = errors_um(lab, "sine_fast"), errors_um(lab, "sine_wide")
    return Measured.of(
        (f["FSMC"] / w["FSMC"] for f, w in zip(fast, wide, strict=True)), note=f"{RULES}; drastically: more than twice"
    )


# ---- 7: circles
@claim(
    "7.2, after Figure 14",
    "sine 5",
    says="0.1",
    unit="s",
    basis="printed plant",
    over={"r5": CIRCLES["r5"], "r1": CIRCLES["r1"]},
    holds=at_most(0.1),
)
def fsmc_damps_the_glitch(lab, way):
    """FSMC damps stick motion in less than 0.1 s: longest quadrant glitch, {case}"""
    printed, corrected = (glitch(circle_of(lab, law, way)).lasts_s for law in ("paper.fsmc", "corrected.fsmc"))
    return Measured(printed, corrected, note=f"until the radius stays within a tenth of the peak; {RULES}")


COMPENSATED = "corrected: rules along s + s_c at 4 kHz, our gains (ours.fsmc_4khz); 2 µm of play, classical model"


@claim(
    "7.2, Figure 19",
    "encoder 1",
    says="0",
    unit="um",
    basis="reconstructed plant",
    over=BOTH_SINES,
    holds=at_most(LEAST_UM),
)
def linear_encoder_compensates(lab, sine):
    """With a linear encoder the reversal error is compensated: step of the table that stays, {case}"""
    return Measured(
        None,
        reversals_with(lab, "ours.fsmc_4khz", sine.scenario, "play", TABLE).offset_um,
        note=f"{COMPENSATED}; compensated: one count of 10 nm or less",
    )


@claim("7.2, Figure 19", "encoder 2", says="takes time", unit="ms", basis="reconstructed plant", holds=at_least(0.25))
def compensation_takes_time(lab):
    """The compensation takes a certain time: from the reversal of 5 sin t mm until within 0.1 µm"""
    found = reversals_with(lab, "ours.fsmc_4khz", "sine_wide", "play", TABLE)
    return Measured(None, 1e3 * found.duration_s, note=f"{COMPENSATED}; takes time: more than a period")


@claim(
    "7.2, Figure 19",
    "encoder 2",
    says="peaks",
    unit="1",
    basis="reconstructed plant",
    over=BOTH_SINES,
    holds=at_least(1.0),
)
def compensation_leaves_peaks(lab, sine):
    """Peaks remain at the reversals: largest error over that without play, {case}"""
    with_play = reversals_with(lab, "ours.fsmc_4khz", sine.scenario, "play", TABLE).height_um
    without = largest_um(lab, "ours.fsmc_4khz", sine.scenario)
    return Measured(None, with_play / without, note=f"{um(with_play)} against {um(without)}; {COMPENSATED}")


KAKINO = "decreases, then eliminated"


@claim("7.2, Figure 20", "stick-slip 1", says=KAKINO, basis="printed plant")
def stick_slip_ends(lab):
    """With rising feed stick-slip decreases and is eliminated: error from 2 to 10 µm/s"""
    fsmc, pid = (
        trend([creep(lab, law, feed).peak_to_peak_um for feed in FEEDS_UM_S if feed >= 2.0]) for law in (SLOW_FSMC, PID)
    )
    return Measured(None, fsmc, pid, note="corrected: rules along s + s_c at 4 kHz; ours: a PID without a model")


@claim(
    "7.2, Figure 20",
    "stick-slip 1",
    says="at the axes",
    unit="um",
    basis="printed plant",
    over={"near": "near", "far": "far"},
)
def stick_slip_is_at_the_axes(lab, where):
    """Stick-slip shows where an axis is slow: largest jump between points {case} from 0, 90, 180 and 270°"""
    degrees, change = jumps_um(slow_circle(lab))
    near, far = float(change[degrees < NEAR_DEG].max()), float(change[degrees > FAR_DEG].max())
    rule = Test("ten times", lambda value: near >= 10.0 * far)
    return Measured(
        None,
        near if where == "near" else far,
        holds=rule,
        note=f"within {NEAR_DEG:g}° and beyond {FAR_DEG:g}°; R = 0.1 mm at 20 µm/s, FSMC at 4 kHz; at the axes: ten "
        "times the jumps elsewhere",
    )


@claim(
    "7.2",
    "stick-slip 2",
    says="not seen",
    basis="printed plant",
    over={"smc": "corrected.smc", "csmc": "paper.csmc", "fsmc": "corrected.fsmc"},
)
def stick_slip_without_sampling(lab, law):
    """Stick-slip cannot be seen in the simulation: constant feed of 1 µm/s, {case} without sampling"""
    run = creep(lab, law, 1.0)
    seen = "seen" if run.fastest > 10.0 else "not seen"
    note = f"speed up to {run.fastest:.3g} times the feed; seen: more than ten times"
    return Measured(seen, note=note) if law.startswith("paper.") else Measured(None, seen, note=note)


@claim("7.2", "stick-slip 2", says="0", unit="um", basis="printed plant", holds=at_most(LEAST_UM))
def stick_slip_at_4_khz(lab):
    """Stick-slip cannot be seen in the simulation: error peak to peak at 1 µm/s and 4 kHz"""
    fsmc, pid = (creep(lab, law, 1.0).peak_to_peak_um for law in (SLOW_FSMC, PID))
    return Measured(
        None, fsmc, pid, note="corrected: rules along s + s_c; ours: a PID without a model; seen: over 10 nm"
    )


@claim(
    "7.2, Figure 21",
    "radius",
    says="smaller",
    basis="printed plant",
    over={"smc": "corrected.smc", "csmc": "paper.csmc", "fsmc": "corrected.fsmc"},
)
def circle_shrinks(lab, law):
    """The circle shrinks with the feed: its radius from 0.1 to 10 turns a second, R = 1 mm, {case}"""

    def change(name: str) -> str:
        return "smaller" if radius_um(lab, name, HZ[-1]) < radius_um(lab, name, HZ[0]) else "larger"

    slow, fast = (radius_um(lab, law, hz) for hz in (HZ[0], HZ[-1]))
    note = f"D from {slow:.4f} to {fast:.3f} µm; made by the viscous friction that is believed three times too large"
    if law.startswith("paper."):
        return Measured(change(law), note=note)
    return Measured(None, change(law), change("fsmc_undamped") if "fsmc" in law else None, note=note)


# ---- 8: conclusion
@claim("8", "conclusion 1", says="significantly", unit="1", basis="printed plant", over=SINES, holds=at_most(0.5))
def fsmc_improves(lab, move):
    """{case}: FSMC significantly improves accuracy, its largest error over that of CSMC"""
    printed, corrected = errors_um(lab, move.scenario)
    return Measured(
        printed["FSMC"] / printed["CSMC"],
        corrected["FSMC"] / corrected["CSMC"],
        note=f"{um(corrected['FSMC'])} against {um(corrected['CSMC'])}; {RULES}; significantly: half or less",
    )


FIGURES = {
    15: "Kakino et al., 1993", 16: "Kakino et al., 1993", 17: "Kakino et al., 1993", 18: "Kakino et al., 1993",
    19: "BS ISO 230-4, 1996", 20: "Kakino et al., 1993", 21: "BS ISO 230-4, 1996",
}  # fmt: skip
"""Whose the figures of section 7 are, by their captions."""


@claim("8", "conclusion 2", says="validated", unit="1", basis="paper's data", holds=at_least(1.0), key=True)
def ball_bar_readings_shown(lab):
    """Ball-bar experiments validate the results: figures of section 7 with measurements of the authors"""
    own = [number for number, source in FIGURES.items() if not source]
    return Measured(len(own), note=f"all {len(FIGURES)} are by Kakino (1993) or ISO 230-4 (1996), by their captions")


@claim("8, 7.1", "conclusion 2", "ball bar", says="validated", unit="um", basis="printed plant", holds=at_least(0.1))
def ball_bar_tells_them_apart(lab):
    """A bar with a resolution of 0.1 µm can validate the comparison: range of G(b) of the three laws, R = 5 mm"""
    true = [both(circle_of(lab, law, CIRCLES["r5"])).circular for law in IDEAL]
    return Measured(
        None, max(true) - min(true), note=f"less than a count of {BallBar().resolution_um:g} µm; {BOTH_CHANGES}"
    )


# ---- the whole study in four sentences
def conclusion(lab: Lab) -> list[str]:
    """The study in four sentences."""
    half = errors_um(lab, "sine_wide")[1]
    left, held = left_um(lab, "paper.csmc", "step_quintic"), resting(lab, "corrected.fsmc").mean
    slow = reversal(sine_run(lab, "corrected.fsmc", "sine_slow"), "sine_slow").settled
    periods, slope = laws.longest_periods_us(), laws.printed_slopes()["FSMC"]
    steep = tracked(lab, "paper.smc", "sine_wide", changes={"controller.layer_rate": slope}).largest
    tuned = {
        law: equal.searched_um(law) for law in ("fsmc", "csmc", "smc_integral", "pid_friction", "pd_dob", "pid_bare")
    }
    return [
        f"On the printed stage, simulated and rigid, the order SMC > CSMC > FSMC follows from the gains, not from the "
        f"rules: on 5 sin t mm CSMC errs {half['SMC'] / half['CSMC']:.2f} times less than SMC (without the printed "
        f"integral) and FSMC {half['CSMC'] / half['FSMC']:.1f} times less than CSMC, but with the slope of FSMC in the "
        f"layer, {slope:.3g} 1/s, SMC with the integral of (8), which FSMC has, errs {steep:.4f} µm against "
        f"{half['FSMC']:.4f} µm of FSMC.",
        f"CSMC does not eliminate its steady error ({um(left)} are left), FSMC does not set its torque to zero "
        f"({abs(held):.1f} N·m hold the deflected bristles), and on 0.01 sin t mm its peak takes {1e3 * slow:.0f} ms, "
        "not less than 100.",
        f"The printed gains must be sampled every {min(periods.values()):.1f} to {max(periods.values()):.0f} µs, which "
        "the paper does not state; the ball bar of section 7 could not tell the three laws apart.",
        f"At 4 kHz, tuned by equal searches for friction within 20 %, FSMC errs {tuned['fsmc']:.1f} µm at most on 24 "
        f"other stages, CSMC {tuned['csmc']:.1f}, the integral law (a PID in its layer) {tuned['smc_integral']:.1f}, "
        f"a PID with the same friction model {tuned['pid_friction']:.1f}, one without a model {tuned['pid_bare']:.1f}, "
        f"and a PD with an observer and gains scheduled by speed {tuned['pd_dob']:.2f} µm.",
    ]
