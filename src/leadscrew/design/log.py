"""Logged moves of a servo axis, as a design reads them: error, its change per interval, and the duty.

Two kinds of log:

``normalised``
    the layout of the paper's Table 1: ``e`` and ``ec`` are fractions of their universes, ``rho`` is the duty;
``measured``
    signals against time, as ``leadscrew simulate --out`` writes them: the error is command minus feedback, taken every
    interval, and ``ec`` its change from the interval before.

The sign of ``ec`` must be that of the change of ``e``. A move whose ``ec`` is the change turned round (Table 1 prints
magnitudes where the target is positive) is turned back, and named in :attr:`MoveLog.turned`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

Layout = Literal["normalised", "measured"]


@dataclass(frozen=True)
class Move:
    """One logged move, a sample an interval."""

    name: str
    target_mm: float | None
    """Where it went from 0, where the log says so."""
    number: np.ndarray
    """Of the sample; 0 is the instant of the step."""
    error: np.ndarray
    """Normalised, or in mm."""
    change: np.ndarray
    """Of the error since the sample before, with its sign; says nothing at 0. Normalised, or in mm."""
    duty: np.ndarray

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Indices of neighbouring samples, one interval apart: the earlier and the later ones."""
        later = np.flatnonzero(np.diff(self.number) == 1.0) + 1
        return later - 1, later

    def columns(self) -> dict[str, np.ndarray]:
        """By the names of Table 1."""
        return {"e": self.error, "ec": self.change, "rho": self.duty}


@dataclass(frozen=True)
class MoveLog:
    """All moves of a log."""

    sources: tuple[str, ...]
    layout: Layout
    moves: tuple[Move, ...]
    interval_s: float
    """To which the change of the error refers."""
    peak_change: float
    """Largest change of the error in one interval, wherever the interval begins if the log is finer than that."""
    turned: tuple[str, ...] = ()
    """Moves whose ec had the wrong sign."""

    @property
    def rows(self) -> int:
        """Samples that a rule can come from: all but the first of each move."""
        return sum(int((m.number > 0).sum()) for m in self.moves)

    def samples(self) -> np.ndarray:
        """Rows ``(e, ec, rho)`` of these samples, in the log's units."""
        parts = [np.column_stack([m.error, m.change, m.duty])[m.number > 0] for m in self.moves]
        return np.concatenate(parts) if parts else np.empty((0, 3))

    def scale(self, moves: tuple[Move, ...] | None = None) -> tuple[float, float]:
        """Change of the error per unit of ec by least squares over ``moves`` (all unless given), and what is left.

        The second number is the root mean square of what is left, over that of the change.
        """
        d, x = _stacked([m.columns() for m in moves or self.moves], moves or self.moves, "e", "ec")
        return slope(d, x)


def slope(d: np.ndarray, x: np.ndarray) -> tuple[float, float]:
    """The factor that turns ``x`` into ``d`` best, and the root mean square of the rest over that of ``d``."""
    size, power = float(d @ d), float(x @ x)
    if size == 0.0 or power == 0.0:
        return 0.0, 1.0
    factor = float(x @ d) / power
    return factor, float(np.sqrt(np.sum((d - factor * x) ** 2) / size))


def misfit(moves: tuple[Move, ...], error: str, change: str) -> float:
    """How badly column ``change`` is the change of column ``error``: 0 exactly, 1 not at all; each move by itself."""
    left = whole = 0.0
    for move in moves:
        d, x = _stacked([move.columns()], (move,), error, change)
        size = float(d @ d)
        left += size * slope(d, x)[1] ** 2
        whole += size
    return float(np.sqrt(left / whole)) if whole > 0.0 else 1.0


def _stacked(
    columns: Sequence[Mapping[str, np.ndarray]], moves: tuple[Move, ...], error: str, change: str
) -> tuple[np.ndarray, np.ndarray]:
    d, x = [], []
    for named, move in zip(columns, moves, strict=True):
        before, after = move.pairs()
        d.append(named[error][after] - named[error][before])
        x.append(named[change][after])
    return np.concatenate(d), np.concatenate(x)
