"""Claims about the whole lathe: the loops of speed and depth, all three together, the converter, and other entries."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.lathe import (
    FORCE_N,
    GAIN,
    RPM,
    SLOW_FEED,
    LatheRuns,
    force_law,
    stairs,
)
from leadscrew.studies.grey_turning.readings import read
from leadscrew.studies.grey_turning.saying import said, word

SEEDS = 20
SPINDLE = {"tfc": ("TFC", 5.8, 0.92), "gpfc": ("GPFC, reading B", 5.0, 0.62), "gpfc_a": ("GPFC, reading A", 3.6, 0.64)}
"""Overshoot and settling time of the digest, by law."""
DEPTH = {"tfc": "TFC", "gpfc": "GPFC"}
TFC9, GPFC9, TFC6, GPFC6 = (f"corrected.{law}_{s}" for s in ("s9", "s6") for law in ("tfc", "gpfc_b"))
DIPS = (7.0, 10.0, 16.0)
"""Dips of the force at the steps to 0.8, 0.6 and 0.4 mm, percent, digest: -6 to -8, -10, -16."""
BITS = (0, 16, 14, 12, 11, 10, 8)


def lathe_claims(found: LatheRuns | None = None) -> list[Claim]:
    """All of them; ``found`` keeps what pictures need too."""
    found = found or LatheRuns()
    return [*_spindle(found), *_depth(found), *_stairs(found), *_coupled(found), *_converter(found), *_entries(found)]


def last_outside_s(y: np.ndarray, target: float, band: float, period: float) -> np.ndarray:
    """When rows of ``y`` are outside ``band`` (a share of the target) for the last time, s."""
    outside = np.abs(y / target - 1.0) > band
    return period * (outside.shape[1] - 1 - outside[:, ::-1].argmax(axis=1))


def _spindle(found: LatheRuns) -> Iterator[Claim]:
    for name, (title, overshoot, settled) in SPINDLE.items():
        exact = read(found.spindle(name)["actual.rpm"], RPM)
        noisy = found.spindle(name, noisy=True, runs=SEEDS)
        measured = read(noisy["actual.rpm"], RPM).overshoot
        yield said(
            f"spindle_overshoot_{name}", "section 5.2", f"overshoot of the spindle, 0 to 1,200 1/min, {title}",
            measured.mean(), "%", overshoot, f"mean of {SEEDS} runs, speed read with a scatter of 5 1/min, chosen so "
            f"that the digest's numbers come out, which names no scatter; {exact.overshoot[0]:.2f} % without it; the "
            "output is held to 10 V, the lathe is not cutting", tolerance=0.1, basis="fitted to this number",
        )  # fmt: skip
        late = float(np.median(last_outside_s(noisy["actual.rpm"], RPM, 0.05, 0.02)))
        alone = float(last_outside_s(found.spindle(name)["actual.rpm"], RPM, 0.05, 0.02)[0])
        near = name == "gpfc"
        yield said(
            f"spindle_settling_{name}", "section 5.2", f"last time outside 5 %, {title}", late, "s", settled,
            f"median of {SEEDS} runs with the scatter chosen for these numbers; {alone:.2f} s without"
            + (": its overshoot is that of the band, so noise decides which crossing is the last" if near else ""),
            tolerance=0.02, kind="report" if near else "required", basis="fitted to this number",
        )  # fmt: skip


def _depth(found: LatheRuns) -> Iterator[Claim]:
    for name, title in DEPTH.items():
        gone = (1.0 - found.depth(name)["actual.depth"]) / 0.2
        noisy = (1.0 - found.depth(name, noisy=True, runs=SEEDS)["actual.depth"]) / 0.2
        reading = read(gone, 1.0)
        yield said(
            f"depth_rise_{name}", "Figure 8", f"10 to 90 % of the step from 1 to 0.8 mm, {title}", reading.rise_s[0],
            "s", 0.23, "positional output, the step at the first sample, so that it makes no change of the error; the "
            "digest says 0.21 to 0.25 s", tolerance=0.021,
        )  # fmt: skip
        yield said(
            f"depth_overshoot_{name}", "Figure 8", f"overshoot of that step, {title}",
            max(reading.overshoot[0], 0.0), "%", 0.6, "none; with a scatter of 0.5 um on the encoder "
            f"{read(noisy, 1.0).overshoot.mean():.2f} % of the step: the digest's 0.4 to 0.6 % is such a scatter",
            sense="<=",
        )  # fmt: skip
        error = float(np.abs(found.depth(name)["actual.depth"][0, -1] - 0.8))
        yield said(
            f"depth_error_{name}", "Figure 8", f"error of the depth after 2 s, {title}", error, "mm", 0.001,
            "the slide integrates, so a positional output leaves no error; the digest says less than 0.001 mm",
            sense="<=",
        )  # fmt: skip


def _stairs(found: LatheRuns) -> Iterator[Claim]:
    runs = {t: found.staircase(t, 4, droop=0.0, noise_n=0.0) for t in (TFC9, GPFC9)}
    seen = {t: stairs(r.time, r["feedback.force"], 4) for t, r in runs.items()}
    true = {t: stairs(r.time, r["actual.force"], 4) for t, r in runs.items()}
    for k, (target, to) in enumerate(zip(DIPS, ("0.8", "0.6", "0.4"), strict=True)):
        dips = [-seen[t][k].dip for t in runs]
        yield said(
            f"stairs_dip_{to[2:]}", "section 5.2", f"dip of the filtered force at the step to {to} mm, mean of TFC and "
            "GPFC, S9, all loops", float(np.mean(dips)), "%", target, f"TFC {dips[0]:.1f} %, GPFC {dips[1]:.1f} %; of "
            f"the true force {-true[TFC9][k].dip:.1f} and {-true[GPFC9][k].dip:.1f} %; a step at once would take "
            f"{100.0 * (1.0 - float(to) / (float(to) + 0.2)):.0f} %; without load-cell noise and droop",
            tolerance=1.0 if k == 0 else 0.5,
        )  # fmt: skip
    for tuning, run in runs.items():
        key = "tfc" if tuning == TFC9 else "gpfc"
        yield said(
            f"stairs_no_overshoot_{key}", "section 5.2", f"most above 150 N after any step, {tuning}",
            max(s.over for s in seen[tuning]), "%", 2.2, "a smaller depth makes less force: the steps can only dip, so "
            "the 48.6 % of the paper is not their work", sense="<=",
        )  # fmt: skip
        force = float(run["actual.force"][0, run.time > 9.5].mean())
        yield said(
            f"stairs_saturated_{key}", "section 5.2", f"force left at 0.2 mm, {tuning}", force, "N", 91.0,
            f"the feed is at its limit of 150 mm/min, {100.0 * (force / FORCE_N - 1.0):.0f} % for good, as in "
            "falling_to_02_force without spindle and cross slide", kind="report",
        )  # fmt: skip


def _coupled(found: LatheRuns) -> Iterator[Claim]:
    runs = {droop: found.staircase(GPFC9, runs=SEEDS, droop=droop) for droop in (0.0, 2.5, 24.0)}
    run = runs[2.5]
    t, rpm, late = run.time, run["actual.rpm"], run.time > 7.0
    held = [
        abs(rpm[:, late].mean() / RPM - 1.0), abs(run["feedback.force"][:, late].mean() / FORCE_N - 1.0),
        abs(run["actual.depth"][:, late].mean() / 0.4 - 1.0),
    ]  # fmt: skip
    yield said(
        "three_loops_hold", "acceptance 4", "speed, force and depth are held together, last second of the falling "
        "depth, GPFC on all three", word(max(held) < 0.01), "", "yes",
        f"off by {100.0 * held[0]:.3f}, {100.0 * held[1]:.2f} and {100.0 * held[2]:.4f} %, mean of {SEEDS} runs, with "
        "droop and load-cell noise", sense="yes/no",
    )  # fmt: skip
    torque = float(run["actual.torque"][:, late].mean())
    yield said(
        "spindle_droop", "acceptance 4", "most that the spindle falls below 1,200 1/min as the cut begins", RPM - rpm
        [:, t < 2.0].min(axis=1).mean(), "1/min", None, f"{torque:.2f} N m at 150 N on 50 mm cost 2.5 1/min each, "
        f"{2.5 * torque:.1f} 1/min without a speed loop, {RPM - runs[24.0]['actual.rpm'].min():.0f} with ten times the "
        f"droop; the loop brings it back to {rpm[:, late].mean():.1f} 1/min", kind="report",
    )  # fmt: skip
    over = {d: float(read(r["feedback.force"]).overshoot.mean()) for d, r in runs.items()}
    yield said(
        "droop_and_force", "acceptance 4", "what the droop adds to the overshoot of the force at the entry",
        over[2.5] - over[0.0], "%", 0.5, f"{over[0.0]:.2f} % without, {over[2.5]:.2f} % with, {over[24.0]:.1f} % with "
        "24 1/min per N m: a slower spindle makes a thicker chip", sense="<=",
    )  # fmt: skip


def converter_errors(found: LatheRuns, tuning: str, quiet: bool) -> np.ndarray:
    """Steady errors in percent of 150 N at 1 mm, for converters of :data:`BITS`."""
    changes = force_law(tuning) | ({"sensor.cell.noise_n": 0.0, "plant.runout": 0.0} if quiet else {})
    axes = ("spindle", "feed", "radial")
    return np.array(
        [
            read(
                found.batch(
                    found.running, 3.0, changes | {f"actuator.{a}.bits": n for a in axes}, 1 if quiet else SEEDS
                )["feedback.force"]
            ).steady.mean()
            for n in BITS
        ]
    )


def _converter(found: LatheRuns) -> Iterator[Claim]:
    step_v = 20.0 / 2**12
    slope = 0.77 * FORCE_N / 35.5
    yield said(
        "dac_step", "acceptance 4", "force of one step of a 12-bit converter of -10 to 10 V, 1 mm, S45C",
        step_v * GAIN * slope, "N", 2.4, f"{step_v * GAIN:.3f} mm/min times {slope:.2f} N per mm/min", tolerance=0.05,
        basis="arithmetic",
    )  # fmt: skip
    at = {n: i for i, n in enumerate(BITS)}
    for key, tuning, paper in (("tfc", TFC6, 1.7), ("gpfc", GPFC6, 1.0)):
        quiet, noisy = converter_errors(found, tuning, True), converter_errors(found, tuning, False)
        row = ", ".join(f"{n} bits {e:.2f} %" for n, e in zip(BITS[1:], noisy[1:], strict=True))
        yield said(
            f"dac_steady_{key}", "section 5.1", f"steady error with 12-bit converters, noise and runout, {tuning}",
            noisy[at[12]], "%", None, f"{noisy[at[0]]:.2f} % with ideal ones; {row}; without noise and runout 12 bits "
            f"alone make {quiet[at[12]]:.2f} %", kind="report", paper=paper,
            verdict="reproduced" if abs(noisy[at[12]] - paper) <= 0.15 else "not reproduced",
        )  # fmt: skip
        yield said(
            f"dac_explains_{key}", "section 5.1", f"a 12-bit converter explains the paper's steady error of {paper} %",
            word(noisy[at[12]] > 0.9 * paper), "", "no", f"it adds {noisy[at[12]] - noisy[at[0]]:.3f} points, "
            f"for load-cell noise is dither; 8 bits make {noisy[at[8]]:.2f} %", sense="yes/no",
        )  # fmt: skip


ENTRIES = {"plunge": "plunge from 0 mm while the feed winds up", "air": "0.3 s of air before the full depth"}


def entry_overshoot(found: LatheRuns, tuning: str, how: str, seeds: int = 6) -> float:
    """Overshoot of the filtered force on plant N, percent."""
    changes = force_law(tuning) | SLOW_FEED
    if how == "plunge":
        changes |= {"plant.start.depth": 0.0}
    if how == "air":
        free = found.batch(found.running, 0.5, changes | {"plant.work.starts": 1e6})
        changes |= {"plant.work.starts": float(np.interp(0.3, free.time, free["actual.travel"][0]))}
    return float(read(found.batch(found.running, 3.0, changes, seeds)["feedback.force"]).overshoot.mean())


def _entries(found: LatheRuns) -> Iterator[Claim]:
    for how, title in ENTRIES.items():
        sets = ("sbn", "stfc")
        tfc, gpfc = ([entry_overshoot(found, f"corrected.{law}_{s}", how) for s in sets] for law in ("tfc", "gpfc_b"))
        ratio = min(a / b for a, b in zip(tfc, gpfc, strict=True))
        asked = 48.6 / 12.7
        met = ratio >= 0.8 * asked
        both = "; ".join(f"{s}: TFC {a:.0f} %, GPFC {b:.0f} %" for s, a, b in zip(sets, tfc, gpfc, strict=True))
        yield said(
            f"entry_{how}", "section 5.2", f"{title}, plant N: least overshoot of TFC over that of GPFC", ratio, "",
            None, f"{both}; the paper's ratio is {asked:.1f}: {'this may be' if met else 'not'} how its 48.6 and "
            "12.7 % came about", kind="report", paper=asked,
            verdict="reproduced with change" if met else "not reproduced",
        )  # fmt: skip
