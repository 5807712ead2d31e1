"""A positioning test for reading: tables, sentences in the standard's words, its picture, a page."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.analysis.positioning import OneWay, Positioning
from leadscrew.figures.positioning import draw
from leadscrew.figures.table import NOTHING, fixed, number
from leadscrew.report import page as html
from leadscrew.report.report import File, Report, TextTable, Verbatim, head
from leadscrew.util import escape
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

STANDARD = "ISO 230-2:2014"


def target_table(test: Positioning) -> TextTable:
    """One row for each target."""
    rows = []
    for i, target in enumerate(test.targets_mm):
        means = [None if way is None else float(way.mean[i]) for way in (test.up, test.down)]
        spreads = [None if way is None else float(way.s[i]) for way in (test.up, test.down)]
        both = test.both
        last = (None, None) if both is None else (float(both.reversal_at[i]), float(both.repeatability_at[i]))
        rows.append([number(target, 6), *(fixed(x, 2) for x in (*means, *spreads, *last))])
    heads = ("target (mm)", "mean + (µm)", "mean − (µm)", "s + (µm)", "s − (µm)", "reversal (µm)", "R (µm)")
    return TextTable(heads, rows, title="Targets")


def result_table(test: Positioning) -> TextTable:
    """The quantities of the axis: by direction, and both."""
    up, down, both = test.up, test.down, test.both

    def of(name: str) -> list[str]:
        return [fixed(None if way is None else getattr(way, name), 2) for way in (up, down, both)]

    def only(name: str) -> list[str]:
        return [NOTHING, NOTHING, fixed(None if both is None else getattr(both, name), 2)]

    rows = [
        ["accuracy", "A", *of("accuracy"), "µm"],
        ["repeatability", "R", *of("repeatability"), "µm"],
        ["systematic error", "E", *of("systematic"), "µm"],
        ["mean bidirectional error", "M", *only("mean_error"), "µm"],
        ["reversal value, largest", "B", *only("reversal"), "µm"],
        ["reversal value, mean", "", *only("mean_reversal"), "µm"],
    ]
    heads = ("quantity", "", "direction +", "direction −", "both", "unit")
    return TextTable(heads, rows, [False, False, True, True, True, False], title="Axis")


def sentences(test: Positioning) -> list[str]:
    """The result in words, a line each."""
    travel = f"between {test.targets_mm[0]:g} and {test.targets_mm[-1]:g} mm"
    lines = []
    if test.both is None:
        way, name = (test.up, "+") if test.up is not None else (test.down, "-")
        assert way is not None
        lines += _one_way(way, name, travel)
    else:
        both, left = test.both, test.compensated().both
        assert left is not None
        lines += [
            f"bidirectional accuracy of positioning {travel}: A = {fixed(both.accuracy, 2)} µm",
            f"bidirectional repeatability of positioning: R = {fixed(both.repeatability, 2)} µm",
            f"bidirectional systematic error: E = {fixed(both.systematic, 2)} µm; mean bidirectional error: "
            f"M = {fixed(both.mean_error, 2)} µm",
            f"reversal value: B = {fixed(both.reversal, 2)} µm (mean {fixed(both.mean_reversal, 2)} µm)",
            f"at these targets a compensation of each direction's mean leaves A = {fixed(left.accuracy, 2)} µm",
        ]
    return lines


def _one_way(way: OneWay, name: str, travel: str) -> list[str]:
    return [
        f"unidirectional accuracy of positioning {travel}, direction {name}: A = {fixed(way.accuracy, 2)} µm",
        f"unidirectional repeatability of positioning: R = {fixed(way.repeatability, 2)} µm",
        f"unidirectional systematic error: E = {fixed(way.systematic, 2)} µm",
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
        **head("positioning"), "file": source, "standard": STANDARD,
        **test.as_dict(), "accuracy_if_compensated": None if left is None else left.accuracy,
        "uncertainty": None, "sentences": sentences(test), "notes": test.notes(),
    }  # fmt: skip


def report_of(test: Positioning, source: str, files: Sequence[File] = (), then: str = "") -> Report:
    """The report of ``leadscrew positioning``; ``then`` says what to do with a file."""
    return Report(
        summary(test, source),
        parts=[
            target_table(test), result_table(test), *sentences(test),
            *([Verbatim(then.splitlines())] if then else []),
        ],
        notes=test.notes(),
        files=files,
        page=lambda folder: write(test, source, folder),
    )  # fmt: skip


def write(test: Positioning, source: str, folder: str | Path) -> None:
    """Writes ``report.html``, ``positioning.json`` and ``positioning.png``, complete or not at all.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as beside:
        drawn = picture(test, f"{STANDARD}: {source}")
        drawn.savefig(beside / "positioning.png", dpi=130, metadata={"Software": None})
        found = json.dumps(strict(summary(test, source)), indent=1, allow_nan=False)
        (beside / "positioning.json").write_text(found + "\n", encoding="utf-8")
        (beside / "report.html").write_text(page(test, source, drawn), encoding="utf-8")


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
        html.table(result_table(test)),
        html.table(target_table(test)),
    ]
    return html.page(title, parts)
