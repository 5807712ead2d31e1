"""What a log must be before anything is designed from it: enough rows, things that change, columns that are what they
say.

Columns are checked by physics, not by their names. ``ec`` must be the change of ``e`` in one interval, and no other
pair of columns may fit that better; the duty must drive the error to zero, in the sense of the lathe's controllers
(a positive duty makes the error rise, so the duty has the sign of ``-e``).
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from leadscrew.design.log import Move, MoveLog, misfit, slope
from leadscrew.kernel.errors import DataError

LEAST_ROWS = 10
"""Samples after the first of each move; each of the paper's moves has 20."""
MOST_MISFIT = 0.35
"""Of ec as the change of e: Table 1 has 0.007 to 0.094 by its rounding, unrelated columns 0.8 and more."""
LEAST_OPPOSED = 0.5
"""Correlation of -e and the duty, about zero, from which the duty drives the error to zero; Table 1 has 0.96."""
SAID = {"normalised": ("e", "ec", "rho"), "measured": ("command - feedback", "its change", "output")}


def checked(log: MoveLog) -> MoveLog:
    """The log with the sign of ``ec`` put right where a move has it turned round.

    Raises:
        DataError: too few rows, a column that never changes, columns that look swapped, or a duty that does not drive
            the error to zero; one sentence.
    """
    where = ", ".join(log.sources)
    if log.rows < LEAST_ROWS:
        raise DataError(
            f"{where}: {log.rows} row{'' if log.rows == 1 else 's'} after the start of a move: a rule base needs "
            f"{LEAST_ROWS} at least"
        )
    _changing(log, where)
    if not any(len(m.pairs()[0]) for m in log.moves):
        raise DataError(
            f"{where}: no two rows are one interval apart (columns k and r): ec cannot be checked against e"
        )
    if log.layout == "normalised":
        _columns(log, where)
        log = _turned(log)
    _opposed(log, where)
    return log


def _changing(log: MoveLog, where: str) -> None:
    rows = log.samples()
    for name, column in zip(SAID[log.layout], rows.T, strict=True):
        if np.ptp(column) == 0.0:
            raise DataError(f"{where}: {name} is always {column[0]:g}: there is nothing to learn from")


def _columns(log: MoveLog, where: str) -> None:
    """``ec`` is the change of ``e``, and no other pair of columns fits better."""
    fits = {pair: misfit(log.moves, *pair) for pair in itertools.permutations(("e", "ec", "rho"), 2)}
    own = fits["e", "ec"]
    best = min(fits, key=lambda pair: fits[pair])
    if best == ("e", "ec") and own <= MOST_MISFIT:
        return
    if fits[best] <= MOST_MISFIT:
        raise DataError(
            f"{where}: columns look swapped: {best[1]} is the change of {best[0]} per row (misfit "
            f"{100.0 * fits[best]:.0f} %), ec is not that of e ({100.0 * own:.0f} %)"
        )
    raise DataError(
        f"{where}: ec is not the change of e per row (misfit {100.0 * own:.0f} %, allowed are "
        f"{100.0 * MOST_MISFIT:.0f} %), nor is any other pair of columns: are they e, ec and rho, one row an interval?"
    )


def _turned(log: MoveLog) -> MoveLog:
    moves, turned = [], []
    for move in log.moves:
        if _slope_of(move) < 0.0:
            turned.append(move.name)
            move = replace(move, change=-move.change)
        moves.append(move)
    return replace(log, moves=tuple(moves), turned=tuple(turned))


def _slope_of(move: Move) -> float:
    before, after = move.pairs()
    return slope(move.error[after] - move.error[before], move.change[after])[0]


def _opposed(log: MoveLog, where: str) -> None:
    e, _, rho = log.samples().T
    size = float(np.sqrt((e @ e) * (rho @ rho)))
    agreement = -float(e @ rho) / size if size > 0.0 else 0.0
    if agreement >= LEAST_OPPOSED:
        return
    error, _, duty = SAID[log.layout]
    if agreement <= -LEAST_OPPOSED:
        swapped = "command and feedback are swapped, or " if log.layout == "measured" else ""
        raise DataError(
            f"{where}: {duty} has the sign of {error} (correlation {-agreement:.2f}): {swapped}the duty's sense is "
            "the other one; these controllers take a positive duty to make the error rise, so turn its sign"
        )
    raise DataError(
        f"{where}: {duty} does not drive {error} to zero (correlation with its negative {agreement:.2f}, at least "
        f"{LEAST_OPPOSED:g} is expected): are the columns what they say?"
    )
