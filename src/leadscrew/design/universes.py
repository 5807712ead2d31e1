"""Step 2 of a design: what e = 1 and ec = 1 mean in millimetres.

A measured log gives the universes that it reaches: the largest error and the largest change of the error in any
interval, wherever the interval begins. A normalised log has its universes already; what they are in mm follows from
``r`` and the first ``e`` of the longest move, and from the change of ``e`` that one unit of ``ec`` stands for (least
squares over all moves).

Source: step 1 of section IV.b of Long et al. (2014), equations (5) and (6).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from leadscrew.design.log import MoveLog
from leadscrew.kernel.errors import DataError, ValueRefused

MOST_APART = 0.05
"""Part by which the moves' own scales of e may differ."""


@dataclass(frozen=True)
class Universes:
    """Scales of the inputs, and how far the samples reach into [-1, 1]."""

    error_mm: float
    rate_mm: float
    """Change per interval."""
    interval_s: float
    reached: tuple[float, float]
    """Largest size of e in the log, its starts included, and of ec among the samples."""
    how: tuple[str, str]
    """Where each scale comes from."""
    outside: tuple[int, int] = (0, 0)
    """Samples of e and ec beyond their universe, which a narrower scale leaves; they count as its end."""

    def lines(self) -> list[str]:
        """The step as text."""
        names = ("e", "ec")
        scales = (f"{self.error_mm:.6g} mm", f"{self.rate_mm:.6g} mm per {self.interval_s:g} s")
        lines = [
            f"{name} = 1 is {scale}: {how}; the log reaches {reached:.3f}"
            for name, scale, how, reached in zip(names, scales, self.how, self.reached, strict=True)
        ]
        return lines + [
            f"{count} samples of {name} lie outside and count as the end of their universe"
            for name, count in zip(names, self.outside, strict=True)
            if count
        ]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)


def find_universes(
    log: MoveLog, error_scale_mm: float | None = None, rate_scale_mm: float | None = None
) -> tuple[Universes, np.ndarray]:
    """The universes of a log, and its samples ``(e, ec, duty)`` in them; a scale that is given stands in for the log's.

    Raises:
        ValueRefused: a scale that is not positive.
        DataError: a normalised log whose ``r`` and ``e`` disagree, or do not say what e = 1 is.
    """
    for name, value in (("error_scale", error_scale_mm), ("rate_scale", rate_scale_mm)):
        if value is not None and not (value > 0.0 and np.isfinite(value)):
            raise ValueRefused(f"{name} = {value!r}: must be a number of mm above 0")
    normalised = log.layout == "normalised"
    own = _normalised(log, error_scale_mm) if normalised else _measured(log)
    error = own[0][0] if error_scale_mm is None else error_scale_mm
    rate = own[1][0] if rate_scale_mm is None else rate_scale_mm
    how = (
        own[0][1] if error_scale_mm is None else "given",
        own[1][1] if rate_scale_mm is None else f"given (the log says {own[1][0]:.4g})",
    )
    samples = log.samples() if normalised else log.samples() / [error, rate, 1.0]
    sizes = [np.abs(samples[:, k]) for k in (0, 1)]
    whole = max(float(np.abs(m.error).max()) for m in log.moves)
    reached = (whole if normalised else whole / error, float(sizes[1].max()))
    outside = (int((sizes[0] > 1.0).sum()), int((sizes[1] > 1.0).sum()))
    return Universes(error, rate, log.interval_s, reached, how, outside), samples


def _measured(log: MoveLog) -> tuple[tuple[float, str], tuple[float, str]]:
    error = max(float(np.abs(m.error).max()) for m in log.moves)
    return (error, "the largest error"), (log.peak_change, f"the largest change of the error in {log.interval_s:g} s")


def _normalised(log: MoveLog, error_scale_mm: float | None) -> tuple[tuple[float, str], tuple[float, str]]:
    error, how = (error_scale_mm, "given") if error_scale_mm is not None else _scale_of_r(log)
    factor, rest = log.scale()
    own = ", ".join(f"{abs(error * log.scale((m,))[0]):.2f}" for m in log.moves)
    return (error, how), (
        factor * error,
        f"least squares of the change of e on ec (the moves by themselves: {own}; {100.0 * rest:.1f} % left)",
    )


def _scale_of_r(log: MoveLog) -> tuple[float, str]:
    """``r`` over the first ``e`` of the longest move."""
    where = ", ".join(log.sources)
    found = {
        m.name: float(m.target_mm / m.error[0])
        for m in log.moves
        if m.target_mm and m.number[0] == 0.0 and m.error[0] != 0.0
    }
    if not found:
        raise DataError(f"{where}: no move has a row k = 0 with r and e: say with error_scale what e = 1 is in mm")
    longest = max((m for m in log.moves if m.name in found), key=lambda m: abs(m.error[0]))
    scale = found[longest.name]
    for name, other in found.items():
        if not abs(other - scale) <= MOST_APART * abs(scale) or other <= 0.0:
            raise DataError(
                f"{where}: r over e at k = 0 is {other:.4g} mm in the move {name} and {scale:.4g} mm in "
                f"{longest.name}: columns r and e do not belong together"
            )
    return scale, f"r over e at k = 0 of the move {longest.name}"
