"""Claims beyond the paper: depth feed-forward, normalised gain, adaptive inversion, and all in one; M1 to M5."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.controllers.force.tunings import PREVIEW_N_S
from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.beyond import (
    AT_ONCE,
    BEST,
    LATE,
    QUIET,
    SLOW_ENTRY,
    TRIED,
    WRONG,
    Beyond,
    beyond_of,
    high,
    iae_change,
)
from leadscrew.studies.grey_turning.montecarlo import KF, Judged
from leadscrew.studies.grey_turning.montecarlo_runs import percentile
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said, word

SOURCE = "not in the paper; digest 9"
ALL, ALL_N = "constant_force", "constant_force_n"


def beyond_claims(loops: Loops) -> list[Claim]:
    """Digest section 9 and its moonshots."""
    found = beyond_of(loops)
    return [*_feed_forward(found), *_normalised(found), *_inversion(found), *_moonshots(found), *_slow(found),
            *_elsewhere(found), *_air(found)]  # fmt: skip


def _interval(found: Judged) -> tuple[float, float, float]:
    """90th percentile of the overshoot and its 95 % interval."""
    q = percentile(found.overshoot, 90.0)
    return high(found), float(q.low), float(q.high)


# fmt: off
def _feed_forward(b: Beyond) -> Iterator[Claim]:
    plain, at_once = b.stairs("tfc", "plant_f_radial").of(0), b.stairs("tfc", "plant_f").of(0)
    cases = b.stairs("tfc_ff", "plant_f_radial", TRIED)
    best, late = cases.of(BEST), cases.of(LATE)
    sudden = b.stairs("tfc_ff", "plant_f", AT_ONCE).of(0)
    yield said("ff_dip_none", SOURCE, "worst dip of the filtered force on the stairs 1 to 0.4 mm, best TFC, depth by "
               "the radial servo", plain.low, "%", -18.6, f"true force {plain.true_low:.1f} % (digest -22.5); with "
               f"depths that change at once {at_once.low:.1f} and {at_once.true_low:.1f} %. The digest does not "
               "say how its depth moves; its factors here are others", kind="report")
    yield said("ff_dip", SOURCE, "the same with depth feed-forward and 65 ms of preview", best.low, "%", -1.5,
               f"digest -1.3 to -1.7; true force {best.true_low:.2f} % (digest -2.9 to -4.8). Only a depth that moves "
               "as the radial servo does, in the loop and in the belief, gives these numbers", tolerance=0.25)
    yield said("ff_rise", SOURCE, "largest excess of the filtered force on them", best.high, "%", 1.4,
               f"digest at most 1.4 %; true force {best.true_high:.2f} % (at most 4.2)", sense="<=", tolerance=0.05)
    yield said("ff_true_dip", SOURCE, "worst dip of the true force", best.true_low, "%", -4.8, "digest -2.9 to -4.8",
               sense=">=")
    yield said("ff_mean", SOURCE, "mean |e| after 2 s with feed-forward", best.mean, "%", 0.4,
               f"{plain.mean:.2f} % without: below 0.8 mm the TFC is slow", tolerance=0.05)
    yield said("ff_no_preview", SOURCE, "worst dip without preview", late.low, "%", -7.5, "what the feed servo and the "
               f"first half revolution cost; true force {late.true_low:.1f} %. Digest -7.5, of another factor set",
               kind="report")
    wrong = [cases.of(k) for k in WRONG]
    yield said("ff_tolerant", SOURCE, "worst deviation with P believed 0.70 or 0.85, or the depth 0.05 mm wrong, "
               "filtered force", max(s.worst for s in wrong), "%", 2.8,
               f"true force {max(s.true_worst for s in wrong):.2f} % (digest 5.6); "
               f"{', '.join(f'{s.worst:.2f}' for s in wrong)} % of the filtered one. The digest has 2.8 at most, of "
               "another factor set", sense="<=", kind="report")
    yield said("ff_at_once", SOURCE, "true force with feed-forward where the depth changes at once: worst deviation",
               sudden.true_worst, "%", None, f"filtered {sudden.low:.2f} to {sudden.high:+.2f} %: the force follows "
               "the depth at once and the feed within 0.1 s, so preview can only share it out", kind="report")


def _normalised(b: Beyond) -> Iterator[Claim]:
    tfc, found, first = b.drawn("tfc"), b.drawn("gain_normalised"), b.entry("gain_normalised").reading
    p90, low, top = _interval(found)
    yield said("normalised_p90", SOURCE, "overshoot, 90th percentile of 300 draws, TFC with normalised gain", p90, "%",
               7.0, f"95 %: {low:.1f} to {top:.1f} %; {high(tfc):.1f} % without. Digest 4 to 7: of draws from the same "
               "ranges, but not the same draws; ours is shown, not judged", sense="<=", kind="report")
    yield said("normalised_bad", SOURCE, "bad draws of it", 100.0 * found.bad.mean(), "%", 0.3,
               f"{tfc.bad.sum()} of 300 without, {found.bad.sum()} with: one draw is 0.33 %. Digest 0 to 0.3, "
               "of other draws from the same ranges",
               sense="<=", kind="report")
    yield said("normalised_rise", SOURCE, "rise time of it at the nominal cut", float(np.mean(first.rise_s)), "s", 0.28,
               f"{np.mean(b.entry('tfc').reading.rise_s):.3f} s without: the feed starts from rest with 0.3 of each "
               f"increment; IAE of the draws {iae_change(found, tfc):+.0f} %. Digest 0.28 to 0.34", tolerance=0.005)


def _inversion(b: Beyond) -> Iterator[Claim]:
    tfc, found, cautious = b.drawn("tfc"), b.drawn("inversion"), b.drawn("inversion_cautious")
    p90, low, top = _interval(found)
    yield said("inversion_p90", SOURCE, "overshoot, 90th percentile of 300 draws, adaptive inversion", p90, "%", 5.3,
               f"95 %: {low:.1f} to {top:.1f} %; TFC {high(tfc):.1f} (digest 15.2). Other draws from the same "
               "ranges: shown, not judged", kind="report")
    yield said("inversion_bad", SOURCE, "bad draws of it", float(found.bad.sum()), "draws", 0.0,
               f"TFC {tfc.bad.sum()}")
    change = iae_change(found, tfc)
    yield said("inversion_iae", SOURCE, "median change of the IAE against the best TFC", change, "%", -8.0,
               f"better in {100 * np.mean(found.iae < tfc.iae):.0f} % of the draws", tolerance=1.0)
    slow, slow_high, slow_top = _interval(cautious)
    yield said("inversion_cautious", SOURCE, "the same percentile with the prior three times the nominal and 12 kN/mm",
               slow, "%", 2.9, f"95 %: {slow_high:.1f} to {slow_top:.1f} %; rise of the nominal cut "
               f"{np.mean(b.entry('inversion_cautious').reading.rise_s):.2f} s (digest 0.32), IAE "
               f"{iae_change(cautious, tfc):+.0f} %", tolerance=0.1)
    rigid, rigid_low, rigid_top = _interval(b.drawn("inversion", stiffness=1e9))
    nominal = b.entry("inversion", stiffness=1e9)
    yield said("inversion_no_compliance", SOURCE, "the same percentile without the correction for compliance", rigid,
               "%", 11.0, f"95 %: {rigid_low:.1f} to {rigid_top:.1f} %; nominal cut "
               f"{np.mean(nominal.reading.overshoot):.1f} %, true force {nominal.peak.mean():.1f} %. Digest 11 to 21",
               sense=">=")
    below, above = (b.entry("inversion", scenario=QUIET, first_k=k * KF) for k in (0.8, 1.3))
    yield said("inversion_low_prior", SOURCE, "peak of the true force at the nominal cut, noise-free, prior 0.8 of the "
               "true K", float(below.peak[0]), "%", 6.0, f"filtered {np.mean(below.reading.overshoot):.1f} %; with the "
               f"prior of 1.3 the true one peaks at {above.peak[0]:.1f} %. Digest: 4 to 8, without saying of which "
               "force or prior", tolerance=2.0)


def _moonshots(b: Beyond) -> Iterator[Claim]:
    moon = partial(said, kind="moonshot")
    entry, quiet = b.entry(ALL), b.entry(ALL, scenario=QUIET)
    r, rise = entry.reading, float(np.mean(entry.reading.rise_s))
    yield moon("m1_overshoot", SOURCE, "M1: overshoot at the nominal cut, sigma 2 N, all in one", float(np.mean(
        r.overshoot)), "%", 1.2, f"noise alone makes 1.0 to 1.1 %; {np.max(r.overshoot):.2f} % in the worst of "
        f"{len(r.overshoot)} seeds", sense="<=")
    yield moon("m1_noise_free", SOURCE, "M1: the same noise-free", float(np.mean(quiet.reading.overshoot)), "%", 0.1,
               "no overshoot but rounding", sense="<=")
    yield moon("m1_rise", SOURCE, "M1: rise time", rise, "s", 0.22, f"{np.mean(quiet.reading.rise_s):.3f} s "
               f"noise-free; best TFC {np.mean(b.entry('tfc').reading.rise_s):.3f} s, both between samples", sense="<=")
    yield moon("m1_bias", SOURCE, "M1: mean error of the last second", float(np.mean(r.bias)), "%", 0.1,
               "mean of the seeds' sizes; what is left is the noise's own mean", sense="<=")
    stairs, sudden = b.stairs(ALL, "plant_f_radial").of(0), b.stairs(ALL, "plant_f").of(0)
    yield moon("m2_filtered", SOURCE, "M2: worst deviation on the stairs after the entry, filtered force, depth by the "
               "radial servo", stairs.worst, "%", 3.0, f"{stairs.low:.2f} to {stairs.high:+.2f} %; at once "
               f"{sudden.low:.2f} to {sudden.high:+.2f} %", sense="<=")
    yield moon("m2_true", SOURCE, "M2: the same, true force", stairs.true_worst, "%", 5.0,
               f"{stairs.true_low:.2f} to {stairs.true_high:+.2f} %; at once {sudden.true_low:.1f} to "
               f"{sudden.true_high:+.1f} %, which no feed servo can meet", sense="<=")
    tfc, drawn, blind = b.drawn("tfc"), b.drawn(ALL), b.drawn(ALL, told=False)
    p90, low, top = _interval(drawn)
    yield moon("m3_p90", SOURCE, "M3: overshoot, 90th percentile of 300 draws", p90, "%", 5.5,
               f"95 %: {low:.2f} to {top:.2f} %; told 1 mm whatever is cut: {high(blind):.2f} %", sense="<=")
    yield moon("m3_bad", SOURCE, "M3: bad draws", float(drawn.bad.sum()), "draws", 0.0,
               f"of {len(drawn.bad)}; TFC {tfc.bad.sum()}")
    yield moon("m3_iae", SOURCE, "M3: median change of the IAE against the best TFC", iae_change(drawn, tfc), "%", -8.0,
               f"better in {100 * np.mean(drawn.iae < tfc.iae):.0f} % of the draws; told 1 mm whatever is cut: "
               f"{iae_change(blind, tfc):.0f} %", sense="<=")
    yield moon("m5_true_overshoot", SOURCE, "M5: overshoot of the true force at the nominal cut", float(
        entry.peak.mean()), "%", 3.0, f"mean of {len(entry.peak)} seeds with noise of 2 N and runout, which alone "
        f"makes 1.5 %; worst seed {entry.peak.max():.1f} %, noise-free {float(quiet.peak[0]):.2f} %, at a rise of "
        f"{rise:.3f} s; best TFC {b.entry('tfc').peak.mean():.1f} %", sense="<=")


def _slow(b: Beyond) -> Iterator[Claim]:
    machine, moon = "plant_n", partial(said, kind="moonshot")
    plain = b.stairs("tfc", f"{machine}_radial").of(0)
    ahead = b.stairs("tfc_ff", f"{machine}_radial", ({"preview_s": 0.12},)).of(0)
    yield said("ff_slow", SOURCE, "plant N: worst dip on the stairs, feed-forward with 120 ms of preview, TFC "
               "tuned for plant F", ahead.low, "%", -1.5, f"{plain.low:.1f} % without (digest -24); the filtered force",
               tolerance=0.25)
    entry, stairs = b.entry(ALL_N, machine), b.stairs(ALL_N, f"{machine}_radial").of(0)
    drawn, tfc = b.drawn(ALL_N, machine), b.drawn("tfc_n", machine)
    p90, low, top = _interval(drawn)
    rise, quiet = float(np.mean(entry.reading.rise_s)), b.entry(ALL_N, machine, QUIET)
    fast = b.entry(ALL, machine)
    yield moon("m4_slow_overshoot", SOURCE, "M4: overshoot at the nominal cut, plant N; one law, its second preset: "
               f"preview of {1e3 * PREVIEW_N_S:.0f} ms and another lead", float(np.mean(entry.reading.overshoot)), "%",
               1.2,
               f"rise {rise:.3f} s, bias {np.mean(entry.reading.bias):.3f} %, true force {entry.peak.mean():.1f} %; "
               "tuned controllers of the digest rise in 0.24 to 0.33 s there", sense="<=")
    yield moon("m4_slow_stairs", SOURCE, "M4: worst deviation on the stairs, plant N, filtered force", stairs.worst,
               "%", 3.0, f"true force {stairs.true_worst:.2f} % (5 is asked)", sense="<=")
    yield moon("m4_slow_true_stairs", SOURCE, "M4: the same, true force", stairs.true_worst, "%", 5.0,
               f"{stairs.true_low:.2f} to {stairs.true_high:+.2f} %", sense="<=")
    yield moon("m4_slow_p90", SOURCE, "M4: overshoot, 90th percentile of 400 draws, plant N", p90, "%", 5.5,
               f"95 % interval {low:.2f} to {top:.2f} %, {'all below' if top <= 5.5 else 'on both sides of'} 5.5; "
               f"TFC tuned for plant N {high(tfc):.2f} %", sense="<=")
    yield moon("m4_slow_bad", SOURCE, "M4: bad draws, plant N", float(drawn.bad.sum()), "draws", 0.0,
               f"of {len(drawn.bad)}; TFC tuned for plant N {tfc.bad.sum()}")
    yield moon("m4_slow_iae", SOURCE, "M4: median change of the IAE, plant N, against the TFC that is tuned for it",
               iae_change(drawn, tfc), "%", -8.0, f"better in {100 * np.mean(drawn.iae < tfc.iae):.0f} % of the draws",
               sense="<=")
    yield moon("m4_slow_bias", SOURCE, "M4: mean error of the last second, plant N", float(np.mean(entry.reading.bias)),
               "%", 0.1, "mean of the seeds' sizes", sense="<=")
    yield moon("m4_slow_noise_free", SOURCE, "M4: overshoot noise-free, plant N", float(np.mean(
        quiet.reading.overshoot)), "%", 0.1, f"true force {quiet.peak[0]:.2f} %", sense="<=")
    yield moon("m4_rise", SOURCE, "M4: rise time on plant N", rise, "s", 0.22, "M1 asks it of plant F; here the lead "
               "is larger and the peak of the true force higher", sense="<=")
    yield said("m5_slow_true_overshoot", SOURCE, "M5 on plant N: overshoot of the true force at the nominal cut", float(
        entry.peak.mean()), "%", 3.0, f"worst of {len(entry.peak)} seeds {entry.peak.max():.1f} %, noise-free "
        f"{quiet.peak[0]:.2f} %; the digest asks 3 % of plant F, not of plant N", sense="<=", kind="report")
    yield said("m4_one_preset", SOURCE, "rise time on plant N with the preset of plant F: why there is a second one",
               float(np.mean(fast.reading.rise_s)), "s", None, f"{rise:.3f} s with its own; overshoot "
               f"{np.mean(fast.reading.overshoot):.2f} %, true force {fast.peak.mean():.1f} %: one law, two presets, "
               "not one setting for both machines", kind="report")
    fast, steps, draws = b.entry(ALL), b.stairs(ALL, "plant_f_radial").of(0), b.drawn(ALL)
    together = (
        np.mean(fast.reading.overshoot) <= 1.2 and np.mean(fast.reading.rise_s) <= 0.22
        and np.mean(fast.reading.bias) <= 0.1 and np.mean(b.entry(ALL, scenario=QUIET).reading.overshoot) <= 0.1
        and steps.worst <= 3.0 and steps.true_worst <= 5.0 and high(draws) <= 5.5 and draws.bad.sum() == 0
        and iae_change(draws, b.drawn("tfc")) <= -8.0
    )
    yield moon("m4_together", SOURCE, "M4: whether one controller with one setting meets M1, M2, M3 on plant F", word(
        bool(together)), "", "yes", "the stairs with the radial servo in the machine and in the belief; plant N needs "
        "its own preset, see m4_slow_overshoot and m4_one_preset", sense="yes/no")


def _elsewhere(b: Beyond) -> Iterator[Claim]:
    iron, tfc = b.entry(ALL, "plant_f_iron"), b.entry("tfc", "plant_f_iron")
    bold = b.entry(ALL, "plant_f_iron", exponent_caution=0.0)
    rise = float(np.mean(iron.reading.rise_s))
    yield said("iron_overshoot", SOURCE, "iron, all in one with the preset for steel: overshoot of the filtered force",
               float(np.mean(iron.reading.overshoot)), "%", None, f"rise {rise:.3f} s; best TFC "
               f"{np.mean(tfc.reading.overshoot):.2f} % at {np.mean(tfc.reading.rise_s):.2f} s: its gain is tuned for "
               "steel", kind="report")
    yield said("iron_true_overshoot", SOURCE, "the same, true force", float(iron.peak.mean()), "%", None,
               f"mean of {len(iron.peak)} seeds, worst {iron.peak.max():.1f} %; best TFC {tfc.peak.mean():.1f} %, "
               f"{np.mean(tfc.reading.rise_s) / rise:.1f} times as slow. Without care for the exponent "
               f"{bold.peak.mean():.1f} %: iron needs three times the feed of the belief", kind="report")
    ours, ff, plain = (b.entry(name, scenario=SLOW_ENTRY) for name in (ALL, "tfc_ff", "tfc"))
    yield said("tool_entry_overshoot", SOURCE, "tool that enters within 0.4 s, all in one: overshoot of the filtered "
               "force", float(np.mean(ours.reading.overshoot)), "%", None, "told 0 mm it feeds 0.1 V at most until the "
               f"tool is in the cut; best TFC {np.mean(plain.reading.overshoot):.1f} %, with depth feed-forward "
               f"{np.mean(ff.reading.overshoot):.1f} %", kind="report")
    yield said("tool_entry_true_overshoot", SOURCE, "the same, true force", float(ours.peak.mean()), "%", None,
               f"best TFC {plain.peak.mean():.1f} %, whose feed runs up while the cut is shallow; with depth "
               f"feed-forward {ff.peak.mean():.1f} %", kind="report")


def _air(b: Beyond) -> Iterator[Claim]:
    air, cut, left = ({name: b.outing(name, what) for name in (ALL, "tfc_ff", "tfc")}
                      for what in ("air", "air_then_cut", "exit"))
    yield said("air_feed", SOURCE, "largest feed voltage where the programme says air, all in one and TFC with depth "
               "feed-forward", max(air[ALL].output, air["tfc_ff"].output), "V", 0.1, "the parameter air_feed; the TFC "
               f"alone {air['tfc'].output:.1f} V", sense="<=", tolerance=1e-9)
    yield said("air_then_cut", SOURCE, "largest excess of the true force where 1 mm follows on 2 s of air, larger of "
               "both", max(cut[ALL].peak, cut["tfc_ff"].peak), "%", 5.0, f"all in one {cut[ALL].peak:.1f}, preview "
               f"{cut['tfc_ff'].peak:.1f}, TFC alone {cut['tfc'].peak:.0f} %; noise-free, depth at once; bound of M2",
               sense="<=")
    yield said("exit_peak", SOURCE, "largest excess of the true force where the tool leaves as programmed, larger of "
               "both", max(left[ALL].peak, left["tfc_ff"].peak), "%", 5.0, "no preview towards air: the feed stays as "
               f"in the cut; TFC alone {left['tfc'].peak:.1f} %; bound of M2", sense="<=")
