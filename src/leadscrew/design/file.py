"""What a designed controller's file says of its origin, and what the first step prints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from leadscrew.design.log import MoveLog

if TYPE_CHECKING:
    from leadscrew.design.vud import VudDesign

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


def log_lines(log: MoveLog) -> list[str]:
    """The first step as text."""
    names = ", ".join(m.name for m in log.moves)
    every = (
        f"one a row, {log.interval_s:g} s apart" if log.layout == "normalised" else f"one every {log.interval_s:g} s"
    )
    lines = [f"{len(log.moves)} move{'' if len(log.moves) == 1 else 's'} ({names}), {log.rows} samples, {every}"]
    if log.turned:
        lines.append(
            f"the sign of ec is turned in {', '.join(log.turned)}: there ec has the other sign than the change of e"
        )
    return lines
