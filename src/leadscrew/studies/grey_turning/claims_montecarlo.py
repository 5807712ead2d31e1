"""Claims of the Monte Carlo: the digest's table of random machines, pair by pair, and A10."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from leadscrew.report.claim import Claim, Kind
from leadscrew.studies.grey_turning.montecarlo import COUNTS, Judged
from leadscrew.studies.grey_turning.montecarlo_runs import (
    ROUGH,
    TABLES,
    Compared,
    MonteCarlo,
    Share,
    compared,
    montecarlo_of,
    percentile,
    share,
)
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said, word

SOURCE = "Monte Carlo"
WIDE = 3.0
"""Standard deviations of the difference of two independent samples: some fifty rows are compared, so two would miss a
few that are right."""


class Digest(NamedTuple):
    """Percent of the draws, in the digest."""

    plant: str
    overshoot: float
    steady: float
    all_three: float
    bad_tfc: float
    bad_b: float


SAME_FACTORS: dict[str, Digest] = {
    "s6": Digest("plant_f", 84, 63, 47, 19.3, 19.0),
    "s9": Digest("plant_f", 100, 85, 36, 79.0, 32.3),
    "s9_half": Digest("plant_f", 100, 78, 10, 38.3, 5.0),
    "stfc": Digest("plant_f", 83, 59, 0, 0.7, 0.0),
    "s6n": Digest("plant_n", 79, 54, 17, 7.5, 7.2),
    "sbn": Digest("plant_n", 93, 56, 4, 11.0, 2.2),
}
"""GPFC-B against TFC of the same factors."""
TWO_POINT: dict[str, dict[str, float]] = {
    "s6": {"overshoot": 97, "steady": 89, "bad": 7.7}, "s9": {"bad": 57.0}, "s9_half": {"bad": 20.0},
}  # fmt: skip
"""The two-point predictor in reading B against TFC."""
OWN = 200
"""Draws under factors of one's own: the digest gives ranges only."""
READING_A = (("s6", 36.0, 42.0), ("s9_half", 36.0, 42.0))
"""Factors; what the digest has over all six sets: overshoot lower in 36 to 100 %, steady error in 5 to 42 %."""
READING_A_BAD = 42.3
"""Percent of bad runs in the digest at the factors s6."""


def spread(percent: float, seen: Share) -> float:
    """Tolerance of a share between the digest's draws and ours, percent: both are samples of the same size."""
    p = 0.5 * (0.01 * percent + seen.value)
    p = min(max(p, 2.0 / seen.of), 1.0 - 2.0 / seen.of)
    return WIDE * 100.0 * math.sqrt(2.0 * p * (1.0 - p) / seen.of)


def montecarlo_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    made = montecarlo_of(loops)
    return [
        *_a10(made), *_same_factors(made), *_two_point(made), *_reading_a(made), _below_digest(made),
        *_own_tuned(made), *_rough(made), *_tails(made),
    ]  # fmt: skip


def _row(name: str, what: str, seen: Share, target: float, more: str = "", kind: Kind = "required") -> Claim:
    return said(
        f"mc_{name}", SOURCE, what, 100.0 * seen.value, "%", target,
        f"{seen}; digest {target:g} %{more}", tolerance=spread(target, seen), kind=kind,
    )  # fmt: skip


def _a10(made: MonteCarlo) -> Iterator[Claim]:
    found = made.pair("corrected.gpfc_b_s9_half", "corrected.tfc_s9_half")
    tfc, b = found.bad
    where = f"of {COUNTS['plant_f']} random plants F at the factors S9/2"
    yield said("a10_bad_tfc", SOURCE, f"A10: bad runs {where}, TFC", 100.0 * tfc.value, "%", 25.0, str(tfc), sense=">=")
    yield said("a10_bad_gpfc", SOURCE, f"A10: bad runs {where}, GPFC-B", 100.0 * b.value, "%", 10.0, str(b), sense="<=")
    yield said(
        "a10_overshoot", SOURCE, f"A10: {where}, GPFC-B overshoots less than TFC", 100.0 * found.overshoot.value, "%",
        95.0, str(found.overshoot), sense=">=",
    )  # fmt: skip


def _same_factors(made: MonteCarlo) -> Iterator[Claim]:
    for factors, digest in SAME_FACTORS.items():
        found = made.pair(f"corrected.gpfc_b_{factors}", f"corrected.tfc_{factors}", digest.plant)
        where = f"random plant {digest.plant[-1].upper()}"
        what = f"{where}, {factors}: GPFC-B"
        tfc, b = found.bad
        yield _row(f"{factors}_overshoot", f"{what} overshoots less than TFC", found.overshoot, digest.overshoot)
        yield _row(f"{factors}_steady", f"{what} has less steady error than TFC", found.steady, digest.steady)
        yield _row(
            f"{factors}_all_three", f"{what} has less overshoot and steady error and rises in no more samples",
            found.all_three, digest.all_three,
            f"; with rise times between samples {100.0 * found.all_three_between.value:.0f} %",
        )  # fmt: skip
        yield _row(f"{factors}_bad_tfc", f"{where}, {factors}: bad runs of TFC", tfc, digest.bad_tfc)
        yield _row(
            f"{factors}_bad_gpfc", f"{where}, {factors}: bad runs of GPFC-B", b, digest.bad_b,
            _order(made, factors, digest),
        )  # fmt: skip
        yield _faster(factors, what, found)
    stfc = made.pair("corrected.gpfc_b_stfc", "corrected.tfc_stfc")
    yield _row("stfc_iae", "random plant F, stfc: GPFC-B has a lower integral of the error than TFC", stfc.iae, 15.0)


def _order(made: MonteCarlo, factors: str, digest: Digest) -> str:
    """How the two laws stand to each other, draw by draw, and whether the digest has them the other way round."""
    from scipy.stats import binomtest

    tfc, b = (made.of(f"corrected.{law}_{factors}", digest.plant).bad for law in ("tfc", "gpfc_b"))
    spoiled, rescued = int((b & ~tfc).sum()), int((tfc & ~b).sum())
    if not (b.mean() - tfc.mean()) * (digest.bad_b - digest.bad_tfc) < 0.0:
        return f"; bad under GPFC-B alone {spoiled}, under TFC alone {rescued}"
    chance = binomtest(spoiled, spoiled + rescued).pvalue
    return (
        f"; the other way round than the digest, {digest.bad_tfc:g} to {digest.bad_b:g} % there and "
        f"{100.0 * tfc.mean():.1f} to {100.0 * b.mean():.1f} % here: bad under GPFC-B alone {spoiled}, under TFC alone "
        f"{rescued}, by chance with p = {chance:.2g}"
    )


def _below_digest(made: MonteCarlo) -> Claim:
    rows: list[tuple[str, Share, float]] = []
    for factors, digest in SAME_FACTORS.items():
        if digest.plant == "plant_f":
            tfc, b = made.pair(f"corrected.gpfc_b_{factors}", f"corrected.tfc_{factors}").bad
            rows += [(f"TFC {factors}", tfc, digest.bad_tfc), (f"GPFC-B {factors}", b, digest.bad_b)]
    for factors, there in TWO_POINT.items():
        two = made.pair(f"ours.two_point_{factors}", f"corrected.tfc_{factors}").bad[1]
        rows.append((f"two-point {factors}", two, there["bad"]))
    rows.append(("GPFC-A s6", made.pair("corrected.gpfc_a_s6", "corrected.tfc_s6").bad[1], READING_A_BAD))
    off = [round(100.0 * seen.value, 1) - target for _, seen, target in rows]
    apart = [WIDE * change / spread(target, seen) for change, (_, seen, target) in zip(off, rows, strict=True)]
    far = int(np.argmax(np.abs(apart)))
    name, seen, target = rows[far]
    return said(
        "mc_below_digest", SOURCE, "random plants F: shares of bad runs that lie below the digest's",
        sum(change < 0.0 for change in off), f"of {len(rows)}", None,
        f"above it {sum(change > 0.0 for change in off)}; in the mean {np.mean(off):+.1f} points; farthest {name}, "
        f"{100.0 * seen.value:.1f} for {target:g} %, {abs(apart[far]):.1f} standard deviations; "
        f"{sum(abs(a) <= WIDE for a in apart)} within {WIDE:g} of them. All rows share their draws, ours as the "
        f"digest's: they are not {len(rows)} witnesses, and whether the draws or the plants differ this does not tell",
        kind="report",
    )  # fmt: skip


def _faster(factors: str, what: str, found: Compared) -> Claim:
    statement, name = f"{what} rises in fewer samples than TFC", f"{factors}_faster"
    if factors == "s6":
        return _row(name, statement, found.faster, 40.0)
    return said(
        f"mc_{name}", SOURCE, statement, 100.0 * found.faster.value, "%", 10.0,
        f"{found.faster}; digest 0 to 10 %", sense="<=", tolerance=spread(10.0, found.faster),
    )  # fmt: skip


def _two_point(made: MonteCarlo) -> Iterator[Claim]:
    for factors, digest in TWO_POINT.items():
        found = made.pair(f"ours.two_point_{factors}", f"corrected.tfc_{factors}")
        grey = made.pair(f"corrected.gpfc_b_{factors}", f"corrected.tfc_{factors}")
        shares = {"overshoot": found.overshoot, "steady": found.steady, "bad": found.bad[1]}
        words = {"overshoot": "overshoots less than TFC", "steady": "has less steady error than TFC", "bad": "bad runs"}
        others = {"overshoot": grey.overshoot, "steady": grey.steady, "bad": grey.bad[1]}
        for key, target in digest.items():
            yield _row(
                f"two_point_{factors}_{key}", f"random plant F, {factors}: two-point predictor, {words[key]}",
                shares[key], target, f"; GPFC-B {100.0 * others[key].value:.1f} %",
            )  # fmt: skip


def _reading_a(made: MonteCarlo) -> Iterator[Claim]:
    for factors, least, most in READING_A:
        found = made.pair(f"corrected.gpfc_a_{factors}", f"corrected.tfc_{factors}")
        what = f"random plant F, {factors}: GPFC-A"
        yield said(
            f"mc_reading_a_{factors}_overshoot", SOURCE, f"{what} overshoots less than TFC",
            100.0 * found.overshoot.value, "%", least, f"{found.overshoot}; digest 36 to 100 % over its sets",
            sense=">=", tolerance=spread(least, found.overshoot),
        )  # fmt: skip
        yield said(
            f"mc_reading_a_{factors}_steady", SOURCE, f"{what} has less steady error than TFC",
            100.0 * found.steady.value, "%", most, f"{found.steady}; digest 5 to 42 % over its sets",
            sense="<=", tolerance=spread(most, found.steady),
        )  # fmt: skip
    bad = made.pair("corrected.gpfc_a_s6", "corrected.tfc_s6").bad
    yield _row("reading_a_s6_bad", "random plant F, s6: bad runs of GPFC-A", bad[1], READING_A_BAD, f"; TFC {bad[0]}")


def _own_tuned(made: MonteCarlo) -> Iterator[Claim]:
    for plant, letter in (("plant_f", "F"), ("plant_n", "N")):
        found = compared(made.tuned("gpfc_b", plant, OWN), made.tuned("tfc", plant, OWN))
        change = found.iae_change
        yield said(
            f"mc_own_tuned_{letter.lower()}_iae", SOURCE, f"random plant {letter}: GPFC-B has a lower integral of the "
            "error than TFC, each at its own factors", 100.0 * found.iae.value, "%", 78.0,
            f"{found.iae}; digest 78 to 98 % with factors that it does not give, ours are those of the ablation",
            sense=">=", kind="report",
        )  # fmt: skip
        yield said(
            f"mc_own_tuned_{letter.lower()}_change", SOURCE, f"random plant {letter}: median change of that integral",
            change.value, "%", -4.0, f"95 %: {change.low:.1f} to {change.high:.1f} %; digest -4 to -9 %", sense="<=",
            kind="report",
        )  # fmt: skip


def _rough(made: MonteCarlo) -> Iterator[Claim]:
    found = {name: made.rough(code) for name, code in ROUGH.items()}
    tfc, b = found["tfc"], found["gpfc_b"]
    rows: list[tuple[str, str, np.ndarray, float]] = [
        ("bad_tfc", "bad runs of TFC", tfc.bad, 52.0), ("bad_gpfc", "bad runs of GPFC-B", b.bad, 48.0),
        ("rescued", "bad under TFC, not under GPFC-B", tfc.bad & ~b.bad, 8.0),
        ("spoiled", "bad under GPFC-B, not under TFC", b.bad & ~tfc.bad, 4.0),
        ("overshoot", "GPFC-B overshoots less than TFC", b.overshoot < tfc.overshoot, 71.0),
        ("steady", "GPFC-B has less steady error than TFC", b.steady < tfc.steady, 64.0),
    ]  # fmt: skip
    more = "; the digest does not give its factors, ours are sbn times 1/4 to 4 each"
    for name, words, holds, target in rows:
        yield _row(f"rules_{name}", f"{TABLES} random rule tables and factors, plant N: {words}", share(holds), target,
                   more, "report")  # fmt: skip
    biased = share(made.rough(ROUGH["gpfc_b"], antisymmetric=False).bad)
    yield _row("rules_biased", "the same, every rule with an error of its own: bad runs of GPFC-B", biased, 85.0, more,
               "report")  # fmt: skip
    most = max(share(b.bad).value, biased.value)
    yield said(
        "mc_rules_good", "5.2, Fig 11", "GPFC-B is good where the rules are rough: at most one table in ten is bad",
        word(most <= 0.1), "", None,
        f"bad {share(b.bad)} of antisymmetric tables, {biased} of others: prediction helps where the factors "
        "make the integral too strong, it does not mend wrong rules", sense="yes/no", kind="report",
        group="as corrected", paper="yes", verdict="reproduced" if most <= 0.1 else "not reproduced",
    )  # fmt: skip


def _tails(made: MonteCarlo) -> Iterator[Claim]:
    names = [f"{law}_{f}" for f, d in SAME_FACTORS.items() if d.plant == "plant_f"
             for law in ("corrected.tfc", "corrected.gpfc_b")]  # fmt: skip
    for name in (*names, "ours.smith_f"):
        found: Judged = made.of(name)
        tail, rise = percentile(found.overshoot, 90.0), percentile(found.rise_s, 50.0)
        yield said(
            f"mc_{name.replace('.', '_')}", SOURCE, f"{COUNTS['plant_f']} random plants F: 90th percentile of the "
            f"overshoot, {name}", tail.value, "%", None,
            f"95 %: {tail.low:.1f} to {tail.high:.1f} %; median rise {rise.value:.2f} s; bad {share(found.bad)}",
            kind="report",
        )  # fmt: skip
