"""The paper's data: Table 1, the moves of the original servo, read through the log door; Table 2 lies with the blocks.

Table 1 holds, every 0.1 s, the normalised error, its change per 0.1 s and the duty of four steps from the middle of
the rail. ``ec`` is printed as a magnitude where the target is positive, although the error falls there: :func:`moves`
gives it the sign that it must have, ``printed_rate`` keeps it as it is.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew.identify.gain import Record
from leadscrew.identify.log import read_log
from leadscrew.kernel.errors import DataError

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
        """Input and travel for :func:`leadscrew.identify.gain.fit_gain`."""
        return Record(self.time_s, self.duty, FULL_SCALE_MM * (self.error[0] - self.error))


def moves(path: str | Path = TABLE_1) -> dict[str, Move]:
    """The moves of a file laid out like Table 1 (columns k, r, e, ec, rho), by target: ``r=-190`` and so on.

    Raises:
        DataError: what :func:`leadscrew.identify.log.read_log` refuses, a value outside [-1, 1], or a target twice.
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
