"""The page of a Monte Carlo report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.report.tables import number
from leadscrew.tune.montecarlo_notes import alike, independence, missing, unknown, without_value

if TYPE_CHECKING:
    from leadscrew.tune.montecarlo_report import Findings


def percent(part: float | None) -> str:
    """A part of one as percents."""
    return short(None if part is None else 100.0 * part)


def short(value: float | None) -> str:
    """Four digits, as many as a sample is good for."""
    return number(value) if value is None else f"{value:.4g}"


def render(findings: Findings, said: Mapping[str, Any], folder: Path, drawn: Sequence[tuple[str, str, str]]) -> str:
    """The page, from what the summary says; ``drawn`` are name, caption and source of each figure."""
    from leadscrew.report.folder import manifest
    from leadscrew.report.html import template

    made = manifest(findings.found.wall_s)
    made.pop("wall time of the study")
    return template("montecarlo.html.j2", number=number, percent=percent, short=short).render(
        said=said,
        title=f"{Path(str(said['study'])).name} under {said['controller']}" if said["controller"] else said["study"],
        several=len(said["scenarios"]) > 1,
        groups=[
            ("Distributions", [d for d in drawn if d[0] in findings.shown]),
            ("Which runs fail", [d for d in drawn if d[0].startswith("fails_")]),
            ("Sensitivity", [d for d in drawn if d[0] in ("sensitivity", "sobol")]),
            ("Wear", [d for d in drawn if d[0].startswith("life_") and d[0] not in findings.shown]),
        ],
        independence=independence(findings.found),
        alike=alike(findings.found),
        without=without_value(findings.found),
        sobol_notes=[s for s in (unknown(findings), missing(findings)) if s],
        keys=list(findings.found.space.keys),
        folder=folder,
        command=findings.command,
        manifest={**findings.cost, **made},
        level=findings.level,
        shown=findings.shown,
    )
