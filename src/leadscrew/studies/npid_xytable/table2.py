"""Table II of the paper and what it says when its percentages are worked out anew.

The table prints, for three spindle speeds and five frequencies, the amplitude of the position error under PID and NPID
and a whole percentage of "error reduction". Its base is the PID column where the reduction is positive.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from leadscrew.identify.log import read_log
from leadscrew.studies.npid_xytable.calibration import ORDERS
from leadscrew.studies.npid_xytable.columns import TABLE_2

NAMES = ("spindle_rpm", "harmonic_hz", "pid_um", "npid_um", "printed_percent")

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

    @property
    def key(self) -> str:
        """For the names of claims: ``1000_3_5``."""
        return f"{self.rpm}_{self.hz:.1f}".replace(".", "_")


@lru_cache(maxsize=1)
def rows() -> tuple[Row, ...]:
    """The fifteen rows, in the order of the table."""
    log = read_log(TABLE_2, NAMES, increasing="harmonic_hz", within="spindle_rpm")
    return tuple(Row(int(v[0]), *map(float, v[1:])) for v in zip(*(log[name] for name in NAMES), strict=True))


def at(rpm: int) -> tuple[Row, ...]:
    """The five rows of a spindle speed."""
    return tuple(row for row in rows() if row.rpm == rpm)


class Comparison(NamedTuple):
    """Some rows together, PID against NPID."""

    mean: float
    """Mean of the reductions worked out anew, %."""
    printed_mean: float
    """Mean of the printed percentages, %."""
    of_sums: float
    """Reduction of the sum of the amplitudes, %."""
    of_largest: float
    """Reduction of the largest amplitude, %."""
    worse: int
    """Rows that NPID makes worse."""
    t_test: float
    """p of the paired t-test."""
    wilcoxon: float
    """p of Wilcoxon's signed-rank test, two-sided, exact."""
    geometric: float
    """Reduction of the geometric mean, %."""
    geometric_low: float
    """Lower end of its 95 % confidence interval, from Student's t on the logarithms of the ratios."""
    geometric_high: float
    log_sd: float
    """Standard deviation of the logarithms of the ratios."""


def compared(some: tuple[Row, ...]) -> Comparison:
    """The comparison of rows, one run each: their scatter is all that the table tells about repeatability."""
    from scipy.stats import t, ttest_rel, wilcoxon

    pid, npid = np.array([r.pid_um for r in some]), np.array([r.npid_um for r in some])
    logs = np.log(npid / pid)
    half = float(t.ppf(0.975, len(some) - 1)) * logs.std(ddof=1) / np.sqrt(len(some))
    low, middle, high = (100.0 * (1.0 - np.exp(logs.mean() + x)) for x in (half, 0.0, -half))
    return Comparison(
        float(np.mean([r.reduction for r in some])), float(np.mean([r.printed for r in some])),
        100.0 * (1.0 - npid.sum() / pid.sum()), 100.0 * (1.0 - npid.max() / pid.max()), int((npid > pid).sum()),
        float(ttest_rel(pid, npid).pvalue), float(wilcoxon(pid, npid).pvalue), float(middle), float(low), float(high),
        float(logs.std(ddof=1)),
    )  # fmt: skip


def base_hz(orders: tuple[int, ...] = ORDERS) -> float:
    """The fundamental whose multiples are nearest to the printed frequencies, by least squares, Hz."""
    n, labels = np.array(orders, dtype=float), np.array([r.hz for r in rows()[: len(orders)]])
    return float(n @ labels / (n @ n))


def label_errors_hz(orders: tuple[int, ...] = ORDERS) -> np.ndarray:
    """Printed frequency less the multiple of the fitted fundamental, for each line, Hz."""
    return np.array([r.hz for r in rows()[: len(orders)]]) - base_hz(orders) * np.array(orders)
