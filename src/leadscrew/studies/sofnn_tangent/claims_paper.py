"""What the paper's text says, beside what comes out: the three areas of Figure 4, its claims and its conclusions."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.fuzzy.partition import Partition
from leadscrew.neural.inference_net import CENTRES, LABELS
from leadscrew.neural.performance import GOLDEN, TABLE, looked_up, measured
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.comparison import MAMDANI, comparison_of
from leadscrew.studies.sofnn_tangent.lines import PERIOD_S
from leadscrew.studies.sofnn_tangent.online import PNN, TUNED, deviations, loop_of, rms
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, verdict_of, word

NONE, FIXED = "paper.uncompensated", "corrected.fnn"
SETS = Partition(tuple(CENTRES.tolist()), LABELS)
AREAS = {1: ("I", -4.0, 2.0, "PS"), 2: ("II", 2.0, 2.0, "NS"), 3: ("III", 2.0, -2.0, "ZO")}
"""Number, E, EC at the peaks of the sets that the paper names, and its P."""
QUIET = "wave_fabric_quiet"

printed = partial(said, group="as printed")


def paper_claims(loops: Loops) -> list[Claim]:
    """Verdicts are computed; where the paper gives no number its statement stands in its place.

    'Better effect' is judged by literal_lower_than_none and literal_lower_than_fixed, 'adaptive' by
    change_literal_gain.
    """
    return [*_areas(loops), *_responds(loops), *_conclusions(loops)]


def sets_of(value: float) -> str:
    """The set to which a level belongs most; both where two have the same membership."""
    found = SETS.winner(value)
    return f"{LABELS[found.index]} or {LABELS[found.index + 1]}" if found.tied else LABELS[found.index]


def passed_areas(e: np.ndarray, ec: np.ndarray) -> list[str]:
    """The areas of Figure 4 that a response passes, in their order: by the signs of the deviation and of its rate."""
    found: list[str] = []
    for x, dx in zip(e, ec, strict=True):
        if abs(x) < 0.02 or abs(dx) < 1e-4:
            continue
        area = {(False, True): "I", (True, True): "II", (True, False): "III"}.get((x > 0.0, dx > 0.0), "")
        if area and (not found or found[-1] != area):
            found.append(area)
    return found


def _areas(loops: Loops) -> Iterator[Claim]:
    for number, (roman, e, ec, label) in AREAS.items():
        table, net = looked_up(TABLE, e, ec), measured(GOLDEN, e, ec)
        text = f"Figure 4, area {roman}: E = {e:g}, EC = {ec:g}"
        given = ((f"paper_area_{number}", table, "Table 1"), (f"area_{number}_network", net, "the safe network"))
        for name, value, what in given:
            sets = sets_of(value)
            fits = label in sets.split(" or ")
            yield printed(
                name, text, f"set of the correction that {what} gives in area {roman}", sets, "", None,
                f"{value:+.2f} level; {label} is {CENTRES[LABELS.index(label)]:+.0f}", kind="report", sense="yes/no",
                paper=label, verdict=verdict_of(fits), basis="paper's data",
            )  # fmt: skip
    ways = {}
    most = 0.0
    for name in (PNN, TUNED):
        run = loop_of(loops, name, "step").run(6.0, record=("controller.watch.error", "controller.watch.rate"))
        rate = run["controller.watch.rate"][104:]
        ways[name] = passed_areas(run["controller.watch.error"][104:], rate)
        most = max(most, float(np.abs(rate).max()))
    first = ways[TUNED][:2] == ["I", "II"] and "III" in ways[TUNED]
    yield printed(
        "step_areas_state", "Figure 4", "the answer to a step passes the areas I, II and III", word(first), "", "yes",
        f"tuned network, which overshoots: {', '.join(ways[TUNED][:4])}; the literal one, which does not: "
        f"{', '.join(ways[PNN])} alone. EC as large as PS would be {2.0 / (6.0 / 90.0):.0f} deg in a sample, the "
        f"answer has {most:.2f} at most: in degrees per sample these states do not occur", sense="yes/no",
        paper="three areas", verdict=verdict_of(first, change=True),
    )  # fmt: skip


def _responds(loops: Loops) -> Iterator[Claim]:
    run = loop_of(loops, PNN, "step").run(6.0, record=("actual.deviation", "output"))
    none = loop_of(loops, NONE, "step").run(6.0, record=("actual.deviation",))["actual.deviation"]
    e, d = run["actual.deviation"], run["output"]
    moved = PERIOD_S * float(np.flatnonzero(np.abs(d) > 0.01)[0]) - 1.0
    yield printed(
        "paper_responds", "section 4: 'the controller responds to the deviation'", "time from the step to an answer of "
        "the offset", moved, "s", 0.1, f"two periods of the loop and the camera's 40 ms; the offset goes against the "
        f"deviation, to {d[-1]:+.2f} deg at {none[-1]:+.2f} deg of shear", sense="<=", paper="responds",
        verdict=verdict_of(d[-1] * none[-1] < 0.0),
    )  # fmt: skip
    share = 100.0 * (1.0 - abs(e[-1]) / abs(none[-1]))
    yield printed(
        "paper_compensates", "section 4: 'the corresponding compensation angle is compensated'", "share of a steady "
        "deviation that is compensated 5 s after the step", share, "%", 99.0, f"{none[-1]:.2f} deg become "
        f"{e[-1]:.4f}; fixed rules leave six sevenths", sense=">=", paper="compensated",
        verdict=verdict_of(share >= 99.0),
    )  # fmt: skip
    on_line = loop_of(loops, PNN, QUIET)
    bare = deviations(loop_of(loops, NONE, QUIET).start(), 923)
    left = deviations(on_line.start(), 923)
    offset = np.asarray(on_line.run(9.24, record=("output",))["output"])[:923]
    match = float(np.corrcoef(-bare, offset)[0, 1])
    yield printed(
        "paper_compensated_share", "Figures 6 and 7", "share of the deviation (RMS) that is compensated on the wave in "
        "fabric without noise", 100.0 * (1.0 - rms(left) / rms(bare)), "%", None, f"{rms(bare):.3f} to {rms(left):.3f} "
        f"deg; the offset follows what is needed with a correlation of {match:.2f}: it is late in every bend. The "
        "paper has no number to it", kind="report", paper="compensated",
    )  # fmt: skip


def _conclusions(loops: Loops) -> Iterator[Claim]:
    made = comparison_of(loops)
    plain, reasoning, trained = (made.cells[c].rms.mean(axis=2) for c in ("corrected.fuzzy", MAMDANI, FIXED))
    better = [int((trained < other).sum()) for other in (plain, reasoning)]
    alike = (better[0] == trained.size) == (better[1] == trained.size)
    yield printed(
        "paper_offline_training", "conclusion 1: 'the control effect is further improved'", "what training offline "
        "takes from the mean RMS of the same rules untrained", 100.0 * (1.0 - trained.mean() / plain.mean()), "%", None,
        f"{plain.mean():.3f} to {trained.mean():.3f} deg, lower in {better[0]} of {trained.size} cells; the fuzzy "
        f"reasoning that it is trained on has {reasoning.mean():.3f} deg, the trained network is lower in {better[1]}. "
        "The paper does not say than what the effect is better", kind="report", paper="further improved",
        verdict=verdict_of(better[0] == trained.size) if alike else "cannot be checked",
    )  # fmt: skip
    rows = [loops.cells(c).rms.mean(axis=2) for c in (FIXED, PNN)]
    worst = 100.0 * (1.0 - float((rows[1] / rows[0]).max()))
    yield printed(
        "paper_knowledge_base", "conclusion 2: 'knowledge base composed and updated by PNN'", "least gain in a cell "
        "that the network's corrections on line bring over the same rules held", worst, "%", 0.0,
        f"{100.0 * (1.0 - rows[1].mean() / rows[0].mean()):.0f} % in the mean. The rules are updated; what they keep "
        "when they are held is another matter, see recall_share_median", sense=">=", paper="validity verified",
        verdict=verdict_of(worst > 0.0, change=True),
    )  # fmt: skip
    tight = {"controller.passes": 5, "controller.tolerance": 1e-3}
    run = loop_of(loops, PNN, "flower_foam", tight).run(7.9, record=("controller.updates",))["controller.updates"]
    reached = 100.0 * float(np.mean(run < 5))
    yield printed(
        "paper_output_approaches", "section 4: 'u* approximation to the expected output u'", "share of samples in "
        "which the rules reach the expected output within five passes, J < 1e-3", reached, "%", 99.0,
        f"{run.max():.0f} passes at most, flower in foam: the learning does what step (7) asks", sense=">=",
        paper="approaches", verdict=verdict_of(reached >= 99.0),
    )  # fmt: skip
