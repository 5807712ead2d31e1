"""What controllers let through of a disturbance, each with its price in margin; cascade and PID; unknown spindle speed.

Section 7 of the digest as far as it is about single controllers; and M7. Everything here is ours: the paper compares a
PID with its nonlinear variant and nothing else.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.controllers import cascade_ppi, input_dob, repetitive
from leadscrew.controllers.pid import TUNINGS as PID
from leadscrew.controllers.pid import pid
from leadscrew.report.claim import Claim
from leadscrew.studies.npid_xytable.calibration import BASE_HZ, LINES_HZ
from leadscrew.studies.npid_xytable.rejection import BEST, let_through, opened, peak, still_to_gain
from leadscrew.studies.npid_xytable.runs import Loops, amplitudes_um
from leadscrew.studies.npid_xytable.saying import said, word
from leadscrew.studies.npid_xytable.unknown_speed import COARSE, DRIFT, OFF, WANDER_S, Cuts, drifting, kept

SECTION = "section III"
RETUNED = {"paper.pid": 1.87, "ours.pid_ms_159": 1.59, "ours.pid_ms_185": 1.85}
"""The digest's peak of sensitivity."""
WEIGHTS = {"controller.b": 0.45, "controller.c": 0.8}
"""Of the command, for a step without overshoot under our PID of Ms 1.59."""

ours = partial(said, source=SECTION)


def rejection_claims(loops: Loops) -> list[Claim]:
    """All of them."""
    return [*_gains(), *_best(), *_observer(loops), *_overshoot(loops), *_cascade(), *_repeated(), *_speed(loops)]


def _gains() -> Iterator[Claim]:
    through = {name: let_through(opened(PID[name])) for name in RETUNED}
    name = "ours.pid_ms_185"
    for at, key, target in ((0, "low", 0.053), (-1, "high", 0.198)):
        yield ours(
            f"let_through_pid_ms_185_{key}",
            statement=f"error for 1 mV at the plant's input at {LINES_HZ[at]:.1f} Hz, {name}",
            measured=through[name][at], unit="um/mV", target=target, tolerance=5e-4,
            reason=f"L*, exact: {', '.join(f'{g:.3f}' for g in through[name])} um/mV at the five lines",
        )  # fmt: skip
    ratio = through["paper.pid"] / through["ours.pid_ms_185"]
    for at, target, tolerance in ((0, 14.0, 0.5), (-1, 3.7, 0.05)):
        yield ours(
            f"let_through_ratio_{'low' if at == 0 else 'high'}",
            statement=f"how much less the retuned PID of Ms 1.85 lets through at {LINES_HZ[at]:.1f} Hz than Table I",
            measured=ratio[at], unit="1", target=target, tolerance=tolerance,
            reason="an integral that works: Ki / Kp is 150/s, in Table I 1/1600 s; the peak of sensitivity is no worse",
        )  # fmt: skip
    tooth = {name: float(let_through(opened(PID[name]), (100.0 / 3.0,))[0]) for name in RETUNED}
    yield ours(
        "let_through_33_hz",
        statement="error for 1 mV at 33.3 Hz, retuned PID of Ms 1.59 over Table I's: two teeth at 1,000 1/min",
        measured=tooth["ours.pid_ms_159"] / tooth["paper.pid"], unit="1", target=None, kind="report",
        reason=f"{tooth['ours.pid_ms_159']:.2f} against {tooth['paper.pid']:.2f} um/mV: what integral action takes at "
        "low frequency comes back around the crossover; where a spindle line lies there, it takes resonators",
    )  # fmt: skip
    for name, target in RETUNED.items():
        yield ours(
            f"ms_{name.split('.')[1]}", statement=f"peak of sensitivity in L*, {name}",
            measured=peak(opened(PID[name])), unit="1", target=target, tolerance=5e-3,
            reason="from the very steps that run, 6,000 frequencies",
        )  # fmt: skip


def _best() -> Iterator[Claim]:
    table_i, by_hand = (let_through(opened(PID[name])) for name in ("paper.pid", "ours.pid_ms_159"))
    for most, block in BEST.items():
        loop, key, p = opened(block), round(100 * most), block.params
        through = let_through(loop)
        given = f"Kp {p.kp:g}, Ki {p.ki:g}, Kd {p.kd:g}"
        yield ours(
            f"best_pid_{key}_ms", statement=f"peak of sensitivity of the best PID for {most:g}", measured=peak(loop),
            unit="1", target=most, sense="<=", reason=f"{given}: least mean error per disturbance at the five lines",
        )  # fmt: skip
        yield ours(
            f"best_pid_{key}_optimum", statement="by how much a local search from there still lowers that mean",
            measured=still_to_gain(most), unit="%", target=0.1, sense="<=",
            reason="Nelder-Mead on ln Kp, ln Ki, ln Kd at the same peak; the start is the end of a global search",
        )  # fmt: skip
        yield ours(
            f"best_pid_{key}_rows", statement="least reduction of a row of Table II against Table I's PID",
            measured=100.0 * float((1.0 - through / table_i).min()), unit="%", target=60.0, sense=">=",
            reason=f"{', '.join(f'{g:.3f}' for g in through)} um/mV at the five lines; the digest's retuned PID of "
            f"Ms 1.59, found at the edge of a grid, {', '.join(f'{g:.3f}' for g in by_hand)}",
            kind="moonshot" if most <= 1.6 else "report",
        )  # fmt: skip


def _observer(loops: Loops) -> Iterator[Claim]:
    plain, peaks = let_through(opened(pid)), {}
    shares = {}
    for name, block in input_dob.TUNINGS.items():
        loop = opened(block)
        shares[name], peaks[name] = let_through(loop) / plain, peak(loop)
    runs = [loops.run(name, "sine_1mm") for name in ("paper.pid", "ours.pid_dob_150")]
    followed = [float(amplitudes_um(run, (BASE_HZ,))[0]) for run in runs]
    yield ours(
        "dob_following", statement="following error at 0.7 Hz with a disturbance observer of 150 rad/s, over without",
        measured=followed[1] / followed[0], unit="1", target=1.0, tolerance=1e-3,
        reason=f"{followed[0]:.3f} um without, {followed[1]:.3f} um with: while the plant is the believed one, the "
        "observer has nothing to find",
    )  # fmt: skip
    amplified = 100.0 * (shares["ours.pid_dob_60"][-1] - 1.0)
    yield ours(
        "dob_60_amplifies", statement="what an observer of 60 rad/s adds to the line at 7.7 Hz", measured=amplified,
        unit="%", target=9.0, kind="report",
        reason=f"{amplified:.1f} % in the linear loop; the digest's 9 % is the worst of its rows, read through an "
        "encoder of 0.5 um, which adds or takes a percent of 0.3 um",
    )  # fmt: skip
    for name, target in (("ours.pid_dob_60", 19.0), ("ours.pid_dob_100", 42.0), ("ours.pid_dob_150", 58.0)):
        yield ours(
            f"dob_{name.rsplit('_', 1)[1]}_mean", statement=f"mean reduction of the five lines, {name}",
            measured=100.0 * float(1.0 - shares[name].mean()), unit="%", target=target, tolerance=0.5,
            reason=f"{', '.join(f'{100 * (1 - s):.0f}' for s in shares[name])} % from 2.1 to 7.7 Hz",
        )  # fmt: skip
        yield ours(
            f"dob_{name.rsplit('_', 1)[1]}_ms", statement=f"peak of sensitivity, {name}", measured=peaks[name],
            unit="1", target=None, kind="report",
            reason="Table I's PID alone: 1.87; the observer costs little margin",
        )  # fmt: skip


def _overshot(loops: Loops, name: str, changes: dict[str, float] | None = None) -> float:
    """Percent of the step."""
    loop = loops.get(name, "step_10um", changes=changes)
    return 100.0 * float(loop.run(0.5, record=()).metrics.overshoot) / loop.parameters["reference.target"]


def _overshoot(loops: Loops) -> Iterator[Claim]:
    yield ours(
        "overshoot_pid_ms_159", statement="overshoot of a bare step of 10 um, ours.pid_ms_159",
        measured=_overshot(loops, "ours.pid_ms_159"), unit="%", target=45.0, tolerance=0.5,
        reason="the command enters all three terms: the price of integral action; Table I has "
        f"{_overshot(loops, 'paper.pid'):.1f} %",
    )  # fmt: skip
    half = _overshot(loops, "ours.pid_ms_159", {"controller.c": 0.0})
    yield ours(
        "overshoot_two_dof", statement="the same with the command weighed 0.45 in P and 0.8 in D",
        measured=_overshot(loops, "ours.pid_ms_159", WEIGHTS), unit="%", target=2.0, sense="<=",
        reason="two degrees of freedom change nothing of what the loop does to a disturbance; the derivative on the "
        f"measurement alone, the usual advice, makes it worse: {half:.0f} %",
    )  # fmt: skip


def _cascade() -> Iterator[Claim]:
    g = PID["ours.pid_ms_159"].params
    yield ours(
        "cascade_of_retuned", statement="whether the digest's retuned PID of Ms 1.59 is a cascade too",
        measured=word(g.kp**2 >= 4.0 * g.kd * g.ki), unit="", target="no", sense="yes/no", basis="arithmetic",
        reason=f"Kp^2 = {g.kp**2:.2f} < 4 Kd Ki = {4.0 * g.kd * g.ki:.2f}: its zeros are complex, a cascade's are real",
    )  # fmt: skip
    block = cascade_ppi.TUNINGS["ours.cascade"]
    loop = opened(block)
    through = let_through(loop)
    yield ours(
        "cascade_best", statement="mean error per disturbance of the best cascade of that peak, over the retuned PID's",
        measured=float(through.mean() / let_through(opened(PID["ours.pid_ms_159"])).mean()), unit="1", target=None,
        kind="report", reason=f"Ms {peak(loop):.2f}; {', '.join(f'{x:.3f}' for x in through)} um/mV: a drive with "
        "a P and a PI loop can do no better, complex zeros need a PID",
    )  # fmt: skip


def _repeated() -> Iterator[Claim]:
    p = repetitive.TUNINGS["ours.repetitive"].params.inner
    w = np.geomspace(1.0, 6270.0, 3000)
    shrinks = repetitive.contraction(PID["ours.pid_ms_159"], w, p.cutoff_hz, p.lead_s, p.strength)
    yield ours(
        "repetitive_contraction", statement="what an error at its worst frequency keeps from one period to the next",
        measured=float(shrinks.max()), unit="1", target=1.0, sense="<=",
        reason=f"repetitive control with a cut-off of {p.cutoff_hz:g} Hz: it converges at every frequency, and forgets "
        "nothing that it knew but what lies above the cut-off",
    )  # fmt: skip


def _speed(loops: Loops) -> Iterator[Claim]:
    fine, box = kept(loops), kept(loops, box=True)
    percent = 100.0 * OFF
    said_of = f"spindle speed right, {percent:g} % too high and too low, 1,000 to 3,000 1/min"
    for key, found, where in (("", fine, "nominal axis"), ("_box", box, "twelve plants of the box")):
        yield ours(
            f"m7{key}_rms", statement=f"largest rms error, {said_of}, {where}", measured=float(found.rms.max()),
            unit="um", target=0.1, sense="<=", kind="moonshot", reason=_rms(found),
        )  # fmt: skip
        yield ours(
            f"m7{key}_rows", statement=f"largest of Table II's rows, {said_of}, {where}",
            measured=float(found.rows.max()), unit="um", target=0.02, sense="<=", kind="moonshot",
            reason=f"mean {found.rows.mean():.4f} um, with an encoder of 0.5 um and 0.1 um of noise",
        )  # fmt: skip
    after = fine.found_after()
    yield ours(
        "m7_found", statement="time until the speed stays within 0.05 % of the true one, longest", unit="s",
        measured=float(after.max()), target=10.0, sense="<=",
        reason=f"shortest {after.min():.1f} s; the second half of 20 s is judged",
    )  # fmt: skip
    coarse = kept(loops, COARSE)
    off = coarse.rms[coarse.share != 0.0]
    yield ours(
        "m7_told_wrong", statement=f"rms error of resonators that are told a speed {percent:g} % off, mean",
        measured=float(off.mean()), unit="um", target=None, kind="report",
        reason=f"{off.min():.2f} to {off.max():.2f} um; with the right speed "
        f"{coarse.rms[coarse.share == 0.0].max():.3f} um at most: a resonator a few rad/s off does nothing",
    )  # fmt: skip
    drift, wander = drifting(loops), drifting(loops, 0.0, OFF)
    yield ours(
        "m7_drift",
        statement=f"largest rms error while the speed grows by {100 * DRIFT:g} % a second from {percent:g} % below",
        measured=float(drift.rms.max()), unit="um", target=0.1, sense="<=", kind="moonshot", reason=_rms(drift),
    )  # fmt: skip
    yield ours(
        "m7_wander", statement=f"largest rms error while the speed swings by {percent:g} % with a period of "
        f"{WANDER_S:g} s", measured=float(wander.rms.max()), unit="um", target=None, kind="report",
        reason=f"{_rms(wander)}: up to 1.3 % a second is too fast for an adaptation of rate 2 1/s",
    )  # fmt: skip


def _rms(found: Cuts) -> str:
    parts = (f"{found.rms[found.rpm == rpm].max():.3f} um at {rpm:,} 1/min" for rpm in np.unique(found.rpm))
    return ", ".join(parts)
