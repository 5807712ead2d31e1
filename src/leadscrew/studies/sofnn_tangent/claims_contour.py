"""Claims of the place of the cut: how far it leaves its line, a wrong zero of the camera, the floor of the texture."""

from __future__ import annotations

import math
from collections.abc import Iterator

from leadscrew.plants.flexible_cut import MATERIALS
from leadscrew.report.claim import Claim
from leadscrew.studies.sofnn_tangent.chance import HALF_DIGIT, by_chance
from leadscrew.studies.sofnn_tangent.comparison import (
    DIGEST,
    FIXED,
    FLOOR,
    NONE,
    PAPER,
    PID,
    TUNED,
    Comparison,
    comparison_of,
    texture_floor,
)
from leadscrew.studies.sofnn_tangent.lines import FEED, MATERIAL_NAMES
from leadscrew.studies.sofnn_tangent.runs import Loops
from leadscrew.studies.sofnn_tangent.saying import said
from leadscrew.studies.sofnn_tangent.tuning import best

SOURCE = "digest, section 7"
ASIDE: dict[str, tuple[float, float]] = {
    NONE: (7.75, 14.4), FIXED: (6.79, 12.8), PAPER: (1.07, 1.71), TUNED: (0.31, 0.64), PID: (0.33, 0.59),
}  # fmt: skip
"""Mean and worst cell of the largest distance of the cut from its line, mm."""
DIGEST_RUNS = 3
"""Textures and noises of these rows in the digest."""
ZERO_DEG = 0.1
WAY_MM = 450.0
TEXTURE_DEG, TEXTURE_MM = 0.25, 3.0
"""Standard deviation and correlation length of the texture."""


def contour_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    made = comparison_of(loops)
    return [*_rows(made), *_gains(made), *_zero(loops), *_floor(loops)]


def _rows(made: Comparison) -> Iterator[Claim]:
    for name, (mean, worst) in ASIDE.items():
        standing, short, words = made.standing(name), name.split(".")[-1], DIGEST[name].words
        by_cell = standing.cells.lateral.mean(axis=-1)
        allowed = standing.allowed("lateral", 0.05 if worst > 10.0 else HALF_DIGIT, DIGEST_RUNS)
        chance = standing.allowed_mean("lateral", HALF_DIGIT, DIGEST_RUNS)
        yield said(
            f"contour_{short}_mean", SOURCE, f"largest distance of the cut from its line, mean of nine cells: {words}",
            standing.aside, "mm", mean, f"{standing.aside:.2f} mm; the digest, on three "
            f"textures of its own, {mean:g}; by chance they differ by up to {chance:.2f}", tolerance=chance,
        )  # fmt: skip
        yield said(
            f"contour_{short}_worst", SOURCE, f"the same of the worst cell: {words}", standing.aside_worst, "mm", worst,
            f"{standing.aside_worst:.2f} mm; the digest {worst:g}", tolerance=float(allowed.ravel()[by_cell.argmax()]),
        )  # fmt: skip


def _gains(made: Comparison) -> Iterator[Claim]:
    def less(pick: str) -> float:
        own, none = (getattr(made.cells[name], pick).mean() for name in (PAPER, NONE))
        return 100.0 * float(1.0 - own / none)

    aside, rms = less("lateral"), less("rms")
    yield said(
        "contour_favours", SOURCE, "reduction of the distance from the line by the paper's SOFNN, against none", aside,
        "%", 86.0, f"{aside:.0f} % of the distance but {rms:.0f} % of the RMS angle: what it removes is the mean "
        "angle, and that is what moves the cut aside", tolerance=2.0,
    )  # fmt: skip
    for short, name, target in (("tuned", TUNED, 0.40), ("literal", PAPER, 1.3)):
        value = float(made.cells[name].lateral.mean())
        yield said(
            f"contour_{short}_target", "digest A11",
            f"distance from the line, mean of nine cells: {DIGEST[name].words}", value, "mm", target,
            f"{value:.2f} mm; PID 0.7, 14, 0.005 beside it "
            f"{made.cells[PID].lateral.mean():.2f}, tuned with equal effort: PID "
            f"{made.cells['equal.pid'].lateral.mean():.2f}, SOFNN {made.cells['equal.sofnn'].lateral.mean():.2f}",
            sense="<=",
        )  # fmt: skip
    observer, gain = made.cells["equal.observer"], best("observer").values["gain"]
    yield said(
        "contour_observer", "digest A11", "distance from the line of the observer tuned for RMS, over that of the PID",
        float(observer.lateral.mean() / made.cells["equal.pid"].lateral.mean()), "", None,
        f"{observer.lateral.mean():.2f} mm at an RMS of {observer.rms.mean():.3f} deg, PID "
        f"{made.cells['equal.pid'].lateral.mean():.2f} mm at {made.cells['equal.pid'].rms.mean():.3f} deg; the search "
        f"judged the RMS alone and takes off {100.0 * gain:.0f} % of what the observer finds: the rest stays as a mean "
        "angle, and that moves the cut aside", kind="report",
    )  # fmt: skip


def _zero(loops: Loops) -> Iterator[Claim]:
    arithmetic = WAY_MM * math.sin(math.radians(ZERO_DEG))
    yield said(
        "zero_error_arithmetic", SOURCE, f"way aside after {WAY_MM:g} mm at a constant angle of {ZERO_DEG:g} deg",
        arithmetic, "mm", 0.8, f"{WAY_MM:g} sin {ZERO_DEG:g} deg = {arithmetic:.3f} mm", basis="arithmetic",
        tolerance=0.05,
    )  # fmt: skip
    for short, name in (("tuned", TUNED), ("pid", PID)):
        ends, changed = [], {"sensor.zero_deg": ZERO_DEG}
        for changes in ({}, changed):
            run = loops.run(name, "wave_fabric_quiet", changes=changes)
            ends.append(float(run["actual.lateral"][-1]))
        way = 0.5 * (len(run["actual.lateral"]) - 1)
        per = abs(ends[1] - ends[0]) * WAY_MM / way
        yield said(
            f"zero_error_{short}", SOURCE, f"way aside per {WAY_MM:g} mm that a zero of the camera wrong by "
            f"{ZERO_DEG:g} deg adds: {DIGEST[name].words}", per, "mm", 0.8, f"{per:.2f} mm: the loop holds the reading "
            "at zero, so the cut has the camera's error; calibrate it", tolerance=0.08,
        )  # fmt: skip


def _floor(loops: Loops) -> Iterator[Claim]:
    found = texture_floor(loops)
    for material in MATERIAL_NAMES:
        mean, deviation = found[material]
        lag_s, width_s = MATERIALS[material].lag_s, TEXTURE_MM / FEED
        expected = TEXTURE_DEG * math.sqrt(width_s / (width_s + lag_s))
        yield said(
            f"texture_floor_{material}", SOURCE, f"RMS deviation where only the texture acts: {material}",
            mean, "deg", FLOOR[material], f"{mean:.3f} deg without shear, fibre and bevel, {deviation:.3f} from run to "
            f"run; by the formula for a texture behind the lag {expected:.3f}, the digest {FLOOR[material]:g}. No "
            "feedback removes it, because the texture changes within the camera's delay",
            tolerance=by_chance(deviation),
        )  # fmt: skip
