"""The original servo of the lathe, of which the paper prints moves and no law: laws fitted to the errors of Table 1.

Every law is tried in the closed loop of Figure 1 (encoder, chain (2) and (3), slide), simulated over the four moves of
Table 1 and compared with their errors; every move counts the same. The duty column is left out of the fits, so that it
can judge them. Two ways to choose the speed at full duty: 289 mm/s, as the duty column asks for, or whatever the errors
ask for.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from leadscrew.controllers._vud.duty_pid import duty_pid
from leadscrew.identify.output_error import OutputErrorFit, Search, Trajectory, fit_output_error
from leadscrew.kernel.block import Block
from leadscrew.studies.lab import Lab, measure
from leadscrew.studies.vud_lathe.laws import FULL_SCALE_MM, Move, moves
from leadscrew.studies.vud_lathe.scenarios import PERIOD_S

GAIN, EXPONENT = "controller.gain", "controller.exponent"
KP, KI, KD = "controller.kp", "controller.ki", "controller.kd"
SPEED, TARGET = "plant.full_duty_speed_mm_s", "reference.target"
MAX_CONDITION = 1e3
"""Twice what a fit allows by default: gain and derivative of the PD can nearly take each other's place."""
LINEAR = duty_pid(filter_s=0.0005, anti_windup="clamping")
"""PID with the integral held while the duty is at its limit; with other rules the fits differ."""
TARGETS_MM = (-50.0, -170.0)
"""The steps of Figure 11."""


class Law(NamedTuple):
    """A law to fit: its block, what stays fixed, and what is fitted between which bounds from which start."""

    doc: str
    block: str | Block
    fixed: Mapping[str, float]
    bounds: Mapping[str, tuple[float, float]]
    start: Mapping[str, float]
    """Near the best fit, which ``search="global"`` finds; a test repeats that search."""


LAWS: dict[str, Law] = {
    "p_289": Law(
        "P, duty = gain |e|, at 289 mm/s",
        "ours.original_fit",
        {EXPONENT: 1.0, SPEED: 289.0},
        {GAIN: (0.3, 6.0)},
        {GAIN: 1.8},
    ),
    "pd_289": Law(
        "PD at 289 mm/s",
        LINEAR,
        {SPEED: 289.0, KI: 0.0},
        {KP: (0.001, 0.05), KD: (0.0, 0.01)},
        {KP: 0.02, KD: 0.004},
    ),
    "power_289": Law(
        "duty = gain |e|^exponent at 289 mm/s",
        "ours.original_fit",
        {SPEED: 289.0},
        {GAIN: (0.3, 4.0), EXPONENT: (0.2, 1.2)},
        {GAIN: 0.93, EXPONENT: 0.62},
    ),
    "power_216": Law(
        "duty = gain |e|^exponent at 216 mm/s",
        "ours.original_fit",
        {SPEED: 216.0},
        {GAIN: (0.3, 4.0), EXPONENT: (0.2, 1.2)},
        {GAIN: 1.6, EXPONENT: 0.75},
    ),
    "p_209": Law(
        "P, duty = gain |e|, at 209 mm/s",
        "ours.original_fit",
        {EXPONENT: 1.0, SPEED: 209.0},
        {GAIN: (0.3, 6.0)},
        {GAIN: 2.7},
    ),
    "pid_209": Law(
        "PID at 209 mm/s",
        LINEAR,
        {SPEED: 209.0},
        {KP: (0.001, 0.05), KI: (0.0, 0.01), KD: (0.0, 0.01)},
        {KP: 0.014, KI: 0.001, KD: 0.0001},
    ),
    "p_free": Law(
        "P, duty = gain |e|, at the speed that fits best",
        "ours.original_fit",
        {EXPONENT: 1.0},
        {GAIN: (0.3, 6.0), SPEED: (150.0, 400.0)},
        {GAIN: 2.7, SPEED: 210.0},
    ),
    "power_free": Law(
        "duty = gain |e|^exponent at the speed that fits best",
        "ours.original_fit",
        {},
        {GAIN: (0.3, 4.0), EXPONENT: (0.2, 1.2), SPEED: (150.0, 400.0)},
        {GAIN: 1.6, EXPONENT: 0.75, SPEED: 216.0},
    ),
}
"""By law and speed at full duty."""


def trajectories(moves: Mapping[str, Move]) -> dict[str, Trajectory]:
    """The errors of Table 1 as positions of moves that start from 0."""
    return {
        name: Trajectory(m.time_s, m.target_mm - FULL_SCALE_MM * m.error, {TARGET: m.target_mm})
        for name, m in moves.items()
    }


@measure
def fit_law(lab: Lab, name: str, search: Search = "local") -> OutputErrorFit:
    """The law ``name`` of :data:`LAWS`, fitted to Table 1."""
    law = LAWS[name]
    loop = lab.loop(law.block, "step_m190").using(law.fixed)
    return fit_output_error(
        loop, trajectories(moves()), law.bounds, start=law.start, search=search, max_condition=MAX_CONDITION
    )


class Played(NamedTuple):
    """A fitted law on the four moves of Table 1 and the two steps of Figure 11, ``[move, period]``."""

    targets_mm: np.ndarray
    time_s: np.ndarray
    position_mm: np.ndarray
    duty: np.ndarray

    def row(self, target_mm: float) -> int:
        """Where a move lies."""
        return int(np.flatnonzero(self.targets_mm == target_mm)[0])

    def error_mm(self, target_mm: float) -> np.ndarray:
        """Target minus true position of one move."""
        return target_mm - self.position_mm[self.row(target_mm)]

    def within_s(self, target_mm: float, band_mm: float) -> float:
        """When the error of one move stays within a band from then on."""
        outside = np.flatnonzero(np.abs(self.error_mm(target_mm)) > band_mm)
        return float(PERIOD_S * (outside[-1] + 1)) if len(outside) else 0.0


@measure
def play(lab: Lab, name: str) -> Played:
    """The fitted law over 4 s of every move of Table 1 and both steps of Figure 11."""
    targets = np.array(sorted({m.target_mm for m in moves().values()} | set(TARGETS_MM)))
    loop = lab.loop(LAWS[name].block, "step_m190")
    settings = {**LAWS[name].fixed, **fit_law(lab, name).parameters}
    varied = {k: np.full(len(targets), v) for k, v in settings.items()} | {TARGET: targets}
    batch = loop.batch(4.0, varied, record=("actual.position", "output"))
    return Played(targets, batch.time, batch["actual.position"], batch["output"])


def duty_misfit(played: Played, moves: Mapping[str, Move]) -> dict[str, float]:
    """Root mean square difference of the law's duty from that of Table 1, which no fit saw, without the start.

    At k = 0 Table 1 prints a duty of 0, from before the step.
    """
    found = {}
    for name, move in moves.items():
        at = np.rint(move.time_s / PERIOD_S).astype(int)
        mine = played.duty[played.row(move.target_mm), at]
        found[name] = float(np.sqrt(np.mean((mine - move.duty)[1:] ** 2)))
    return found
