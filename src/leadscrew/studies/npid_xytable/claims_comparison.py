"""Every controller on the same cuts: Table II's lines at three speeds, thirty draws of their phases each; and M1, M3.

1 mm at 0.7 Hz in L*, runout and tooth passing of the spindle, an encoder of 0.5 um with 0.1 um of noise. The digest's
table has two draws a speed: where a controller is linear its amplitudes do not depend on phases and both must agree;
where it is not, or where the largest value of a run is meant, the digest's number is only shown.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from leadscrew.report.claim import Claim, Kind
from leadscrew.studies.npid_xytable.columns import NPID_UM, PID_UM
from leadscrew.studies.npid_xytable.controllers import CONTROLLERS
from leadscrew.studies.npid_xytable.rejection import opened, peak
from leadscrew.studies.npid_xytable.results import Trials
from leadscrew.studies.npid_xytable.saying import said
from leadscrew.studies.npid_xytable.scenarios import SPEEDS
from leadscrew.studies.npid_xytable.trials import DRAWS, Trial


class Digest(NamedTuple):
    """A row of the digest's table, as it is printed there."""

    motion: str
    rms: str
    largest: str
    chatter: str
    mean: str
    least: str | None
    below_pid: int | None
    below_npid: int
    linear: bool = True


TABLE: dict[str, Digest] = {
    "paper.pid": Digest("7.12", "5.23", "10.1", "6.2", "0", None, None, 4),
    "corrected.npid_um": Digest("3.34", "2.92", "8.2", "27.5", "59", "39", 15, 13, linear=False),
    "paper.npid_mm": Digest("7.12", "5.23", "10.1", "6.2", "0", None, None, 4),
    "ours.pid_scaled": Digest("3.15", "2.34", "5.2", "14.5", "56", "55", 15, 12),
    "ours.npid_slope": Digest("3.71", "2.73", "5.5", "13.1", "53", "47", 15, 12, linear=False),
    "ours.pid_ff": Digest("0.003", "1.38", "4.2", "6.2", "0", None, None, 4),
    "ours.npid_ff": Digest("0.05", "1.04", "3.5", "10.0", "27", "18", 15, 7, linear=False),
    "ours.pid_dob_60": Digest("7.12", "5.20", "9.8", "6.2", "19", "-9", 12, 7),
    "ours.pid_dob_100": Digest("7.12", "5.15", "9.5", "6.2", "42", "15", 15, 11),
    "ours.pid_dob_150": Digest("7.12", "5.13", "9.3", "6.2", "58", "35", 15, 14),
    "ours.pid_159_ff": Digest("0.02", "1.49", "3.3", "4.0", "76", "61", 15, 15),
    "ours.pid_185_ff": Digest("0.014", "1.11", "2.5", "5.0", "83", "73", 15, 15),
    "ours.resonant": Digest("0.002", "0.70", "1.6", "6.2", "99.6", "99.2", 15, 15),
    "ours.resonant_full_185": Digest("0.003", "0.097", "0.36", "5.0", "99.6", "99.1", 15, 15),
}
"""Section 7 of the digest: um, um, um, mV, %, %, rows, rows."""

UNITS = {"motion": "um", "rms": "um", "largest": "um", "chatter": "mV", "mean": "%", "least": "%"}
WORDS = {
    "motion": "following error at 0.7 Hz",
    "rms": "rms error",
    "largest": "largest error, mean over the runs",
    "chatter": "rms change of the output from sample to sample",
    "mean": "mean reduction of the fifteen rows",
    "least": "least reduction of a row",
}


def measured(trial: Trial) -> dict[str, float]:
    """The columns of the table for one controller."""
    printed = np.concatenate([PID_UM[rpm] for rpm in SPEEDS])
    against = np.concatenate([NPID_UM[rpm] for rpm in SPEEDS])
    rows = trial.by_row()
    reductions = 100.0 * (1.0 - rows / printed)
    return {
        "motion": float(trial.motion.mean()),
        "rms": float(trial.rms.mean()),
        "largest": float(trial.largest.mean()),
        "chatter": float(trial.chatter.mean()),
        "mean": float(reductions.mean()),
        "least": float(reductions.min()),
        "below_pid": int((rows < printed).sum()),
        "below_npid": int((rows < against).sum()),
    }


def half_digit(printed: str) -> float:
    """Half a unit of the last printed digit."""
    return 0.5 * 10.0 ** -len(printed.partition(".")[2])


def _scatter(found: Trial, values: np.ndarray) -> float:
    """Three standard deviations of the mean of six runs, two a speed as in the digest, from draw to draw."""
    within = np.mean([values[found.speeds == rpm].var(ddof=1) for rpm in SPEEDS])
    return 3.0 * float(np.sqrt(within / (2 * len(SPEEDS))))


def comparison_claims(trials: Trials) -> list[Claim]:
    """The table of the digest's section 7, controller by controller, and what is best in it."""
    return [*_table(trials), *_moonshots(trials)]


def _table(trials: Trials) -> Iterator[Claim]:
    for name, digest in TABLE.items():
        found, key = measured(trials.nominal(name)), name.replace(".", "_")
        listed = f"rms {found['rms']:.3g} um, rows {found['mean']:.1f} % lower (least {found['least']:.1f} %)"
        run = trials.nominal(name)
        scatter = {"rms": _scatter(run, run.rms), "chatter": _scatter(run, run.chatter)}
        for column, unit in UNITS.items():
            printed = getattr(digest, column)
            if printed is None:
                continue
            near = half_digit(printed) + scatter.get(column, 0.0)
            kind: Kind = "required" if digest.linear and column in ("rms", "chatter", "mean") else "report"
            yield said(
                f"compared_{key}_{column}", "Table II", f"{WORDS[column]}, {name}", found[column], unit, float(printed),
                f"{listed}; {3 * DRAWS} runs; {printed} {unit} in the digest, of two draws a speed; tolerance: its "
                "last digit and three standard deviations of a mean of six runs", tolerance=near, kind=kind,
            )  # fmt: skip
        for column, words in (("below_pid", "PID"), ("below_npid", "NPID")):
            wanted = getattr(digest, column)
            if wanted is not None:
                yield said(
                    f"compared_{key}_{column}", "Table II", f"rows of fifteen below the printed {words} column, {name}",
                    found[column], "rows", wanted, f"{listed}; the digest counts {wanted}", kind="report",
                )  # fmt: skip


def _moonshots(trials: Trials) -> Iterator[Claim]:
    for name in ("ours.pid_ms_159", "ours.pid_159_ff", "ours.pid_best_160_ff"):
        found, key = measured(trials.nominal(name)), name.replace(".", "_")
        both, ms = min(found["below_pid"], found["below_npid"]), peak(opened(CONTROLLERS[name]))
        yield said(
            f"m1_{key}_rows", "Table II", f"rows of fifteen below both printed columns, {name}", both, "rows", 15,
            f"a linear PID with integral action, Ms {ms:.3f}, beats the paper's NPID on every row", sense=">=",
            kind="moonshot",
        )  # fmt: skip
        yield said(
            f"m1_{key}_ms", "Table II", f"peak of the sensitivity of {name}", ms, "", 1.6,
            "in L*, as sampled; feed-forward has no part in it", sense="<=", kind="moonshot", tolerance=5e-4,
        )  # fmt: skip
        yield said(
            f"m1_{key}_least", "Table II", f"least reduction against PID, {name}", found["least"], "%", 60.0,
            f"mean {found['mean']:.1f} %", sense=">=", kind="moonshot",
        )  # fmt: skip
    full = trials.nominal("ours.resonant_full")
    for rpm in SPEEDS:
        rms = float(full.rms[full.speeds == rpm].max())
        yield said(
            f"m3_rms_{rpm}", "Table II", f"total rms error at {rpm} 1/min, spindle lines included, worst draw", rms,
            "um", 0.1, f"ours.resonant_full, told the spindle speed; encoder of 0.5 um; mean of the draws "
            f"{full.rms[full.speeds == rpm].mean():.3f} um", sense="<=", kind="moonshot",
        )  # fmt: skip
