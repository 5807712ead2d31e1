"""What goes beyond the paper: other laws, linear controllers, proofs, friction, the spindle, a mode of the screw."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from leadscrew.analysis.stability.criteria import ask
from leadscrew.analysis.stability.lure import lure
from leadscrew.analysis.stability.margins import margins
from leadscrew.controllers._npid import npid
from leadscrew.controllers._npid_after import npid_after
from leadscrew.controllers._npid_slope import npid_slope
from leadscrew.kernel.block import Block
from leadscrew.studies.exhibits import Table, experiment
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable import chatter, friction, spindle, two_mass
from leadscrew.studies.npid_xytable import split_law as split
from leadscrew.studies.npid_xytable.calibration import gain_um_per_mv
from leadscrew.studies.npid_xytable.claims import (
    DIFFERENTIATORS,
    FOLLOWED_UM,
    LOST_UM,
    NPID,
    PID,
    RETUNED,
    TOP,
    clipped_um,
    differentiated,
    proofs,
    uncompensated_um,
)
from leadscrew.studies.npid_xytable.controllers import BOUNDS
from leadscrew.studies.npid_xytable.cutting import FEW, LOADS_UM, Trial, load_volts, sines, swing_um, trial
from leadscrew.studies.npid_xytable.equal import engineers_choice, tuned_standings
from leadscrew.studies.npid_xytable.intercept import crossing, sampled_crossing
from leadscrew.studies.npid_xytable.laws import GAINS
from leadscrew.studies.npid_xytable.measurement import (
    COHERENT,
    LABELS_HZ,
    LONG,
    SHORT,
    by_fft,
    by_least_squares,
    encoded,
    percent,
    record_um,
    turned,
)
from leadscrew.studies.npid_xytable.reference_loops import reference_loops
from leadscrew.studies.npid_xytable.rejection import BEST, let_through, opened, peak
from leadscrew.studies.npid_xytable.table2 import LINES_HZ, NPID_UM, ORDERS, PID_UM, SPEEDS
from leadscrew.studies.npid_xytable.tunings import TUNINGS
from leadscrew.tune.statistics import Interval

LINE_COLUMNS = tuple(f"{hz:.1f} Hz (%)" for hz in LINES_HZ)
COMPARED = (
    PID, NPID, "ours.npid_slope", "ours.pid_scaled", "ours.pid_dob_150", RETUNED, "ours.pid_159_ff", "ours.pid_185_ff",
    "ours.npid_slope_159", "ours.resonant", "ours.resonant_full",
)  # fmt: skip
BOXED = (
    PID, NPID, "ours.npid_slope", RETUNED, "ours.npid_slope_159", "ours.pid_159_ff", "ours.resonant_box",
    "ours.resonant_full",
)  # fmt: skip


# ---- Table II: how its numbers are read, and what friction alone would give
@measure
def fft_scatter(lab: Lab) -> np.ndarray:
    """Spread over phases of the five amplitudes read off 8192 samples without a window, 5 to 95 %, percent."""
    read = np.array([by_fft(SHORT, "rectangular", phases=tuple(p)) for p in turned(200)])
    return np.ptp(np.percentile(read, (5, 95), axis=0), axis=0)


@experiment("How far off are amplitudes of Table II's size when they are read off an FFT?")
def reading_the_lines(lab: Lab) -> tuple[Table, str]:
    """A record of the PID column at 1,000 1/min, its lines known, read in several ways; error of each amplitude. The
    spread is 5 to 95 % over 200 draws of the phases, the encoder has 0.5 µm and 0.1 µm of noise.
    """
    from leadscrew.analysis.harmonics import spectrum

    rows: dict[str, Any] = {f"least squares, {n} samples": by_least_squares(n) for n in (5000, SHORT, COHERENT)}
    for window in ("rectangular", "hann", "flattop"):
        rows |= {f"FFT, {window}, {n} samples": by_fft(n, window) for n in (SHORT, LONG, COHERENT)}
    rows[f"FFT, rectangular, {SHORT} samples, spread over phases"] = fft_scatter(lab)
    rows[f"least squares at the printed frequencies, {SHORT} samples"] = by_least_squares(SHORT, LABELS_HZ)
    taken, y = record_um(COHERENT)
    rows["FFT at the printed frequencies, coherent"] = percent(spectrum(taken, y).amplitude(LABELS_HZ))
    rows["least squares behind an encoder, mean of 60 records"] = percent(encoded(60).mean(axis=0))
    worst = float(fft_scatter(lab).max())
    return Table("method", LINE_COLUMNS, {name: tuple(map(float, row)) for name, row in rows.items()}), (
        f"Off the bins and without a window the phases move an amplitude by up to {worst:.0f} %, as much as Table II "
        "has between PID and NPID; least squares at the lines' frequencies is exact."
    )


@experiment("Would friction alone make the lines of Table II?")
def friction_alone(lab: Lab) -> tuple[Table, str]:
    """Coulomb friction of 2.6 mV under Table I's PID, in closed form and simulated at 15 mm without any cutting,
    beside the PID column at 3,000 1/min.
    """
    sines_at = friction.sines_on_friction(lab)[PID].orders
    row = sines_at[len(friction.TABLE) + friction.MORE.index(friction.COULOMB_15)]
    rows = {}
    for n, hz, printed in zip(ORDERS, LINES_HZ, PID_UM[3000], strict=True):
        law = 4.0 * friction.COULOMB_15.friction_mv / (np.pi * n) * gain_um_per_mv(hz)
        rows[f"{hz:.1f} Hz"] = (float(law), float(row[n - 1]), printed, 100.0 * (float(law) / printed - 1.0))
    near = sum(abs(off) < 25.0 for *_, off in rows.values())
    columns = ("closed form (um)", "simulated (um)", "printed, 3,000 1/min (um)", "closed form over printed (%)")
    needed = 0.8 / gain_um_per_mv(LINES_HZ[0]) * 3.0 * np.pi / 4.0
    return Table("line", columns, rows), (
        f"{near} of 5 lines are within a quarter of the printed ones; it takes a friction of {needed:.1f} mV, which is "
        "tiny for such a table."
    )


# ---- the law and its stability
@experiment("What does e_max clip: the error inside the gain, or the error itself?")
def clipping(lab: Lab) -> tuple[Table, str]:
    """A sine of 2 mm at 0.7 Hz in L* without cutting, Table I's NPID with the error in mm and in µm; largest error.
    Followed means within 1 % of the motion.
    """
    found = clipped_um(lab)
    rows: dict[str, tuple[Any, ...]] = {
        f"e in {unit}, {where}": (float(found[i, k]), "yes" if found[i, k] < FOLLOWED_UM else "no")
        for i, unit in enumerate(("mm", "µm"))
        for k, where in enumerate(("clipped inside the gain", "clipped itself"))
    }
    return Table("reading", ("largest error (um)", "followed"), rows), (
        f"With e in mm the clip is never met ({found[0, 1]:.1f} µm); with e in µm the letter, which clips the error "
        f"itself, loses the axis ({found[1, 1]:,.0f} µm), so the study clips inside the gain ({found[1, 0]:.2f} µm)."
    )


@experiment("Which holds and delays make the plot cross at −0.4?")
def added_delays(lab: Lab) -> tuple[Table, str]:
    """The loop of Table I with dynamics that the paper does not print: where it crosses the negative real axis. None of
    the delays is in the paper.
    """

    def continuous(delay_s: float = 0.0, hold_s: float = 0.0) -> float:
        found = crossing(delay_s=delay_s, hold_s=hold_s)
        assert found is not None
        return found.value

    tries = {
        "1.2 ms of dead time": continuous(1.2e-3), "1.28 ms of dead time": continuous(1.28e-3),
        "a zero-order hold of 0.5 ms alone": continuous(hold_s=5e-4),
        "a zero-order hold of 1 ms alone": continuous(hold_s=1e-3),
        "2 kHz and a backward difference alone": sampled_crossing(0.0).value,
        "2 kHz and a delay of 0.5 ms": sampled_crossing(5e-4).value,
        "2 kHz and a delay of 1 ms": sampled_crossing(1e-3).value,
        "4 kHz and a delay of 1 ms": sampled_crossing(1e-3, 2.5e-4).value,
    }  # fmt: skip
    alone = min(value for name, value in tries.items() if name.endswith("alone"))
    return Table("added", ("crossing (1)",), {name: (value,) for name, value in tries.items()}), (
        f"Holding and sampling alone cross at −{abs(alone):.2f} at most; −0.4 takes a delay that is chosen for it."
    )


@experiment("Which range of gains do the criteria prove, and in which loop?")
def stability_limits(lab: Lab) -> tuple[Table, str]:
    """The loop of Table I with the dead time that makes the crossing -0.4, with a filtered derivative beside less dead
    time, sampled, and as printed; upper end of the gain. Popov's criterion is for continuous loops, Tsypkin's and Jury
    and Lee's for sampled ones; these two and Zames and Falb's are for NPID in L*, the last column for every command and
    load.
    """
    loops = {
        "dead time 1.2888 ms": "Lc",
        "derivative filtered with 0.5 ms, dead time 0.909 ms": "Lc_filter_500us",
        "L*: 2 kHz, delay 0.775 ms": "L_star", "as printed": "no_delay",
    }  # fmt: skip
    rows: dict[str, tuple[Any, ...]] = {}
    for name, key in loops.items():
        loop = reference_loops()[key]
        popovs = (None, None) if loop.sampled else tuple(ask("popov", loop, k).limit for k in (0.0, 1.0))
        circles = tuple(ask("circle", loop, k).limit for k in (0.0, 1.0))
        more: tuple[Any, ...] = (None,) * 4
        if key == "L_star":
            law = lure(npid)
            multipliers = [
                ask("tsypkin", loop, 1.0),
                *(ask(n, loop, nonlinearity=law) for n in ("jury-lee", "zames-falb")),
            ]
            more = (*(found.limit for found in multipliers), proofs(lab)["driven"].limit)
        rows[name] = (loop.gain_limit(), popovs[0], popovs[1], *circles, *more, margins(loop).pm_deg)
    columns = ("constant (1)", "Popov, from 0 (1)", "Popov, from 1 (1)", "circle, from 0 (1)", "circle, from 1 (1)",
               "Tsypkin, from 1 (1)", "Jury-Lee, from 1 (1)", "Zames-Falb, from 1 (1)", "driven, slope from 1 (1)",
               "phase margin (deg)")  # fmt: skip
    best = max(rows["L*: 2 kHz, delay 0.775 ms"][5:8])
    late = rows["dead time 1.2888 ms"]
    return Table("loop", columns, rows), (
        f"Popov's criterion from 0 proves {100.0 * late[1] / late[0]:.0f} % of the Nyquist limit, from 1 all of it; "
        f"for gains that vary in time the circle proves {late[4]:.2f}. In L* multipliers reach {best:.2f}, where NPID "
        f"needs {TOP:.2f}; a criterion that is only sufficient does not show that a loop is unstable."
    )


@measure
def chatter_rows(lab: Lab) -> dict[str, chatter.Row]:
    """Every chatter run of the study by what is set in it."""
    rows = {f"load {row.load_um:g} µm": row for row in chatter.by_load(lab)}
    rows |= {f"e_max {row.e_max:.4g} µm": row for row in chatter.by_e_max(lab)}
    rows |= {f"dead time {1e3 * row.delay_s:g} ms": row for row in chatter.by_delay(lab)}
    return rows


@experiment("Under which loads does the nonlinear gain chatter, and is it predicted?")
def chatter_under_load(lab: Lab) -> tuple[Table, str]:
    """NPID with e in µm at rest in L*, a constant load and a kick that has ended 1.5 s before. With e_max and dead time
    varied, the load that chatters most; predicted by harmonic balance and by the describing function.
    """
    rows: dict[str, tuple[Any, ...]] = {}
    for name, row in chatter_rows(lab).items():
        loud = row.peak_to_peak_um > chatter.QUIET_UM
        foreseen = [chatter.predicted_um(lab, row, many) if loud else None for many in (True, False)]
        rows[name] = (row.load_um, row.mean_um, row.peak_to_peak_um, row.hz if loud else None, *foreseen)
    columns = ("load (um)", "mean error (um)", "peak to peak (um)", "frequency (Hz)", "harmonic balance (um)",
               "describing function (um)")  # fmt: skip
    loud_rows = [row for row in rows.values() if row[3] is not None]
    off = [max(abs(100.0 * (row[k] / row[2] - 1.0)) for row in loud_rows) for k in (4, 5)]
    edges, kicks = chatter.edges_um(lab), chatter.kicked_um(lab)
    return Table("setting", columns, rows), (
        f"Harmonic balance meets the size to {off[0]:.2f} %, the describing function to {off[1]:.0f} %; under a load "
        f"that rises it chatters up to {edges['up_ends']:.1f} µm, under one that falls from {edges['down_starts']:.1f} "
        f"µm on, and at 12 µm only after a kick ({kicks[0.0]:.3f} and {kicks[chatter.KICK_V]:.1f} µm)."
    )


@experiment("Which shape and which place of the nonlinear gain avoid the chatter?")
def other_laws(lab: Lab) -> tuple[Table, str]:
    """Thirteen constant loads of 2 to 30 µm, largest swing at the end; and a sine of 1 mm without cutting. The three
    small cosh laws have e_max chosen so that their slope ends at the number given.
    """
    from scipy.optimize import brentq

    def reach(bound: float) -> float:
        return float(brentq(lambda x: math.cosh(x) + x * math.sinh(x) - bound, 0.0, 3.0)) / GAINS.alpha

    tries: dict[str, Block] = {
        "Table I, gain before the PID": npid,
        **{f"cosh with slopes to {b:g}": npid(e_max=reach(b)) for b in (2.5, 2.27, 2.0)},
        "gain behind the PID": npid_after,
        "slope-limited, k = 2.2, es = 0.3 µm": npid_slope(es_um=0.3),
        "slope-limited, k = 2.2, es = 0.5 µm": npid_slope(es_um=0.5),
    }
    loads = {"disturbance.first.amplitude": load_volts(LOADS_UM)}
    rows: dict[str, tuple[Any, ...]] = {}
    for name, law in tries.items():
        swing = float(swing_um(lab, law, loads).max())
        size, most, calm = sines(lab, law, "sine_1mm", {"reference.amplitude": np.ones(1)})
        rows[name] = (swing, float(size[0]), float(most[0]), float(calm[0]))
    columns = ("largest swing (um)", "rms error, 1 mm (um)", "largest error, 1 mm (um)", "change of the output (mV)")
    behind, before = rows["gain behind the PID"], rows["Table I, gain before the PID"]
    return Table("law", columns, rows), (
        f"A slope below the gain margin keeps the axis quiet; behind the PID the same gain chatters by {behind[0]:.1f} "
        f"in place of {before[0]:.1f} µm and moves the drive {before[3] / behind[3]:.0f} times less."
    )


# ---- controllers
def of_the_table(found: Trial) -> tuple[float, ...]:
    """Following and rms error, um; change of the output, mV; reductions against PID, %; rows below both columns."""
    printed, against = (np.concatenate([column[rpm] for rpm in SPEEDS]) for column in (PID_UM, NPID_UM))
    rows = found.by_row()
    less = 100.0 * (1.0 - rows / printed)
    below = int((rows < np.minimum(printed, against)).sum())
    return (
        float(found.motion.mean()),
        float(found.rms.mean()),
        float(found.chatter.mean()),
        float(less.mean()),
        float(less.min()),
        below,
    )


@experiment("What does a linear controller do under the same cuts?")
def controllers(lab: Lab) -> tuple[Table, str]:
    """1 mm at 0.7 Hz in L*, Table II's lines at three speeds, six draws of their phases each, runout and tooth
    passing, an encoder of 0.5 µm with 0.1 µm of noise. *Rows*: the fifteen of Table II.
    """
    rows = {name: of_the_table(trial(lab, name, 1.0, FEW)) for name in COMPARED}
    columns = ("following error (um)", "rms error (um)", "change of the output (mV)", "rows, mean reduction (%)",
               "rows, least reduction (%)", "rows below both printed columns (1)")  # fmt: skip
    linear, full = rows[RETUNED], rows["ours.resonant_full"]
    ms = peak(opened(TUNINGS[RETUNED]))
    return Table("controller", columns, rows), (
        f"The linear {RETUNED} of Ms {ms:.2f} is below both printed columns on {linear[5]:.0f} of 15 rows, at least "
        f"{linear[4]:.0f} % below PID; with resonators {full[1]:.2f} µm of error are left."
    )


@experiment("How do controllers stand plants that are not the nominal one?")
def robustness_box(lab: Lab) -> tuple[Table, str]:
    """Twelve plants, gain and damping 20 % off, dead time 0.70 and 0.85 ms, at three spindle speeds, one draw of the
    phases. NPID's size depends on the draw; lost is a plant with more than 100 µm rms at one speed or more.
    """
    rows, swings = {}, {}
    for name in BOXED:
        found = trial(lab, name, 1.0, 1, box=True)
        by_plant = found.rms.reshape(len(SPEEDS), -1)
        rows[name] = (
            float(np.nanmax(found.rows)),
            float(np.nanmean(found.rows)),
            float(found.rms.mean()),
            float(found.rms.max()),
            int((by_plant > LOST_UM).any(axis=0).sum()),
        )
        swings[name] = by_plant[by_plant > LOST_UM]
    columns = ("largest row (um)", "mean row (um)", "rms error, mean (um)", "rms error, largest (um)",
               "plants lost (1)")  # fmt: skip
    lost = "; ".join(
        f"{name} on {rows[name][4]} of {by_plant.shape[1]} ({x.min():.0f} to {x.max():.0f} µm rms)"
        for name, x in swings.items() if x.size
    )  # fmt: skip
    return Table("controller", columns, rows), (
        f"In a limit cycle that only the supply holds: {lost}. With resonators the largest row "
        f"is {rows['ours.resonant_full'][0]:.3f} µm."
    )


@experiment("What does less error at low frequencies cost elsewhere?")
def price_of_rejection(lab: Lab) -> tuple[Table, str]:
    """Error for 1 mV at the plant's input in L*, exact, and the margins of the same loop. A line at 33 Hz is that of
    two teeth at 1,000 1/min.
    """
    blocks = {
        PID: TUNINGS[PID], "ours.pid_dob_60": TUNINGS["ours.pid_dob_60"],
        "ours.pid_dob_150": TUNINGS["ours.pid_dob_150"], "ours.cascade": TUNINGS["ours.cascade"],
        RETUNED: TUNINGS[RETUNED], "ours.pid_ms_185": TUNINGS["ours.pid_ms_185"], "best PID of Ms 1.6": BEST[1.6],
        "best PID of Ms 1.85": BEST[1.85], "ours.pid_rest": lab.study.controllers["ours.pid_rest"],
        "ours.pid_work": lab.study.controllers["ours.pid_work"],
    }  # fmt: skip
    rows = {}
    for name, block in blocks.items():
        loop = opened(block)
        through, at = let_through(loop, (LINES_HZ[0], LINES_HZ[-1], 100.0 / 3.0, 100.0)), margins(loop)
        rows[name] = (*map(float, through), peak(loop), at.gm, at.pm_deg)
    columns = ("2.1 Hz (µm/mV)", "7.7 Hz (µm/mV)", "33 Hz (µm/mV)", "100 Hz (µm/mV)", "Ms (1)", "gain margin (1)",
               "phase margin (deg)")  # fmt: skip
    table_i, best = rows[PID], rows["best PID of Ms 1.6"]
    return Table("controller", columns, rows), (
        f"The best PID of Ms 1.6 lets {table_i[1] / best[1]:.1f} to {table_i[0] / best[0]:.0f} times less through at "
        f"Table II's lines than Table I, and {best[2] / table_i[2]:.1f} times more at 33 Hz."
    )


@experiment("What would an engineer use instead?")
def equal_baselines(lab: Lab) -> tuple[Table, str]:
    """PID, the paper's NPID, npid_split and two linear laws (a PID behind a second-order low-pass, and that with a lag)
    tuned by one search with one budget for the smallest mean row of Table II at 1 mm, all with Ms of 1.6 at every error
    and a proof on the box: with 0.5 mV of activity at rest, or 2 mV at work; judged under other phases, and on other
    plants with 95 % intervals of the difference. *_ff* knows the plant.
    """
    found = tuned_standings(lab)
    rows: dict[str, tuple[Any, ...]] = {}
    for name, x in found.items():
        less: tuple[Any, ...] = (None, None, None) if x.less is None else x.less
        key = f"{name}, knows the plant" if name.endswith("_ff") else name
        rows[key] = (
            x.row,
            x.other_plants.value,
            *less,
            x.row_15mm,
            x.worst_15mm,
            x.rms,
            x.ms,
            x.box_ms,
            x.rest,
            x.work,
        )
    columns = ("mean row (um)", "other plants, mean row (um)", "less PID (um)", "from (um)", "to (um)",
               "15 mm, mean row (um)", "15 mm, worst row over PID (%)", "rms error (um)", "Ms (1)",
               "Ms on the box (1)", "at rest (mV)", "at work (mV)")  # fmt: skip
    rest, work = (Interval(*rows[f"ours.npid_split_{bound}"][2:5]) for bound in BOUNDS)
    proofs = split.proofs(lab)
    proved = sum(one.grade == "certificate" for one in proofs)
    return Table("controller", columns, rows), (
        f"{engineers_choice(lab)} On other plants npid_split is {1e3 * rest.value:+.0f} nm from the PID (95 % "
        f"{1e3 * rest.low:+.0f} to {1e3 * rest.high:+.0f}) and {1e3 * work.value:+.1f} nm; it is proved by a matrix "
        f"inequality on {proved} of {len(proofs)} plants."
    )


# ---- what the paper recommends
@experiment("What does a dead-zone compensator give back?")
def dead_zone(lab: Lab) -> tuple[Table, str]:
    """Table I's PID and NPID on a 1 mm sine, the drive losing 20 mV of every output; the controller adds a share of
    them, by a tanh over 1 mV or by the sign.
    """
    names = ("none", "80 %", "all", "all, by the sign", "120 %")
    rows = {name: (float(a), float(b)) for name, a, b in zip(names, *uncompensated_um(lab), strict=True)}
    sound, nonlinear = (
        float(sines(lab, law, "sine_1mm", {"reference.amplitude": np.ones(1)})[0][0]) for law in (PID, NPID)
    )
    rows["a drive without a dead zone"] = (sound, nonlinear)
    over = rows["120 %"]
    return Table("compensated", ("PID, rms error (um)", "NPID, rms error (um)"), rows), (
        f"The dead zone costs PID {rows['none'][0] / sound:.1f} times the error; its inverse gives all but "
        f"{1e3 * (rows['all'][0] - sound):.0f} nm of it back, 80 % of it leaves {rows['80 %'][0]:.2f} µm. Too much, "
        f"120 %, leaves PID {over[0]:.2f} µm, less than a sound drive: what is too much pushes along the motion and "
        "takes off the lag of a PID without integral action; NPID, which lags less, gains "
        f"{100.0 * (1.0 - over[1] / rows['all'][1]):.1f} % by it."
    )


@experiment("What does a tracking differentiator change?")
def tracking_differentiator(lab: Lab) -> tuple[Table, str]:
    """1 mm at 0.7 Hz, an encoder of 0.5 µm with 0.1 µm of noise; the derivative from a follower of the error with
    acceleration limit r and filter h.
    """
    size, calm, plain = differentiated(lab)
    rows = {}
    for k, law in enumerate(("PID", "NPID")):
        rows[f"{law} alone"] = (float(plain[k, 0]), float(plain[k, 1]))
        for i, (h, r) in enumerate(zip(*DIFFERENTIATORS.values(), strict=True)):
            rows[f"{law}, h = {1e3 * h:g} ms, r = {r:g} mm/s²"] = (float(size[k, i]), float(calm[k, i]))
    lost = [int((size[k] > LOST_UM).sum()) for k in range(2)]
    return Table("controller", ("rms error (um)", "change of the output (mV)"), rows), (
        f"With the PID the drive is {plain[0, 1] / calm[0, 0]:.1f} times calmer at the same error; lost are {lost[0]} "
        f"of {size.shape[1]} loops with the PID, {lost[1]} with NPID: the filter takes the margin that its gain needs."
    )


# ---- friction, spindle, screw
@experiment("What is left against friction?")
def against_friction(lab: Lab) -> tuple[Table, str]:
    """Sines of 0.7 Hz against LuGre friction, 10 s after 20 s; the learned feed-forward on ours.pid_ms_185 behind an
    encoder, 15 mm against 150 mV, with the axis or its belief off.
    """
    rows = {}
    for name, found in friction.sines_on_friction(lab).items():
        for k, case in enumerate(friction.TABLE):
            key = f"{name}, {case.amplitude_mm:g} mm, {case.friction_mv:g} mV"
            rows[key] = (float(found.rms[k]), float(found.largest[k]))
    learned = {name: (float(x.rms[0]), float(x.largest[0])) for name, x in friction.learned_sines(lab).items()}
    rows |= {f"learned, {name}": values for name, values in learned.items()}
    worst = max(values[0] for name, values in learned.items() if name not in friction.WRONG)
    wrong = max(learned[name][0] for name in friction.WRONG)
    plain = rows["ours.pid_ms_185, 15 mm, 150 mV"][0]
    return Table("controller, motion, friction", ("rms error (um)", "largest error (um)"), rows), (
        f"Learned feed-forward takes the retuned PID from {plain:.1f} to {learned['as believed'][0]:.2f} µm, "
        f"{worst:.2f} µm with friction, presliding and gain off at once; with a wrong presliding travel {wrong:.1f} µm."
    )


@experiment("What do faster spindles do?")
def spindle_speeds(lab: Lab) -> tuple[Table, str]:
    """1 mm at 0.7 Hz, 1 mV of runout and 2 mV at four teeth, 500 to 24,000 1/min; the largest error at each line and
    the speed where it is. Above 15,000 1/min the teeth pass faster than half the sampling frequency.
    """
    rows = {}
    for name in spindle.SWEPT:
        found = spindle.sweep(lab, name)
        row: list[float] = []
        for values in (found.spindle, found.tooth):
            worst = int(np.argmax(values))
            row += [float(values[worst]), float(spindle.RPM[worst])]
        rows[name] = tuple(row)
    columns = ("spindle line (um)", "at (1/min)", "tooth line (um)", "at it (1/min)")
    hz = spindle.tooth_hz(spindle.GHOST_RPM)
    plain, ghost = (spindle.line(spindle.SWEPT[RETUNED], hz, cancelled=c) for c in (False, True))
    return Table("controller", columns, rows), (
        f"What takes the lines at 2 to 8 Hz pays at the spindle: {rows[RETUNED][0] / rows[PID][0]:.1f} times Table I's "
        f"error there; a resonator at a folded tooth line leaves {spindle.ghost_um(lab):.0e} µm at the samples and "
        f"{ghost.rms / plain.rms:.1f} times the true motion."
    )


@experiment("What if the spindle turns at another speed than is set?")
def unknown_spindle_speed(lab: Lab) -> tuple[Table, str]:
    """1,000 to 3,000 1/min, right, 2 % off, growing by 0.1 % a second from 2 % below, and swinging by 2 % in 10 s;
    resonators that estimate the speed, and resonators that take the set one.
    """
    fine, coarse = spindle.wrong_speed(lab, spindle.ADAPTIVE), spindle.wrong_speed(lab, spindle.KNOWN_SPEED)
    moving = {"growing": (spindle.DRIFT, 0.0), "swinging": (0.0, spindle.OFF)}
    rows: dict[str, tuple[Any, ...]] = {}
    for name, exact in (("right", True), ("2 % off", False)):
        runs = (fine.share == 0.0) == exact
        after = float(fine.found_after()[runs].max())
        rows[name] = (float(fine.rms[runs].max()), after, float(coarse.rms[runs].max()))
    rows |= {n: (float(spindle.moving_speed(lab, *how).rms.max()), None, None) for n, how in moving.items()}
    columns = ("estimated, rms error (um)", "estimate right after (s)", "speed as set, rms error (um)")
    return Table("speed", columns, rows), (
        f"A speed that is 2 % off is found within {rows['2 % off'][1]:.1f} s and costs nothing; resonators at the "
        f"speed that is set leave {rows['2 % off'][2]:.2f} µm. A speed that swings is not followed."
    )


@experiment("What does the first mode of the screw allow?")
def screw_mode(lab: Lab) -> tuple[Table, str]:
    """The axis on two masses, half of it at the table, 3 % of damping, read at the motor: Ms, none where unstable.
    Share of its speed that ours.pid_ms_159 keeps within Ms 2, without and with a notch at the mode.
    """
    rows: dict[str, tuple[Any, ...]] = {}
    stable = 0
    for hz in two_mass.MODES_HZ:
        motor, table = (two_mass.mode(lab, hz, at_table) for at_table in (False, True))
        stable += sum(found.stable for found in table[0].values())
        rows[f"{hz:g} Hz"] = (*(f.ms if f.stable else None for f in motor[0].values()), *motor[1], *table[1])
    columns = (
        *(f"{name}, Ms (1)" for name in two_mass.TRIED),
        *(f"speed, {at}, {what} (1)" for at in ("motor", "table") for what in ("no notch", "notch")),
    )
    low, high = (f(row[7] / row[6] for row in rows.values()) for f in (min, max))
    return Table("mode", columns, rows), (
        f"With a scale at the table {stable} of {len(two_mass.TRIED) * len(rows)} loops are stable; a notch makes the "
        f"axis {low:.1f} to {high:.1f} times faster there, and at the motor it may only add lag."
    )
