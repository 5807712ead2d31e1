"""Claims about what constant force is for: time, removal rate and peak force on two bars, against a constant feed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim
from leadscrew.studies.grey_turning.removal import (
    DEPTHS,
    FIXED_RATE,
    FUZZY,
    OURS,
    REGULATED,
    STRETCH_MM,
    Account,
    Removal,
    roughness_um,
)
from leadscrew.studies.grey_turning.saying import said, word

SOURCE = "sections 1 and 6"
NAMES = {
    "corrected.tfc_s9": "tfc_s9", "corrected.gpfc_b_s9": "gpfc_s9", "corrected.tfc_stfc": "tfc_tuned",
    "corrected.gpfc_b_sg": "gpfc_tuned", REGULATED: "fixed_rate", OURS: "constant_force",
}  # fmt: skip
TUNED = ("corrected.tfc_stfc", "corrected.gpfc_b_sg", OURS)


def removal_claims(found: Removal | None = None) -> list[Claim]:
    """All of them; ``found`` keeps what pictures need too."""
    found = found or Removal()
    falling, mixed = found.accounts("falling"), found.accounts("mixed")
    return [*_table(falling, "falling"), *_table(mixed, "mixed"), *_what_for(falling, mixed), *_fixed(falling),
            *_roughness()]  # fmt: skip


def _table(accounts: dict[str, Account], bar: str) -> Iterator[Claim]:
    depths = ", ".join(f"{b:g}" for b in DEPTHS[bar])
    for name, short in NAMES.items():
        a = accounts[name]
        yield said(
            f"removal_{bar}_{short}", SOURCE, f"time of a constant feed of equal peak force over that of {name}, bar "
            f"of {depths} mm" + (", the last 25 % harder" if bar == "mixed" else ""), a.gain, "", None,
            f"{a.time_s:.1f} s, {a.rate:.1f} mm3/s, peak {a.peak_n:.0f} N, {a.over_s:.2f} s above 165 N; the constant "
            f"feed with that peak is {a.feed_same_peak:.1f} mm/min and takes {a.time_same_peak_s:.1f} s; true force, "
            "entry and runout included", kind="report",
        )  # fmt: skip


def _what_for(falling: dict[str, Account], mixed: dict[str, Account]) -> Iterator[Claim]:
    paper = falling["corrected.tfc_s9"]
    yield said(
        "removal_paper_tfc_pays", SOURCE, "the TFC with the overshoot of Figure 9 is sooner done than a constant feed "
        "of equal peak, falling bar", word(paper.gain > 1.0), "", "no", f"{paper.time_s:.1f} against "
        f"{paper.time_same_peak_s:.1f} s: the {paper.peak_n:.0f} N of its entry buy a constant feed of "
        f"{paper.feed_same_peak:.0f} mm/min; the GPFC of the same factors is even, "
        f"{falling['corrected.gpfc_b_s9'].gain:.2f}", sense="yes/no", paper="yes",
        verdict="reproduced" if paper.gain > 1.0 else "not reproduced",
    )  # fmt: skip
    least, other = (min(bar[name].gain for name in TUNED) for bar in (falling, mixed))
    yield said(
        "removal_tuned_pays", SOURCE, "what tuned constant force is worth at equal peak force, falling bar: least of "
        "three", least, "", 1.3, ", ".join(f"{n} {falling[n].gain:.2f}" for n in TUNED) + "; on this bar, whose "
        "depth only falls, constant force pays without overshoot; on the mixed bar, whose depth also rises, "
        + ", ".join(f"{mixed[n].gain:.2f}" for n in TUNED) + (": there it loses" if other < 1.0 else ""), sense=">=",
        paper="a higher removal rate", verdict="not reproduced" if least <= 1.0 else
        "reproduced with change" if other < 1.0 else "reproduced",
    )  # fmt: skip
    best = max(mixed[name].gain for name in (*FUZZY, OURS))
    yield said(
        "removal_shoulders", SOURCE, "the same where unannounced shoulders rise: best of five", best, "", 1.0,
        f"peaks {min(mixed[n].peak_n for n in FUZZY):.0f} to {max(mixed[n].peak_n for n in FUZZY):.0f} N: at a "
        "shoulder the force is in proportion to the depth before any controller acts, and constant force has fed the "
        "shallow cut fast; a constant feed is better there, unless the depth is told in advance", sense="<=",
    )  # fmt: skip


def _fixed(falling: dict[str, Account]) -> Iterator[Claim]:
    a, plain = falling[REGULATED], falling["corrected.tfc_stfc"]
    ideal_s = float(np.pi * 50.0 * STRETCH_MM * sum(DEPTHS["falling"])) / FIXED_RATE
    yield said(
        "removal_fixed_rate", "reference [13]", "time at a fixed removal rate of 92.9 mm3/s over that at 1,200 1/min, "
        "falling bar", a.time_s / plain.time_s, "", None, f"{a.time_s:.1f} against {plain.time_s:.1f} s, volume over "
        f"rate {ideal_s:.1f} s; at constant force a thick chip at small depth removes more, so holding the rate slows "
        f"the spindle down; peak {a.peak_n:.0f} N", kind="report",
    )  # fmt: skip


def _roughness() -> Iterator[Claim]:
    feeds = {1.0: 35.50, 0.8: 47.43, 0.6: 68.92, 0.4: 116.69}
    row = ", ".join(f"{b:g} mm {roughness_um(v):.2f} um" for b, v in feeds.items())
    yield said(
        "roughness", SOURCE, "theoretical roughness at 0.4 mm over that at 1 mm, 150 N, S45C, 1,200 1/min",
        roughness_um(feeds[0.4]) / roughness_um(feeds[1.0]), "", None, f"f^2 / (8 r), nose 0.8 mm: {row}: constant "
        "force makes shallow cuts rough", kind="report", basis="arithmetic",
    )  # fmt: skip
