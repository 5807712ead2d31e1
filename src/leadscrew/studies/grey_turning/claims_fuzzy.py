"""Claims on the fuzzy controllers themselves: what their rules are near the set-point, and how smooth, how stable."""

from __future__ import annotations

import numpy as np

from leadscrew.controllers.grey_fuzzy.gpfc import gpfc
from leadscrew.controllers.grey_fuzzy.pi_incremental import pi_incremental
from leadscrew.controllers.grey_fuzzy.rule_tables import TABLES, rough
from leadscrew.controllers.grey_fuzzy.rules_shown import as_fuzzy_system
from leadscrew.controllers.grey_fuzzy.surface import MINIMUM, PRODUCT, concluded
from leadscrew.controllers.grey_fuzzy.tfc import tfc
from leadscrew.controllers.grey_fuzzy.tunings import FACTORS, Factors, at
from leadscrew.grey.predictors import GM_SHIFTED
from leadscrew.kernel.block import Block
from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.claims_fuzzy_margins import FACTOR_3, margin_claims
from leadscrew.studies.grey_turning.machines import PERIOD_S
from leadscrew.studies.grey_turning.readings import activity_v, read
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said, word

SHIFT = 1e6
"""Added before GM(1,1) for the limit in which it is a fixed filter, N."""
SMOOTHNESS = ("s6", "s9", "s9_half", "stfc")
SEEDS = 20


def fuzzy_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    return [*surface_claims(), *reduction_claims(), *smoothness_claims(loops), *margin_claims(), *law_claims(loops)]


# ---- the rules as a surface (A3)
def answers(block: Block, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What the rules say over S3 at errors of ``x`` S1 and changes of ``y`` S2: rows by x, columns by y."""
    p, b = block.prepare(block.params, PERIOD_S), block.params  # type: ignore[misc]
    rows = [[concluded(p, b.error_scale * i, b.change_scale * j) for j in y] for i in x]
    return np.asarray(rows) / b.output_scale


def surface_claims() -> list[Claim]:
    """A3: linear inside, near the clip outside, antisymmetric, bounded."""
    axis = np.linspace(-8.0, 8.0, 65)
    given = answers(tfc, axis, axis)
    linear = axis[:, None] + axis[None, :]
    inside = (np.abs(linear) <= 4.0) & (np.abs(axis) <= 6.0)[:, None] & (np.abs(axis) <= 6.0)[None, :]
    clipped = np.clip(linear, -6.0, 6.0)
    held = np.clip(axis, -6.0, 6.0)
    corners = np.abs(given - np.clip(held[:, None] + held[None, :], -6.0, 6.0))
    worst = float(np.abs(given - linear)[inside].max())
    beyond = float(np.abs(given - clipped).max())
    odd = float(np.abs(given + given[::-1, ::-1]).max())
    most = max(
        float(np.abs(answers(tfc(rules=table, inference=kind), axis[::4], axis[::4])).max())
        for table in (*TABLES.values(), rough(2, antisymmetric=False))
        for kind in (PRODUCT, MINIMUM)
    )
    return [
        said(
            "rules_are_linear_inside", "equations (15) to (18), Fig 3",
            "with the standard table the rules say S3 (e/S1 + ec/S2) while its size is at most 4 S3", worst, "S3", 0.0,
            f"largest difference on a grid of 65 by 65 points: {worst:.1e} S3; Table 1 is missing, the table is ours",
            tolerance=1e-12, group="as corrected", basis="arithmetic",
        ),
        said(
            "saturated_rules_are_near_the_clip", "equations (15) to (18), Fig 3",
            "beyond, they are within S3 / 2 of S3 clip(e/S1 + ec/S2, -6, 6), each input held to 6 factors",
            float(corners.max()), "S3", 0.5,
            f"the corners of the interpolation cut the clip by {corners.max():.3f} S3 at most (inputs held; where one "
            f"is beyond its universe and the other pulls back, {beyond:.1f} S3 from the clip of the unheld sum)",
            tolerance=1e-12, sense="<=", group="as corrected", basis="arithmetic",
        ),
        said(
            "rules_are_antisymmetric", "equations (15) to (18)", "the rules answer -e, -ec with the opposite", odd,
            "S3", 0.0, f"largest sum of the two answers {odd:.1e} S3", tolerance=1e-12, group="as corrected",
            basis="arithmetic",
        ),
        said(
            "rules_are_bounded", "equation (18)", "no table and no way of inference says more than 6 S3", most, "S3",
            6.0, f"largest answer of {len(TABLES) + 1} tables, product and minimum: {most:.3f} S3", tolerance=1e-12,
            sense="<=", group="as corrected", basis="arithmetic",
        ),
        *toolbox_claims(),
    ]  # fmt: skip


def toolbox_claims() -> list[Claim]:
    """The same rules by a second way: 49 rules of the fuzzy toolbox."""
    worst = 0.0
    for kind in (PRODUCT, MINIMUM):
        block = tfc(inference=kind)
        points = np.random.default_rng(5).uniform(-8.0, 8.0, (400, 2))
        p = block.prepare(block.params, PERIOD_S)
        scaled = points * (block.params.error_scale, block.params.change_scale)
        ours = np.array([concluded(p, *row) for row in scaled])
        theirs = np.ravel(as_fuzzy_system(block).many(scaled))
        worst = max(worst, float(np.abs(ours - theirs).max()) / block.params.output_scale)
    return [
        said(
            "rules_by_the_toolbox", "equations (15) to (18)",
            "49 rules evaluated one by one give what the four active ones give, product and minimum", worst, "S3", 0.0,
            f"largest difference at 800 points {worst:.1e} S3", tolerance=1e-12, group="as corrected",
            basis="arithmetic",
        )
    ]  # fmt: skip


# ---- the linear laws behind the fuzzy ones (A4, A11)
def replies(block: Block, force: np.ndarray, target: float = 150.0, start_v: float = 0.2) -> np.ndarray:
    """Outputs of a controller that is aligned at the set-point and then sees ``force``."""
    p = block.prepare(block.params, PERIOD_S)  # type: ignore[misc]
    state, found = block.align(p, target, target, start_v), []  # type: ignore[misc]
    for y in force:
        state, u = block.step(p, state, target, float(y), PERIOD_S)
        found.append(u)
    return np.asarray(found)


def reduced(reading: str, gains: Factors, force: np.ndarray, target: float = 150.0, start_v: float = 0.2) -> np.ndarray:
    """The linear law that a GPFC is near its set-point, as one sum, without a prediction or a rule."""
    e = target - force
    late = np.concatenate([[target] * 3, force])
    y, y1, y2, y3 = late[3:], late[2:-1], late[1:-2], late[:-3]
    averaged = 0.5 * (y1 + y2) - target
    if reading == "a":
        return np.asarray(start_v + gains.ki * np.cumsum(e) - (gains.kp + gains.ki) * averaged)
    return np.asarray(
        start_v + gains.ki * np.cumsum(e) - gains.ki * averaged - gains.kp * (y + 0.5 * (y1 - y3) - target)
    )


def reduction_claims() -> list[Claim]:
    """A4, A11: near the set-point each fuzzy controller is a linear law."""
    claims = []
    force = 150.0 + np.random.default_rng(3).uniform(-0.5, 0.5, 300)
    for reading, code in (("b", 0), ("a", 1)):
        block = at(gpfc, FACTORS["s6"], predictor=GM_SHIFTED, shift=SHIFT, reading=code)
        off = float(np.abs(replies(block, force) - reduced(reading, FACTORS["s6"], force)).max())
        claims.append(
            said(
                f"gpfc_{reading}_is_a_linear_law", "section 4, look-ahead fuzzy control",
                f"near the set-point the GPFC of reading {reading.upper()} is a PI with another action of the output",
                off, "V", 0.0,
                f"300 samples within 0.5 N, shifted by {SHIFT:.0e} N before GM(1,1): {off:.1e} V apart from the linear "
                "recursion",
                tolerance=1e-7, group="as corrected", basis="arithmetic",
            )
        )  # fmt: skip
    f = FACTORS["s6"]
    pair = [replies(b, force) for b in (at(tfc, f), pi_incremental(kp=f.kp, ki=f.ki))]
    off = float(np.abs(pair[0] - pair[1]).max())
    claims.append(
        said(
            "tfc_is_a_pi", "section 4", "inside its rules the TFC is the PI with Kp = S3/S2 and Ki = S3/S1", off, "V",
            0.0, f"300 samples within 0.5 N: {off:.1e} V apart", tolerance=1e-13, group="as corrected",
            basis="arithmetic",
        )
    )  # fmt: skip
    return claims


# ---- product or minimum
def kinks(kind: int) -> tuple[float, float, float]:
    """Of the surface within 2 factors of the set-point: distance from the plane, least and steepest slope along e."""
    axis = np.linspace(-2.0, 2.0, 81)
    given = answers(tfc(inference=kind), axis, axis)
    slopes = np.diff(given, axis=0) / (axis[1] - axis[0])
    return (
        float(np.abs(given - axis[:, None] - axis[None, :]).max()), float(slopes.min()), float(slopes.max())
    )  # fmt: skip


def voltages(loops: Loops, name: str, kind: int) -> tuple[float, float]:
    """Mean change of the voltage a sample in steady state (mV) and steady error (%), mean of the seeds."""
    loop = loops.get(f"corrected.tfc_{name}", "fig6_fixed_depth").using({"controller.inference": kind})
    batch = loop.batch(4.0, {"controller.upper": np.ones(SEEDS)}, record=("feedback", "output"))
    steady = activity_v(np.asarray(batch["output"]), (2.0, 4.0)) / round(2.0 / PERIOD_S)
    return float(1e3 * steady.mean()), float(read(np.asarray(batch["feedback"])).steady.mean())


def smoothness_claims(loops: Loops) -> list[Claim]:
    """The paper's reason for the product in (17), on the surface and in the loop."""
    (flat, *even), (rough_, least, steepest) = kinks(PRODUCT), kinks(MINIMUM)
    claims = [
        said(
            "product_surface_is_smoother", "section 4, equation (17)",
            "the product makes the change of suitability smooth where the minimum does not",
            word(rough_ > 1e-6 and flat < 1e-12), "", "yes",
            f"within two factors of the set-point the product is a plane to {flat:.0e} S3 (slopes {even[0]:.3f} to "
            f"{even[1]:.3f}); the minimum leaves it by {rough_:.2f} S3 and its slope along e lies between {least:.2f} "
            f"and {steepest:.2f} of the plane's",
            sense="yes/no", group="as corrected", basis="arithmetic", paper="smoother with the product",
            verdict="reproduced" if rough_ > 1e-6 and flat < 1e-12 else "not reproduced",
        )
    ]  # fmt: skip
    pairs = {f: (voltages(loops, f, PRODUCT), voltages(loops, f, MINIMUM)) for f in SMOOTHNESS}
    calmer = all(a[0] < b[0] for a, b in pairs.values())
    words = "; ".join(f"{f} {a[0]:.2f} and {b[0]:.2f} mV" for f, (a, b) in pairs.items())
    errors = "; ".join(f"{f} {a[1]:.2f} and {b[1]:.2f} %" for f, (a, b) in pairs.items())
    claims.append(
        said(
            "product_voltage_is_smoother", "section 4, equation (17)",
            "in the closed loop the voltage is calmer with the product, at every factor set", word(calmer), "", "yes",
            f"mean change of the voltage a sample from 2 to 4 s, {SEEDS} seeds, product and minimum: {words}; steady "
            f"error: {errors}",
            sense="yes/no", group="as corrected", paper="smoother with the product",
            verdict="reproduced" if calmer else "not reproduced",
        )
    )  # fmt: skip
    return claims


# ---- what follows from the form of the law
def law_claims(loops: Loops) -> list[Claim]:
    """Slew limit of the rules, positional output, the Smith predictor."""
    f = FACTORS["s6"]
    y = loops.run("corrected.tfc_s6", "noise_free")["feedback"]
    steepest, slew = float(np.diff(y).max()), 6.0 * f.change
    left = [
        float(
            read(loops.get(at(tfc, f, positional=True), "noise_free").run(3.0, record=("feedback",))["feedback"]).bias
        )
        for f in (FACTORS["s6"], FACTORS["s9"])
    ]
    claims = [
        said(
            "rules_limit_the_slew", FACTOR_3, "with S6 the force rises by at most 6 S2 a sample", steepest, "N", slew,
            f"noise-free entry on plant F: at most {steepest:.2f} N a sample, 6 S2 = {slew:.2f} N: a fall of the error "
            "by 6 S2 is answered with 0 or less, however large the error is",
            sense="<=",
        ),
        said(
            "positional_leaves_an_error", FACTOR_3, "with a positional output the force stays away from its set-point",
            min(left), "%", 10.0,
            f"bias of the last second {left[0]:.0f} % with S6 and {left[1]:.0f} % with S9: force by feed holds no "
            "integral, and the rules say at most 6 S3",
            sense=">=",
        ),
    ]  # fmt: skip
    claims += smith_claims(loops)
    return claims


def smith_claims(loops: Loops) -> list[Claim]:
    """The Smith predictor against the best TFC, on seeds that neither was tuned on."""
    claims = []
    for machine, ours, other in (("plant_f", "ours.smith_f", "corrected.tfc_stfc"),
                                 ("plant_n", "ours.smith_n", "corrected.tfc_stfc_n")):  # fmt: skip
        seen = []
        for name in (ours, other):
            loop = loops.get(name, "fig6_fixed_depth", machine=machine)
            batch = loop.batch(3.0, {"controller.upper": np.ones(60)}, record=("feedback",))
            seen.append(read(np.asarray(batch["feedback"])[20:]))
        a, b = seen
        rise, before = float(a.rise_s.mean()), float(b.rise_s.mean())
        claims.append(
            said(
                f"smith_{machine}", "ours", f"a Smith predictor rises no slower than the tuned TFC on {machine}", rise,
                "s", before,
                f"40 seeds, Smith and TFC: rise {rise:.3f} and {before:.3f} s, overshoot {a.overshoot.mean():.2f} and "
                f"{b.overshoot.mean():.2f} %, steady error {a.steady.mean():.2f} and {b.steady.mean():.2f} %; it "
                "needs a model of servo, chip and filter, which GM(1,1) does not",
                sense="<=", kind="report",
            )
        )  # fmt: skip
    return claims
