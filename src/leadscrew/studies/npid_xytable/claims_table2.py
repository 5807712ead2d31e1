"""Table II worked out anew: its percentages, what it says of NPID as a whole, and which motion its lines belong to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from leadscrew.report.claim import Claim, Kind, Verdict
from leadscrew.studies.npid_xytable.calibration import BASE_HZ
from leadscrew.studies.npid_xytable.runs import Loops
from leadscrew.studies.npid_xytable.saying import said, verdict_of, word
from leadscrew.studies.npid_xytable.scenarios import SPEEDS
from leadscrew.studies.npid_xytable.table2 import Row, at, base_hz, compared, label_errors_hz, rows

RECOMPUTED = (
    45.79, -84.14, 30.44, 29.00, -20.84, 57.96, 19.97, 22.85, 43.42, 59.92, 70.15, 1.72, -9.93, -11.50, 28.24,
)  # fmt: skip
"""The digest's percentages, in the order of the table."""
FLAGGED = {"1000_3_5": -45.7, "1000_7_7": -17.2, "2000_3_5": None, "3000_5_0": -9.0, "3000_6_3": -10.3}
"""Rows that the digest flags, and what they are with NPID as their base."""
MEANS = {1000: (8.4, 0.05, 10.8, 1.55), 2000: (40.4, 40.8, 43.4, 47.3), 3000: (16.2, 15.7, 23.3, 9.1)}
"""Mean of the printed column, mean worked out anew, reduction of the sum, of the largest, %; by speed."""
MAXIMA = {"npid": (0.7743, 0.6987, 0.7151), "pid": (0.7865, 1.327, 0.787)}
"""Largest amplitudes by speed as the conclusion prints them, um."""
P_VALUES = {1000: 0.62, 2000: 0.021, 3000: 0.36}
"""Of the paired t-test by speed, in the digest."""


def table2_claims(loops: Loops) -> list[Claim]:
    """A6, A12, the conclusion's maxima, and what the table's scatter allows to say."""
    return [*_percentages(), *_means(), *_maxima(), *_significance(), *_base()]


def _data(
    name: str, statement: str, measured: float | str, unit: str, target: float | str | None, reason: str,
    tolerance: float = 0.0, source: str = "Table II", paper: float | str | None = None,
    verdict: Verdict = "cannot be checked", kind: Kind = "required",
) -> Claim:  # fmt: skip
    return said(
        name, source, statement, measured, unit, target, reason, tolerance=tolerance, kind=kind, group="as printed",
        basis="paper's data", paper=paper, verdict=verdict, sense="yes/no" if isinstance(measured, str) else "=",
    )  # fmt: skip


def _why(row: Row) -> str:
    if row.agrees:
        return f"{row.reduction:.2f} %, rounded as printed"
    if row.wrong_base:
        return (
            f"printed {row.printed:g} % is the difference over the NPID column ({row.against_npid:.1f} %); over PID, "
            f"as in the other rows, it is {row.reduction:.2f} %: NPID is worse than printed"
        )
    return (
        f"printed {row.printed:g} %; over PID {row.reduction:.2f} %, over NPID {row.against_npid:.2f} %: neither base "
        "gives it, a slip"
    )


def _percentages() -> Iterator[Claim]:
    for row, digest in zip(rows(), RECOMPUTED, strict=True):
        yield _data(
            f"table2_percent_{row.key}", f"reduction at {row.hz:g} Hz, {row.rpm} 1/min", row.reduction, "%", digest,
            _why(row), 0.005, paper=row.printed, verdict="reproduced" if row.agrees else "not reproduced",
        )  # fmt: skip
    wrong = [r for r in rows() if not r.agrees]
    bases = [r for r in wrong if r.wrong_base]
    listed = ", ".join(f"{r.hz:g} Hz at {r.rpm}" for r in wrong)
    yield _data(
        "table2_percent_agree", "percentages that follow from the amplitudes beside them", len(rows()) - len(wrong),
        "of 15", 10, f"not: {listed}", paper=15, verdict="not reproduced" if wrong else "reproduced",
    )  # fmt: skip
    same = {r.key for r in wrong} == set(FLAGGED)
    yield _data(
        "table2_percent_flagged", "the five wrong rows are those that the digest flags", word(same), "", "yes", listed,
    )  # fmt: skip
    yield _data(
        "table2_wrong_base", "wrong percentages that are differences over the NPID column", len(bases), "rows", 4,
        "every negative percentage: the base is the larger amplitude instead of PID; the fifth (3.5 Hz at 2000) is 20 "
        "printed as 18",
    )  # fmt: skip
    for row in bases:
        digest_base = FLAGGED.get(row.key)
        yield _data(
            f"table2_base_{row.key}", f"difference over the NPID column at {row.hz:g} Hz, {row.rpm} 1/min",
            row.against_npid, "%", digest_base, f"printed {row.printed:g} %; with the right base {row.reduction:.2f} %",
            0.05, paper=row.printed, verdict=verdict_of(abs(row.against_npid - row.printed) < 0.5, change=True),
        )  # fmt: skip


def _means() -> Iterator[Claim]:
    everything = compared(rows())
    for rpm, (printed, mean, sums, largest) in MEANS.items():
        found = compared(at(rpm))
        yield _data(
            f"table2_printed_mean_{rpm}", f"mean of the printed percentages at {rpm} 1/min", found.printed_mean, "%",
            printed, f"worked out anew {found.mean:.2f} %", 0.05, "abstract",
        )  # fmt: skip
        yield _data(
            f"table2_mean_{rpm}", f"mean reduction at {rpm} 1/min, worked out anew", found.mean, "%", mean,
            f"mean of the printed column {found.printed_mean:.1f} %", 0.005 if rpm == 1000 else 0.05, "abstract",
            paper="8 to 40 %",
            verdict="reproduced" if 8.0 - 0.5 <= found.mean <= 40.0 + 1.0 else "not reproduced",
        )  # fmt: skip
        yield _data(
            f"table2_sum_{rpm}", f"reduction of the sum of the amplitudes at {rpm} 1/min", found.of_sums, "%", sums,
            f"mean of the rows' reductions {found.mean:.2f} %", 0.05,
        )  # fmt: skip
        yield _data(
            f"table2_largest_{rpm}", f"reduction of the largest amplitude at {rpm} 1/min", found.of_largest, "%",
            largest, f"{max(r.pid_um for r in at(rpm)):.4g} to {max(r.npid_um for r in at(rpm)):.4g} um",
            0.005 if rpm == 1000 else 0.05, "section IV",
        )  # fmt: skip
    low, high = (f(compared(at(rpm)).printed_mean for rpm in SPEEDS) for f in (min, max))
    rounded = (round(low), round(high)) == (8, 40)
    yield _data(
        "table2_8_to_40", "'8 to 40 %' are the least and largest mean of the printed percentages", word(rounded), "",
        "yes", f"{low:.1f} and {high:.1f} %; with the right base 0.05 to 40.8 %: at 1000 1/min NPID reduces nothing on "
        "average", source="abstract", paper="8 to 40 %", verdict="reproduced" if rounded else "not reproduced",
    )  # fmt: skip
    yield _data(
        "table2_mean", "mean reduction of all rows, worked out anew", everything.mean, "%", 18.9,
        f"mean of the printed percentages {everything.printed_mean:.1f} %", 0.05,
    )  # fmt: skip
    yield _data(
        "table2_printed_mean", "mean of all printed percentages", everything.printed_mean, "%", 21.7,
        f"worked out anew {everything.mean:.1f} %", 0.05,
    )  # fmt: skip
    yield _data(
        "table2_sum", "reduction of the sum of all amplitudes", everything.of_sums, "%", 29.0,
        f"mean of the rows' reductions {everything.mean:.1f} %", 0.05,
    )  # fmt: skip
    yield _data(
        "table2_worse", "rows that NPID makes worse", everything.worse, "rows", 4,
        "the paper names one of them (3.5 Hz at 1000 1/min)",
    )  # fmt: skip


def _maxima() -> Iterator[Claim]:
    for name, printed in MAXIMA.items():
        for rpm, value in zip(SPEEDS, printed, strict=True):
            found = max(getattr(r, f"{name}_um") for r in at(rpm))
            same = abs(found - value) < 5e-5
            yield _data(
                f"table2_max_{name}_{rpm}", f"largest amplitude under {name.upper()} at {rpm} 1/min", found, "um",
                value, "the conclusion calls it the amplitude of the error; it is the largest of five lines", 5e-5,
                "section IV", value, "reproduced" if same else "not reproduced",
            )  # fmt: skip


def _significance() -> Iterator[Claim]:
    found = compared(rows())
    once = "one run a cell, no repeats reported: rows stand in for repeats"
    yield _data("table2_t_test", "p of the paired t-test, all rows", found.t_test, "", 0.019, once, 5e-4)
    yield _data("table2_wilcoxon", "p of Wilcoxon's signed-rank test, all rows", found.wilcoxon, "", 0.022, once, 5e-4)
    for rpm, value in P_VALUES.items():
        by_speed = compared(at(rpm)).t_test
        yield _data(
            f"table2_t_test_{rpm}", f"p of the paired t-test at {rpm} 1/min", by_speed, "", value,
            "five rows; " + ("a difference" if by_speed < 0.05 else "no difference told"),
            5e-4 if value < 0.1 else 5e-3,
        )  # fmt: skip
    says = (
        f"95 % from {found.geometric_low:.1f} to {found.geometric_high:.1f} %; standard deviation of the logarithms "
        f"{found.log_sd:.2f}"
    )
    for name, words, value, digest in (
        ("geometric", "reduction of the geometric mean", found.geometric, 27.0),
        ("geometric_low", "lower end of its 95 % confidence interval", found.geometric_low, 5.0),
        ("geometric_high", "upper end of its 95 % confidence interval", found.geometric_high, 44.0),
    ):
        yield _data(f"table2_{name}", words, value, "%", digest, says, 0.5)
    yield _data(
        "table2_log_sd", "standard deviation of the logarithm of NPID over PID", found.log_sd, "", 0.48,
        f"one row scatters by a factor {np.exp(found.log_sd):.2f}: more than the mean effect "
        f"({1.0 / (1.0 - 0.01 * found.geometric):.2f})", 0.005,
    )  # fmt: skip


def _base() -> Iterator[Claim]:
    found, off = base_hz(), label_errors_hz()
    yield _data(
        "table2_base_hz", "fundamental whose odd multiples 3 to 11 fit the printed frequencies", found, "Hz", 0.7014,
        "the motion is at 0.7 Hz; the lines are its odd harmonics 2.1, 3.5, 4.9, 6.3, 7.7 Hz, labels rounded", 5e-5,
    )  # fmt: skip
    yield _data(
        "table2_base_residual", "largest distance of a printed frequency from its multiple", float(np.abs(off).max()),
        "Hz", 0.104, ", ".join(f"{r.hz:g} Hz: {x:+.3f}" for r, x in zip(rows(), off, strict=False)), 5e-4,
    )  # fmt: skip
    even = float(np.abs(label_errors_hz((2, 4, 6, 8, 10))).max())
    yield _data(
        "table2_base_odd", "odd orders fit the printed frequencies better than even ones",
        word(float(np.abs(off).max()) < even), "", "yes",
        f"largest distance {np.abs(off).max():.3f} Hz, with orders 2 to 10 {even:.3f} Hz: friction and reversal give "
        "odd orders",
    )  # fmt: skip
    lowest = min(SPEEDS) / 60.0
    highest = max(r.hz for r in rows())
    turns = any(abs(r.hz - k * r.rpm / 60.0) < 0.5 for r in rows() for k in range(1, 5))
    yield _data(
        "table2_not_spindle", "a printed frequency is a multiple of a spindle frequency", word(turns), "", "no",
        f"the lowest spindle frequency is {lowest:.2f} Hz, the highest line {highest:g} Hz, and the lines are the same "
        "at all three speeds: they are no cutting-force harmonics", source="section III",
        paper="cutting force harmonics", verdict=verdict_of(turns),
    )  # fmt: skip
    orders = [round(r.hz / BASE_HZ) for r in at(SPEEDS[0])]
    yield _data(
        "table2_orders", "printed frequencies over 0.7 Hz, rounded", ", ".join(map(str, orders)), "",
        "3, 5, 7, 9, 11", "odd only: what changes sign with the direction of motion has no even orders",
    )  # fmt: skip
