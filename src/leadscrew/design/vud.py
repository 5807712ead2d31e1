"""From a log of the old controller to a VUD fuzzy controller: the five steps of Long et al. (2014) as one procedure.

1. the log, its columns checked by physics (:mod:`leadscrew.design.files`);
2. universes;
3. curvature, where the log can tell;
4. sets;
5. rules and completion;
6. contraction-expansion factors and law.

Steps 2 to 6 are in :mod:`leadscrew.design.vud_steps`.

Every step says what it found, what it took instead, and why. The result is a controller file
(:mod:`leadscrew.controller_file`) for the blocks ``vud_beta_e`` and ``vud``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.design.files import INTERVAL_S, MoveLog, read_moves
from leadscrew.design.vud_steps import (
    ACCURACY,
    MOST_CONDITION,
    Bending,
    Factors,
    Rules,
    Sets,
    Universes,
    find_bending,
    find_rules,
    find_sets,
    find_universes,
)
from leadscrew.fuzzy.grids import Reading

if TYPE_CHECKING:
    from leadscrew.controller_file import ControllerFile
    from leadscrew.kernel.block import Block


STUDY = "vud_lathe"
"""Whose axis a controller file names by default."""


@dataclass(frozen=True)
class VudDesign:
    """A designed controller, and every step that led to it."""

    log: MoveLog
    universes: Universes
    bending: Bending
    sets: Sets
    rules: Rules
    factors: Factors

    @property
    def parameters(self) -> dict[str, Any]:
        """Of the controller's block."""
        centres = [float(c) for c in self.sets.partition.centres]
        return {
            "error_full_scale_mm": self.universes.error_mm,
            "rate_full_scale_mm": self.universes.rate_mm,
            "rate_interval_s": self.universes.interval_s,
            **self.factors.parameters(),
            "e_centres": centres,
            "ec_centres": centres,
            "rules": self.rules.table.tolist(),
        }

    def controller(self) -> Block:
        """The controller as a block for a loop."""
        from leadscrew.controllers import _vud as laws
        from leadscrew.kernel.parameters import checked_replace

        base: Block = getattr(laws, self.factors.law)
        return replace(base, params=checked_replace(base.params, self.parameters, where="design"))

    def controller_file(self, study: str = STUDY) -> ControllerFile:
        """The controller as a file that ``simulate``, ``tune`` and ``export`` take."""
        from leadscrew.controller_file import ControllerFile

        return ControllerFile(study, self.factors.law, self.parameters, origin(self))

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data, for JSON."""
        return {
            "log": {
                "sources": list(self.log.sources), "layout": self.log.layout, "samples": self.log.rows,
                "moves": [m.name for m in self.log.moves], "turned": list(self.log.turned),
            },
            "universes": self.universes.as_dict(),
            "curvature": self.bending.as_dict(),
            "sets": self.sets.as_dict(),
            "rules": self.rules.as_dict(),
            "factors": self.factors.as_dict(),
            "controller": self.factors.law,
            "parameters": self.parameters,
        }  # fmt: skip


def design_vud(
    log: MoveLog | str | Path | Sequence[str | Path],
    *,
    interval_s: float = INTERVAL_S,
    error_scale_mm: float | None = None,
    rate_scale_mm: float | None = None,
    curvature: Sequence[float] | None = None,
    most_condition: float = MOST_CONDITION,
    accuracy: float = ACCURACY,
    reading: Reading | None = None,
    sets: int | None = None,
    centres: Sequence[float] | None = None,
    complete: Sequence[str] | None = None,
    levels: Sequence[float] | None = None,
    factors: Factors | None = None,
) -> VudDesign:
    """A VUD controller from a log, or from the files of one.

    Args:
        log: files (a table like Table 1, or signals of ``simulate --out``), or a log that was read.
        interval_s: of a table's rows, and at which signals are taken.
        error_scale_mm: what e = 1 is; the log's unless given.
        rate_scale_mm: what ec = 1 is, per interval; the log's unless given.
        curvature: u_ee and u_cc in place of an estimate.
        most_condition: condition number up to which an estimate is believed.
        accuracy: of equation (10), in duty.
        reading: of equation (10): half, full or intervals; the number of sets follows from it.
        sets: number of evenly spaced sets instead.
        centres: of the sets instead, from -1 to 1.
        complete: steps of completion; see :mod:`leadscrew.design.vud_steps`.
        levels: sizes of the consequents; the sets' centres unless given.
        factors: exponents, floor and law.

    Raises:
        DataError: the log is refused; one sentence.
        ValueRefused: an option out of range, or a step that cannot be taken; one sentence.
        NameUnknown: no such step of completion.
    """
    given = log if isinstance(log, MoveLog) else read_moves(log, interval_s)
    universes, samples = find_universes(given, error_scale_mm, rate_scale_mm)
    bending = find_bending(samples, curvature, most_condition)
    found = find_sets(bending, reading, sets, centres, accuracy)
    rules = find_rules(samples, found.partition, complete, levels)
    return VudDesign(given, universes, bending, found, rules, factors or Factors())


MADE_BY = "leadscrew design vud"


def origin(design: VudDesign) -> dict[str, Any]:
    """The table ``[tuning]`` of the file: where the parameters come from."""
    from leadscrew._version import __version__

    learned, compared = design.rules.learned, design.rules.compared
    notes = [
        f"made by {MADE_BY} from {', '.join(design.log.sources)}",
        f"{learned.covered} of {learned.total} rules from {learned.samples} samples, {len(learned.conflicts)} in "
        f"conflict; the others by {', '.join(design.rules.steps) or 'no step'}, which is not data",
    ]
    if compared is not None:
        notes.append(f"{compared.equal} of {design.rules.table.size} cells are those of the printed Table 2")
    return {"made_by": MADE_BY, "leadscrew": __version__, "notes": notes}
