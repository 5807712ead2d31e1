"""The design of a VUD fuzzy controller in words: its six steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from leadscrew.report.report import File, Report, head
from leadscrew.report.text import steps

if TYPE_CHECKING:
    from leadscrew.design.files import MoveLog
    from leadscrew.design.vud import VudDesign


def report_of(design: VudDesign, most: int = 60, files: Sequence[File] = ()) -> Report:
    """The report of ``leadscrew design vud``; lists are cut after ``most`` lines, and say so."""
    shown = steps(
        ("log", log_lines(design.log)),
        ("universes", design.universes.lines()),
        ("curvature", design.bending.lines()),
        ("sets", design.sets.lines()),
        ("rules", design.rules.lines(most)),
        ("factors", design.factors.lines()),
    )
    return Report({**head("design vud"), **design.as_dict()}, [shown], files=files)


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
