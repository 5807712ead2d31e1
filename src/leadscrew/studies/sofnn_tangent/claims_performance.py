"""Claims about the performance measurement: Table 1, the golden network, what makes a network safe."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.neural.performance import GOLDEN, LEVELS, TABLE, measured
from leadscrew.neural.performance_shape import BIASES, READINGS, Shape
from leadscrew.neural.safety import WORST_RMSE, crossing, safety
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.performance_facts import (
    even_part,
    membership,
    nearest_plane,
    odd_part,
    rises,
    rows_with_humps,
    uneven_pairs,
    wrong_signs,
)
from leadscrew.studies.sofnn_tangent.performance_runs import NAMES, accepted_net, nets
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, verdict_of, word

LEVEL_DEG = 15.0
"""Degrees a level at the literal scale, 90 / 6."""
AREAS = {"I": (-4.0, 2.0, "PS", 2.0, 2.71), "II": (2.0, 2.0, "NS", -2.0, -2.63), "III": (2.0, -2.0, "ZO", 0.0, -0.56)}
"""Areas of Figure 4: E, EC, the paper's P and its centre; the golden network's value in the digest."""

table = partial(said, group="as printed", basis="paper's data")
network = partial(said, group="as corrected", basis="arithmetic")


def performance_claims(loops: Loops | None = None) -> list[Claim]:
    """A1 and A3, sections 2 and 4 of the digest, errata 1, 2, 7 and 17; no loop runs."""
    return [*_table(), *_shape_of_table(), *_areas(), *_counts(), *_golden(), *_unsafe()]


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _table() -> Iterator[Claim]:
    source = "Table 1"
    numbers = [
        ("mean", "mean of the 169 cells", float(TABLE.mean()), "levels", -0.124, 0.0005, "an odd table has 0"),
        ("rms", "root mean square of the cells", _rms(TABLE), "levels", 3.475, 0.0005, "of 6 at most"),
        ("zeros", "cells that correct nothing", int(np.count_nonzero(TABLE == 0.0)), "", 66, 0.0,
         f"{100.0 * np.mean(TABLE == 0.0):.0f} % of the table"),
        ("odd_rms", "root mean square of the odd part", _rms(odd_part(TABLE)), "levels", 3.459, 0.0005,
         "all that a network without biases can learn"),
        ("even_rms", "root mean square of the even part (A1)", _rms(even_part(TABLE)), "levels", 0.331, 0.0005,
         "no odd network can have a smaller RMSE"),
    ]  # fmt: skip
    for name, statement, value, unit, target, tolerance, reason in numbers:
        yield table(f"table_{name}", source, statement, value, unit, target, reason, tolerance=tolerance)
    plane = nearest_plane(TABLE)
    yield table(
        "table_plane", source, "RMSE of the nearest held plane P = -(a E + b EC)", plane.rmse, "levels", 1.23,
        f"a = {plane.a:.3f}, b = {plane.b:.3f}; the digest has 0.75 and 0.50, which give the same to its digits: the "
        "table is a proportional and derivative action with a limit, and 1.2 levels of something else",
        tolerance=0.005,
    )  # fmt: skip


def _shape_of_table() -> Iterator[Claim]:
    source = "Table 1 (erratum 7)"
    pairs = uneven_pairs(TABLE)
    worst = max(pairs, key=lambda p: abs(p.value + p.mirror))
    right = sum((abs(p.value) > abs(p.mirror)) == (p.e > 0) for p in pairs)
    yield table(
        "table_uneven_pairs", source, "pairs of mirrored cells, of 84, that do not cancel (A1)", len(pairs), "", 20,
        f"the largest at EC = {worst.ec}, E = {worst.e}: {worst.value:g} and {worst.mirror:g}; in "
        f"{right} of them the cell with E > 0 corrects more",
    )  # fmt: skip
    yield table(
        "table_worst_pair", source, "sum of the pair that cancels least", worst.value + worst.mirror, "levels", -3.0,
        f"at E = {worst.e} and {-worst.e}, EC = {worst.ec}",
    )  # fmt: skip
    rows = ", ".join(str(ec) for ec in rows_with_humps(TABLE))
    yield table(
        "table_rises_e", source, "steps along E where a larger deviation gets a smaller correction (A1)",
        rises(TABLE, 1), "", 10, f"in the rows EC = {rows}, all where the deviation is large and already returns",
    )  # fmt: skip
    yield table(
        "table_rises_ec", source, "steps along EC where the correction rises (A1)", rises(TABLE, 0), "", 3,
        "the deviation grows faster and is corrected less",
    )  # fmt: skip
    still = int(np.count_nonzero(TABLE[:, 6]))
    yield table(
        "table_no_anticipation", source, "rows that correct anything at E = 0", still, "", 0,
        "crossing zero at any speed is not corrected: the table has no anticipation there",
    )  # fmt: skip
    yield table(
        "table_sign", source, "cells whose correction has the sign of E, or of E + EC",
        wrong_signs(TABLE, 0.0) + wrong_signs(TABLE, 1.0), "", 0, "the table itself never drives the wrong way",
    )  # fmt: skip


def _areas() -> Iterator[Claim]:
    for name, (e, ec, says, centre, _) in AREAS.items():
        value = float(TABLE[int(ec) + 6, int(e) + 6])
        belongs = membership(value, centre)
        yield table(
            f"area_{name.lower()}", "section 3 and Figure 4 (erratum 17)", f"Table 1 in area {name}, E = {e:g}, EC = "
            f"{ec:g}", value, "levels", {"I": 3.0, "II": -2.0, "III": 0.0}[name], f"the text says {says}, {centre:g}; "
            f"{value:g} belongs to it by {belongs:g}", paper=centre, verdict=verdict_of(belongs >= 0.5),
        )  # fmt: skip
    yield table(
        "areas_given", "section 3 and Figure 4 (erratum 17)", "combinations of sets of E and EC that the text derives",
        len(AREAS), "", None, "read off the paper, of 49; the others (\"by that analogy\") are in Table 1 alone",
        kind="report", basis="paper's data",
    )  # fmt: skip


def _counts() -> Iterator[Claim]:
    source = "section 3, P = 2 (2 + 6) = 16 (erratum 1)"
    for name, target in (("18", 18), ("19", 19), ("24", 24), ("25", 25)):
        shape = READINGS[name]
        yield table(
            f"weights_{name}", source, f"weights of a network {shape.name.split(', tanh')[0]}", shape.weights, "",
            target, "the paper's network 2-6-1 in this reading; not 16", basis="arithmetic", paper=16,
            verdict=verdict_of(shape.weights == 16),
        )  # fmt: skip
    shapes = [Shape(h, biases) for h in range(16, 0, -1) for biases in BIASES]
    fits = "; ".join(s.name.split(", tanh")[0] for s in shapes if s.weights == 16)
    yield table(
        "weights_16", source, "networks 2-h-1 that do have 16 weights", fits, "",
        "2-5-1, output bias; 2-4-1, hidden biases", "none of them has six hidden neurons; with the factors in "
        "another order, 6 (2 + 1), the paper's formula gives the 18 of a network without biases",
        basis="arithmetic", sense="order",
    )  # fmt: skip
    patterns = TABLE.size
    yield table(
        "probabilistic_count", "section 3, \"probabilistic neural network (PNN)\" (erratum 2)",
        "numbers that a probabilistic network of the 169 cells holds", 3 * patterns, "", 507, "two of a place and one "
        "of a value for each pattern, and nothing to train; the paper gives its network a parameter count of back-"
        "propagation and trains it, so it is no probabilistic network", basis="arithmetic",
        paper=16, verdict=verdict_of(3 * patterns == 16),
    )  # fmt: skip


def _golden() -> Iterator[Claim]:
    source, found = "digest, section 4, golden network", safety(GOLDEN)
    yield network(
        "golden_rmse", source + " (A3)", "RMSE of the golden network on the cells", found.rmse, "levels", 0.601,
        f"largest difference {found.largest:.2f} levels", tolerance=0.002,
    )  # fmt: skip
    yield network(
        "golden_largest", source, "largest difference of the golden network to a cell", found.largest, "levels", 1.93,
        f"{found.largest:.4f}: the digest cut the third digit off", tolerance=0.01,
    )  # fmt: skip
    yield network(
        "golden_exact", source, "cells exact after rounding", 100.0 * found.exact, "%", 74.0,
        "no memory of the table: a quarter of it is wrong by a level", tolerance=0.5,
    )  # fmt: skip
    yield network(
        "golden_within_one", source, "cells within a level after rounding", 100.0 * found.within_one, "%", 96.0,
        f"{round(169 * (1.0 - found.within_one))} cells are further off", tolerance=0.5,
    )  # fmt: skip
    near = (measured(GOLDEN, 0.25, 0.0) - measured(GOLDEN, -0.25, 0.0)) / 0.5
    yield network(
        "golden_slope", source, "slope of the golden network, from P at E = -0.25 and 0.25", near, "", -0.62,
        f"at the origin itself it is {found.slope:.3f}; the table has {found.wanted_slope:g}", tolerance=0.005,
    )  # fmt: skip
    yield network(
        "golden_safe", source + " (A2)", "the golden network passes the safety test", word(found.accepted), "", "yes",
        "; ".join(found.failures()) or f"P(0, 0) = {found.origin:g}, slope {found.slope:.2f}, RMSE {found.rmse:.3f}",
        sense="yes/no",
    )  # fmt: skip
    signs = {"I": (1.0, 7.0), "II": (-7.0, -1.0), "III": (-1.0, 1.0)}
    for name, (e, ec, says, centre, target) in AREAS.items():
        value = measured(GOLDEN, e, ec)
        low, high = signs[name]
        yield network(
            f"golden_area_{name.lower()}", "section 3; acceptance A3", f"golden network in area {name}, E = {e:g}, EC "
            f"= {ec:g}", value, "levels", target, f"the text says {says}", tolerance=0.005, paper=centre,
            verdict=verdict_of(low < value < high, change=True),
        )  # fmt: skip


def _unsafe() -> Iterator[Claim]:
    source = "digest, section 4, sign safety"
    net = accepted_net()
    found = safety(net)
    yield network(
        "trained_rmse", "acceptance A2", "RMSE of a network trained by the genetic algorithm and polished", found.rmse,
        "levels", WORST_RMSE, f"18 weights, slope {found.slope:.2f}, largest P sign(E) near 0 {found.wrong_way:.4f}",
        sense="<=",
    )  # fmt: skip
    yield network(
        "trained_safe", "acceptance A2", "it passes all conditions of the safety test", word(found.accepted), "", "yes",
        "; ".join(found.failures()) or "P(0, 0), sign up to |E| = 1.5, slope, RMSE", sense="yes/no",
    )  # fmt: skip
    golden = safety(GOLDEN).rmse
    for name, statement in NAMES.items():
        bad = nets()[name]
        judged = safety(bad)
        rest = crossing(bad)
        ends = "no place to rest: it drives to the limit" if np.isnan(rest) else (
            f"a learning loop rests at E = {rest:.2f}, {LEVEL_DEG * rest:.1f} deg off"
        )  # fmt: skip
        yield network(
            f"rejected_{name}", source + " (A7)", f"the safety test refuses {statement}", word(not judged.right_way),
            "", "yes", f"RMSE {judged.rmse:.3f}, the golden network's {golden:.3f}; "
            f"{'; '.join(judged.failures())}; {ends}",
            sense="yes/no",
        )  # fmt: skip
    even = float(np.abs([measured(GOLDEN, e, ec) + measured(GOLDEN, -e, -ec) for e in LEVELS for ec in LEVELS]).max())
    yield network(
        "golden_odd", source, "largest P(E, EC) + P(-E, -EC) of a network without biases", even, "levels", 0.0,
        "exactly odd, so P(0, 0) = 0 without asking", tolerance=1e-12,
    )  # fmt: skip
