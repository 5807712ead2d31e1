"""Claims about Figures 6 and 7: constant force at a fixed depth of cut, with and without grey prediction."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.claims_fuzzy_margins import margins_of
from leadscrew.studies.grey_turning.readings import read
from leadscrew.studies.grey_turning.reproduction import WORDS, Case, Cuts, Reproduction, Told, together, told
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said

SOURCE = "section 5.1, Figures 6 and 7"
PAPER = {"tfc": (2.7, 0.5, 1.7), "b": (1.5, 0.3, 1.0)}
"""Overshoot in %, rise time in s, steady error in %."""
UNITS = {"overshoot": "%", "rise": "s", "steady": "%"}
DIGIT = {"overshoot": 0.01, "rise": 0.01, "steady": 0.01}
NEAR = {"overshoot": 0.6, "rise": 0.05, "steady": 0.35}
"""What still counts as the paper's number, which is told as 'about'."""

fitted = partial(said, source=SOURCE, group="as corrected", basis="fitted to this number")
corrected = partial(said, source=SOURCE, group="as corrected")


def fixed_claims(loops: Loops, found: Reproduction | None = None) -> list[Claim]:
    """A7's first half, A13 and the rows of section 6 of the digest that belong to 5.1."""
    found = found or Reproduction(loops)
    return [
        *_fitted(found), *_windows(found), *_quiet(found), *_reading_a(found), *_slow(found), *_edge(found),
        *_tuned(found), *_noise_floor(found), *_activity(found), *_faster(loops),
    ]  # fmt: skip


def three(cuts: Cuts) -> dict[str, Told]:
    """Overshoot, rise time and steady error of a case."""
    return {"overshoot": told(cuts.overshoot), "rise": told(cuts.rise_s), "steady": told(cuts.steady())}


def row(found: dict[str, Told]) -> str:
    """The three in words."""
    o, r, s = found.values()
    return f"{o.mean:.2f} % / {r.mean:.3f} s / {s.mean:.2f} %"


def _fitted(found: Reproduction) -> Iterator[Claim]:
    targets = {"tfc": (2.84, 0.50, 0.45), "b": (1.41, 0.49, 0.48)}
    why = {
        "overshoot": "fitted, not predicted: three factors were chosen to give the paper's overshoots and the TFC's "
        "rise time",
        "rise": "a shared set of factors never gives 0.5 and 0.3 s: while the force rises the predicted error is "
        "smaller, so the increment is smaller",
        "steady": "the noise floor at 2 N of noise: the paper's value depends on noise or on a limit cycle (edge_* "
        "below), of which it says nothing",
    }
    for law, printed in PAPER.items():
        seen = three(found.fixed[f"s6_{law}"])
        for (what, value), target, paper in zip(seen.items(), targets[law], printed, strict=True):
            same = abs(value.mean - paper) <= NEAR[what]
            yield fitted(
                f"fixed_{what}_{law}", statement=f"{NAMES[what]} at a fixed depth, {WORDS[law]} with S6, plant F",
                measured=value.mean, unit=UNITS[what], target=target, tolerance=value.tolerance(DIGIT[what]),
                paper=paper, verdict="reproduced with change" if same else "not reproduced",
                reason=f"mean of {value.seeds} noise seeds, one seed scatters by {value.spread:.2g} {UNITS[what]}; "
                f"{why[what]}", basis="fitted to this number" if same else "reconstructed plant",
            )  # fmt: skip


NAMES = {"overshoot": "overshoot", "rise": "rise time from 10 to 90 %", "steady": "steady error of the last second"}


def _windows(found: Reproduction) -> Iterator[Claim]:
    t, b = (three(found.fixed[f"s6_{law}"]) for law in ("tfc", "b"))
    passes = (
        2.3 <= t["overshoot"].mean <= 3.3
        and 0.45 <= t["rise"].mean <= 0.55
        and b["overshoot"].mean <= 1.7
        and b["rise"].mean <= 1.05 * t["rise"].mean
    )
    yield fitted(
        "fixed_windows", statement="TFC overshoots by 2.3 to 3.3 % and rises in 0.45 to 0.55 s; GPFC by at most 1.7 %, "
        "no slower than 1.05 times", measured="yes" if passes else "no", unit="", target="yes", sense="yes/no",
        reason=f"TFC {row(t)}, GPFC {row(b)}; S6 was fitted, so this shows agreement with the digest's prototype and "
        "nothing about the paper",
    )  # fmt: skip
    gain = 100.0 * (1.0 - b["rise"].mean / t["rise"].mean)
    yield corrected(
        "fixed_rise_gain", statement="how much faster GPFC rises than TFC with the same factors", measured=gain,
        unit="%", target=20.0, sense="<=", paper=40.0,
        verdict="reproduced" if gain >= 30.0 else "not reproduced",
        reason=f"{t['rise'].mean:.3f} and {b['rise'].mean:.3f} s; factors of its own rise in "
        f"{told(found.fixed['sg_b'].rise_s).mean:.2f} s, and a TFC with its own in "
        f"{told(found.fixed['stfc_tfc'].rise_s).mean:.2f} s: prediction is not what makes the loop fast",
    )  # fmt: skip


def _quiet(found: Reproduction) -> Iterator[Claim]:
    targets = {"tfc": (2.59, 0.50, 0.01), "b": (0.43, 0.50, 0.00)}
    for law in PAPER:
        seen = three(found.quiet[f"s6_{law}"])
        for (what, value), target in zip(seen.items(), targets[law], strict=True):
            yield corrected(
                f"fixed_quiet_{what}_{law}", statement=f"{NAMES[what]}, noise-free, {WORDS[law]} with S6, plant F",
                measured=value.mean, unit=UNITS[what], target=target, tolerance=0.5 * DIGIT[what] + 1e-9,
                reason="without noise and runout",
            )  # fmt: skip


def _reading_a(found: Reproduction) -> Iterator[Claim]:
    a, b = (three(found.fixed[f"s6_{law}"]) for law in ("a", "b"))
    yield corrected(
        "fixed_reading_a_cycles", statement="steady error of GPFC in reading A with S6", measured=a["steady"].mean,
        unit="%", target=1.5, sense=">=", reason=f"a limit cycle: {row(a)}; reading B {row(b)}. In reading A the "
        "predicted change is the predicted error less the measured one, which lends the proportional part a lag",
    )  # fmt: skip
    yield corrected(
        "fixed_reading_b_settles", statement="steady error of GPFC in reading B with S6", measured=b["steady"].mean,
        unit="%", target=1.5, sense="<=", reason=f"{row(b)}: the noise floor",
    )  # fmt: skip
    for (what, value), target in zip(a.items(), (5.1, 0.57, 2.8), strict=True):
        yield corrected(
            f"fixed_reading_a_{what}", statement=f"{NAMES[what]}, GPFC in reading A with S6, plant F",
            measured=value.mean, unit=UNITS[what], target=target,
            tolerance=value.tolerance(0.01 if what == "rise" else 0.1),
            reason=f"one seed scatters by {value.spread:.2g} {UNITS[what]}",
        )  # fmt: skip


def _slow(found: Reproduction) -> Iterator[Claim]:
    for law, targets in (("tfc", (2.90, 0.50, 0.46)), ("b", (1.20, 0.50, 0.47))):
        for (what, value), target in zip(three(found.fixed[f"s6n_{law}"]).items(), targets, strict=True):
            yield fitted(
                f"fixed_plant_n_{what}_{law}", statement=f"{NAMES[what]}, {WORDS[law]} with S6n, plant N",
                measured=value.mean, unit=UNITS[what], target=target, tolerance=value.tolerance(DIGIT[what], 20),
                reason=f"one seed scatters by {value.spread:.2g} {UNITS[what]}; the slower plant can be fitted to 5.1 "
                "as well: the figures do not tell the plants apart",
            )  # fmt: skip


def _edge(found: Reproduction) -> Iterator[Claim]:
    targets = {"tfc": (2.96, 0.58, 1.66), "b": (1.51, 0.61, 0.76)}
    seen = {law: three(found.fixed[f"edge_{law}"]) for law in ("tfc", "b", "a")}
    for law, printed in PAPER.items():
        margin = margins_of("tfc" if law == "tfc" else "gpfc_b", "edge_n", rigid=False).gain
        for (what, value), target, paper in zip(seen[law].items(), targets[law], printed, strict=True):
            same = abs(value.mean - paper) <= NEAR[what]
            yield fitted(
                f"edge_{what}_{law}", statement=f"{NAMES[what]}, {WORDS[law]} at the edge of a limit cycle, plant N, "
                "1 N of noise", measured=value.mean, unit=UNITS[what], target=target,
                tolerance=value.tolerance(DIGIT[what]), paper=paper,
                verdict="reproduced with change" if same else "not reproduced",
                basis="fitted to this number" if same else "reconstructed plant",
                reason=f"one seed scatters by {value.spread:.2g} {UNITS[what]}; here the steady error is a ripple of "
                f"the loop, whose linear gain margin is {margin:.3f}",
            )  # fmt: skip
    low, high = ({law: three(found.fixed[f"edge_{end}_{law}"]) for law in ("tfc", "b")} for end in ("low", "high"))
    for law, (least, most) in {"tfc": (1.3, 8.4), "b": (1.0, 5.4)}.items():
        for end, of, target in (("low", low, least), ("high", high, most)):
            value = of[law]["overshoot"]
            yield corrected(
                f"edge_{end}_overshoot_{law}", statement=f"the same, overshoot of {WORDS[law]} with a loop gain "
                f"{'10 % lower' if end == 'low' else '10 % higher'}", measured=value.mean, unit="%", target=target,
                tolerance=value.tolerance(0.1), reason=f"steady error {of[law]['steady'].mean:.2f} %: a cut that needs "
                "another feed by a tenth leaves the paper's numbers",
            )  # fmt: skip
    a = seen["a"]["steady"]
    yield corrected(
        "edge_reading_a", statement="the same, steady error of GPFC in reading A", measured=a.mean, unit="%",
        target=10.6, tolerance=a.tolerance(0.1), reason=f"{row(seen['a'])}: it cycles",
    )  # fmt: skip
    calm = {law: told(found.fixed[f"edge_{law}"].activity_mv(2.0, 3.0)) for law in ("tfc", "b")}
    for law, target in (("tfc", 2.5), ("b", 1.6)):
        yield corrected(
            f"edge_activity_{law}", statement=f"the same, change of the voltage a sample in the last second, "
            f"{WORDS[law]}", measured=calm[law].mean, unit="mV", target=target, tolerance=calm[law].tolerance(0.1),
            reason="the one set of all where GPFC is calmer in steady state",
        )  # fmt: skip
    ratios = [100.0 * PAPER["b"][i] / PAPER["tfc"][i] for i in (0, 2)]
    yield corrected(
        "edge_ratio", statement="the paper's steady error over its overshoot, TFC", measured=1.7 / 2.7, unit="",
        target=0.63, tolerance=0.005, basis="arithmetic",
        reason=f"arithmetic on two numbers of the paper, nothing is simulated; a sine of amplitude "
        f"'overshoot' has 2/pi = {2.0 / np.pi:.3f}; GPFC {1.0 / 1.5:.2f}: both errors of 5.1 "
        f"could be ripples (GPFC over TFC {ratios[0]:.0f} and {ratios[1]:.0f} %)",
    )  # fmt: skip


def _tuned(found: Reproduction) -> Iterator[Claim]:
    for name, law, targets in (("stfc", "tfc", (1.05, 0.22, 0.36)), ("sg", "b", (1.13, 0.23, 0.37))):
        seen = three(found.fixed[f"{name}_{law}"])
        for (what, value), target in zip(seen.items(), targets, strict=True):
            yield said(
                f"tuned_{what}_{law}", SOURCE, f"{NAMES[what]}, {WORDS[law]} with factors tuned for it, plant F",
                value.mean, UNITS[what], target, f"{row(seen)}; the paper's GPFC 1.5 % / 0.3 s / 1.0 %: a tuned TFC "
                "without prediction beats it in all three", tolerance=value.tolerance(DIGIT[what]),
            )  # fmt: skip
    tfc = three(found.fixed["stfc_tfc"])
    paper = dict(zip(tfc, PAPER["b"], strict=True))
    beats = all(tfc[what].mean < paper[what] for what in tfc)
    yield said(
        "tuned_tfc_beats_paper_gpfc", SOURCE, "a tuned TFC beats the paper's GPFC in overshoot, rise time and steady "
        "error", "yes" if beats else "no", "", "yes", f"{row(tfc)} against 1.5 % / 0.3 s / 1.0 %; on another lathe "
        "than the paper's", sense="yes/no",
    )  # fmt: skip


def _noise_floor(found: Reproduction) -> Iterator[Claim]:
    cuts = found.fixed["stfc_tfc"]
    late = cuts.y[:, -50:]
    most = told(100.0 * np.abs(late / 150.0 - 1.0).max(axis=1))
    over, error = told(cuts.overshoot), told(cuts.steady())
    true = told(np.asarray(read(cuts.force).steady))
    lines = (
        ("overshoot", "overshoot", over, 1.05, 0.05), ("mean", "steady error", error, 0.38, 0.02),
        ("max", "largest error of the last second", most, 1.15, 0.05),
        ("true", "steady error of the true force", true, 0.68, 0.005),
    )  # fmt: skip
    for name, words, value, target, width in lines:
        yield said(
            f"noise_floor_{name}", SOURCE, f"{words} of a tuned TFC at 2 N of noise: the noise floor", value.mean, "%",
            target, f"nothing below it can be told on this load cell; one seed scatters by {value.spread:.2g} %"
            + ("; the runout of 0.01 mm makes it" if name == "true" else ""), tolerance=value.tolerance(0.0) + width,
        )  # fmt: skip


def _activity(found: Reproduction) -> Iterator[Claim]:
    steady = {
        name: {law: told(found.long[f"{name}_{law}"].activity_mv(2.0, 4.0)) for law in ("tfc", "b")}
        for name in ("s6", "s9", "stfc")
    }
    for name, targets in (("s9", (0.98, 1.16)), ("s6", (1.26, 1.63)), ("stfc", (0.61, 0.70))):
        for law, target in zip(("tfc", "b"), targets, strict=True):
            value = steady[name][law]
            yield corrected(
                f"activity_steady_{name}_{law}", statement="change of the voltage a sample in steady state, 2 to 4 s, "
                f"{WORDS[law]} with {name.upper()}", measured=value.mean, unit="mV", target=target,
                tolerance=value.tolerance(0.01), reason="mean size; predictions of reading B amplify noise",
            )  # fmt: skip
    more = {name: 100.0 * (both["b"].mean / both["tfc"].mean - 1.0) for name, both in steady.items()}
    calmer = all(v < 0.0 for v in more.values())
    yield corrected(
        "activity_steady_smoother", statement="in steady state the voltage is smoother with GPFC than with TFC",
        measured="yes" if calmer else "no", unit="", target="no", sense="yes/no", paper="smoother",
        verdict="reproduced" if calmer else "not reproduced",
        reason="GPFC over TFC: " + ", ".join(f"{n.upper()} {v:+.0f} %" for n, v in more.items())
        + "; it is smoother in the entry transient only, and at the edge of a limit cycle",
    )  # fmt: skip


def _faster(loops: Loops) -> Iterator[Claim]:
    from leadscrew.controllers.grey_fuzzy.tunings import Factors

    drowned = {"plant.servo.rate": 15.0, "sensor.noise_n": 6.0}
    late = {"plant.servo.rate": 25.0, "plant.servo.dead_time_s": 0.05, "sensor.noise_n": 3.0, "plant.runout": 0.0}
    one, two = Factors(9.88, 0.205, 0.0018), Factors(26.3, 4.68, 0.0146)
    seen = {
        **together(loops, {f"drowned_{law}": Case(one, law, drowned) for law in ("tfc", "b")}, 3.0, 20, period=0.01,
                   substeps=10),
        **together(loops, {f"late_{law}": Case(two, law, late) for law in ("tfc", "b")}, 3.0, 20, period=0.05,
                   substeps=50),
    }  # fmt: skip
    t, b = three(seen["drowned_tfc"]), three(seen["drowned_b"])
    better = all(b[what].mean < t[what].mean for what in t)
    yield corrected(
        "faster_in_noise", statement="with an error change that drowns in noise (10 ms, servo of 15 rad/s, 6 N) GPFC "
        "is better in overshoot, rise and steady error with the same factors", measured="yes" if better else "no",
        unit="", target="yes", sense="yes/no", reason=f"TFC {row(t)}, GPFC {row(b)}; the digest 7.7 % / 0.93 s / 3.3 % "
        "and 6.8 % / 0.82 s / 2.5 %: it has smaller steady errors, by what is not known; our two programs agree",
    )  # fmt: skip
    for law, target in (("tfc", 0.93), ("b", 0.82)):
        value = three(seen[f"drowned_{law}"])["rise"]
        yield corrected(
            f"faster_in_noise_rise_{law}", statement=f"the same, rise time of {WORDS[law]}", measured=value.mean,
            unit="s", target=target, tolerance=value.tolerance(0.01),
            reason=f"one seed scatters by {value.spread:.2g} s",
        )  # fmt: skip
    for law, target in (("tfc", 0.75), ("b", 0.47)):
        both = three(seen[f"late_{law}"])
        yield corrected(
            f"faster_when_late_rise_{law}", statement="rise time where period and dead time are 50 ms and the servo "
            f"has 25 rad/s, {WORDS[law]}", measured=both["rise"].mean, unit="s", target=target,
            tolerance=both["rise"].tolerance(0.01) + 0.025, reason=f"{row(both)}: of all regimes the one where the "
            "prediction buys the paper's gain in rise time, and it costs overshoot; rise counts samples of 50 ms",
        )  # fmt: skip
