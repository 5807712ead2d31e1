"""Controllers that ``leadscrew design rejection`` tuned alike, judged: other phases, other plants, another motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import entries
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.controllers import BOUNDS
from leadscrew.studies.npid_xytable.cutting import trial
from leadscrew.studies.npid_xytable.search import LAWS, REST_MV, WORK_MV, rest_du_mv
from leadscrew.tune.statistics import Interval, paired, standing

JUDGED, PLANTS = 2, 12
"""Draws of the phases on the nominal plant, and of phases and plant."""


class Standing(NamedTuple):
    """One tuned controller, judged; um and mV."""

    row: float
    other_plants: Interval
    less: Interval | None
    """Its mean row less that of the PID with the same bounds and knowledge, on the same draws."""
    row_15mm: float
    worst_15mm: float | None
    """Where its row is largest against the PID's, percent above it."""
    rms: float
    ms: float
    """Of the nominal axis, and the largest over the plants of the box."""
    box_ms: float
    rest: float
    work: float


def peaks(law: str, params: Any) -> tuple[float, float]:
    """Ms of a law at every error on the nominal axis, and the largest on the box."""
    nominal, box = LAWS[law].peaks({e.key: np.array([e.default]) for e in entries(params)})
    return float(nominal[0]), float(box[0])


@measure
def tuned_standings(lab: Lab) -> dict[str, Standing]:
    """The controllers of ``leadscrew design rejection`` by name."""
    found: dict[str, Standing] = {}
    for group in (f"_{bound}{fed}" for fed in ("", "_ff") for bound in BOUNDS):
        against = far_against = np.zeros(0)
        for law, chosen in LAWS.items():
            name = f"ours.{law}{group}"
            if name not in lab.study.controllers:
                continue
            p = lab.study.controllers[name].params
            inner = replace(chosen.block, params=p.inner if group.endswith("_ff") else p)
            ms, box_ms = peaks(law, inner.params)
            near, far = trial(lab, name, 1.0, JUDGED), trial(lab, name, 15.0, JUDGED).by_row()
            rows = trial(lab, name, 1.0, PLANTS, own_plants=True).by_draw()
            if law == "pid":
                against, far_against = rows, far
            none = np.zeros(PLANTS, dtype=bool)
            pair = None if law == "pid" else paired(name, "pid", rows, against, none, none, 0).difference
            worst = None if law == "pid" else float(100.0 * (far / far_against - 1.0).max())
            found[name] = Standing(
                float(near.rows.mean()), standing(rows, 0).mean, pair, float(far.mean()), worst, float(near.rms.mean()),
                ms, box_ms, float(rest_du_mv(lab, inner)[0]), float(near.chatter.mean()),
            )  # fmt: skip
    return found


def engineers_choice(lab: Lab) -> str:
    """The comparisons at work and at rest in one sentence, from the numbers on the nominal plant."""
    work, rest = (
        {law: float(trial(lab, f"ours.{law}_{bound}", 1.0, JUDGED).rows.mean()) for law in LAWS}
        for bound in ("work", "rest")
    )
    needless = all(rows["pid_lag"] < min(rows["npid"], rows["npid_split"]) for rows in (work, rest))
    ms = {law: peaks(law, lab.study.controllers[f"ours.{law}_rest"].params)[1] for law in ("pid_lag", "npid_split")}
    return (
        f"On the reconstructed plant, tuned by one search, a linear PID behind a second-order low-pass and a lag "
        f"leaves a mean row of Table II of {work['pid_lag']:.3f} µm with {WORK_MV:g} mV of activity at work and "
        f"{rest['pid_lag']:.2f} µm with {REST_MV:g} mV at rest, a PID {work['pid']:.3f} and {rest['pid']:.2f}, the "
        f"paper's law {work['npid']:.3f} and {rest['npid']:.2f}, npid_split {work['npid_split']:.3f} and "
        f"{rest['npid_split']:.2f} µm; on other plants Ms goes to {ms['pid_lag']:.1f} with the lag, to "
        f"{ms['npid_split']:.1f} with npid_split{': no gain that grows with the error is needed' if needless else ''}."
    )
