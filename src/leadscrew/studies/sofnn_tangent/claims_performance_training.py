"""Claims about training the performance network: RMSE by method and reading, unsafe shares, hidden size, weights."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import pairwise

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.performance_runs import SIZES, Row, of, shape_named, trainings
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, word

READ = ("18_linear", "18", "25", "16_four_hidden")
"""Columns of the digest's table."""
DIGEST: dict[str, tuple[tuple[float, float], ...]] = {
    "ga_16x200": ((0.78, 0.91), (0.83, 0.88), (0.91, 0.97), (0.93, 0.97)),
    "ga_80x600": ((0.72, 0.77), (0.73, 0.78), (0.76, 0.80), (0.73, 0.90)),
    "ga_80x2000": ((0.69, 0.72), (0.71, 0.75), (0.73, 0.76)),
    "pymoo_80x600": ((0.79, 0.88), (0.84, 0.85), (0.86, 0.88)),
    "cma_48k": ((0.61, 0.65), (0.60, 0.64), (0.57, 0.63)),
    "ga+lm": ((0.61, 0.65), (0.59, 0.66), (0.55, 0.61), (0.69, 0.83)),
    "lm": ((0.606, 0.650), (0.589, 0.668), (0.569, 0.621)),
}
"""Best and median RMSE by method and reading, levels; section 4 of the digest."""
SAID = {
    "ga_16x200": "genetic algorithm, 16 x 200",
    "ga_80x600": "genetic algorithm, 80 x 600",
    "ga_80x2000": "genetic algorithm, 80 x 2000",
    "pymoo_80x600": "pymoo's genetic algorithm, 80 x 600",
    "cma_48k": "CMA-ES, 48,000 evaluations",
    "ga+lm": "genetic algorithm, then least squares",
    "lm": "least squares from random starts",
}
SHARES = {"ga_80x600": (0, 36), "ga+lm": (11, 36), "lm": (12, 60)}
"""Trainings of 18 weights with a slope of 0 or more at the origin, and all; the digest."""
GOOD_RMSE = 0.68
"""Trainings that ended in a good valley, levels."""
HIDDEN = {6: 0.58, 10: 0.47, 12: 0.40, 20: 0.26, 30: 0.19, 40: 0.06}
"""Best RMSE by hidden neurons, levels; the digest."""

APART = frozenset({
    "rmse_ga_80x600_18_linear", "rmse_ga_80x2000_18_linear", "rmse_ga_80x2000_18", "bad_slopes_ga_80x600",
    "hidden_30", "hidden_40",
})  # fmt: skip
"""Claims whose number is not the digest's within the scatter of the seeds; they only report."""

trained = partial(said, group="ours", basis="arithmetic")
SOURCE = "digest, section 4"


def performance_training_claims(loops: Loops | None = None) -> list[Claim]:
    """A2 and the trainings of section 4, from the kept rows; no training runs."""
    return [*_methods(), *_best_of_three(), *_shares(), *_biased(), *_sizes(), *_weights()]


def _methods() -> Iterator[Claim]:
    for method, columns in DIGEST.items():
        for reading, (best, median) in zip(READ, columns, strict=False):
            name = f"rmse_{method.replace('+', '_')}_{reading}"
            rmse = np.array([r.rmse for r in of(reading, method)])
            spread = float(rmse.std(ddof=1))
            apart = "; apart by more than the seeds scatter, and the digest does not give its seeds"
            yield trained(
                name, SOURCE, f"median RMSE, {SAID[method]}: {shape_named(reading).name}", float(np.median(rmse)),
                "levels", median, f"{rmse.size} seeds, best {rmse.min():.3f} (digest {best:g}), standard deviation "
                f"{spread:.3f}{apart if name in APART else ''}", tolerance=spread + 0.005,
                kind="report" if name in APART else "required",
            )  # fmt: skip


def _best_of_three() -> Iterator[Claim]:
    first = [r.rmse for r in of("18", "ga_80x600") if r.seed < 3]
    yield trained(
        "ga_best_of_three", "acceptance A2", "smallest RMSE of three seeds of the genetic algorithm alone, 18 weights",
        min(first), "levels", 0.85, ", ".join(f"{v:.3f}" for v in first) + "; one takes below 1 s on a free core",
        sense="<=",
    )  # fmt: skip
    alone, polished = (np.median([r.rmse for r in of("18", m)]) for m in ("ga_80x600", "ga+lm"))
    yield trained(
        "polish_gain", "acceptance A2", "what least squares takes off the median RMSE of the genetic algorithm",
        float(alone - polished), "levels", 0.0, f"{alone:.3f} to {polished:.3f}: a gradient finds in a second what "
        "generations do not", sense=">=",
    )  # fmt: skip


def _shares() -> Iterator[Claim]:
    for method, (bad, count) in SHARES.items():
        name = f"bad_slopes_{method.replace('+', '_')}"
        rows = of("18", method)
        near, wrong, safe = (
            sum(fits) for fits in zip(*((r.quarter >= 0.0, r.slope >= 0.0, -1.5 <= r.slope <= -0.4) for r in rows),
                                      strict=True)
        )  # fmt: skip
        share = bad / count
        yield trained(
            name, SOURCE + ", sign safety", "trainings of 18 weights that drive the wrong way between E = -0.25 "
            f"and 0.25, {SAID[method]}", near, f"of {len(rows)}", bad, f"digest {bad} of {count}, with its slopes over "
            f"such a step; at the origin itself {wrong} of {len(rows)} have a slope of 0 or more, {safe} a safe one"
            f"{'; more often than in the digest, whose seeds are not given' if name in APART else ''}",
            tolerance=2.0 * float(np.sqrt(count * share * (1.0 - share))) + 0.5,
            kind="report" if name in APART else "required",
        )  # fmt: skip
    rows = [r for r in trainings() if r.reading == "18" and r.method in ("lm", "ga+lm", "cma_48k")]
    best = sorted(rows, key=lambda r: r.rmse)[:20]
    unsafe = sum(r.slope > -0.4 for r in best)
    yield trained(
        "rmse_is_no_test", SOURCE + ", headline 3", "of the twenty trainings of 18 weights of the smallest RMSE, those "
        "with a slope above -0.4", unsafe, "of 20", None, f"RMSE {best[0].rmse:.3f} to {best[-1].rmse:.3f} levels: how "
        "well the cells are met says nothing about the way between them", kind="report",
    )  # fmt: skip


def _biased() -> Iterator[Claim]:
    for method, digest in (("ga_80x600", 0.30), ("lm", 0.50)):
        origins = np.array([r.origin for r in of("25", method)])
        yield trained(
            f"biased_origin_{method}", SOURCE + ", sign safety", f"largest |P(0, 0)| of 25 weights, {SAID[method]}",
            float(np.abs(origins).max()), "levels", digest, f"{origins.size} seeds, root mean square "
            f"{np.sqrt(np.mean(origins**2)):.2f}; below 0.02 in {np.count_nonzero(np.abs(origins) < 0.02)} of them. "
            "The largest of so many draws is no steady number", kind="report",
        )  # fmt: skip
    yield trained(
        "biased_never_safe", SOURCE + ", sign safety", "trainings of 25 weights on the cells alone with |P(0, 0)| "
        "below 0.02 and a slope of -1.5 to -0.4",
        sum(abs(r.origin) < 0.02 and -1.5 <= r.slope <= -0.4 for r in _plain("25")), f"of {len(_plain('25'))}", None,
        "with biases, P(0, 0) = 0 has to be asked for", kind="report",
    )  # fmt: skip


def _plain(reading: str) -> list[Row]:
    return [r for r in trainings() if r.reading == reading]


def _sizes() -> Iterator[Claim]:
    best = {}
    for size in SIZES:
        rows = of(f"hidden_{size}", "lm")
        rmse = np.array([r.rmse for r in rows])
        best[size] = min(rows, key=lambda r: r.rmse)
        spread = float(rmse.std(ddof=1))
        name, count = f"hidden_{size}", shape_named(f"hidden_{size}").weights
        less = "; less than in the digest, which does not say how many starts" if name in APART else ""
        yield trained(
            name, SOURCE + ", hidden size", f"smallest RMSE with {size} hidden neurons and all biases",
            float(rmse.min()), "levels", HIDDEN[size], f"{rmse.size} starts of least squares, {count} weights, "
            f"standard deviation of the starts {spread:.3f}; {100.0 * best[size].exact:.0f} % of the cells exact{less}",
            tolerance=spread + 0.005, kind="report" if name in APART else "required",
        )  # fmt: skip
    falls = all(best[a].rmse > best[b].rmse for a, b in pairwise(SIZES))
    yield trained(
        "hidden_falls", SOURCE + ", hidden size", "the RMSE falls with every size", word(falls), "", "yes",
        "the table can be memorised, but not by six neurons", sense="yes/no",
    )  # fmt: skip
    largest = best[SIZES[-1]]
    yield trained(
        "hidden_40_exact", SOURCE + ", hidden size", "cells that 161 weights give exactly after rounding",
        169 * largest.exact, "of 169", 169.0, f"RMSE {largest.rmse:.3f}", sense="=", tolerance=1e-9,
    )  # fmt: skip


def _weights() -> Iterator[Claim]:
    good = [r for m in ("lm", "ga+lm", "cma_48k") for r in of("18", m) if r.rmse <= GOOD_RMSE]
    for name, words, values, digest in (
        ("exact", "exact after rounding", np.rint([169 * r.exact for r in good]), "65 to 75 %"),
        ("within_one", "within a level after rounding", np.rint([169 * r.within_one for r in good]), "96 to 99 %"),
    ):
        share = values / 1.69
        yield trained(
            f"memorised_{name}", "section 2 of the paper, \"memory\"", f"cells of 169 that a network of 18 weights "
            f"gives {words}, median", float(np.median(values)), "cells", None, f"{len(good)} trainings of an RMSE of "
            f"{GOOD_RMSE:g} or less: {share.min():.0f} to {share.max():.0f} %, the digest has {digest}", kind="report",
            paper="memory of the table", verdict="reproduced" if values.max() == 169.0 else "not reproduced",
        )  # fmt: skip
    largest = np.array([r.largest for r in good])
    yield trained(
        "memorised_largest", "section 2 of the paper, \"memory\"", "largest difference to a cell, median of the same "
        "trainings", float(np.median(largest)), "levels", 2.0, f"{largest.min():.2f} to {largest.max():.2f}; the "
        "digest says about 2", tolerance=0.5,
    )  # fmt: skip
    most = np.array([r.most_weight for r in of("18", "lm_free")])
    held = np.array([r.most_weight for r in of("18", "lm")])
    yield trained(
        "free_weights", SOURCE, "largest weight of least squares with neither ridge nor box, 18 weights",
        float(most.max()), "", 6e4, f"{most.size} starts, median {np.median(most):.3g}; with ridge and box "
        f"{held.max():.3g} at most: the RMSE is flat there, and the weights run off", sense=">=", kind="report",
    )  # fmt: skip
