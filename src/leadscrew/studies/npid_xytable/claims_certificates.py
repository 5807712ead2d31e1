"""Claims about proofs: sectors of the main loop proved in exact arithmetic, and random plants against simulation.

What :mod:`leadscrew.studies.npid_xytable.claims_stability` checks on a grid of frequencies is proved here: the circle
criterion at rest and under load, and Tsypkin's, as matrix inequalities for the loop that runs.
"""

from __future__ import annotations

import math

import numpy as np

from leadscrew.analysis.stability.certificate import Certificate
from leadscrew.analysis.stability.driven import driven
from leadscrew.analysis.stability.kyp import ROUNDING
from leadscrew.analysis.stability.lmi import largest_proved
from leadscrew.analysis.stability.lmi_zames_falb import lmi_zames_falb
from leadscrew.analysis.stability.loop import reference_loops
from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable import random_plants
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.saying import said, word

STEEPEST = math.cosh(1.5) + 1.5 * math.sinh(1.5)
"""Slope of the paper's law just below e_max, 5.5463."""
FROM_ZERO = 1e-5
"""Where a sector "from 0" begins: the loop's integrator allows none at 0 itself."""


def certificates_claims(loops: Loops) -> list[Claim]:
    """The main loop, then the random plants."""
    return [*_main(), *_random()]


def _main() -> list[Claim]:
    loop = reference_loops()["L_star"]
    circle, tsypkin = largest_proved(loop, 1.0), largest_proved(loop, 1.0, "tsypkin")
    steep = largest_proved(loop, 1.0, "tsypkin", (1.0, STEEPEST))
    zero = largest_proved(loop, FROM_ZERO)
    ours, paper = driven(loop, (1.0, 2.2)), driven(loop, (1.0, STEEPEST))
    gain = math.cosh(1.5)
    rest = lmi_zames_falb(loop, 1.0, 1e-4 * math.ceil(1e4 * gain), 1e-4 * math.ceil(1e4 * STEEPEST))
    return [
        said("proof_circle_1", "section 3.2", "L*: largest K proved for sector [1, K], circle criterion by an LMI",
             _limit(circle), "1", 2.265, _proof(circle), tolerance=0.005 * 2.265, basis="printed plant"),
        said("proof_circle_0", "section 3.2", "L*: the same for a sector from 1e-5", _limit(zero), "1", 0.697,
             _proof(zero), tolerance=0.005 * 0.697, basis="printed plant"),
        said("proof_tsypkin_1", "section 3.2", "L*: the same by Tsypkin's criterion: fixed laws of slope at least 1",
             _limit(tsypkin), "1", None, f"{_proof(tsypkin)}; q = {tsypkin.multiplier:.3g}", kind="report",
             basis="printed plant"),
        said("proof_tsypkin_slope", "section 3.2", "L*: the same for fixed laws of slope 1 to 5.546, as the paper's",
             _limit(steep), "1", None, f"{_proof(steep)}; the paper's K = {gain:.4f} lies "
             f"{'inside' if _limit(steep) >= gain else 'above'}: 2.265 by the circle, {_limit(steep):.4f} by Tsypkin "
             "with the slope, and 2.510 would be unstable", kind="report", basis="printed plant"),
        said("proof_paper_at_rest", "section 3.2", "whether the paper's NPID is proved stable at rest in L*",
             word(rest.grade == "certificate"), "", "yes", f"its gain of {gain:.4f} is beyond Tsypkin's "
             f"{_limit(steep):.4f}, but the Zames-Falb condition with six delays holds up to "
             f"{rest.data.get('grid_limit', 0.0):.4f} and is proved up to {_limit(rest):.4f}; Popov from 0, as the "
             "paper draws it, proves 1.41", basis="printed plant", sense="yes/no", paper="stable for K < 2.5",
             verdict="reproduced with change" if rest.grade == "certificate" else "not reproduced"),
        said("proof_paper_driven", "section 3.2", "whether the paper's NPID is proved stable under load in L*",
             word(paper.grade == "certificate"), "", "no", paper.statement, basis="printed plant", sense="yes/no",
             paper="stable for K < 2.5",
             verdict="reproduced" if paper.grade == "certificate" else "not reproduced"),
        said("proof_slope_driven", "section 3.2", "whether the slope-limited NPID, k = 2.2, is proved under every "
             "command and load in L*", word(ours.grade == "certificate"), "", "yes", _proof(ours),
             basis="printed plant", sense="yes/no"),
        said("proof_tolerance", "section 3.2", "smallest relative change of L*'s matrices that these proofs cover",
             min(_tolerance(c) for c in (circle, tsypkin, steep, zero, rest, ours)), "1", ROUNDING,
             "a thousand roundings of double precision are asked for; the error of the hold's matrix exponential is "
             "less than a tenth of that, by its series in fractions", sense=">=", basis="printed plant"),
    ]  # fmt: skip


def _limit(found: Certificate) -> float:
    return float("nan") if found.limit is None or found.grade != "certificate" else found.limit


def _tolerance(found: Certificate) -> float:
    return float(found.data.get("tolerance", 0.0))


def _proof(found: Certificate) -> str:
    return (
        f"P > 0 and the inequality verified in exact arithmetic, order {found.data.get('order', 0)}; holds for all "
        f"loops within {_tolerance(found):.2g} of each entry"
    )


def _random() -> list[Claim]:
    found = random_plants.gaps()
    trials = random_plants.inside()
    nyquist = np.array([g.nyquist for g in found])
    off = np.abs(np.array([g.simulated for g in found]) / nyquist - 1.0)
    varying = np.array([g.varying_gap for g in found])
    static = np.array([g.static_gap for g in found])
    steep = np.array([g.steep_gap for g in found])
    shifted = np.array([g.shifted_gap for g in found])
    laws = len(random_plants.STATIC | random_plants.MONOTONE | random_plants.FALLING)
    drawn = f"{len(found)} plants of order three with 1 to 4 periods of delay, seed {random_plants.SEED}"
    return [
        said("random_limit", "section 3.2", "random plants with delay: largest difference between the Nyquist limit "
             "of the gain and the simulated one", 100.0 * float(off.max()), "%", 1.0,
             f"{drawn}; simulated 1 % below and above, worst of {random_plants.STARTS} starts", sense="<="),
        said("random_inside", "section 3.2", f"the same plants at {random_plants.BELOW:g} of the bounds of circle, "
             "Tsypkin and Jury-Lee: largest growth in the second half of any simulation", trials.worst, "1", 1.0,
             f"{trials.trials} motions; {laws} fixed laws, {len(random_plants.FALLING)} of them not monotone, and "
             f"{len(random_plants.VARYING)} gains that switch; the circle's sector from 0 and from above it; slowest: "
             f"{trials.where}", sense="<="),
        said("random_driven", "section 3.2", "the same under one command and laws of bounded slope: growth of the "
             "distance between motions from different starts", trials.apart, "1", 1.0,
             "the driven certificate says that every two motions converge", sense="<="),
        said("random_gap_varying", "section 3.2", "circle criterion: what is proved for [0, K], in parts of the "
             "smallest gain that some switching breaks; mean", float(varying.mean()), "1", None,
             f"{varying.min():.2f} to {varying.max():.2f}: between the two nothing is known", kind="report"),
        said("random_gap_static", "section 3.2", "Tsypkin: what is proved for [0, K], in parts of the Nyquist limit, "
             "mean", float(static.mean()), "1", None, f"{static.min():.2f} to {static.max():.2f}", kind="report"),
        said("random_gap_steep", "section 3.2", f"Jury-Lee, slopes up to {random_plants.STEEP:g} of the Nyquist limit, "
             "laws may fall: what is proved for [0, K], in parts of that limit; mean", float(steep.mean()), "1", None,
             f"{steep.min():.2f} to {steep.max():.2f}; simulated over {random_plants.LONG} periods, as motions decay "
             "slowly so near the limit", kind="report"),
        said("random_gap_shifted", "section 3.2", "circle criterion from 0.3 of the Nyquist limit on: what is proved, "
             "in parts of that limit; mean", float(shifted.mean()), "1", None,
             f"{shifted.min():.2f} to {shifted.max():.2f}; a sector that begins where the law's gain does loses less",
             kind="report"),
    ]  # fmt: skip
