"""Claims on what the controller reads and sends: scales, their cap, the unit of the rate, folded angles, rounding."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.controllers.sofnn.fixed import fnn
from leadscrew.controllers.sofnn.network import sofnn
from leadscrew.neural.inference_net import CENTRES, SETS
from leadscrew.neural.performance import GOLDEN, ROUNDED, TABLE, correction
from leadscrew.plants.flexible_cut import flexible_cut
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.lines import LAPS, PERIOD_S, line
from leadscrew.studies.sofnn_tangent.online import (
    CALM,
    STRAIGHT,
    deviations,
    first_rules,
    listed,
    loop_of,
    rms,
    rules,
)
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said, verdict_of

SCALES = sofnn.params
MOST_DEG = flexible_cut.params.most
RANGES = "section 3 of the paper, ranges of e, ec and d"
UNIT_RMS = {0: 0.98, 1: 3.6, 2: 5.2, 4: 7.1}
"""RMS of the fixed network with the rate in deg/s, by the samples that the camera is late; digest section 1."""
UNIT_DIGITS = {0: 0.005, 1: 0.05, 2: 0.05, 4: 0.05}
FOLDED = {"wave": 0, "flower": 3}
SEEDS = 5
WAVE_SAMPLES = 923

printed = partial(said, group="as printed")


def signals_claims(loops: Loops) -> list[Claim]:
    """Section 1 of the digest and its headline 4."""
    return [*_gain(loops), *_rate(loops), *_folding(), *_rounding(loops)]


def identity_rules() -> np.ndarray:
    """Rules that send minus the level of the deviation, whatever its rate: 49 consequents, levels."""
    return np.tile(-CENTRES, SETS)


def settled(loops: Loops, controller: object, **changes: float) -> float:
    """Where the deviation ends on the step, deg."""
    keyed = {key.replace("__", "."): value for key, value in changes.items()}
    run = loops.get(controller, "step", changes=keyed).run(6.0, record=("actual.deviation",))  # type: ignore[arg-type]
    return float(run["actual.deviation"][-1])


def _gain(loops: Loops) -> Iterator[Claim]:
    gain = SCALES.k_d * SCALES.k_e
    yield printed(
        "literal_loop_gain", RANGES, "loop gain k_d k_e of a rule map of slope 1", gain, "1", 1.0 / 6.0,
        f"k_e = 6/90 level/deg and k_d = 15/6 deg/level: {SCALES.k_e:.4f} times {SCALES.k_d:.2f}", tolerance=1e-12,
        basis="paper's data",
    )  # fmt: skip
    left = settled(loops, fnn(rules=identity_rules()), plant__material__gain=1.0)
    none = settled(loops, "paper.uncompensated", plant__material__gain=1.0)
    share = 100.0 * (1.0 - left / none)
    yield printed(
        "fixed_cap", RANGES, "share of a steady deviation that a fixed rule map of slope 1 takes away", share, "%",
        100.0 / 7.0, f"simulated, blade and cut turning alike: {none:.3f} deg become {left:.3f}; 1 - 1/(1 + 1/6) = "
        "1/7: the ranges of +-90 and +-15 deg leave six sevenths of every slow error", tolerance=0.05,
    )  # fmt: skip
    end = settled(loops, "corrected.fnn")
    bare = settled(loops, "paper.uncompensated")
    limited = -MOST_DEG * math.tanh(5.0 / MOST_DEG)
    yield printed(
        "fixed_step_end", "Figure 4; digest section 7", "where the fixed network settles after a step of -5 deg", end,
        "deg", -4.13, f"uncompensated {bare:.3f} deg: the material's limit of {MOST_DEG:g} deg makes {limited:.3f} of "
        f"the step. The rules leave {100.0 * end / bare:.0f} % of that; what they take from the nine cells, see "
        "fixed_cap_measured", tolerance=0.005,
    )  # fmt: skip
    fixed, none_rms = loops.cells("corrected.fnn").rms, loops.cells("paper.uncompensated").rms
    measured = 100.0 * (1.0 - fixed.mean() / none_rms.mean())
    each = 100.0 * (1.0 - fixed.mean(axis=2) / none_rms.mean(axis=2))
    yield printed(
        "fixed_cap_measured", "digest section 1; erratum 9", "what the fixed network takes from the mean RMS of the "
        "nine cells", measured, "%", 12.0, f"{none_rms.mean():.3f} to {fixed.mean():.3f} deg; between {each.min():.1f} "
        f"and {each.max():.1f} % by cell, never more than the 14.3 % of the loop gain", tolerance=0.5,
    )  # fmt: skip
    wide = loops.cells("corrected.fnn_15").rms
    yield said(
        "scaling_fixed_15", "digest section 7", "mean RMS of the fixed network with a range of +-15 deg for e",
        wide.mean(), "deg", 1.23, f"k_e = 6/15 in place of 6/90: {100.0 * (1.0 - wide.mean() / none_rms.mean()):.0f} % "
        "less than without; the scales do more than the learning of the literal network", tolerance=0.015,
        group="as corrected",
    )  # fmt: skip


def with_rate_per_second(loops: Loops) -> dict[int, np.ndarray]:
    """RMS of the fixed network with its rate in deg/s on the wave in fabric, by camera delay in samples, deg."""
    found = {}
    for late in UNIT_RMS:
        asked = {"controller.per_second": True, "sensor.trailing_s": late * PERIOD_S}
        loop = loop_of(loops, "corrected.fnn", "wave_fabric", asked)
        found[late] = np.array([rms(deviations(loop.start(run=k), WAVE_SAMPLES)) for k in range(SEEDS)])
    return found


def _rate(loops: Loops) -> Iterator[Claim]:
    noise, rate = camera_noise(loops)
    yield said(
        "ec_noise", "step (3) of the paper; digest section 1", "scatter of the difference quotient of the camera's "
        "readings", noise, "deg/s", 21.0, "0.15 deg of noise at 10 ms; sqrt(2) 0.15 / 0.01 = "
        f"{15.0 * math.sqrt(2.0):.2f}: the rate cannot be used without a filter", tolerance=0.5,
    )  # fmt: skip
    keep = math.exp(-PERIOD_S / SCALES.filter_s)
    theory = 15.0 * (1.0 - keep) * math.sqrt(2.0 / (1.0 + keep))
    yield said(
        "ec_filtered", "digest section 1", "scatter of the rate behind its filter of 0.05 s", rate, "deg/s", theory,
        f"{noise / rate:.1f} times less; for white noise (1 - a) sqrt(2/(1 + a)) 15 = {theory:.3f} with "
        f"a = exp(-0.2) = {keep:.4f}", tolerance=0.1,
    )  # fmt: skip
    run = loop_of(loops, "corrected.fnn", "flower_foam").run(7.9, record=("controller.watch.rate",))
    most = float(np.abs(run["controller.watch.rate"]).max()) * SCALES.k_ec
    yield said(
        "ec_unit_literal", "ec = de/dt, range of +-90", "largest |EC| where ec is read in deg per sample, flower in "
        "foam", most, "levels", 0.1, "of six: read so the rate plays no part, and the two-dimensional table and rules "
        "are used on their row EC = 0", sense="<=", group="as corrected",
    )  # fmt: skip
    found = with_rate_per_second(loops)
    gain = SCALES.k_d * SCALES.k_ec
    for late, values in found.items():
        spread = float(values.std(ddof=1))
        why = f"d has {gain:.3f} s times ec, more than a late loop bears" if late else "without any delay it settles"
        yield printed(
            f"ec_unit_{late}", "ec = de/dt, range of +-90", f"RMS of the fixed network with ec in deg/s, camera {late} "
            "samples late, wave in fabric", values.mean(), "deg", UNIT_RMS[late], f"{why}; {SEEDS} textures, which "
            f"scatter by {spread:.2g} deg, the digest has one", tolerance=2.0 * spread + UNIT_DIGITS[late],
        )  # fmt: skip


def camera_noise(loops: Loops) -> tuple[float, float]:
    """Scatter of the difference quotient of readings on a straight line, raw and behind the filter, deg/s."""
    held = fnn(rules=np.zeros(49))
    loop = loops.get(held, "straight", changes={**CALM, **STRAIGHT})
    run = loop.run(100.0, record=("feedback.deviation", "controller.watch.rate"))
    raw = np.diff(run["feedback.deviation"]) / PERIOD_S
    return float(raw.std()), float(run["controller.watch.rate"].std()) / PERIOD_S


def folded(heading: np.ndarray) -> np.ndarray:
    """The acute angle to the horizontal, -90 to 90 deg: what the paper calls the tangential angle."""
    return (np.asarray(heading) + 90.0) % 180.0 - 90.0


def jumps(heading: np.ndarray) -> int:
    """How often the folded angle jumps by more than 90 deg from one sample to the next."""
    return int(np.count_nonzero(np.abs(np.diff(folded(heading))) > 90.0))


def _folding() -> Iterator[Claim]:
    for name in LAPS:
        heading = line(name).heading
        count = jumps(heading)
        turns = float(np.ptp(heading))
        target = FOLDED.get(name)
        yield printed(
            f"folded_jumps_{name}", "section 3: the acute angle between tangent and horizontal", "jumps of 180 deg in "
            f"the tangential angle along the {name}", count, "", target,
            f"the heading runs through {turns:.0f} deg, from {heading.min():.0f} to {heading.max():.0f}; folded, it "
            f"jumps wherever it passes 90 deg and goes on: {count} times", kind="required" if name in FOLDED else
            "report", basis="arithmetic",
        )  # fmt: skip
    heading = line("flower").heading
    off = folded(heading + 1.0) - folded(heading)
    wrapped = (off + 180.0) % 360.0 - 180.0
    yield printed(
        "folded_error", "section 3: e = phi - phi_r", "largest error computed from folded angles of a cut that is 1 "
        "deg off everywhere, flower", float(np.abs(wrapped).max()), "deg", 179.0, "a difference of two acute angles is "
        "wrong by 180 deg between the two jumps; here every angle is unwrapped", tolerance=1e-6, basis="arithmetic",
    )  # fmt: skip


def dead_zone_deg() -> float:
    """Smallest deviation with a correction when levels are rounded, deg; found by trying."""
    tried = np.arange(0.0, 20.0, 0.01)
    given = [correction(ROUNDED, TABLE, GOLDEN, SCALES.k_e * e, 0.0) for e in tried]
    return float(tried[np.flatnonzero(given)[0]])


def _rounding(loops: Loops) -> Iterator[Claim]:
    zone = dead_zone_deg()
    yield printed(
        "rounding_dead_zone", "13 levels over +-90 deg", "smallest deviation that has a correction when levels are "
        "rounded", zone, "deg", 7.5, f"a level is {1.0 / SCALES.k_e:.0f} deg", tolerance=0.02, basis="paper's data",
    )  # fmt: skip
    fixed, rounded = loops.cells("corrected.fnn"), loops.cells("paper.sofnn_rounded")
    apart = 100.0 * np.abs(rounded.rms.mean(axis=2) / fixed.rms.mean(axis=2) - 1.0)
    same = float(apart.max()) <= 1.0
    yield printed(
        "rounded_is_fixed", "13 levels; acceptance A7", "largest difference in RMS between the network that learns "
        "from rounded levels and the fixed one, nine cells", apart.max(), "%", 1.0,
        f"mean {rounded.rms.mean():.3f} and {fixed.rms.mean():.3f} deg; the largest deviation of all runs is "
        f"{rounded.most.max():.1f} deg, and below {zone:.1f} deg nothing is corrected. By cell {listed(apart, 3)} %",
        sense="<=",
        paper="learns on line", verdict=verdict_of(not same),
    )  # fmt: skip
    live = loop_of(loops, "paper.sofnn_rounded", "flower_foam").start()
    live.advance(live.loop.periods(loops.scenarios["flower_foam"].duration_s))
    moved = float(np.abs(rules(live).weights - first_rules(loops, "paper.sofnn_rounded")).max())
    between = loops.cells("corrected.sofnn_table").rms.mean()
    yield printed(
        "rounded_weights_still", "13 levels", "largest change of a rule on the flower in foam, levels rounded", moved,
        "levels", 0.0, f"nothing is learned; read between the cells, the same table brings the mean RMS to "
        f"{between:.2f} deg", tolerance=1e-9,
    )  # fmt: skip
