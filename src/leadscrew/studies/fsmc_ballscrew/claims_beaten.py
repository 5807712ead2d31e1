"""Claims about the controller that learns its friction: the digest's moonshots on quadrant peaks and the circle.

Every number is of true errors, at 4 kHz with a scale of 10 nm, with one tuning that believes the hats of Table 2 at its
start. It learns in the first half of a run; the second half counts. What happens until then has rows of its own.
"""

from __future__ import annotations

import math

import numpy as np

from leadscrew.analysis.circular.quantities import quantities
from leadscrew.friction.lugre import LuGre
from leadscrew.report.claim import Claim, Kind, Sense
from leadscrew.studies.fsmc_ballscrew.beaten import BEFORE, OURS, Runs, friction, slip_foreseen_wrong
from leadscrew.studies.fsmc_ballscrew.claims_readings import row
from leadscrew.studies.fsmc_ballscrew.driven import errors_um
from leadscrew.studies.fsmc_ballscrew.runs import ENCODER_NM, PERIOD_S, Loops, tail_um
from leadscrew.studies.fsmc_ballscrew.scenarios import SINES

WAY = dict(zip(SINES, ("0.01 sin t mm", "5 sin t mm", "sin 2 pi t mm"), strict=True))
ROOM = {"nominal": ("the stage of Table 2", {}, 0.05), "friction_p20": ("F_C and F_S 20 % larger", friction(1.2), 0.1),
        "friction_m20": ("F_C and F_S 20 % smaller", friction(0.8), 0.1)}  # fmt: skip
"""Truths, what they change, and the moonshot's largest error in um."""
TURNS = 5.0
"""Of the circle; the last one counts."""
EMPTY = 2.12e-4
"""Inertia without the table, kg m^2."""


def beaten_claims(loops: Loops, runs: Runs | None = None) -> list[Claim]:
    """Peaks on three truths and on Maxwell slip, the bound there, the circle, what it learns, and its limits."""
    kept = runs or Runs(loops)
    return [*_peaks(kept), *_maxwell(kept), *_circle(kept), *_learning(kept), *_limits(kept)]


def _row(
    name: str, statement: str, measured: float | str, unit: str, sense: Sense, target: float | str | None, reason: str,
    kind: Kind = "required", tolerance: float = 0.0,
) -> Claim:  # fmt: skip
    return row(f"beaten_{name}", "section 7, Table 2", "ours", statement, None, measured, unit, sense, target,
               tolerance, "cannot be checked", reason, kind)  # fmt: skip


def _peaks(runs: Runs) -> list[Claim]:
    rows = []
    for key, (words, changes, most) in ROOM.items():
        options = {"changes": changes} if changes else {}
        for scenario in SINES:
            found = runs.late(OURS, scenario, **options)
            rows.append(
                _row(f"{key}_{scenario}", f"largest error on {WAY[scenario]}, {words}", found, "um", "<=", most,
                     f"{ENCODER_NM:g} nm encoder, 4 kHz, after it has learned; digest's best robust tuning "
                     "0.064, 0.095 and 0.195 um on the nominal stage", "moonshot")
            )  # fmt: skip
    for key, (words, changes, most) in ROOM.items():
        peaks = runs.scatter(OURS, "sine_fast", changes)
        rows.append(
            _row(f"scatter_{key}", f"share of peaks above {most:g} um on sin 2 pi t mm, {words}, eight amplitudes "
                 "within 2 %", 100.0 * float(np.mean(peaks > most)), "%", "<=", None, f"of 64 peaks the median is "
                 f"{np.median(peaks):.3g}, the largest {peaks[-1]:.3g} um: each hangs on where the encoder's steps "
                 "fall, so the largest of a few reversals says less than it seems to", "report")
        )  # fmt: skip
    before = [tail_um(runs.loops.run("ours.pd_dob", s))[0] for s in SINES]
    ratios = [b / runs.late(OURS, s) for b, s in zip(before, SINES, strict=True)]
    rows.append(
        _row("better", "smallest factor by which the largest errors on the three sines are below those of ours.pd_dob",
             min(ratios), "", ">=", 1.5,
             f"ours.pd_dob: {before[0]:.3g}, {before[1]:.3g} and {before[2]:.3g} um; factors {ratios[0]:.2g}, "
             f"{ratios[1]:.2g} and {ratios[2]:.2g}")
    )  # fmt: skip
    return rows


def _maxwell(runs: Runs) -> list[Claim]:
    rows = []
    for scenario in SINES:
        rows.append(
            _row(f"gms_{scenario}", f"largest error on {WAY[scenario]}, six Maxwell elements for friction",
                 runs.on_maxwell(OURS, scenario), "um", "<=", 0.1, "what is learned is a LuGre model, whose damping "
                 "fades where that of the elements ends at once; the digest's robust tuning, which learns nothing, "
                 "0.083, 0.21 and 0.355 um", "moonshot")
        )  # fmt: skip
    slips = [slip_foreseen_wrong(nm) for nm in (0.5 * ENCODER_NM, -0.5 * ENCODER_NM)]
    one, two = min(s.one for s in slips), min(s.two for s in slips)
    rows += [
        _row("gms_bound", "error two periods after the last Maxwell element slips half an encoder step from where it "
             "is foreseen, with the torque exact but for that", two, "um", ">=", 0.1,
             f"at {slips[0].travel:.3f} um of travel {slips[0].drop:.2g} N m of damping end at once; {one:.3f} um "
             "after one period, before anybody can know: 0.1 um asks for a position better than the scale gives"),
        _row("gms_bound_exact", "the same with the position exact", slip_foreseen_wrong(0.0).two, "um", "<=", 1e-3,
             "so the loss is the position's"),
    ]  # fmt: skip
    return rows


def _circle(runs: Runs) -> list[Claim]:
    found, before = quantities(runs.circle(OURS, TURNS)), quantities(runs.circle(BEFORE, 2.0))
    assert found.ccw and found.cw and found.both and before.ccw
    worst = max(found.ccw.circular, found.cw.circular)
    return [
        _row("circle_ccw", "G, R = 100 mm, 1,000 mm/min, counter-clockwise", found.ccw.circular, "um", "<=", 0.05,
             f"turn {TURNS:g}; ours.pd_dob {before.ccw.circular:.3g} um, the digest's best 0.102 um", "moonshot"),
        _row("circle_cw", "G, R = 100 mm, 1,000 mm/min, clockwise", found.cw.circular, "um", "<=", 0.05,
             f"turn {TURNS:g}", "moonshot"),
        _row("circle_both", "G(b), R = 100 mm, 1,000 mm/min", found.both.circular, "um", "<=", None,
             f"extremes of both directions together; D {1e3 * found.both.mean_radial:.2f} nm", "report"),
        _row("circle_better", "larger G of both directions in that of ours.pd_dob", before.ccw.circular / worst, "",
             ">=", 1.3, "a guarantee where the moonshot is none"),
    ]  # fmt: skip


def _learning(runs: Runs) -> list[Claim]:
    rows = []
    for scenario in SINES[1:]:
        peaks = runs.by_reversal(OURS, scenario)
        above = np.flatnonzero(peaks > 0.05)
        rows += [
            _row(f"first_{scenario}", f"largest error at a reversal of {WAY[scenario]} while it learns", peaks.max(),
                 "um", "<=", None, f"at reversal {int(peaks.argmax()) + 1}: the hats believe bristles twice as stiff "
                 f"and damped; the first leaves {peaks[0]:.3g} um, ours.pd_dob "
                 f"{tail_um(runs.loops.run('ours.pd_dob', scenario))[0]:.3g} um at every one",
                 "report"),
            _row(f"learns_{scenario}", f"reversals of {WAY[scenario]} until every peak stays below 0.05 um",
                 float(above[-1] + 1 if above.size else 0), "", "<=", None,
                 f"of {len(peaks)} in the run", "report"),
        ]  # fmt: skip
    truth = LuGre()
    live = runs.loops.get(OURS, "sine_fast").start()
    run = live.advance(round(12.0 / PERIOD_S), record=("controller",), every=100)
    known = {name: float(run[f"controller.{name}"][-1]) for name in ("coulomb", "bend", "bristle_damping", "viscous")}
    stiffness = known["coulomb"] / known["bend"]
    pairs = ((known["coulomb"], truth.coulomb), (stiffness, truth.stiffness),
             (known["bristle_damping"], truth.damping), (known["viscous"], truth.viscous))  # fmt: skip
    off = [100.0 * abs(found / true - 1.0) for found, true in pairs]
    rows.append(
        _row("learned", "F_C, sigma_0, sigma_1 and sigma_2 as learned on sin 2 pi t mm: largest error", max(off), "%",
             "<=", 10.0, f"{off[0]:.2g}, {off[1]:.2g}, {off[2]:.2g} and {off[3]:.2g} %; believed at the start: sigma_0 "
             "and sigma_1 twice, sigma_2 three times the true ones")
    )  # fmt: skip
    mine, before = runs.wandering(OURS), runs.wandering(BEFORE)
    rows += [
        _row("wander_peak", "largest error on a path that never repeats, over that of ours.pd_dob", mine[0] / before[0],
             "", "<=", 1.0, f"{mine[0]:.3g} against {before[0]:.3g} um; 2 sin 2.3 t + sin 5.23 t + 0.5 sin 9.17 t mm"),
        _row("wander_rms", "the same for the RMS error", mine[1] / before[1], "", "<=", 1.0,
             f"{1e3 * mine[1]:.3g} against {1e3 * before[1]:.3g} nm"),
    ]  # fmt: skip
    return rows


def _limits(runs: Runs) -> list[Claim]:
    two = SINES[1:]
    late = [errors_um(runs.loops, OURS, s, "delay").largest for s in two]
    light = [runs.late(OURS, s, changes={"plant.inertia": EMPTY}) for s in two]
    quick = [runs.late(OURS, s, period=1e-4) for s in two]
    ideal, finer = runs.late(OURS, "sine_fast", encoder_nm=0.0), runs.late(OURS, "sine_fast", encoder_nm=1.0)
    coarser = [runs.late(OURS, "sine_fast", encoder_nm=nm) for nm in (20.0, 50.0)]
    creeping = runs.error(OURS, "creep", 4.0)
    lost = not all(math.isfinite(v) for v in late)
    return [
        _row("delay", "the two wide sines from rest with one sample of computation delay",
             "diverges" if lost else "stable", "", "yes/no", None,
             "gains that use up what 4 kHz allows: take ours.pd_dob_delay for such a drive",
             "report"),
        _row("empty", "largest error on the two wide sines with the empty stage, 2.12e-4 kg m^2", max(light), "um",
             "<=", None, f"{light[0]:.3g} and {light[1]:.3g} um; it believes the full table", "report"),
        _row("10khz", "largest error on the two wide sines at 10 kHz, gains unchanged", max(quick), "um", "<=", None,
             f"{quick[0]:.3g} and {quick[1]:.3g} um", "report"),
        _row("scale", "largest error on sin 2 pi t mm with a scale of 20 nm", coarser[0], "um", "<=", None,
             f"{coarser[1]:.3g} um with 50 nm, {finer:.3g} um with 1 nm, {ideal:.3g} um with the true position",
             "report"),
        _row("creep", "error peak to peak at a constant feed of 1 um/s", float(np.ptp(creeping[len(creeping) // 2 :])),
             "um", "<=", 0.1, "below the Stribeck speed, where PID sticks and slips by 5 um"),
    ]  # fmt: skip
