"""Controllers that ``leadscrew design rejection`` tuned alike, judged: other phases, other plants, another motion."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from leadscrew.kernel.sheet import entries
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.npid_xytable.controllers import BOUNDS
from leadscrew.studies.npid_xytable.cutting import trial
from leadscrew.studies.npid_xytable.search import LAWS, largest_ms, rest_du_mv
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
    rest: float
    work: float


@measure
def tuned_standings(lab: Lab) -> dict[str, Standing]:
    """The controllers of ``leadscrew design rejection`` by name."""
    found: dict[str, Standing] = {}
    for group in (f"_{bound}{fed}" for fed in ("", "_ff") for bound in BOUNDS):
        against = far_against = np.zeros(0)
        for law, (block, _, ends_of) in LAWS.items():
            name = f"ours.{law}{group}"
            p = lab.study.controllers[name].params
            inner = replace(block, params=p.inner if group.endswith("_ff") else p)
            ends = ends_of({e.key: np.array([e.default]) for e in entries(inner.params)})
            near, far = trial(lab, name, 1.0, JUDGED), trial(lab, name, 15.0, JUDGED).by_row()
            rows = trial(lab, name, 1.0, PLANTS, own_plants=True).by_draw()
            if law == "pid":
                against, far_against = rows, far
            none = np.zeros(PLANTS, dtype=bool)
            pair = None if law == "pid" else paired(name, "pid", rows, against, none, none, 0).difference
            worst = None if law == "pid" else float(100.0 * (far / far_against - 1.0).max())
            found[name] = Standing(
                float(near.rows.mean()), standing(rows, 0).mean, pair, float(far.mean()), worst, float(near.rms.mean()),
                float(largest_ms(ends)[0]), float(rest_du_mv(lab, inner)[0]), float(near.chatter.mean()),
            )  # fmt: skip
    return found


def engineers_choice(lab: Lab) -> str:
    """Both comparisons in two sentences, from the numbers on the nominal plant."""
    (work, work_mv), (rest, rest_mv) = (
        zip(*(
            (float(x.rows.mean()), float(x.chatter.mean()))
            for x in (trial(lab, f"ours.{law}_{bound}", 1.0, JUDGED) for law in LAWS)
        ), strict=True)
        for bound in ("work", "rest")
    )  # fmt: skip
    off = max(abs(100.0 * (row / work[0] - 1.0)) for row in work)
    return (
        f"On the reconstructed plant, with drives equally active at work ({max(work_mv):.1f} mV), a linear PID tuned "
        f"by the same search leaves a mean row of Table II of {work[0]:.3f} µm, the paper's law {work[1]:.3f} and "
        f"npid_split {work[2]:.3f} µm, all within {off:.1f} % of it; with drives equally active at rest it is "
        f"{rest[0]:.2f}, {rest[1]:.2f} and {rest[2]:.2f} µm, and npid_split moves the drive "
        f"{rest_mv[2] / rest_mv[0]:.1f} times as much at work."
    )
