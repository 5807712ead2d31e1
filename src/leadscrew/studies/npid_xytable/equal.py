"""Controllers that ``leadscrew design rejection`` tuned alike, judged: other phases, other plants, another motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import entries
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.controllers import BOUNDS
from leadscrew.studies.npid_xytable.cutting import trial
from leadscrew.studies.npid_xytable.search import LAWS, rest_du_mv
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
    """The comparisons at work and at rest, from the numbers on the nominal plant."""
    at = {bound: {law: trial(lab, f"ours.{law}_{bound}", 1.0, JUDGED) for law in LAWS} for bound in ("work", "rest")}
    rows = {bound: {law: float(x.rows.mean()) for law, x in laws.items()} for bound, laws in at.items()}
    rest, work = rows["rest"], rows["work"]
    _, box = peaks("pid_lag", lab.study.controllers["ours.pid_lag_rest"].params)
    more = float(at["rest"]["npid_split"].chatter.mean() / at["rest"]["pid"].chatter.mean())
    return (
        f"On the reconstructed plant, with drives equally active at work (2 mV), a linear PID tuned by the same search "
        f"leaves a mean row of Table II of {work['pid']:.3f} µm, the paper's law {work['npid']:.3f} and npid_split "
        f"{work['npid_split']:.3f} µm, but a linear PID behind a second-order low-pass and a lag {work['pid_lag']:.3f} "
        f"µm; with drives equally active at rest it is {rest['pid']:.2f}, {rest['npid']:.2f} and "
        f"{rest['npid_split']:.2f} µm, npid_split moving the drive {more:.1f} times as much at work, and "
        f"{rest['pid_low_pass']:.2f} µm with the low-pass alone, {rest['pid_lag']:.2f} µm with the lag, whose Ms goes "
        f"to {box:.1f} on other plants of the box: no gain that grows with the error is needed."
    )
