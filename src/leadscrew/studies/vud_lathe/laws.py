"""What only this study computes: Table 1 and its rules, the printed law's arithmetic, and what a grating counts.

Table 1 holds, every 0.1 s, the normalised error, its change per 0.1 s and the duty of four steps from the middle of
the rail. ``ec`` is printed as a magnitude where the target is positive, although the error falls there: :func:`moves`
gives it the sign that it must have, ``printed_rate`` keeps it as it is. Table 2 lies with the blocks.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from leadscrew.controllers._vud.universe import CENTRES, TABLE_2, contraction
from leadscrew.fuzzy.fill import Completion, complete_rules
from leadscrew.fuzzy.inference import infer, rule_base
from leadscrew.fuzzy.learning import LearnedRules, learn_rules
from leadscrew.fuzzy.partition import Partition
from leadscrew.identify.linear.servo_gain import HOLDS, GainFit, Record, fit_gain
from leadscrew.logs.csv_columns import read_log
from leadscrew.sensors.grating._quadrature import SignalErrors
from leadscrew.util.errors import DataError

TABLE_1 = Path(__file__).parent / "data" / "table1.csv"
SAMPLE_TIME_S = 0.1
"""Sampling of Table 1 (section IV.b, step 4)."""
FULL_SCALE_MM = 190.0
"""Error that is 1 in Table 1, (5)."""
UNIVERSE = (-1.0, 1.0)


class Move(NamedTuple):
    """One column of Table 1."""

    target_mm: float
    time_s: np.ndarray
    error: np.ndarray
    """Normalised, as printed."""
    rate: np.ndarray
    """Normalised change of the error per 0.1 s, with its sign."""
    printed_rate: np.ndarray
    duty: np.ndarray

    def record(self) -> Record:
        """Input and travel for :func:`leadscrew.identify.linear.servo_gain.fit_gain`."""
        return Record(self.time_s, self.duty, FULL_SCALE_MM * (self.error[0] - self.error))


def moves(path: str | Path = TABLE_1) -> dict[str, Move]:
    """The moves of a file laid out like Table 1 (columns k, r, e, ec, rho), by target: ``r=-190`` and so on.

    Raises:
        DataError: what :func:`leadscrew.logs.csv_columns.read_log` refuses, a value outside [-1, 1], or a target twice.
    """
    limits = dict.fromkeys(("e", "ec", "rho"), UNIVERSE)
    log = read_log(path, ("k", "r", "e", "ec", "rho"), increasing="k", within="r", limits=limits)
    starts = [0, *(np.flatnonzero(np.diff(log["r"])) + 1).tolist(), len(log["r"])]
    found: dict[str, Move] = {}
    for first, last in pairwise(starts):
        k, r, e, ec, rho = (log[name][first:last] for name in ("k", "r", "e", "ec", "rho"))
        name = f"r={r[0]:g}"
        if name in found:
            raise DataError(f"{path}: the target {name} appears in two places")
        found[name] = Move(float(r[0]), SAMPLE_TIME_S * k, e, -ec if r[0] > 0.0 else ec, ec, rho)
    return found


LABELS = ("NB", "NM", "NS", "PS", "PM", "PB")
SETS = Partition(tuple(CENTRES.tolist()), LABELS)
"""The six sets of e, ec and the duty (Figures 6 to 8)."""

MAGNITUDES = (0.333, 0.677, 1.0)
"""Sizes of small, medium and big in Table 2; the text and the sets have 0.33 and 0.67."""

Rate = Literal["signed", "printed"]


def samples(found: Mapping[str, Move], rate: Rate = "signed") -> list[tuple[float, float, float]]:
    """The samples k = 1 ... 20 of all moves: the paper's 80."""
    return [
        (float(e), float(ec), float(rho))
        for move in found.values()
        for e, ec, rho in zip(
            move.error[1:], (move.rate if rate == "signed" else move.printed_rate)[1:], move.duty[1:], strict=True
        )
    ]


def learn(found: Mapping[str, Move], ties: Literal["drop", "keep"] = "drop", rate: Rate = "signed") -> LearnedRules:
    """The rules of Table 1 by (12) to (16) and the choice of the strongest."""
    return learn_rules(samples(found, rate), (SETS, SETS), SETS, ties, names=("e", "ec", "rho"))


def rebuild(learned: LearnedRules, add_growth_level: bool = True) -> Completion:
    """The full table; see :mod:`leadscrew.fuzzy.fill` for what is data in it and what is not."""
    return complete_rules(learned, add_growth_level)


def equal_cells(completion: Completion, table: np.ndarray = TABLE_2) -> int:
    """How many cells of the rebuilt table equal Table 2."""
    return completion.agreement(table, MAGNITUDES)


# ---- the gain of the axis, from Table 1
LAGS_S = (0.0008, 0.0015, 0.017)
"""The lags of (2) and (3)."""
RATE_SCALE_MM = 25.87
"""Change of the error per 0.1 s that is ec = 1."""


def gain_fits(found: Mapping[str, Move]) -> dict[str, GainFit]:
    """The speed at full duty from Table 1, under each assumption about the duty between its samples."""
    records = {name: move.record() for name, move in found.items()}
    return {hold: fit_gain(records, LAGS_S, hold) for hold in HOLDS}


def bent_gain_fit(found: Mapping[str, Move], exponent: float, late_s: float = 0.0) -> GainFit:
    """Common speed and misfits where ``|duty|^exponent`` drives the chain; every move counts the same."""

    def bent(move: Move) -> Record:
        time, duty, position = move.record()
        way = float(np.ptp(position))
        return Record(time, np.sign(duty) * np.abs(duty) ** exponent / way, position / way)

    lags = (*LAGS_S, late_s) if late_s > 0.0 else LAGS_S
    return fit_gain({name: bent(move) for name, move in found.items()}, lags, "current")


def best_exponent(found: Mapping[str, Move]) -> float:
    """The exponent of the duty with the smallest misfit over all moves."""
    from scipy.optimize import minimize_scalar

    def misfit(exponent: float) -> float:
        return sum(m**2 for m in bent_gain_fit(found, exponent).nrmse_percent.values())

    return float(minimize_scalar(misfit, bounds=(0.5, 1.2), method="bounded", options={"xatol": 1e-4}).x)


# ---- the printed law, by arithmetic
TAU, FLOOR = 0.9, 1e-4
"""Exponent and floor of (17) to (19)."""
TABLE_2_RULES = rule_base(CENTRES, CENTRES, TABLE_2)
TABLE_2_RULES_067 = rule_base(CENTRES, CENTRES, np.where(abs(TABLE_2) == 0.677, 0.67 * np.sign(TABLE_2), TABLE_2))
"""Table 2 with the 0.67 that the worked example has in place of 0.677."""


def answered(shape: float, periods: int, start: float, tau: float = TAU, floor: float = FLOOR) -> float:
    """The duty of (21) after some periods in which the rules say ``shape``."""
    rho = start
    for _ in range(periods):
        rho = contraction(rho, tau, floor, 1.0) * shape
    return rho


def resting(e: float, tau: float = TAU, floor: float = FLOOR, output_tau: float = TAU) -> float:
    """The duty at which the printed law comes to rest for a constant error and no rate."""
    shape = infer(TABLE_2_RULES, -e / contraction(e, tau, floor, 1.0), 0.0)
    return answered(shape, 1000, 1.0, output_tau, floor)


# ---- the grating's signals
SEED = 0
ANGLE_RAD = math.radians(0.1)
"""A small crossing angle of the gratings, chosen: the paper prints none."""
TRIAL = SignalErrors(offset_u=0.05, offset_v=-0.03, gain=0.1, phase=math.radians(5.0))
"""Signals of a reader as it comes out of its box, chosen."""
ALONE = {
    "offset of 5 %": SignalErrors(offset_u=0.05),
    "amplitudes 10 % apart": SignalErrors(gain=0.1),
    "third harmonic of 2 %": SignalErrors(harmonic=0.02),
    "phase error of 5 degrees": SignalErrors(phase=math.radians(5.0)),
    "offsets 5 and −3 %, 10 %, 5 degrees": TRIAL,
}
NOISES = (0.005, 0.02)
POINTS = 40_000
"""Logged samples of one pitch for the ellipse; a peak over fewer would be smaller."""


def crossed_period_mm(lines_per_mm: float, angle_rad: float) -> float:
    """Width of the fringe from the two gratings' wave vectors: 1 over the length of their difference. Without (1)."""
    first, second = (lines_per_mm * np.array([math.cos(a), math.sin(a)]) for a in (-0.5 * angle_rad, 0.5 * angle_rad))
    return 1.0 / float(np.linalg.norm(first - second))
