"""Claims of the table: golden runs without noise, nine cells by controller, gains, tuning with equal effort."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.changing import with_values
from leadscrew.studies.sofnn_tangent.comparison import (
    BILINEAR,
    DIGEST,
    FAST,
    FAST_MEAN,
    FIXED,
    MAMDANI,
    NONE,
    PAPER,
    PID,
    TUNED,
    Comparison,
    comparison_of,
    learning_step_us,
    period_us,
)
from leadscrew.studies.sofnn_tangent.fixed_fuzzy import system
from leadscrew.studies.sofnn_tangent.lines import PERIOD_S
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, verdict_of
from leadscrew.studies.sofnn_tangent.tuning import BUDGET, LAWS, SEARCHES, at_ends, best

SAMPLE = 200
GOLDEN: dict[str, tuple[str, float, float, float | None]] = {
    "none": (NONE, 1.1797, 2.9196, 1.3751),
    "fixed": (FIXED, 1.0167, 2.5191, 1.1643),
    "table": (BILINEAR, 0.6112, 1.9179, -0.1643),
    "net": (PAPER, 0.7680, 2.1530, None),
    "tuned": (TUNED, 0.1525, 0.7689, None),
}
"""RMS, largest deviation and that of sample 200 in the digest, deg: wave in fabric, nothing random, delay rule 6."""
GOLDEN_VALUES: dict[str, dict[str, float]] = {"table": {"delay": 6}, "net": {"delay": 6}, "tuned": {"leak": 0.0}}
"""What the study's controllers have differently: their delay is 4 as in the digest's table, and the tuned one leaks."""
SHARE = 0.02
"""A5: within 2 %."""
SMALL = 0.2
"""Level at which the two inferences are compared; between the inner rules the single numbers give it as it is."""
RULES_APART = 2.0
"""Levels between one set of E and the next."""
NO_FILTER = 0.1
"""A filter of less than this share of a period is none."""

PAPER_SAYS = "better effect"


def comparison_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    made = comparison_of(loops)
    return [
        *_golden(loops), *_rows(made), *_mamdani(made), *_gains(made), *_tuned(made), *_equal(made), *_cost(made),
    ]  # fmt: skip


def _golden(loops: Loops) -> Iterator[Claim]:
    for short, (name, rms, most, at) in GOLDEN.items():
        values = GOLDEN_VALUES.get(short, {})
        block, called = loops.controllers[name](**values), with_values(name, values)
        e = loops.run(block, "wave_fabric_quiet")["actual.deviation"][1:]
        where = "the wave in fabric without texture and noise"
        measured = {"rms": (float(np.sqrt(np.mean(e**2))), rms), "max": (float(np.abs(e).max()), most)}
        if at is not None:
            measured["e200"] = float(e[SAMPLE]), at
        words = {"rms": "RMS deviation", "max": "largest deviation", "e200": f"deviation of sample {SAMPLE}"}
        for key, (value, target) in measured.items():
            yield said(
                f"golden_{short}_{key}", "digest, section 6 (A5)", f"{words[key]} of {called} on {where}", value, "deg",
                target, f"{value:.4f} deg; the digest has {target:.4f} and asks for 2 %",
                tolerance=SHARE * abs(target),
            )  # fmt: skip


def _rows(made: Comparison) -> Iterator[Claim]:
    for name, row in DIGEST.items():
        standing, short = made.standing(name), name.split(".")[-1]
        mean, most = standing.allowed_mean(), standing.allowed_mean("most", 0.05)
        same = standing.agreeing(row)
        source = "digest, section 7"
        yield said(
            f"table_{short}_mean", source, f"mean RMS deviation of nine cells: {row.words}", standing.mean, "deg",
            row.mean, f"{standing.mean:.3f} deg; the digest, on other random textures, has {row.mean:g}; by chance "
            f"they differ by up to {mean:.2f}", tolerance=mean,
        )  # fmt: skip
        yield said(
            f"table_{short}_max", source, f"mean of the largest deviations: {row.words}", standing.most, "deg",
            row.most, f"{standing.most:.2f} deg; the digest has {row.most:g}; by chance they differ by up to "
            f"{most:.2f}", tolerance=most,
        )  # fmt: skip
        yield said(
            f"table_{short}_cells", source, f"cells that agree with the digest's but for chance: {row.words}", same,
            "of 9", 9.0, " ".join(f"{x:.2f}" for x in standing.by_cell())
            + " deg against " + " ".join(f"{x:.2f}" for x in row.rms),
        )  # fmt: skip
    standing = made.standing(FAST)
    allowed = standing.allowed_mean()
    yield said(
        "table_pid_fast_mean", "digest, section 7", "mean RMS deviation of nine cells: PID 0.7, 22, 0.01",
        standing.mean, "deg", FAST_MEAN, f"{standing.mean:.3f} deg; the digest has {FAST_MEAN:g}", tolerance=allowed,
    )  # fmt: skip


def _mamdani(made: Comparison) -> Iterator[Claim]:
    plain, rules, net = (made.mean(n) for n in (MAMDANI, "corrected.fuzzy", FIXED))
    steep = system().many([[SMALL, 0.0]]).item() / SMALL
    yield said(
        "mamdani_mean", "digest, section 7", "mean RMS deviation with Mamdani's max-min inference and centroid",
        plain, "deg", None,
        f"{plain:.3f} deg against {rules:.3f} with the same rules as single numbers and {net:.3f} with the trained "
        f"network: at {SMALL:g} level of deviation the centroid of cut triangles gives {steep:.2f} times as much as "
        "the single numbers",
        kind="report",
    )  # fmt: skip
    yield said(
        "training_worth", "digest, section 7", "what the Kalman training of the fixed network changes in the mean RMS, "
        "either way",
        100.0 * abs(rules - net) / rules, "%", 1.0, f"{rules:.3f} deg untrained, {net:.3f} trained: at this plant the "
        "plain rules and the trained network are the same", sense="<=",
    )  # fmt: skip


def _lower(made: Comparison, name: str, than: str) -> int:
    return int((made.cells[name].rms.mean(axis=-1) < made.cells[than].rms.mean(axis=-1)).sum())


def _less(made: Comparison, name: str, than: str) -> float:
    return 100.0 * (1.0 - made.mean(name) / made.mean(than))


def _gains(made: Comparison) -> Iterator[Claim]:
    a6 = "simulation tests; digest A6"
    for short, than, words in (("none", NONE, "than no compensation"), ("fixed", FIXED, "than fixed rules")):
        count = _lower(made, PAPER, than)
        yield said(
            f"literal_lower_than_{short}", a6, f"cells in which the paper's SOFNN deviates less {words} (RMS)", count,
            "of 9", 9.0, f"{made.mean(PAPER):.2f} deg in the mean against {made.mean(than):.2f}; with a performance "
            "network that is safe in sign, and inputs that are not rounded", paper=PAPER_SAYS,
            verdict=verdict_of(count == 9, change=True),
        )  # fmt: skip
    for short, name, than, target, seen in (
        ("literal_reduction_none", PAPER, NONE, 33.0, 36.0), ("literal_reduction_fixed", PAPER, FIXED, 25.0, 28.0),
        ("bilinear_reduction_none", BILINEAR, NONE, 40.0, 42.0),
    ):  # fmt: skip
        value = _less(made, name, than)
        yield said(
            short, "digest A6", f"mean RMS deviation of {name} below that of {than}", value, "%", target,
            f"{made.mean(name):.3f} deg against {made.mean(than):.3f}: {value:.1f} %; the digest measured {seen:g} %",
            sense=">=",
        )  # fmt: skip
    worse = [
        f"{line} {material}"
        for (line, material), before, after in zip(
            ((a, b) for a in ("wave", "flower", "rrect") for b in ("fabric", "leather", "foam")),
            made.cells[FIXED].most.mean(axis=-1).ravel(), made.cells[PAPER].most.mean(axis=-1).ravel(), strict=True,
        )
        if after > before
    ]  # fmt: skip
    flower = made.cells[PAPER].most.mean(axis=-1)[1] - made.cells[FIXED].most.mean(axis=-1)[1]
    yield said(
        "literal_raises_max", "digest, section 7",
        "cells in which the paper's SOFNN has a larger peak than fixed rules", len(worse), "of 9", 2.0,
        f"{', '.join(worse) or 'none'}; flower in leather {flower[1]:+.2f} deg, in foam "
        f"{flower[2]:+.2f} deg",
    )  # fmt: skip
    prior, without = made.mean(PAPER), made.mean("paper.sofnn_no_prior")
    yield said(
        "prior_rules_worth", "digest, section 7",
        "what the rules from before are worth: mean RMS without them less that with", without - prior, "deg", 0.13,
        f"{prior:.2f} deg with prior rules, {without:.2f} without any: it learns them "
        "on the way. What training them is worth is paper_offline_training", tolerance=0.02,
    )  # fmt: skip
    bad = made.cells["paper.sofnn_bad_slope"]
    rms, most = float(bad.rms.mean()), float(bad.most.mean())
    yield said(
        "bad_slope_mean", "digest, section 7 (A7)", "mean RMS deviation with a performance network of the wrong slope "
        "at the origin", rms, "deg", made.mean(NONE), f"{rms:.1f} deg, {most:.1f} at most (the digest's net: 12.1 and "
        f"16.8), {made.mean(NONE):.2f} without any compensation: the loop runs away", sense=">=",
    )  # fmt: skip


def _tuned(made: Comparison) -> Iterator[Claim]:
    mean, pid, sofc = (made.mean(n) for n in (TUNED, PID, "corrected.sofc"))
    yield said(
        "tuned_mean", "digest A11", "mean RMS deviation of the tuned SOFNN", mean, "deg", 0.80,
        f"{mean:.3f} deg; PID 0.7, 14, 0.005 beside it {pid:.3f}, PID 0.7, 22, 0.01 {made.mean(FAST):.3f}", sense="<=",
    )  # fmt: skip
    yield said(
        "pid_beats_tuned", "digest, headline 7", "mean RMS deviation of the faster PID below the tuned SOFNN's",
        mean - made.mean(FAST), "deg", 0.0,
        f"PID {made.mean(FAST):.3f} deg, SOFNN {mean:.3f}: a well-tuned PID equals or beats it", sense=">=",
    )  # fmt: skip
    stored, added = made.mean("corrected.sofc_stored"), made.mean("corrected.sofnn_accumulate")
    both = made.mean(BILINEAR)
    net = 100.0 * (stored / both - 1.0), 100.0 * (sofc / added - 1.0)
    form = 100.0 * (stored / sofc - 1.0), 100.0 * (both / added - 1.0)
    forms = f"stored target {stored:.3f} and {both:.3f} deg, added {sofc:.3f} and {added:.3f}"
    yield said(
        "sofc_stored", "introduction", "mean RMS deviation of the standard self-organising controller over that of "
        "the network, both with the table and the stored target", stored / both, "", None,
        f"without and with network: {forms}; the networks and the Kalman filter change the RMS by "
        f"{abs(net[0]):.0f} and {abs(net[1]):.0f} %, the form of the target by {abs(form[0]):.0f} and "
        f"{abs(form[1]):.0f} %", kind="report",
    )  # fmt: skip
    yield said(
        "sofc_added", "introduction", "the same where every correction is added", sofc / added, "", None,
        f"without and with network: {forms}, all at the printed scales", kind="report",
    )  # fmt: skip


def _apart(made: Comparison, law: str, other: str) -> str:
    """Which of two laws that were tuned alike is better, by the interval of their difference."""
    mean, half = made.apart(f"equal.{law}", f"equal.{other}")
    words, than = LAWS[law].words, LAWS[other].words
    if abs(mean) <= half:
        return f"{words} and {than} cannot be told apart ({mean:+.3f} +- {half:.3f} deg)"
    return f"{words} is {'worse' if mean > 0.0 else 'better'} than {than} by {abs(mean):.3f} +- {half:.3f} deg"


def _levels(made: Comparison, law: str) -> float:
    """Largest deviation of a law's runs, in its levels."""
    return best(law).values["k_e"] * float(made.cells[f"equal.{law}"].most.max())


def _ends(law: str) -> str:
    """Parameters at an end of their range; a filter shorter than a tenth of a period is none."""
    found = best(law)
    none = found.values.get("filter_s", 1.0) < NO_FILTER * PERIOD_S
    ends = [key for key in at_ends(found) if not (none and key == "filter_s")]
    filtered = f"; a filter of {1e3 * found.values['filter_s']:.2g} ms is none" if none else ""
    return filtered + (f"; at the end of its range: {', '.join(ends)}" if ends else "")


def _equal(made: Comparison) -> Iterator[Claim]:
    effort = f"{BUDGET} evaluations, {len(SEARCHES)} searches, fabric, two textures"
    ranked = sorted(LAWS, key=lambda law: made.mean(f"equal.{law}"))
    for law, (_, _, words) in LAWS.items():
        cells, found = made.cells[f"equal.{law}"], best(law).values
        fabric, all_nine = float(cells.rms[:, 0].mean()), float(cells.rms.mean())
        values = ", ".join(f"{key} {x:.3g}" for key, x in found.items())
        if "kg" in found:
            values += f"; a deviation is {_levels(made, law):.2g} levels of 6 at most"
        yield said(
            f"equal_{law}", "simulation tests; digest A11",
            f"mean RMS deviation after tuning with equal effort: {words}", all_nine, "deg", None,
            f"{all_nine:.3f} deg on nine cells, {fabric:.3f} in fabric, for which it was tuned "
            f"({effort}), largest {cells.most.mean():.2f} deg, contour {cells.lateral.mean():.2f} mm; "
            f"{values}{_ends(law)}", kind="report",
        )  # fmt: skip
    pid, sofnn, paper = (made.mean(f"equal.{law}") for law in ("pid", "sofnn", "paper"))
    order = "; ".join(f"{LAWS[law].words} {made.mean(f'equal.{law}'):.3f}" for law in ranked)
    behind = "; ".join(_apart(made, law, ranked[0]) for law in ranked[1:4])
    yield said(
        "equal_winner", "simulation tests; digest A11", "the best law after tuning with equal effort", ranked[0], "",
        None, f"{order} deg. {behind} (95 %)", kind="report",
    )  # fmt: skip
    yield said(
        "equal_sofnn_over_pid", "conclusion", "mean RMS deviation of the SOFNN over that of a PID, both tuned alike",
        sofnn / pid, "", None, f"{_apart(made, 'sofnn', 'pid')} (95 %, five textures and noises that no search has "
        "seen); the paper compares with no controller of another kind", kind="report",
    )  # fmt: skip
    yield said(
        "equal_paper_over_pid", "conclusion", "the same of the paper's law and network", paper / pid, "", None,
        f"{_apart(made, 'paper', 'pid')}, {_apart(made, 'paper', 'sofnn')} (95 %). No deviation of it is more than "
        f"{_levels(made, 'paper'):.2g} levels of 6, so that the rules about E = 0 fire with "
        f"{100.0 * (1.0 - _levels(made, 'paper') / RULES_APART):.1f} % or more: of seven columns of rules the search "
        "has left one in use", kind="report",
    )  # fmt: skip
    fixed = made.mean("equal.fixed")
    yield said(
        "equal_fixed_over_paper", "conclusion", "mean RMS deviation of fixed rules over the paper's SOFNN, both tuned "
        "alike", fixed / paper, "", None, f"{_apart(made, 'paper', 'fixed')} (95 %): beside fixed rules learning is "
        "worth something, whatever their gain" if fixed > paper else _apart(made, "paper", "fixed"), kind="report",
    )  # fmt: skip


def _cost(made: Comparison) -> Iterator[Claim]:
    whole, plain, step = period_us(made.loops, TUNED), period_us(made.loops, PID), learning_step_us()
    yield said(
        "step_time", "digest A12", "time of a period of the whole loop under the SOFNN, compiled", whole, "us", 50.0,
        f"{whole:.2f} us on this machine, as busy as it is, {plain:.2f} under the PID; the digest 11.6 us for its "
        "dense network alone", sense="<=", kind="report",
    )  # fmt: skip
    yield said(
        "step_marginal", "issue 10", "what a step of the self-organising network costs in a compiled loop: a loop with "
        "it less one without", step, "us", 1.0, f"{step:.2f} us on this machine, as busy as it is; leadscrew bench, "
        "part 'self-organising network', measures the same beside dense matrices and C", sense="<=", kind="report",
    )  # fmt: skip
    rows = len(made.cells)
    yield said(
        "table_seconds", "acceptance 2; digest A12",
        "time for the table: nine cells of every controller, five runs each", made.seconds, "s", 60.0,
        f"{rows} rows in {made.seconds:.1f} s, none of them made before, compilation included where it was not yet "
        "done; leadscrew bench, part 'tangential table', measures it in a process of its own", sense="<=",
        kind="report",
    )  # fmt: skip
