"""Claims about the Kalman filter of the inference network, and about the groups of weights that it leaves alone."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.neural.inference_net import CENTRES, RULES, W0, regressors
from leadscrew.neural.samples import rms
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.inference_filter import (
    FORGETTING,
    P0,
    UPDATES,
    apart_from_dense,
    forms_kept,
    judged,
    learned,
    update_cost,
)
from leadscrew.studies.sofnn_tangent.inference_runs import (
    LITERAL,
    TUNED,
    centres_on_the_way,
    groups_kept,
    laps_with,
)
from leadscrew.studies.sofnn_tangent.lines import MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, word

arithmetic = partial(said, basis="arithmetic")
printed = partial(said, basis="arithmetic", group="as printed")

SAFETY = "digest section 3, numerical safety"
GROUPS = "digest section 3, v_kj"
ONLINE = "digest section 7, on-line EKF of centres"
DIGEST_LAPS = 1.36, 4.28
"""RMS of laps 1 and 20 with forgetting, deg."""


def filter_claims(loops: Loops) -> list[Claim]:
    """The filter of section 3 of the digest, v_kj, the on-line EKF of section 7, what an update costs."""
    return [*_safety(loops), *_groups(), *_online(loops), *_cost()]


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
        "no cap", gone.rms[-1] / gone.rms[0], "1", DIGEST_LAPS[1] / DIGEST_LAPS[0],
        f"{gone.rms[0]:.2f} deg in lap 1, {gone.rms[-1]:.2f} in lap 20, trace {gone.trace[-1]:.0e}; with Q and cap "
        f"{kept.rms[0]:.2f} and {kept.rms[-1]:.2f}, trace {kept.trace[-1]:.0f}. The digest has {DIGEST_LAPS[0]:g}, "
        f"{DIGEST_LAPS[1]:g} and 4e10: its first lap is ours, its last is not. What happens then hangs on what is done "
        "with numbers of that size; not explained further", tolerance=0.01, kind="report",
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


# ---- what an update costs
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
        "2,401 elements of P is left. The digest's dense step takes 11.6 us. The whole step of the network: "
        "step_marginal", kind="report", basis="arithmetic",
    )  # fmt: skip
