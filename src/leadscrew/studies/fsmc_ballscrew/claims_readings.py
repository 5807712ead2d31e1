"""Claims about how the paper can be read: units, f_hat, F~, the bounds (13) and (16), and the plant by itself."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from leadscrew.friction.lugre import HAT, LuGre, steady_friction
from leadscrew.kernel.loop import DivergenceWarning
from leadscrew.plants.ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD
from leadscrew.report.claim import Basis, Claim, Group, Kind, Sense, Verdict
from leadscrew.studies.fsmc_ballscrew import algebra
from leadscrew.studies.fsmc_ballscrew.readings import COMPLEMENTARY, CONVENTIONAL, LITERAL, SLOTINE, held_loop, read_as
from leadscrew.studies.fsmc_ballscrew.runs import Loops
from leadscrew.studies.fsmc_ballscrew.tracking import sine_run, tracked

SINES = ("sine_slow", "sine_wide", "sine_fast")
WORDS = {"sine_slow": "0.01 sin t", "sine_wide": "5 sin t", "sine_fast": "sin 2 pi t"}
LAW_WORDS = {"corrected.smc": "SMC, conventional", "paper.csmc": "CSMC"}
ETA = {"corrected.smc": 120.0, "paper.csmc": 20.0}
UM_PER_RAD = 1e3 * TRAVEL_MM_PER_RAD

SHORT = {"sine_slow": (8.4, 3.0, 2e-4), "sine_wide": (5.2, 3.0, 2e-4), "sine_fast": (1.5, 0.6, 1e-4)}
"""Length of a run, from when it counts, and interval between samples, s."""

UNITS: dict[str, tuple[str, dict[str, tuple[float, float, float]]]] = {
    "rad": ("rad, u in rad/s^2", {"corrected.smc": (0.377, 0.283, 0.327), "paper.csmc": (0.161, 0.142, 0.164)}),
    "mm": ("mm, u in mm/s^2", {"corrected.smc": (0.204, 0.178, 0.206), "paper.csmc": (0.100, 0.089, 0.103)}),
    "torque": ("rad, K = F~ + eta in N m", {"corrected.smc": (0.023, 0.021, 0.026), "paper.csmc": (0.049, 0.045,
    0.055)}), "mixed": (
        "K = F~ in N m + eta, taken as rad/s^2",
        {"corrected.smc": (8995.0, 9021.0, 1793.0), "paper.csmc": (192.0, 4.6, 26.0)},
    ),
}  # fmt: skip
"""Readings of the units of u and K, and the largest errors in um that the digest has for them, on :data:`SINES`."""


def row(
    name: str,
    source: str,
    group: Group,
    statement: str,
    paper: float | str | None,
    measured: float | str,
    unit: str,
    sense: Sense,
    target: float | str | None,
    tolerance: float,
    verdict: Verdict,
    reason: str,
    kind: Kind = "required",
    basis: Basis = "printed plant",
) -> Claim:
    """A claim of this study; where the paper says nothing, nothing of it can be checked."""
    value = measured if isinstance(measured, str) else float(measured)
    judged: Verdict = "cannot be checked" if paper is None else verdict
    return Claim(
        f"fsmc_ballscrew.{name}", source, group, basis, statement, paper, value, unit, sense, target, tolerance, kind,
        judged, reason,
    )  # fmt: skip


def unit_changes(reading: str, law: str) -> dict[str, float]:
    """Parameters of a law in rad that mean the paper's numbers in the units of a reading."""
    if reading == "mm":
        return {"controller.boundary": 0.1 / TRAVEL_MM_PER_RAD, "controller.eta": ETA[law] / TRAVEL_MM_PER_RAD}
    if reading == "torque":
        return {"controller.eta": ETA[law] / INERTIA}
    if reading == "mixed":
        sizes = {"coulomb": 6.24, "static": 9.36, "viscous": 1.0}
        return {f"controller.bound.{name}": INERTIA * size for name, size in sizes.items()}
    return {}


def readings_claims(loops: Loops) -> list[Claim]:
    """Units, f_hat, F~, algebra, and the eigenvalues of the plant."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DivergenceWarning)
        return [*_plant(), *_bounds(loops), *_units(loops), *_f_hat(loops), *_f_tilde(loops), *_forms(loops)]


# ---- units
def _largest(loops: Loops, law: str, scenario: str, changes: dict[str, float]) -> float:
    """Largest error, um; a changed law runs over one reversal of what counts of the sine."""
    if not changes:
        return tracked(sine_run(loops, law, scenario), scenario).largest
    seconds, first, sample = SHORT[scenario]
    run = loops.run(law, scenario, seconds, changes=changes, sample=sample)
    return 1e3 * float(np.abs(run["true_error"][run["time"] >= first]).max())


def _units(loops: Loops) -> list[Claim]:
    rows = []
    for reading, (words, known) in UNITS.items():
        found = {
            law: [_largest(loops, law, s, unit_changes(reading, law)) for s in SINES] for law in ("corrected.smc",
            "paper.csmc")
        }  # fmt: skip
        for law, values in found.items():
            for scenario, value, digest in zip(SINES, values, known[law], strict=True):
                lost = digest > 100.0
                rows.append(
                    row(f"reading_unit_{reading}_{law.split('.')[1]}_{scenario}", "sections 4.2, 6", "as printed",
                        f"largest error on {WORDS[scenario]} mm, {LAW_WORDS[law]}, read as {words}", None, value, "um",
                        "=", digest, max(0.02 * digest, 1e-3 if digest < 0.05 else 0.0), "cannot be checked",
                        "the gain is a thousandth of what friction asks for: the stage stays behind, and how far "
                        "depends "
                        "on when it sticks" if lost else "the paper prints no unit of u, K and phi",
                        "report" if lost else "required")
                )  # fmt: skip
        ratios = [a / b for a, b in zip(found["corrected.smc"], found["paper.csmc"], strict=True)]
        half = all(1.6 <= r <= 2.4 for r in ratios)
        rows.append(
            row(f"reading_unit_{reading}_ratio", "after (16)", "as printed",
                f"smallest error of SMC in those of CSMC over the three sines, read as {words}", 2.0, min(ratios), "",
                "=", 2.0, 0.4, "reproduced with change" if half else "not reproduced",
                f"ratios {ratios[0]:.3g}, {ratios[1]:.3g}, {ratios[2]:.3g}; with the surface of SMC conventional",
                "required" if reading in ("rad", "mm") else "report")
        )  # fmt: skip
    rows.append(
        row("reading_eta_torque", "section 6", "as printed", "eta = 120 rad/s^2 as a torque", None, 120.0 * INERTIA,
            "N m", "=",
            0.0444, 1e-4, "cannot be checked", "against 6.24 N m of friction: as an acceleration eta hardly matters",
            basis="arithmetic")
    )  # fmt: skip
    return rows


# ---- f_hat
def _f_hat(loops: Loops) -> list[Claim]:
    growth = algebra.feedback_growth()
    rows = [
        row("reading_state_damping", "(10), Table 2", "as printed",
            "damping that f-hat of the measured speed adds beyond that of the true bristles", None,
            HAT.damping - LuGre().damping, "N m s/rad", "=", 316.0, 0.5, "cannot be checked",
            "sigma1-hat is twice sigma1: the feed-back of friction is negative damping", basis="arithmetic"),
        row("reading_state_growth", "(10), Table 2", "as printed",
            "growth rate of a stuck stage under that f-hat alone", None, growth, "1/s", "=", 8.5e5, 1e4,
            "cannot be checked", f"e-fold every {1e6 / growth:.1f} us, until the bristles are bent",
            basis="arithmetic"),
    ]  # fmt: skip
    rows += _by_the_letter(loops)
    known = {
        "corrected.smc": (0.259, 0.283, 0.510), "paper.csmc": (0.160, 0.142, 0.329), "corrected.fsmc": (0.111, 0.070,
        0.162),
    }  # fmt: skip
    for law, digests in known.items():
        for scenario, digest in zip(SINES, digests, strict=True):
            value = _largest(loops, law, scenario, {"controller.friction_from": 2})
            plain = _largest(loops, law, scenario, {})
            rows.append(
                row(f"reading_state_no_s1_{law.split('.')[1]}_{scenario}", "(10)", "as corrected",
                    f"largest error of {law} on {WORDS[scenario]} mm, f-hat from the measured speed without sigma1 z'",
                    None, value, "um", "=", digest, 0.02 * digest, "cannot be checked",
                    f"works in continuous time, as a part of the loop; from the commanded speed it is {plain:.3f} um")
            )  # fmt: skip
    return rows


def _by_the_letter(loops: Loops) -> list[Claim]:
    letter = {"controller.friction_from": 3}
    rows = []
    for law in ("corrected.fsmc", "paper.fsmc"):
        run = loops.run(law, "step_raw", changes=letter, bound=1e3)
        lost = "diverges" if run.diverged is not None else "stays"
        after = 1e3 * run.diverged.time if run.diverged is not None else float("nan")
        rows.append(
            row(f"reading_state_{law.replace('.', '_')}_step", "(10), Figure 11", "as printed",
                f"{law} on a step of 1 mm with f-hat by the letter, sigma1 z' of the measured speed included",
                "arrives",
                lost, "", "yes/no", "diverges", 0.0, "not reproduced" if lost == "diverges" else "reproduced",
                f"a metre away after {after:.1f} ms; no bounded fuzzy output holds the feed-back of friction")
        )  # fmt: skip
    torques = {
        law: float(np.abs(loops.run(law, "sine_wide", 4.0, changes=letter, sample=1e-4)["output"]).max())
        for law in ("corrected.smc", "paper.csmc", "corrected.fsmc")
    }
    rows.append(
        row("reading_state_torque", "(10), Figure 13", "as printed",
            "largest torque on 5 sin t mm, f-hat by the letter, the worst of SMC, CSMC and FSMC", None,
            1e-3 * max(torques.values()), "kN m", ">=", 14.0, 0.0, "cannot be checked",
            "at a reversal: " + ", ".join(f"{law} {1e-3 * t:.3g}" for law, t in torques.items())
            + " kN m, where 8 N m is needed; the digest has 14 to 24", "report")
    )  # fmt: skip
    for name, weights, eta in (("smc", CONVENTIONAL, 120.0), ("csmc", COMPLEMENTARY, 20.0)):
        run = held_loop(loops, read_as(weights, eta, held=True, friction_from=3), 1e-4).run(
            1.0, record=("true_error", "output")
        )
        rows.append(
            row(f"reading_state_10khz_{name}", "(10), Figure 14", "as printed",
                f"largest error of {name} on sin 2 pi t mm at 10 kHz, f-hat by the letter", None,
                float(np.abs(run["true_error"]).max()), "mm", ">=", 1.0, 0.0, "cannot be checked",
                f"larger than the motion, with {1e-3 * np.abs(run['output']).max():.3g} kN m; the digest says that it "
                f"runs "
                "away by metres: not found on any of the paper's commands", "report")
        )  # fmt: skip
    return rows


# ---- F~
def _f_tilde(loops: Loops) -> list[Claim]:
    bound = read_as(CONVENTIONAL, 120.0).params.stage.bound
    nothing = {"controller.bound.coulomb": 1e-12, "controller.bound.static": 1e-12, "controller.bound.viscous": 0.0}
    commanded = loops.run("corrected.smc", "step_raw", changes=nothing)
    measured = loops.get(read_as(CONVENTIONAL._replace(signed=1), 120.0), "step_raw").run(
        0.6, record=("true_error", "output")
    )
    return [
        row("reading_bound_at_rest", "section 4.2, Table 2", "as printed", "F~ at rest, static reading", None,
            steady_friction(bound, 0.0), "N m", "=", 9.36, 1e-9, "cannot be checked",
            "must be what static friction can be, or the switching gain cannot break the stage away",
            basis="arithmetic"),
        row("reading_bound_sign_commanded", "section 4.2", "as printed",
            "error left by a step of 1 mm, F~ with the sign() of a speed that is 0 at rest (the commanded one)", None,
            1e3 * abs(float(commanded["true_error"][-1])), "um", "=", 1000.0, 0.5, "cannot be checked",
            f"only eta is left, {commanded['output'][-1]:.4f} N m: the bristles carry it"),
        row("reading_bound_sign_measured", "section 4.2", "as printed",
            "the same with the measured speed, seen exactly", None, 1e3 * abs(float(measured["true_error"][-1])), "um",
            "=", 0.729, 0.015, "cannot be checked",
            "the first picometre of motion switches F~ on: the error is that of the static reading; with a sensor of "
            "finite resolution the speed reads 0, and the stage is stuck as with the commanded one"),
    ]  # fmt: skip


# ---- forms of the equivalent control
def _forms(loops: Loops) -> list[Claim]:
    peaks = {
        name: tracked(loops.get(read_as(weights, 120.0), "sine_fast", sample=1e-4).run(4.0, record=("true_error",
        "output")),
                      "sine_fast").largest
        for name, weights in (("Liang and Su", LITERAL), ("Slotine", SLOTINE))
    }  # fmt: skip
    rows = [
        row(f"reading_binomials_{n}", "(10)", "as printed",
            f"relative error of the binomials of (10) against (d/dt + lam)^{n + 1}, n = {n}", 0.0,
            algebra.binomial_error(n), "", "=", 0.0, 1e-15, "reproduced",
            "so s' + lam s = delta f + v_c: the form of Liang and Su", basis="arithmetic")
        for n in (2, 3, 4)
    ]  # fmt: skip
    worst = max(peaks.values())
    return [
        *rows,
        row("reading_slotine_swap", "(10)", "as corrected",
            "largest error of the integral SMC on sin 2 pi t mm, the larger of Liang-Su's and Slotine's terms", None,
            worst, "um", "=", 0.0841, 1e-3, "cannot be checked",
            f"they differ by {1e3 * abs(peaks['Slotine'] - peaks['Liang and Su']):.3f} nm: which form is meant decides "
            "nothing"),
        row("reading_lyapunov", "after (15)", "as printed",
            "relative error of V' = -lam (s + s_c)^2 + (s + s_c) (delta f + v_c), V = (s^2 + s_c^2) / 2", 0.0,
            algebra.lyapunov_residual(), "", "<=", 1e-12, 0.0, "reproduced",
            "V' by the chain rule at 1000 random states: the layer of (15) is reached", basis="arithmetic"),
    ]  # fmt: skip


# ---- bounds
def _bounds(loops: Loops) -> list[Claim]:
    of_e, of_rate = algebra.tight_bounds()
    lam, phi = 150.0, 0.1
    layer = UM_PER_RAD * phi / lam
    inside = {
        law: max(_largest(loops, law, s, {}) for s in SINES) for law in ("corrected.smc", "paper.smc", "paper.csmc",
        "corrected.fsmc")
    }  # fmt: skip
    return [
        row("reading_l1_position", "(13)", "as printed", "largest lam |e| / phi that |s| <= phi allows, integral s",
            1.0, of_e, "", "=", 0.7358, 1e-4, "reproduced with change", "2 / e: (13) holds for e, and is loose",
            basis="arithmetic"),
        row("reading_l1_speed", "(13)", "as printed", "largest |e'| / phi that |s| <= phi allows, integral s", 2.0,
            of_rate, "", "=", 2.2707, 1e-4, "not reproduced", "2 + 2 / e^2: (13) does not hold for e'",
            basis="arithmetic"),
        row("reading_half", "after (16)", "as printed",
            "gain of (16) over the tight bound of the integral surface", 50.0, 100.0 * (1.0 - 0.5 / of_e), "%", "=",
            32.0,
            0.5, "not reproduced", "50 % against phi / lam, which is the conventional SMC's bound", basis="arithmetic"),
        row("reading_bound_smc", "(13)", "as printed", "bound of the error, phi / lam, in rad", None, layer, "um", "=",
            1.06, 0.005, "cannot be checked", f"1.5923 mm/rad; read in mm it is {1e3 * phi / lam:.2f} um",
            basis="arithmetic"),
        row("reading_bound_csmc", "(16)", "as printed", "bound of the error, phi / (2 lam), in rad", None, layer / 2.0,
            "um", "=", 0.53, 0.005, "cannot be checked", f"read in mm it is {500.0 * phi / lam:.2f} um",
            basis="arithmetic"),
        row("reading_inside_13", "(13)", "as corrected",
            "largest error of the conventional SMC on the three sines, in its bound phi / lam", 1.0,
            inside["corrected.smc"] / layer, "", "<=", 1.0, 0.0, "reproduced with change",
            f"{inside['corrected.smc']:.3f} of {layer:.3f} um, with the surface conventional; integral surface "
            f"{inside['paper.smc']:.3f} of {of_e * layer:.3f} um"),
        row("reading_inside_16", "(16)", "as printed",
            "largest error of CSMC on the three sines, in its bound phi / (2 lam)", 1.0,
            2.0 * inside["paper.csmc"] / layer,
            "", "<=", 1.0, 0.0, "reproduced", f"{inside['paper.csmc']:.3f} of {layer / 2.0:.3f} um; FSMC, which has no "
            f"such bound, {inside['corrected.fsmc']:.3f} um"),
    ]  # fmt: skip


# ---- the plant by itself
EIGENVALUES: dict[float, tuple[float, float]] = {
    0.0: (-8.55e5, -316.0), 1e-5: (-1041.0, 17.0), 1e-4: (4.9e3, -362.0), 3e-4: (4.75e4, -321.0), 1e-3: (2.65e5,
    -317.0), 2e-3: (6.1e4, -320.0), 5e-3: (-1080.0, -80.0), 0.1: (-1603.0, -1080.0), 3.14: (-5.03e4, -1080.0),
    10.0: (-1.60e5, -1080.0),
}  # fmt: skip
"""By speed in rad/s: what the digest has, 1/s."""


def _plant() -> list[Claim]:
    rows = []
    for number, (speed, known) in enumerate(EIGENVALUES.items()):
        found = algebra.open_loop_eigenvalues(speed)
        for which, value, digest in zip(("large", "small"), found, known, strict=True):
            rows.append(
                row(f"linear_eigenvalue_{number}_{which}", "(1) to (5), Table 2", "as printed",
                    f"eigenvalue of the stage in steady sliding at {speed:g} rad/s, the {which} one", None, value,
                    "1/s", "=", digest, _digits(digest), "cannot be checked",
                    "unstable: friction falls with speed" if value > 0.0 else "stable", basis="arithmetic")
            )  # fmt: skip
    euler, rk4 = algebra.explicit_limits_us()
    true = LuGre()
    worst = max(algebra.open_loop_eigenvalues(v)[0] for v in np.geomspace(1e-5, 1e-2, 301))
    small: dict[str, Any] = {"basis": "arithmetic"}
    rows += [
        row("linear_euler_limit", "(1) to (5)", "as printed", "largest stable step of Euler's method on the stage",
            None, euler, "us", "=", 2.34, 0.005, "cannot be checked", "2 J / sigma1, set by the stuck stage", **small),
        row("linear_rk4_limit", "(1) to (5)", "as printed", "largest stable step of RK4 on the stage", None, rk4, "us",
            "=", 3.26, 0.005, "cannot be checked", "2.785 J / sigma1", **small),
        row("linear_limit_speed", "(1) to (5)", "as printed", "speed above which sliding is stiffer than sticking",
            None,
            algebra.explicit_limit_speed(), "rad/s", "=", 53.0, 0.5, "cannot be checked", "the fast sine has 3.9 rad/s",
            **small),
        row("linear_worst_growth", "(1) to (5)", "as printed", "fastest growth of a slip, over all speeds", None, worst,
            "1/s", ">=", 2.6e5, 0.0, "cannot be checked",
            "at 0.0009 rad/s, near v_s: physics of the model, not a fault "
            "of a solver", **small),
        row("linear_passivity", "(2), Table 2", "as printed", "sigma2 that would make the model passive", None,
            algebra.passive_viscosity(true), "N m s/rad", "=", 158.0, 0.5, "cannot be checked",
            f"sigma1 (F_S - F_C) / F_C; the paper's sigma2 is {true.viscous:g}", **small),
        row("linear_stick_damping", "Table 2", "as printed", "damping ratio of the stuck stage on its bristles", None,
            algebra.stick_damping(true, INERTIA), "", "=", 26.0, 0.05, "cannot be checked",
            "the same numbers on 1 kg, where they come from, give 0.50", **small),
        row("linear_stick_damping_1kg", "Table 2", "as printed", "the same for the 1 kg of Canudas de Wit (1995)", None,
            algebra.stick_damping(true, 1.0), "", "=", 0.5, 0.005, "cannot be checked", "N/m and m/s there", **small),
    ]  # fmt: skip
    return rows


def _digits(value: float) -> float:
    """What three digits, or the last one of fewer, leave open."""
    size = abs(value)
    return 0.006 * size if size >= 1e4 else 50.0 if size in (4.9e3,) else 0.6
