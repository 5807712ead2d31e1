"""Table II of the paper, and what it says when its percentages are worked out anew.

The table prints, for three spindle speeds and five frequencies, the amplitude of the position error under PID and NPID
and a whole percentage of "error reduction". Its base is the PID column where the reduction is positive.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np

BASE_HZ = 0.7
"""Frequency of the motion whose odd harmonics Table II shows."""
ORDERS = (3, 5, 7, 9, 11)
LINES_HZ = tuple(BASE_HZ * n for n in ORDERS)
SPEEDS = (1000, 2000, 3000)
"""Spindle speeds, 1/min."""
HALF_PERCENT = 0.5
"""The percentages are printed whole."""


class Row(NamedTuple):
    """A row as printed."""

    rpm: int
    hz: float
    """The printed frequency."""
    pid_um: float
    npid_um: float
    printed: float
    """Printed reduction, %."""

    @property
    def reduction(self) -> float:
        """(PID - NPID) / PID, %."""
        return 100.0 * (self.pid_um - self.npid_um) / self.pid_um

    @property
    def against_npid(self) -> float:
        """(PID - NPID) / NPID, %: the wrong base."""
        return 100.0 * (self.pid_um - self.npid_um) / self.npid_um

    @property
    def agrees(self) -> bool:
        """Whether the printed percentage is the reduction, rounded."""
        return abs(self.reduction - self.printed) <= HALF_PERCENT

    @property
    def wrong_base(self) -> bool:
        """Whether the printed percentage does not agree, and would with NPID as its base."""
        return not self.agrees and abs(self.against_npid - self.printed) <= HALF_PERCENT


def _read() -> tuple[Row, ...]:
    with (Path(__file__).parent / "data" / "table2.csv").open(newline="", encoding="utf-8") as file:
        return tuple(Row(int(rpm), *map(float, rest)) for rpm, *rest in list(csv.reader(file))[1:])


ROWS = _read()
"""The fifteen rows, in the order of the table."""


def at(rpm: int) -> tuple[Row, ...]:
    """The five rows of a spindle speed."""
    return tuple(row for row in ROWS if row.rpm == rpm)


PID_UM = {rpm: tuple(row.pid_um for row in at(rpm)) for rpm in SPEEDS}
"""By spindle speed in 1/min, in the order of the lines: about 2.1, 3.5, 4.9, 6.3, 7.7 Hz."""
NPID_UM = {rpm: tuple(row.npid_um for row in at(rpm)) for rpm in SPEEDS}
"""The same under NPID."""


class Comparison(NamedTuple):
    """Some rows together, PID against NPID."""

    mean: float
    """Mean of the reductions worked out anew, %."""
    printed_mean: float
    """Mean of the printed percentages, %."""
    worse: int
    """Rows that NPID makes worse."""
    t_test: float
    """p of the paired t-test, two-sided."""
    geometric: float
    """Reduction of the geometric mean, %."""
    geometric_low: float
    """Lower end of its 95 % confidence interval, from Student's t on the logarithms of the ratios."""
    geometric_high: float


def compared(some: tuple[Row, ...]) -> Comparison:
    """The comparison of rows, one run each: only their scatter tells about repeatability."""
    from scipy.special import stdtr, stdtrit

    pid, npid = np.array([r.pid_um for r in some]), np.array([r.npid_um for r in some])
    logs, less, free = np.log(npid / pid), pid - npid, len(some) - 1
    half = float(stdtrit(free, 0.975)) * logs.std(ddof=1) / np.sqrt(len(some))
    size = abs(less.mean()) / (less.std(ddof=1) / np.sqrt(len(some)))
    low, middle, high = (100.0 * (1.0 - np.exp(logs.mean() + x)) for x in (half, 0.0, -half))
    return Comparison(
        mean=float(np.mean([r.reduction for r in some])),
        printed_mean=float(np.mean([r.printed for r in some])),
        worse=int((npid > pid).sum()),
        t_test=float(2.0 * stdtr(free, -size)),
        geometric=float(middle),
        geometric_low=float(low),
        geometric_high=float(high),
    )


def base_hz(orders: tuple[int, ...] = ORDERS) -> float:
    """The fundamental whose multiples are nearest to the printed frequencies, by least squares, Hz."""
    n, labels = np.array(orders, dtype=float), np.array([r.hz for r in ROWS[: len(orders)]])
    return float(n @ labels / (n @ n))
