"""Claims that need the paper's own numbers only: worked examples, counts, memberships, printed constants."""

from __future__ import annotations

import numpy as np

from leadscrew.controllers.vud.universe import CENTRES, TABLE_2, contraction
from leadscrew.fuzzy.inference import infer, rule_base
from leadscrew.fuzzy.partition_count import equal_sets_for, interpolation_bound, partition_count
from leadscrew.report.claim import Claim, Kind, Verdict
from leadscrew.studies.vud_lathe.rules import SETS

CURVATURES = (1.96, 1.35)
"""(8) and (9), read off a scope by the authors."""
ACCURACY = 0.05
TAU, FLOOR = 0.9, 1e-4
EXAMPLE = {"e": -0.25, "ec": 0.12, "rho": 0.722}
"""The worked example of section V."""
RIGHT = "agrees to the printed digits"


def _number(
    name: str,
    source: str,
    statement: str,
    paper: float,
    measured: float,
    tolerance: float,
    verdict: Verdict = "reproduced",
    reason: str = RIGHT,
    target: float | None = None,
    kind: Kind = "required",
    unit: str = "1",
) -> Claim:
    goal = paper if target is None else target
    return Claim(
        f"vud_lathe.{name}", source, "as printed", "arithmetic", statement, paper, float(measured), unit, "=", goal,
        tolerance, kind, verdict, reason,
    )  # fmt: skip


def arithmetic_claims() -> list[Claim]:
    """All of them."""
    return [*_scales(), *_partition(), *_strengths(), *_example()]


def _scales() -> list[Claim]:
    return [
        _number("eq5_ke", "(5)", "K_e", 0.00526, 1.0 / 190.0, 5e-6, unit="1/mm"),
        _number("eq6_kec", "(6)", "K_ec", 0.03865, 1.0 / 25.87, 1e-5, unit="1/mm",
                reason=f"{1.0 / 25.87:.6f}, cut off instead of rounded; the unit is per mm in 0.1 s, not per mm/s "
                "(see ec_unit)"),
    ]  # fmt: skip


def _partition() -> list[Claim]:
    count = partition_count(CURVATURES, ACCURACY)
    bound = interpolation_bound(CURVATURES, SETS.centres)
    equal = max(interpolation_bound(CURVATURES, np.linspace(-1.0, 1.0, len(SETS.centres)).tolist()))
    text = "number of sets for an accuracy of 0.05"
    return [
        _number("eq10_half", "(10)", f"{text}, read as printed", 6, count.half, 0, "not reproduced",
                f"with U = 1 the printed formula gives {count.half} sets", target=3, unit="sets"),
        _number("eq10_full", "(10)", f"{text}, with the full width 2U in place of U", 6, count.full, 0,
                "reproduced with change", f"a width of 2 gives {count.full}; the text says that U is 1", unit="sets"),
        _number("eq10_intervals", "(10)", f"{text}, with the root over the sum alone, as intervals", 5,
                count.intervals, 0, "reproduced with change",
                "5 intervals make 6 sets, which also explains the printed count (5 + 1)^2; it is not what (10) says",
                unit="intervals"),
        _number("rule_count", "section IV.b, step 3", "number of rules", 36, TABLE_2.size, 0,
                reason="6 x 6; printed as (M + 1)^n, where M would have to be the 5 intervals", unit="rules"),
        Claim("vud_lathe.equal_partition", "section IV.b, step 3", "as printed", "arithmetic",
              "the six sets part the universe equally", "yes", "yes" if max(SETS.widths) - min(SETS.widths) < 0.02 else
              "no", "", "yes/no", "no", 0.0, "required", "not reproduced",
              f"the printed centres lie {', '.join(f'{w:.2f}' for w in SETS.widths)} apart: there is no set at zero"),
        _number("interpolation_bound", "(10), text", "error that six sets guarantee, in the worst interval", ACCURACY,
                max(bound), 5e-4, "not reproduced",
                f"{max(bound):.3f} in the middle interval, {min(bound):.3f} in the outer ones; six equal sets would "
                f"guarantee {equal:.3f}, and 0.05 needs {equal_sets_for(CURVATURES, ACCURACY)} equal sets",
                target=0.180),
    ]  # fmt: skip


def _strengths() -> list[Claim]:
    e1, ec1, rho1 = (SETS.memberships(x) for x in (-0.932, 0.497, 1.000))
    e2, ec2, rho2 = (SETS.memberships(x) for x in (-0.801, 0.965, 0.921))
    swapped = "the paper swaps the two: its PM 0.509 is the membership in PS, so the rule of (12) is NB, PS -> PB"
    return [
        _number("k1_e_nb", "before (12)", "membership of e = -0.932 in NB", 0.794, e1[0], 5e-4),
        _number("k1_ec_ps", "before (12)", "membership of ec = 0.497 in PS", 0.491, ec1[3], 5e-4, "not reproduced",
                swapped, target=0.509),
        _number("k1_ec_pm", "before (12)", "membership of ec = 0.497 in PM", 0.509, ec1[4], 5e-4, "not reproduced",
                swapped, target=0.491),
        _number("eq14_strength", "(14)", "strength of the first rule", 0.404, e1[0] * ec1[3] * rho1[5], 1e-5,
                target=0.40398, reason="the number is right although its set has the wrong name"),
        _number("k2_e_nm", "before (15)", "membership of e = -0.801 in NM", 0.603, e2[1], 5e-4),
        _number("k2_ec_pb", "before (15)", "membership of ec = 0.965 in PB", 0.894, ec2[5], 5e-4),
        _number("k2_rho_pb", "before (15)", "membership of rho = 0.921 in PB", 0.761, rho2[5], 5e-4),
        _number("eq16_strength", "(16)", "strength of the second rule", 0.410, e2[1] * ec2[5] * rho2[5], 1e-5,
                target=0.41002, reason="the rule is overruled by k = 3, which the text does not say"),
    ]  # fmt: skip


def _example() -> list[Claim]:
    e, ec, rho = EXAMPLE["e"], EXAMPLE["ec"], EXAMPLE["rho"]
    alpha_e, alpha_ec = (contraction(x, TAU, FLOOR, 1.0) for x in (e, ec))
    nb_nm = SETS.contracted(alpha_e).memberships(e)
    pm_pb = SETS.contracted(alpha_ec).memberships(ec)
    medium_as_in_text = np.where(abs(TABLE_2) == 0.677, 0.67 * np.sign(TABLE_2), TABLE_2)
    consequents = {0.677: TABLE_2, 0.67: medium_as_in_text}
    shape = {size: infer(rule_base(CENTRES, CENTRES, t), e / alpha_e, ec / alpha_ec) for size, t in consequents.items()}
    printed = (-0.25 + 0.1925) / (-0.2873 + 0.1925)
    rounded = (0.12 - 0.0995) / (0.1485 - 0.0995)
    swapped = (
        f"the printed fractions give {printed:.4f} and {1.0 - printed:.4f}, not 0.5009 and 0.4991; all four rules that "
        "fire have the same consequent, so the duty does not change"
    )
    where = "section V, example"
    return [
        _number("example_alpha_e", "(17), example", "alpha of e = -0.25", 0.2873, alpha_e, 5e-5),
        _number("example_alpha_ec", "(18), example", "alpha of ec = 0.12", 0.1485, alpha_ec, 1e-4,
                reason="the paper rounds up"),
        _number("example_e_nm_centre", where, "peak of NM of e on the contracted universe", -0.1925, -0.67 * alpha_e,
                5e-5, unit="1"),
        _number("example_e_ns_centre", where, "peak of NS of e on the contracted universe", -0.0948, -0.33 * alpha_e,
                5e-5, unit="1"),
        _number("example_ec_pm_centre", where, "peak of PM of ec on the contracted universe", 0.0995, 0.67 * alpha_ec,
                1e-4, unit="1"),
        _number("example_ec_ps_centre", where, "peak of PS of ec on the contracted universe", 0.0490, 0.33 * alpha_ec,
                1e-4, unit="1"),
        _number("example_e_nb", where, "membership of e in NB", 0.5009, nb_nm[0], 5e-4, "not reproduced", swapped,
                target=0.6065),
        _number("example_e_nm", where, "membership of e in NM", 0.4991, nb_nm[1], 5e-4, "not reproduced", swapped,
                target=0.3935),
        _number("example_ec_pb", where, "membership of ec in PB", 0.4184, pm_pb[5], 2e-3,
                "reproduced with change",
                f"without the paper's rounding of alpha_ec; with it {rounded:.4f}", kind="report"),
        _number("example_duty", where, "next duty, without the floor in beta and with 0.67 as consequent", 0.4998,
                abs(rho) ** TAU * shape[0.67], 1e-5, target=0.49976),
        _number("example_duty_floor", where, "next duty by (19) and (21) as printed, with 0.67", 0.4998,
                contraction(rho, TAU, FLOOR, 1.0) * shape[0.67], 1e-5, target=0.49982,
                reason="the example leaves out the 0.0001 of (19)"),
        _number("example_duty_table2", where, "next duty by (19) and (21) with Table 2's 0.677", 0.4998,
                contraction(rho, TAU, FLOOR, 1.0) * shape[0.677], 1e-4, "not reproduced",
                "the example uses 0.67, Table 2 has 0.677", kind="report"),
    ]  # fmt: skip
