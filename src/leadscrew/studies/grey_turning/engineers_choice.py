"""What an engineer would use instead: every controller tuned by the same search, judged on plants that none has seen.

The gains are the controller files ``tuned/*.toml``; each holds the ``leadscrew tune`` command that found it: CMA-ES,
300 evaluations, seed 1, on 16 random lathes around plant F, each with one entry into the cut at 1 mm (3 s) and one
falling depth (8 s). What is minimised is the mean of

    cut_cost = integral of |F - r| dt + 1 N s for each percent by which F is ever more than 10 % above r

with the true force F. All are judged here on :data:`PLANTS` other lathes of the same ranges with the same noise for
each; the intervals are paired, from a bootstrap over lathes (:mod:`leadscrew.tune.statistics`).
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew import controller_file, toml_file
from leadscrew.studies.grey_turning.scenarios import FORCE_N
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.tuned import FOLDER
from leadscrew.tune.compare import PART, UNSEEN_NOISE
from leadscrew.tune.space import Space
from leadscrew.tune.statistics import Interval, paired
from leadscrew.tune.tuner import held_out_plants

PLANTS, SEED = 64, 1
SECONDS = {"fig6_fixed_depth": 3.0, "fig9_falling_depth": 8.0}
"""The entry and the falling depth."""
PAPERS = "ours.gpfc_tuned"
"""The paper's controller: what the others are compared with."""
ONLY_FORCE, MODEL = "filtered force", "filtered force, model of the lathe"
ENCODERS, DEPTH, ALL_OF_IT = "more: encoders", "more: programmed depth", "more: encoders, programmed depth"
CHOICE = {
    "ours.gpfc_tuned": ("GPFC", ONLY_FORCE),
    "ours.tfc_tuned": ("TFC", ONLY_FORCE),
    "ours.two_point_tuned": ("two-point predictor", ONLY_FORCE),
    "ours.pi_tuned": ("PI", ONLY_FORCE),
    "ours.pid_tuned": ("PID", ONLY_FORCE),
    "ours.pi_normalised_tuned": ("PI, increments scaled by the feed", ONLY_FORCE),
    "ours.smith_tuned": ("TFC behind a Smith predictor", MODEL),
    "ours.inversion_tuned": ("inversion of (1)", ENCODERS),
    "ours.pi_ff_tuned": ("PI, depth feed-forward", DEPTH),
    "ours.pi_normalised_ff_tuned": ("PI, scaled, depth feed-forward", DEPTH),
    "ours.constant_force_tuned": ("constant_force", ALL_OF_IT),
}
"""Controllers, their names in the table, and what they get."""
ANSWER = (PAPERS, "ours.pid_tuned", "ours.constant_force_tuned")
"""Those that the conclusion names."""


def lathes(count: int = PLANTS) -> dict[str, np.ndarray]:
    """Random lathes of the ranges that the searches had, by dotted key; others than theirs."""
    tuning = controller_file.read(Path(__file__).parent / FOLDER / "pi.toml").tuning
    return held_out_plants(Space.of(dict(toml_file.flat(tuning["over"]))), count, SEED, PART)


class Verdict(NamedTuple):
    """One controller on all lathes, a number a lathe."""

    cost: np.ndarray
    """Mean of entry and falling depth, N s."""
    overshoot: np.ndarray
    """Of the true force at the entry, %."""
    rise_s: np.ndarray
    """Of the filtered force."""
    stairs: np.ndarray
    """Largest error of the true force from 1 s on while the depth falls, %."""


@measure
def judged(lab: Lab, name: str) -> Verdict:
    """A controller of the study on :func:`lathes`."""
    first, down = (lab.loop(name, s).batch(t, lathes(), first=UNSEEN_NOISE).metrics for s, t in SECONDS.items())
    cost = 0.5 * (first["cut_cost"] + down["cut_cost"])
    over, off = (100.0 * force / FORCE_N for force in (first["overshoot"], down["max_error"]))
    return Verdict(cost, over, first["filtered_rise"], off)


def against(lab: Lab, name: str, other: str = PAPERS) -> Interval:
    """Change of the mean cost against another controller on the same lathes, N s, with its 95 % interval."""
    one, two = judged(lab, name).cost, judged(lab, other).cost
    none = np.zeros(PLANTS, dtype=bool)
    return paired(name, other, one, two, none, none, SEED).difference


def written(lab: Lab, name: str) -> str:
    """A controller's cost, and how far it is from that of the paper's controller."""
    change = against(lab, name)
    ends = f"{change.low:+.1f} to {change.high:+.1f}".replace("-", "−")
    return f"{CHOICE[name][0]} {judged(lab, name).cost.mean():.1f} ({ends})"


def engineers_answer(lab: Lab, names: Iterable[str] = CHOICE) -> str:
    """What the table says of some controllers, the cheapest first."""
    ranked = sorted(names, key=lambda name: float(judged(lab, name).cost.mean()))
    force, more = (
        ", ".join(written(lab, n) for n in ranked if n != PAPERS and CHOICE[n][1].startswith(group))
        for group in ("filtered", "more")
    )
    return (
        f"with the filtered force alone the GPFC costs {judged(lab, PAPERS).cost.mean():.1f} N·s; {force}; with more "
        f"information {more}; in brackets the paired 95 % interval of the change from the GPFC, N·s."
    )
