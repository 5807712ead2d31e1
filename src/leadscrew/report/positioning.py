"""A positioning test for reading: tables, sentences in the standard's words, its picture, a page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.analysis.positioning import OneWay, Positioning
from leadscrew.figures.formats import NOTHING
from leadscrew.figures.positioning import draw
from leadscrew.report import page as html
from leadscrew.util import escape
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

SCHEMA_VERSION = 1
STANDARD = "ISO 230-2:2014"

TARGET_COLUMNS = ("target mm", "mean + um", "mean - um", "s + um", "s - um", "reversal um", "R um")
RESULT_COLUMNS = ("quantity", "", "direction +", "direction -", "both", "unit")


def um(value: float | None) -> str:
    """Micrometres with two decimals, a dash for what was not measured."""
    return NOTHING if value is None else f"{value:.2f}".replace("-0.00", "0.00")


def target_rows(test: Positioning) -> list[list[str]]:
    """One row for each target."""
    rows = []
    for i, target in enumerate(test.targets_mm):
        means = [None if way is None else float(way.mean[i]) for way in (test.up, test.down)]
        spreads = [None if way is None else float(way.s[i]) for way in (test.up, test.down)]
        both = test.both
        last = (None, None) if both is None else (float(both.reversal_at[i]), float(both.repeatability_at[i]))
        rows.append([f"{target:g}", *map(um, (*means, *spreads, *last))])
    return rows


def result_rows(test: Positioning) -> list[list[str]]:
    """The quantities of the axis: by direction, and both."""
    up, down, both = test.up, test.down, test.both

    def of(name: str) -> list[str]:
        return [um(None if way is None else getattr(way, name)) for way in (up, down, both)]

    only = [
        (NOTHING, NOTHING, um(None if both is None else getattr(both, n)))
        for n in ("mean_error", "reversal", "mean_reversal")
    ]
    return [
        ["accuracy", "A", *of("accuracy"), "um"],
        ["repeatability", "R", *of("repeatability"), "um"],
        ["systematic error", "E", *of("systematic"), "um"],
        ["mean bidirectional error", "M", *only[0], "um"],
        ["reversal value, largest", "B", *only[1], "um"],
        ["reversal value, mean", "", *only[2], "um"],
    ]


def sentences(test: Positioning) -> list[str]:
    """The result in words, a line each."""
    travel = f"between {test.targets_mm[0]:g} and {test.targets_mm[-1]:g} mm"
    said = []
    if test.both is None:
        way, name = (test.up, "+") if test.up is not None else (test.down, "-")
        assert way is not None
        said += _one_way(way, name, travel)
    else:
        both, left = test.both, test.compensated().both
        assert left is not None
        said += [
            f"bidirectional accuracy of positioning {travel}: A = {um(both.accuracy)} um",
            f"bidirectional repeatability of positioning: R = {um(both.repeatability)} um",
            f"bidirectional systematic error: E = {um(both.systematic)} um; mean bidirectional error: "
            f"M = {um(both.mean_error)} um",
            f"reversal value: B = {um(both.reversal)} um (mean {um(both.mean_reversal)} um)",
            f"at these targets a compensation of each direction's mean leaves A = {um(left.accuracy)} um",
        ]
    return said


def _one_way(way: OneWay, name: str, travel: str) -> list[str]:
    return [
        f"unidirectional accuracy of positioning {travel}, direction {name}: A = {um(way.accuracy)} um",
        f"unidirectional repeatability of positioning: R = {um(way.repeatability)} um",
        f"unidirectional systematic error: E = {um(way.systematic)} um",
    ]


def picture(test: Positioning, title: str = "") -> Figure:
    """Deviations against target, both directions: every approach, the means, and the means with two s to each side."""
    from leadscrew.figures.figure import Figure

    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.subplots()
    draw(axes, test)
    if title:
        axes.set_title(escape.figure(title), fontsize="medium")
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    return figure


def summary(test: Positioning, source: str) -> dict[str, Any]:
    """The result as the one JSON object that ``leadscrew positioning --json`` prints."""
    left = test.compensated().both
    return {
        "schema_version": SCHEMA_VERSION, "kind": "leadscrew positioning", "file": source, "standard": STANDARD,
        **test.as_dict(), "accuracy_if_compensated": None if left is None else left.accuracy,
        "uncertainty": None, "sentences": sentences(test), "notes": test.notes(),
    }  # fmt: skip


def write(test: Positioning, source: str, folder: str | Path, more: dict[str, str] | None = None) -> None:
    """Writes ``report.html``, ``positioning.json``, ``positioning.png`` and texts of one's own, complete or not at all.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as beside:
        drawn = picture(test, f"{STANDARD}: {source}")
        drawn.savefig(beside / "positioning.png", dpi=130, metadata={"Software": None})
        found = json.dumps(strict(summary(test, source)), indent=1, allow_nan=False)
        (beside / "positioning.json").write_text(found + "\n", encoding="utf-8")
        (beside / "report.html").write_text(page(test, source, drawn), encoding="utf-8")
        for name, text in (more or {}).items():
            (beside / name).write_text(text, encoding="utf-8")


def page(test: Positioning, source: str, drawn: Figure) -> str:
    """A page that opens anywhere, offline."""
    title = f"Positioning test: {source}"
    lines = [
        *sentences(test),
        *(f"note: {n}" for n in test.notes()),
        f"{len(test.targets_mm)} targets, {test.runs} runs in each direction; deviations are position reached minus "
        f"target; equations of {STANDARD}; the uncertainty of the measurement itself is not estimated",
    ]
    parts = [
        *html.paragraphs(lines),
        html.picture(drawn, "positioning", "deviation against target"),
        html.table("Axis", RESULT_COLUMNS, result_rows(test)),
        html.table("Targets", TARGET_COLUMNS, target_rows(test)),
    ]
    return html.page(title, parts)
