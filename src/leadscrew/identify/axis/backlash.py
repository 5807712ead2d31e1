"""Lost motion of an axis from the reversals in its log.

Behind a play of ``b`` in all the table follows the drive's side by ``table = drive - s b / 2``, ``s`` the direction of
the last motion (:mod:`leadscrew.plants._backlash`). What tells ``b`` depends on what was logged:

- *two positions*, :func:`lost_motion`: the table's lag changes by ``b`` at each reversal. Least squares over sliding,
  ``table - drive = c + k drive - s b / 2``.
- *command, drive and the table's position*: where the loop was closed on the motor, the drive obeys its law with the
  position of the motor, which is the table's and ``s b / 2``:

        u = kp kv (command - table) - kv v - kp kv s b / 2 + ki part

  Least squares of the drive on following error, speed, ``s`` and the sum of the following error give ``b`` as the
  ratio of two coefficients. Where the loop was closed on the logged position itself, the ratio is 0: then a play
  between the encoder and what it drives does not show in this law, and the dwell is tried.
- *drive and the table's position alone*: at a reversal the table dwells while the model's drive crosses the gap
  (:mod:`leadscrew.identify.axis.refine` with ``backlash`` fitted). Only as good as the model of friction at rest.
- one encoder on the motor and none on the table tells nothing: the table has no say in what is logged.

Intervals are robust to correlation within a stroke (``clustered``). ISO 230-1 calls what is measured here the
reversal value of an axis.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from leadscrew.identify.axis.record import count_of
from leadscrew.identify.estimation import clustered, identifiable, quantile
from leadscrew.util.errors import DataError

if TYPE_CHECKING:
    from leadscrew.identify.axis.cascade import Cascade
    from leadscrew.logs import AxisLog

SLIDES = 0.05
"""Share of the top speed above which a flank surely pushes."""
MEAN_S = 0.06
"""Over which signals are averaged before a law is sought in them."""
LIKELY = 6.0
"""Fall of the logarithm of the likelihood up to which a law is not ruled out."""
LEAST_STROKES = 4
"""Strokes from reversal to reversal that a play is judged by."""
OBEYS = 5.0
"""Percent of the drive that the law of a cascade may leave."""
FINE = 50.0
"""Counts of the encoder: where the interval holds 0, a lost motion known to so many is as good as none."""

LEADS = "The drive obeys the law of a cascade with the position of the motor, which leads the table by half of it."
DWELL = (
    "If the position is the table's: at reversals it dwells while the simulated drive crosses the play. As good as the "
    "model of friction at rest; a wind-up of the screw looks alike."
)
CLOSED_HERE = (
    "The drive obeys the law of a cascade with the logged position: the loop was closed on this encoder, and a play "
    "behind it does not show; log the table's position too, or give the model of the axis for the dwell at reversals."
)
ONE_POSITION = (
    "A log with one position does not tell the play between drive and table, unless the loop was closed on the motor, "
    "the position is the table's and the command is logged: log both positions, or the command."
)

Method = Literal["two positions", "command and drive", "dwell at reversals", "none"]


class Backlash(NamedTuple):
    """The lost motion between drive and table, and how well the log determines it."""

    value: float
    """m or rad; both halves together."""
    low: float
    high: float
    """95 %; NaN where nothing determines it."""
    identifiable: bool
    method: Method
    strokes: int
    note: str
    """Where it comes from, or why it is not identifiable, in a sentence."""


def lost_motion(drive_side: np.ndarray, table: np.ndarray, period: float) -> Backlash:
    """The play from two positions in the same unit: one before it, one behind it.

    Raises:
        DataError: unequal lengths, or fewer than four strokes.
    """
    x, y = (np.asarray(v, dtype=np.float64) for v in (drive_side, table))
    if x.shape != y.shape or x.ndim != 1:
        raise DataError(f"drive side and table have the shapes {x.shape} and {y.shape}; expected two equal columns")
    rows, side, stroke = _strokes(y, period)
    columns = np.column_stack([-0.5 * side, x - x.mean(), np.ones(len(x))])[rows]
    coefficients, covariance, degrees = _line(columns, (y - x)[rows], stroke[rows])
    return _found(
        float(coefficients[0]), float(np.sqrt(covariance[0, 0])), float(degrees[0]), count_of(y), "two positions",
        int(stroke[-1]) + 1, "The table's lag behind the drive's side changes by it at each reversal.",
    )  # fmt: skip


def backlash_of(
    log: AxisLog,
    values: Mapping[str, float] | None = None,
    delay_s: float = 0.0,
    cascade: Cascade | None = None,
) -> Backlash:
    """The play from a log of one axis whose position is the table's, or why it is not identifiable from the log.

    Args:
        log: with its command, where the loop was closed on the motor; without, the dwell at reversals is tried.
        values: the model by key of the plant, for the dwell.
        delay_s: of the drive, for the dwell.
        cascade: the loop that was active, where it is known: of it ``over`` counts.
    """
    by_law = None
    try:
        if log.command is not None:
            by_law = _by_law(log, cascade)
        if by_law is not None and by_law.low > 0.0:
            return by_law
        if values is not None:
            return _by_dwell(log, values, delay_s)
    except DataError as error:
        return _unknown(f"{error}.")
    return _unknown(CLOSED_HERE if by_law is not None else ONE_POSITION)


def _by_law(log: AxisLog, cascade: Cascade | None) -> Backlash | None:
    """From the drive's law; None where no law of a cascade gives the drive.

    Periods that the speed is a difference over are those of the cascade; where it is not known, all that the log does
    not rule out, and the interval holds what each of them says.
    """
    from leadscrew.identify.axis.cascade import LONGEST

    _, _, stroke = _strokes(log.position, log.period)
    spans = [cascade.over] if cascade is not None else list(range(1, LONGEST + 1))
    tried = [_law(log, over) for over in spans]
    best = min(tried, key=lambda law: law.left)
    if 100.0 * best.left > OBEYS * float(np.std(best.means[:, -2])):
        return None
    n, count = len(best.means), count_of(log.position)
    likely = [law for law in tried if n * np.log(max(law.left, 1e-300) / max(best.left, 1e-300)) < LIKELY]
    found = [_ratio(law, count, int(stroke[-1]) + 1) for law in [best, *likely]]
    low, high = min(f.low for f in found), max(f.high for f in found)
    return found[0]._replace(low=low, high=high, identifiable=_of_use(found[0].value, low, high, count))


class _Law(NamedTuple):
    left: float
    """Standard deviation of what the law leaves of the drive's means."""
    means: np.ndarray


def _law(log: AxisLog, over: int) -> _Law:
    assert log.command is not None
    rows, side, stroke = _strokes(log.position, log.period)
    error = log.command - log.position
    total = np.cumsum(error) * log.period
    speed = np.zeros(len(error))
    speed[over:] = (log.position[over:] - log.position[:-over]) / (over * log.period)
    columns = np.column_stack([error, speed, side, total - total.mean(), np.ones(len(error)), log.drive])
    means = _means(columns, rows, stroke, max(1, round(MEAN_S / log.period)))
    if len(means) < 3 * LEAST_STROKES:
        raise DataError(f"only {len(means)} pieces of {MEAN_S:g} s slide between reversals; a law needs more")
    size = np.maximum(np.linalg.norm(means[:, :-2], axis=0), 1e-300)
    fit, *_ = np.linalg.lstsq(means[:, :-2] / size, means[:, -2], rcond=None)
    return _Law(float(np.std(means[:, -2] - means[:, :-2] / size @ fit)), means)


def _ratio(law: _Law, count: float, strokes: int) -> Backlash:
    fit, covariance, degrees = _line(law.means[:, :-2], law.means[:, -2], law.means[:, -1])
    value = -2.0 * float(fit[2] / fit[0]) if fit[0] else 0.0
    slope = np.array([-value, -2.0]) / (fit[0] or 1.0)
    error = float(np.sqrt(slope @ covariance[np.ix_([0, 2], [0, 2])] @ slope))
    return _found(value, error, float(degrees[2]), count, "command and drive", strokes, LEADS)


def _means(columns: np.ndarray, rows: np.ndarray, stroke: np.ndarray, length: int) -> np.ndarray:
    """Means over pieces of sliding, the number of their stroke last.

    A law holds for means as it does for samples; and noise, which following error and speed have in them too and which
    makes their coefficients too small, does not matter there.
    """
    starts = np.arange(0, len(rows) - length + 1, length)
    whole = np.logical_and.reduceat(rows, starts) & (stroke[starts] == stroke[starts + length - 1])
    sums = np.add.reduceat(columns[: starts[-1] + length], starts, axis=0) / length
    return np.column_stack([sums, stroke[starts]])[whole]


def _by_dwell(log: AxisLog, values: Mapping[str, float], delay_s: float) -> Backlash:
    from leadscrew.identify.axis.refine import refine

    count, stroke = count_of(log.position), _strokes(log.position, log.period)[2]
    begins = max(20.0 * count, 1e-4 * float(np.ptp(log.position)))
    symmetric = not any(k.startswith("friction.backward.") for k in values)
    tries = [
        refine(log, {**values, "backlash": b}, ["backlash"], symmetric, "windows", delay_s, window_s=0.4)
        for b in (0.2 * begins, begins)
    ]
    found = min(tries, key=lambda f: f.rms)
    low, high = found.interval["backlash"]
    value = found.values["backlash"] if "backlash" not in found.at_bound else 0.0
    known = _of_use(value, low, high, count) and found.standard_error["backlash"] > 0.0
    return Backlash(value, max(low, 0.0), high, known, "dwell at reversals", int(stroke[-1]) + 1, DWELL)


def _strokes(position: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which samples slide, the side of each sample, and the number of its stroke.

    Raises:
        DataError: fewer than four strokes.
    """
    side_n = max(1, round(0.005 / period))
    speed = np.zeros(len(position))
    speed[side_n:-side_n] = (position[2 * side_n :] - position[: -2 * side_n]) / (2 * side_n * period)
    rows = np.abs(speed) > SLIDES * float(np.max(np.abs(speed)))
    moving = np.flatnonzero(rows)
    sign = np.sign(speed[moving])
    stroke_of = np.concatenate([[0], np.cumsum(sign[1:] != sign[:-1])])
    if not len(moving) or int(stroke_of[-1]) + 1 < LEAST_STROKES:
        met = int(stroke_of[-1]) + 1 if len(moving) else 0
        raise DataError(f"the log has {met} strokes from reversal to reversal; a play needs at least {LEAST_STROKES}")
    last = np.maximum(np.searchsorted(moving, np.arange(len(position)), side="right") - 1, 0)
    return rows, sign[last], stroke_of[last]


def _line(columns: np.ndarray, right: np.ndarray, cluster: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Least squares: coefficients, robust covariance, degrees of freedom."""
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    fit, *_ = np.linalg.lstsq(columns / size, right, rcond=None)
    spread = clustered(columns / size, right - columns / size @ fit, cluster)
    return fit / size, spread.covariance / np.outer(size, size), spread.degrees


def _found(
    value: float, error: float, degrees: float, count: float, method: Method, strokes: int, note: str
) -> Backlash:
    # no play is known to better than a tenth of a count
    reach = max(quantile(degrees) * error, 0.1 * count)
    return Backlash(
        max(value, 0.0), max(value - reach, 0.0), max(value + reach, 0.0),
        _of_use(value, value - reach, value + reach, count), method, strokes, note,
    )  # fmt: skip


def _of_use(value: float, low: float, high: float, count: float) -> bool:
    return identifiable(value, 0.5 * (high - low), FINE * count if low <= 0.0 else 0.0)


def _unknown(why: str) -> Backlash:
    return Backlash(0.0, float("nan"), float("nan"), False, "none", 0, why[0].upper() + why[1:])
