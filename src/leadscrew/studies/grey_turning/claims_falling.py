"""Claims about Figures 9 and 10: constant force while the depth of cut falls by 0.2 mm every 2 s."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.machines import IRON_LAW
from leadscrew.studies.grey_turning.reproduction import (
    CHANGES_S,
    FALL_S,
    FOLLOWED,
    PLANT_N,
    WORDS,
    Case,
    Reproduction,
    together,
    told,
)
from leadscrew.studies.grey_turning.runs import Loops
from leadscrew.studies.grey_turning.saying import said, word

SOURCE = "section 5.2, Figures 9 and 10"
PAPER_OVERSHOOT = {"tfc": 48.6, "b": 12.7}
PAPER_STEADY = {"tfc": 1.0, "b": 0.5}
WINDOWS = ((1.0, 1.5), (1.5, 2.0), (2.0, 3.0), (3.0, 4.0))
FITTED_WINDOW = (1.5, 2.0)
"""The half second before the first change of depth."""
WINDOW_ERRORS = {"tfc": (3.14, 1.16, 0.56, 0.51), "b": (0.58, 0.50, 0.48, 0.50)}
DEPTHS = (1.0, 0.8, 0.6, 0.4, 0.2)
DIPS = ((-7.0, 1.0), (-10.0, 0.5), (-16.0, 0.5))
"""Percent and what is allowed, at the first three changes, in the digest; the first is its range -6 to -8."""
FEW = 8
"""Noise seeds of a cause that is only tried out."""

fitted = partial(said, source=SOURCE, group="as corrected", basis="fitted to this number")
corrected = partial(said, source=SOURCE, group="as corrected")


def falling_claims(loops: Loops, found: Reproduction | None = None) -> list[Claim]:
    """A7's second half, and the rows of section 6 of the digest that belong to 5.2."""
    found = found or Reproduction(loops)
    return [
        *_fitted(found), *_by_window(found), *_smooth(found), *_steps(found), *_full_feed(found),
        *_causes(loops),
    ]  # fmt: skip


def _fitted(found: Reproduction) -> Iterator[Claim]:
    cuts = {law: found.fixed[f"s9_{law}"] for law in ("tfc", "b", "two_point")}
    over = {law: told(c.overshoot) for law, c in cuts.items()}
    true = {law: told(100.0 * (c.force.max(axis=1) / 150.0 - 1.0)) for law, c in cuts.items()}
    for law, target in (("tfc", 47.5), ("b", 11.4)):
        value, paper = over[law], PAPER_OVERSHOOT[law]
        yield fitted(
            f"falling_overshoot_{law}", statement=f"overshoot, {WORDS[law]} with S9, plant F", measured=value.mean,
            unit="%", target=target, tolerance=value.tolerance(0.1), paper=paper,
            verdict="reproduced with change" if abs(value.mean - paper) <= 4.5 else "not reproduced",
            reason=f"fitted: three factors and the servo were chosen for the four numbers of 5.2; it is the entry at "
            f"1 mm, not an answer to the falling depth; the true force overshoots by {true[law].mean:.0f} %",
        )  # fmt: skip
    late = {law: told(cuts[law].steady(FITTED_WINDOW)) for law in ("tfc", "b")}
    for law, target in (("tfc", 1.19), ("b", 0.49)):
        value, paper = late[law], PAPER_STEADY[law]
        yield fitted(
            f"falling_steady_{law}", statement=f"steady error 1.5 to 2 s after entry, {WORDS[law]} with S9",
            measured=value.mean, unit="%", target=target, tolerance=value.tolerance(0.01), paper=paper,
            verdict="reproduced with change" if abs(value.mean - paper) <= 0.35 else "not reproduced",
            reason="in this window only, and it was fitted to it; from 3 to 4 s both laws stand at "
            f"{told(found.long['s9_tfc'].steady((3.0, 4.0))).mean:.2f} and "
            f"{told(found.long['s9_b'].steady((3.0, 4.0))).mean:.2f} %",
        )  # fmt: skip
    for law, target in (("tfc", 0.08), ("b", 0.10)):
        value = told(cuts[law].rise_s)
        yield corrected(
            f"falling_rise_{law}", statement=f"rise time in samples of 20 ms, {WORDS[law]} with S9",
            measured=value.mean, unit="s", target=target, tolerance=value.tolerance(0.01),
            reason="the paper gives none for 5.2; this is a sixth of its 0.5 s of 5.1",
        )  # fmt: skip
    two = over["two_point"]
    yield corrected(
        "falling_overshoot_two_point", statement="overshoot with the two-point predictor in place of GM(1,1), S9",
        measured=two.mean, unit="%", target=28.7, tolerance=two.tolerance(0.1),
        reason=f"GM(1,1) brakes an entry more ({over['b'].mean:.1f} %) because it over-predicts a rise that bends",
    )  # fmt: skip
    passes = 44.0 <= over["tfc"].mean <= 52.0 and 9.0 <= over["b"].mean <= 15.0
    yield fitted(
        "falling_windows", statement="TFC overshoots by 44 to 52 %, GPFC by 9 to 15 %", measured=word(passes), unit="",
        target="yes", sense="yes/no", reason=f"{over['tfc'].mean:.1f} and {over['b'].mean:.1f} %: agreement with the "
        "digest's prototype, not evidence for the paper: S9 and plant F were fitted",
    )  # fmt: skip
    yield fitted(
        "falling_steady_ratio", statement="steady error of GPFC over that of TFC, 1.5 to 2 s",
        measured=late["b"].mean / late["tfc"].mean, unit="", target=0.6, sense="<=", paper=0.5,
        verdict="reproduced with change" if late["b"].mean <= 0.6 * late["tfc"].mean else "not reproduced",
        reason="the TFC is still ringing then; later the ratio is about 1",
    )  # fmt: skip
    true_tfc = true["tfc"]
    yield corrected(
        "falling_true_overshoot", statement="overshoot of the true force, TFC with S9", measured=true_tfc.mean,
        unit="%", target=85.0, tolerance=true_tfc.tolerance(1.0), reason=f"the filter hides the difference to "
        f"{over['tfc'].mean:.0f} %: the load on the tool is worse than the figure shows",
    )  # fmt: skip


def _by_window(found: Reproduction) -> Iterator[Claim]:
    for law, targets in WINDOW_ERRORS.items():
        for window, target in zip(WINDOWS, targets, strict=True):
            value = told(found.long[f"s9_{law}"].steady(window))
            yield corrected(
                f"falling_steady_{law}_{10 * window[0]:.0f}_{10 * window[1]:.0f}",
                statement=f"error from {window[0]:g} to {window[1]:g} s, {WORDS[law]} with S9", measured=value.mean,
                unit="%", target=target, tolerance=value.tolerance(0.01, 40),
                reason=f"one seed scatters by {value.spread:.2g} %; the depth stays at 1 mm",
            )  # fmt: skip
    a, b = (told(found.long[f"s9_{law}"].steady((3.0, 4.0))).mean for law in ("tfc", "b"))
    halved = b <= 0.6 * a
    yield corrected(
        "falling_steady_late", statement="once both have settled (3 to 4 s) the error of GPFC is half of TFC's",
        measured=word(halved), unit="", target="no", sense="yes/no", paper="0.5 against 1.0 %",
        verdict="reproduced" if halved else "not reproduced", reason=f"{b:.2f} and {a:.2f} %: ratio {b / a:.2f}",
    )  # fmt: skip


def _smooth(found: Reproduction) -> Iterator[Claim]:
    total = {law: told(np.abs(np.diff(found.fall[f"s9_{law}"].u[:, :400], axis=1)).sum(axis=1)) for law in ("tfc", "b")}
    first = {law: told(found.long[f"s9_{law}"].activity_mv(0.0, 1.0)) for law in ("tfc", "b")}
    for law, target in (("tfc", 2.43), ("b", 1.56)):
        yield corrected(
            f"falling_activity_{law}", statement=f"sum of the changes of the voltage over 8 s, {WORDS[law]} with S9",
            measured=total[law].mean, unit="V", target=target, tolerance=total[law].tolerance(0.01) + 0.02 * target,
            reason="with the four depths; the depth's own response moves it by 2 %",
        )  # fmt: skip
    for law, target in (("tfc", 29.9), ("b", 14.7)):
        yield corrected(
            f"falling_activity_first_{law}", statement=f"change of the voltage a sample in the first second, "
            f"{WORDS[law]} with S9", measured=first[law].mean, unit="mV", target=target,
            tolerance=first[law].tolerance(0.1), reason="the entry transient",
        )  # fmt: skip
    ratio = total["b"].mean / total["tfc"].mean
    after = {law: np.abs(np.diff(found.fall[f"s9_{law}"].u[:, 100:400], axis=1)).sum(axis=1).mean() for law in total}
    yield corrected(
        "falling_smoother", statement="sum of the changes of the voltage over 8 s, GPFC over TFC", measured=ratio,
        unit="", target=0.75, sense="<=", paper="smoother",
        verdict="reproduced with change" if ratio < 1.0 else "not reproduced",
        reason=f"all of it from the entry: in the first second {first['b'].mean / first['tfc'].mean:.2f}, from 2 s on "
        f"{after['b'] / after['tfc']:.2f}",
    )  # fmt: skip


def _steps(found: Reproduction) -> Iterator[Claim]:
    dips: dict[str, list[float]] = {}
    for name in ("s9_tfc", "s9_b", "s6_tfc", "s6_b", "s9_tfc_at_once"):
        mean = found.fall[name].y.mean(axis=0)
        dips[name] = [100.0 * float(mean[50 * int(t) : 50 * int(t) + 100].min() / 150.0 - 1.0) for t in CHANGES_S]
    for i, (target, width) in enumerate(DIPS):
        beyond = abs(dips["s9_b"][i] - target) > width
        spread = ", ".join(f"{WORDS[n.split('_')[1]]} {n[:2].upper()} {d[i]:.1f}" for n, d in dips.items())
        yield corrected(
            f"falling_dip_{10 * DEPTHS[i + 1]:.0f}", statement=f"dip of the filtered force when the depth falls to "
            f"{DEPTHS[i + 1]:g} mm, GPFC (B) with S9", measured=dips["s9_b"][i], unit="%", target=target,
            tolerance=width, kind="report" if i == 2 else "required",
            reason=f"{spread} (the last one: a depth that changes at once); the digest gives -6 to -8, -10, -16 for all"
            + (", its last one milder than any of ours but GPFC with S6" if beyond else ""),
        )  # fmt: skip
    alike = max(abs(dips["s9_tfc"][i] - dips["s9_b"][i]) for i in range(3))
    yield corrected(
        "falling_dips_alike", statement="largest difference of a dip between TFC and GPFC with S9", measured=alike,
        unit="%", target=1.5, sense="<=", reason="prediction from the force cannot know a programmed change; depth "
        "feed-forward can",
    )  # fmt: skip
    for i, target in enumerate((-20.0, -25.0, -33.0, -50.0)):
        ideal = 100.0 * (DEPTHS[i + 1] / DEPTHS[i] - 1.0)
        t = CHANGES_S[i]
        force = found.fall["s9_tfc_at_once"].force.mean(axis=0)
        deepest = 100.0 * float(force[50 * int(t) : 50 * int(t) + 10].min() / 150.0 - 1.0)
        yield corrected(
            f"falling_ideal_dip_{10 * DEPTHS[i + 1]:.0f}", statement="deepest true force, read every 20 ms, when the "
            f"depth falls to {DEPTHS[i + 1]:g} mm at once, TFC with S9", measured=deepest, unit="%", target=target,
            kind="report", reason=f"arithmetic says {ideal:.1f} % for a rigid tool at an unchanged feed, for force "
            "goes with depth: that is the digest's number and cannot fail; here the tool yields and the feed begins "
            "to act",
        )  # fmt: skip
    rises = {
        name: max(
            (told(found.fall[name].extreme(t, t + 2.0, least=False)) for t in CHANGES_S[:3]),
            key=lambda v: v.mean,
        )
        for name in ("s9_tfc", "s9_b", "s6_tfc", "s6_b")
    }
    worst = max((rises["s9_tfc"], rises["s9_b"]), key=lambda v: v.mean)
    yield corrected(
        "falling_no_overshoot", statement="largest overshoot after any change of depth, TFC and GPFC with S9",
        measured=worst.mean, unit="%", target=2.2, sense="<=", kind="report",
        reason=f"{'above' if worst.mean > 2.2 else 'within'} the digest's 2.2 %, whose seeds it does not "
        f"name; one seed scatters by {worst.spread:.2f} %; stairs_no_overshoot_* have it without load-cell noise. "
        f"TFC {rises['s9_tfc'].mean:.2f}, GPFC {rises['s9_b'].mean:.2f} %, with S6 {rises['s6_tfc'].mean:.2f} and "
        f"{rises['s6_b'].mean:.2f} %, of which 1 % is noise: a "
        "falling depth lowers the force, so the paper's 48.6 % cannot be its effect", paper=48.6,
        verdict="not reproduced" if worst.mean < 40.0 else "reproduced",
    )  # fmt: skip


def _full_feed(found: Reproduction) -> Iterator[Claim]:
    cuts = found.fall["s9_tfc"]
    late = slice(round((FALL_S - 0.5) / cuts.period), None)
    force = float(cuts.y[:, late].mean())
    feed = float(cuts.feed[:, late].mean())
    yield corrected(
        "falling_to_02_force", statement="force at 0.2 mm with the feed at its limit", measured=force, unit="N",
        target=91.0, tolerance=0.5, reason=f"the feed stands at {feed:.1f} mm/min, the end of the paper's axis, 150 N "
        f"need 287: a lasting error of {100.0 * (force / 150.0 - 1.0):.1f} %, so '0.2 mm after each 2 s' can hold for "
        "three changes only",
    )  # fmt: skip


def _air(after_s: float) -> dict[str, Any]:
    return {"plant.depth.start": 0.0, "plant.depth.step": 1.0, "plant.depth.every_s": after_s, "plant.depth.steps": 1}


CAUSES: Mapping[str, tuple[str, dict[str, Any], float]] = {
    "rising": ("a depth that rises from 0.4 mm by 0.2 mm every 2 s", {
        "plant.depth.start": 0.4, "plant.depth.step": 0.2, "plant.depth.every_s": 2.0, "plant.depth.steps": 3}, 8.0),
    "plunge": ("a plunge from 0 to 1 mm while the feed winds up", _air(0.02) | FOLLOWED, 3.0),
    "air": ("0.3 s of air before the tool is in the cut at 1 mm", _air(0.3), 3.0),
}  # fmt: skip


def _causes(loops: Loops) -> Iterator[Claim]:
    for cause, (words, changes, seconds) in CAUSES.items():
        cases = {
            f"{name}_{law}": Case(name, law, PLANT_N | changes) for name in ("sbn", "stfc") for law in ("tfc", "b")
        }
        cuts = together(loops, cases, seconds, FEW)
        since = 2.0 if cause == "rising" else 0.0
        over = {name: told(c.extreme(since, seconds, least=False)).mean for name, c in cuts.items()}
        both = all(over[f"{n}_tfc"] >= 40.0 and over[f"{n}_b"] <= 20.0 for n in ("sbn", "stfc"))
        listed = ", ".join(
            f"{n.upper()} {over[f'{n}_tfc']:.0f} and {over[f'{n}_b']:.0f} %" for n in ("sbn", "stfc")
        )  # fmt: skip
        yield corrected(
            f"cause_{cause}", statement=f"{words} gives both overshoots of 5.2, 48.6 and 12.7 %, on plant N",
            measured=word(both), unit="", target="no", sense="yes/no", reason=f"overshoot, TFC and GPFC: {listed}",
        )  # fmt: skip
        if cause == "rising":
            for law, low, high in (("tfc", 36.0, 43.0), ("b", 36.0, 43.0)):
                most = [over[f"{n}_{law}"] for n in ("sbn", "stfc")]
                yield corrected(
                    f"cause_rising_{law}", statement=f"overshoot when the depth rises from 0.4 to 0.6 mm, {WORDS[law]}"
                    ", plant N, SBN", measured=most[0], unit="%", target=0.5 * (low + high),
                    tolerance=0.5 * (high - low),
                    reason=f"with STFC {most[1]:.1f} %: alike with and without prediction",
                )  # fmt: skip
    iron = together(
        loops, {f"s9_{law}": Case("s9", law, {f"plant.{k}": v for k, v in IRON_LAW.items()}) for law in ("tfc", "b")},
        1.0, FEW,
    )  # fmt: skip
    iron_over = {law: told(iron[f"s9_{law}"].overshoot).mean for law in ("tfc", "b")}
    yield corrected(
        "cause_iron", statement="overshoot of TFC with S9 in iron, feed within 150 mm/min", measured=iron_over["tfc"],
        unit="%", target=31.3, sense="<=", reason=f"GPFC {iron_over['b']:.1f} %; iron makes 197 N at 150 mm/min and "
        "1 mm, 31.3 % above the command, so 48.6 % is out of reach at any factors: the work was steel, or the "
        "feed went beyond the paper's axis",
    )  # fmt: skip
