"""Claims about the fuzzy inference network: what it computes, its training, its filter, its other groups of weights."""

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
from leadscrew.studies.sofnn_tangent.inference_runs import (
    FORGETTING,
    LITERAL,
    P0,
    TUNED,
    UPDATES,
    apart_from_dense,
    centres_on_the_way,
    forms_kept,
    groups_kept,
    judged,
    laps_with,
    learned,
    update_cost,
)
from leadscrew.studies.sofnn_tangent.lines import MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, word

arithmetic = partial(said, basis="arithmetic")
printed = partial(said, basis="arithmetic", group="as printed")

TABLE = "digest section 3, table"
SAFETY = "digest section 3, numerical safety"
GROUPS = "digest section 3, v_kj"
ONLINE = "digest section 7, on-line EKF of centres"

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
        *_network(), *_training(), *_centres(), *_safety(loops), *_groups(), *_online(loops), *_errata(loops), *_cost()
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


# ---- the filter
def _safety(loops: Loops) -> Iterator[Claim]:
    at = {(row.form, row.bits, row.forgetting, row.updates): row for row in forms_kept()}
    single, double = at["naive", 32, 1.0, 2000], at["naive", 64, 1.0, UPDATES]
    yield arithmetic(
        "naive_single_breaks", SAFETY, "P - K (P h)' in single precision is positive definite after 2000 updates",
        word(single.positive), "", "no", f"it is not from {_first_lost('naive', 32, 1.0)} updates on; an error of P h "
        "goes into both triangles and is never taken back", sense="yes/no",
    )  # fmt: skip
    yield arithmetic(
        "naive_double_holds", SAFETY, f"the same in double precision after {UPDATES:,} updates", word(double.positive),
        "", "yes", "P0 = 1e4, R = 1e-4, only the nine rules around zero excited", sense="yes/no",
    )  # fmt: skip
    joseph = at["joseph", 32, 1.0, UPDATES].positive
    yield arithmetic(
        "joseph_single_holds", SAFETY, f"Joseph's form in single precision after {UPDATES:,} updates", word(joseph), "",
        "yes", "so does the mean of P - K (h' P) and its mirror image: "
        f"{word(at['symmetrised', 32, 1.0, UPDATES].positive)}", sense="yes/no",
    )  # fmt: skip
    last = [row for row in forms_kept() if row.forgetting < 1.0 and row.updates == UPDATES]
    lost = sum(not row.finite or row.trace > 1e100 for row in last)
    broken = _first_lost("naive", 64, FORGETTING)
    yield arithmetic(
        "forgetting_blows_up", SAFETY, f"forms and precisions, of {len(last)}, whose covariance is lost by forgetting "
        f"{FORGETTING}", lost, "1", len(last), "a trace above 1e100, or no number any more (all in single precision: "
        f"{word(all(not row.finite for row in last if row.bits == 32))}); the naive form is not even positive definite "
        f"in double precision from {broken} updates on",
    )  # fmt: skip
    trace = float(np.log10(at["joseph", 64, FORGETTING, UPDATES].trace))
    exact = float(np.log10(40.0 * P0) - UPDATES * np.log10(FORGETTING))
    yield arithmetic(
        "forgetting_trace", SAFETY, f"decimal exponent of the trace after {UPDATES:,} updates with forgetting, double "
        "precision", trace, "1", 180.9, f"40 rules that nothing excites have 40 P0 / {FORGETTING}^{UPDATES} = "
        f"1e{exact:.2f} of it; the digest's 8e180 is that after 19,980 updates", tolerance=0.2,
    )  # fmt: skip
    hard, mild = learned(), learned(q=0.05, cap=4.0, r=0.01)
    sound = judged(hard)[1] and judged(mild)[1]
    yield arithmetic(
        "covariance_symmetric", "A4", f"asymmetry of P of the network's own filter after {UPDATES:,} updates",
        max(judged(hard)[2], judged(mild)[2]), "level^2", 1e-10, "every element is computed as its mirror image is; "
        "with P0 = 1e4, R = 1e-4 and no walk, and as the controllers run it", sense="<=",
    )  # fmt: skip
    yield arithmetic(
        "covariance_positive", "A4", "it is positive definite then", word(sound), "", "yes",
        f"smallest eigenvalue {np.linalg.eigvalsh(hard)[0]:.1e} and {np.linalg.eigvalsh(mild)[0]:.3f} levels squared; "
        f"with Q = 0.05 and the cap at 4 no element of the diagonal is above {mild.diagonal().max():.6f}",
        sense="yes/no",
    )  # fmt: skip
    kept, gone = laps_with(loops, TUNED), laps_with(loops, TUNED | {"forgetting": FORGETTING, "q": 0.0, "cap": 1e300})
    yield said(
        "forgetting_laps", SAFETY, "RMS of lap 20 of the flower over lap 1, tuned network with forgetting, Q = 0 and "
        "no cap", gone.rms[-1] / gone.rms[0], "1", 1.0,
        f"{gone.rms[0]:.2f} deg in lap 1, {gone.rms[-1]:.2f} in lap 20, "
        f"trace {gone.trace[-1]:.0e}; with Q and cap {kept.rms[0]:.2f} and {kept.rms[-1]:.2f}, trace "
        f"{kept.trace[-1]:.0f}. The digest has 1.36, 4.28 and 4e10: its first lap is ours, the rest hangs on what is "
        "done with numbers of that size", sense=">=",
    )  # fmt: skip


def _first_lost(form: str, bits: int, forgetting: float) -> int:
    """Updates at the first mark at which a covariance was not positive definite."""
    return next(
        r.updates for r in forms_kept() if (r.form, r.bits, r.forgetting) == (form, bits, forgetting) and not r.positive
    )


# ---- v_kj, and all groups together
def _groups() -> Iterator[Claim]:
    points = np.random.default_rng(2).uniform(-6.0, 6.0, (250, 2))
    h = regressors(points[:, 0], points[:, 1])
    said_at = (h @ W0)[:, None]
    by_certainty = h * (W0 - said_at)  # at certainties of one; a factor of a rule's two weights enters it alike
    rank = int(np.linalg.matrix_rank(np.hstack([by_certainty, by_certainty])))
    yield printed(
        "incidence_collapses", GROUPS, "independent directions in which the 98 weights v_kj change the output", rank,
        "1", 48, "two weights of a rule enter as a product, so 49 certainties are left of 98, and a factor common to "
        "all cancels in the normalisation, so 48 of those", tolerance=0.0,
    )  # fmt: skip
    certainty = np.random.default_rng(3).uniform(0.2, 5.0, RULES)
    e, ec = (x.ravel() for x in np.meshgrid(CENTRES, CENTRES))
    peaks = regressors(e, ec) * certainty
    gone = float(np.abs(peaks @ W0 / peaks.sum(axis=1) - W0).max())
    between = h * certainty
    moved = rms(between @ W0 / between.sum(axis=1) - said_at[:, 0])
    yield printed(
        "certainty_cancels", GROUPS, "largest change of the output at the rules' peaks under certainties of 0.2 to 5",
        gone, "level", 1e-12, f"where one rule fires alone its certainty cancels; between the peaks {moved:.2f} levels "
        "RMS of another interpolation are left", sense="<=",
    )  # fmt: skip


def _online(loops: Loops) -> Iterator[Claim]:
    kept = groups_kept()
    base, large = kept["literal"], kept["literal, centres 0.01"]
    small = float(kept["literal, centres 1e-4"].mean())
    yield said(
        "centres_small_walk", ONLINE, "change of the mean RMS of the nine cells when the centres learn too, Q_c = 1e-4",
        100.0 * (small / base.mean() - 1.0), "%", 0.0,
        f"{small:.3f} against {base.mean():.3f} deg with consequents alone, the paper's loop", tolerance=2.0,
    )  # fmt: skip
    change = 100.0 * (large / base - 1.0)
    tuned, wild = kept["tuned"].mean(), kept["tuned, centres 0.01"].mean()
    yield said(
        "centres_large_walk", ONLINE, "largest fall of the RMS in a cell, Q_c = 0.01", -float(change.min()), "%", 16.0,
        f"{change.min():+.0f} to {change.max():+.0f} % in the nine cells, mean {large.mean():.3f} against "
        f"{base.mean():.3f} deg; in the tuned loop the mean goes from {tuned:.2f} to {wild:.2f} deg: off by default",
        tolerance=2.0,
    )  # fmt: skip
    ends = {
        name: centres_on_the_way(loops, "wave_fabric", name, LITERAL | {"q_centre": 0.01}).centres[-1, 2]
        for name in MATERIAL_NAMES
    }
    yield said(
        "centres_wander", ONLINE, "centre of NS of E, -2 at the start, at the end of the wave, Q_c = 0.01, mean",
        float(np.mean(list(ends.values()))), "level", -0.5,
        f"{', '.join(f'{name} {end:.2f}' for name, end in ends.items())}: what was called small is next to zero, so "
        "the rules no longer say what their names say", tolerance=0.2,
    )  # fmt: skip
    both, certain = kept["literal, both 0.01"], kept["literal, certainties 0.01"]
    ratio, alone = 100.0 * (both / base - 1.0), 100.0 * (certain / base - 1.0)
    yield said(
        "three_groups_learned", "section 3, v_ji, v_kj and v_ok", "mean RMS of the nine cells when all three groups "
        "learn, walks of 0.01", float(both.mean()), "deg", None,
        f"{base.mean():.3f} deg with consequents alone ({ratio.min():+.0f} to {ratio.max():+.0f} % by cell); "
        f"consequents and certainties {certain.mean():.3f} deg ({alone.min():+.0f} to {alone.max():+.0f} %). Tuned "
        f"scales alone give {tuned:.2f} deg", kind="report",
    )  # fmt: skip


# ---- errata
def _errata(loops: Loops) -> Iterator[Claim]:
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
        "usual one", ", ".join(wrong), "", "BP for PS", "PB stands in its place at the end of the list, and the text "
        "about figure 4 says PS; the digest reads BP as PB", sense="yes/no", paper=", ".join(listed),
        verdict="not reproduced" if wrong else "reproduced",
    )  # fmt: skip
    learning = [loops.controllers["paper.sofnn_pnn"].state, loops.controllers["paper.sofnn_pnn"].params]
    found = [type(x).__name__ for x in learning if hasattr(x, "weights") or hasattr(x, "net")]
    yield printed(
        "erratum_16_frn_frnc", "figures 1 and 2, conclusion, erratum 16", "networks that the controller needs, for the "
        "three names PNN, FRN and FRNC", len(found), "1", 2, "one in the controller's parameters, the performance "
        "network, and one in its state, the rules: FRN and FRNC are the same", paper="3 names",
        verdict="not reproduced" if len(found) < 3 else "reproduced",
    )  # fmt: skip


def _cost() -> Iterator[Claim]:
    yield arithmetic(
        "sparse_is_dense", "issue 10, acceptance 2", "largest difference of consequents and covariance from the plain "
        "matrix formula", apart_from_dense(), "level", 1e-9, "1,500 updates all over the universe, compiled against "
        "NumPy's dense matrices; a slow test goes on to 100,000", sense="<=",
    )  # fmt: skip
    cost = update_cost()
    yield said(
        "update_cost", "issue 10, acceptance 2", "time of one Kalman update of the 49 consequents, compiled", cost,
        "us", None, "on this machine, as it is busy now, the best of a few; four rows make P h, one pass over the "
        "2,401 elements of P is left. The digest's dense step takes 11.6 us", kind="report", basis="arithmetic",
    )  # fmt: skip


__all__ = ["inference_claims"]
