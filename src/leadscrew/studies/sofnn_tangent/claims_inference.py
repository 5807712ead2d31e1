"""Claims about the fuzzy inference network: what it computes, its training before it is used, its errata.

Those on its filter and on its other groups of weights are in ``claims_inference_filter``.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.neural.centres import TrainedCentres, best_centres, train_centres
from leadscrew.neural.inference_net import (
    AXIS,
    CENTRES,
    CHINESE_RULES,
    LABELS,
    RULES,
    W0,
    fired,
    network_output,
    regressors,
)
from leadscrew.neural.samples import LEVELS, Trained, copied_rmse, reasoning_samples, rms, train_rules, trained_start
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.claims_inference_filter import filter_claims
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said

arithmetic = partial(said, basis="arithmetic")
printed = partial(said, basis="arithmetic", group="as printed")

TABLE = "digest section 3, table"

TRAINING = (
    ("", "default rules", None, 0.537, 0.1702, 0.1705),
    ("_chinese", "Chinese table", CHINESE_RULES, 0.321, 0.1561, 0.149),
)
"""Suffix, words, rules; the digest's RMSE: copied, least squares, centres too."""
ROW_ZO = (5.013, 3.716, 2.039, 0.0, -2.039, -3.716, -5.013)
"""W0 after training, EC = ZO, in the digest."""


def inference_claims(loops: Loops) -> list[Claim]:
    """Section 3 of the digest, A4, the on-line EKF of section 7, and errata 4, 5, 6 and 16 of the network."""
    return [
        *_network(), *_training(), *_centres(), *filter_claims(loops), *_errata()
    ]  # fmt: skip


# ---- what it computes
def _network() -> Iterator[Claim]:
    points = np.random.default_rng(1).uniform(-7.0, 7.0, (500, 2))
    h = regressors(points[:, 0], points[:, 1])
    apart = float(np.abs(h.sum(axis=1) - 1.0).max())
    yield arithmetic(
        "partition_of_unity", "equation (2)", "largest difference of the sum of all firing strengths from one", apart,
        "1", 1e-12, f"{len(points)} points, also outside the universe; so the denominator of (2) can be left out",
        sense="<=",
    )  # fmt: skip
    most = int((h > 0.0).sum(axis=1).max())
    ours = [network_output(W0, fired(AXIS, AXIS, *point)) for point in points]
    worst = float(np.abs(np.array(ours) - (h @ W0) / h.sum(axis=1)).max())
    yield arithmetic(
        "four_rules_suffice", "equation (2)", "largest difference of the interpolation of four consequents from (2)",
        worst, "level", 1e-12, f"{most} of {RULES} rules fire at most: the network is the bilinear interpolation of "
        "its consequents", sense="<=",
    )  # fmt: skip


# ---- training before it is used
def _training() -> Iterator[Claim]:
    for suffix, words, rules, copied, least, _ in TRAINING:
        one = trained_start(rules)
        plain = copied_rmse(rules)
        yield arithmetic(
            f"copied_rules{suffix}", TABLE, f"RMSE against the Mamdani system, consequents of the {words} copied",
            plain, "level", copied, "the rules themselves, interpolated, without training", tolerance=0.0005,
        )  # fmt: skip
        yield arithmetic(
            f"least_squares{suffix}", TABLE, f"the same for the least squares, {words}", one.least, "level", least,
            f"{1.0 - one.least / plain:.0%} of the difference goes; what is left is max-min and centroid against "
            "product and interpolation, which no consequents can take away", tolerance=0.00005,
        )  # fmt: skip
        yield arithmetic(
            f"one_pass_is_batch{suffix}", "step (2), A4",
            f"RMSE of one Kalman pass less that of least squares, {words}",
            one.rmse - one.least, "level", 0.0, f"{one.rmse:.7f} against {one.least:.7f}: the problem is linear in the "
            "consequents, so one pass ends at the batch solution but for the prior variance of 100", tolerance=1e-3,
        )  # fmt: skip
    yield from _start(trained_start())


def _start(one: Trained) -> Iterator[Claim]:
    row = one.weights.reshape(7, 7)[3]
    yield arithmetic(
        "golden_w0", "digest section 3, W0", "largest difference of the trained consequents in the row EC = ZO from "
        "the digest's", float(np.abs(row - ROW_ZO).max()), "level", 0.01,
        f"trained here: {', '.join(f'{abs(w):.3f}' if abs(w) < 5e-4 else f'{w:.3f}' for w in row)}; all 49 within "
        f"{np.abs(one.weights - W0).max():.1e} of those that are kept", sense="<=",
    )  # fmt: skip
    samples = reasoning_samples()
    h = regressors(samples.e, samples.ec)
    rank = int(np.linalg.matrix_rank(h))
    yield arithmetic(
        "samples_rank", TABLE, "rank of the regressors of the 169 samples", rank, "1", 49,
        "every consequent is determined by the samples",
    )  # fmt: skip
    at_peaks = np.isin(samples.e, CENTRES) & np.isin(samples.ec, CENTRES)
    few = train_rules(type(samples)(*(x[at_peaks] for x in samples)))
    rmse = rms(h @ few.weights - samples.d)
    yield arithmetic(
        "few_samples", "digest section 3, 49 samples", "RMSE over all 169 samples, trained on the 49 at the peaks",
        rmse, "level", None, f"{at_peaks.sum()} samples determine all consequents (left over there: {few.rmse:.1e}); "
        f"over all samples {rmse:.4f} against {one.least:.4f} with all of them: enough to be determined, not enough to "
        "be as good", kind="report",
    )  # fmt: skip


def _centres() -> Iterator[Claim]:
    for suffix, words, rules, _, least, digest in TRAINING:
        found = train_centres(reasoning_samples(rules))
        known = suffix == ""
        why = (
            "no better than least squares of the consequents alone: even centres are already the best"
            if known
            else "the digest's 0.149 is within the last digit of the optimum, which ten passes of this filter do not "
            "reach; its start and variances are not given"
        )
        yield arithmetic(
            f"trained_centres{suffix}", TABLE, f"RMSE of the EKF of consequents and 10 centres, 10 passes, {words}",
            found.rmse, "level", digest, f"against {least:.4f}: {why}", tolerance=0.00005 if known else 0.0005,
            kind="required" if known else "report",
        )  # fmt: skip
    chinese = reasoning_samples(CHINESE_RULES)
    best: TrainedCentres = best_centres(chinese)
    alone = trained_start(CHINESE_RULES).least
    yield arithmetic(
        "centres_gain", TABLE, "least-squares optimum of consequents and centres: RMSE lower than of consequents alone",
        100.0 * (1.0 - best.rmse / alone), "%", 5.0, f"{best.rmse:.4f} against {alone:.4f}, Chinese table; SciPy's "
        "trust region over the centres: the consequents are worth training, the centres are not", sense="<=",
    )  # fmt: skip


# ---- errata
def _errata() -> Iterator[Claim]:
    e, ec = (x.ravel() for x in np.meshgrid(LEVELS, LEVELS))
    h = regressors(e, ec)
    undefined = 100.0 * float((h[:, :2].sum(axis=1) == 0.0).mean())
    yield printed(
        "erratum_4_indices", "equation (2), erratum 4", "share of the 13 x 13 levels at which (2) with one n for "
        "inputs and rules, n = 2, is 0/0", undefined, "%", 100.0 * 161.0 / 169.0, "the product has two factors and the "
        f"sum {h.shape[1]} terms; the product starts at j = 0, where there is no input, and the inputs' list at j = i",
        paper="one n", verdict="not reproduced" if undefined > 0.0 else "reproduced", tolerance=0.01,
    )  # fmt: skip
    apart = copied_rmse()
    yield printed(
        "erratum_5_singletons", "equations (1) and (2), erratum 5", "RMS difference between B_i as a set, (1), and as "
        "a number, (2), over the 13 x 13 levels", apart, "level", 0.537, "two different inferences; the network is (2)",
        paper="one B_i", verdict="not reproduced" if apart > 0.0 else "reproduced", tolerance=0.0005,
    )  # fmt: skip
    listed = ("NB", "NM", "NS", "ZO", "BP", "PM", "PB")
    wrong = [f"{theirs} for {ours}" for theirs, ours in zip(listed, LABELS, strict=True) if theirs != ours]
    yield printed(
        "erratum_6_bp", "section 3, list of the sets, erratum 6", "where the printed list of seven sets is not the "
        "usual one", ", ".join(wrong), "", None, "read off the paper: PB stands in its place at the end of the list, "
        "and the text about figure 4 says PS; the digest reads BP as PB", sense="yes/no", kind="report",
        paper=", ".join(listed),
    )  # fmt: skip
    kept = {"PNN": 18, "FRN and FRNC": RULES}
    yield printed(
        "erratum_16_frn_frnc", "figures 1 and 2, conclusion, erratum 16", "networks that the controller needs, for the "
        "three names PNN, FRN and FRNC", len(kept), "", None, "read off the paper: "
        + ", ".join(f"{name} with {count} weights that are learned" for name, count in kept.items())
        + "; no step of its section 4 has a third network", kind="report", paper="3 names",
    )  # fmt: skip
