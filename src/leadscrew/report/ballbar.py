"""A ball-bar test for reading: tables, sentences, polar plot, a page. Every table says what it is about.

The polar plot of a circular test: deviations drawn much larger than the circle, as ball-bar software draws them.

The nominal circle is drawn with a radius of ``CIRCLE`` divisions; a division is a round number of micrometres chosen so
that the largest deviation takes about three. The magnification is how much larger deviations are drawn than the circle:
``R / (CIRCLE division)``. Angles and radii are about the common least-squares centre: the centring does not show.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.circular.evaluation import Evaluation
from leadscrew.analysis.circular.paths import SOURCES, Circle
from leadscrew.analysis.circular.quantities import about
from leadscrew.figures.ballbar import COLOURS, WORDS, division_um, polar
from leadscrew.figures.formats import NOTHING
from leadscrew.report import page as html
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure


def centre_of(found: Evaluation) -> Circle:
    """The least-squares centre of all paths, mm."""
    q = found.quantities
    way = q.both or q.ccw or q.cw
    assert way is not None
    return Circle(1e-3 * way.centre_x, 1e-3 * way.centre_y, found.test.radius_mm)


def picture(found: Evaluation) -> Figure:
    """Polar plot, and the same deviations over the angle."""
    from leadscrew.figures.figure import Figure

    test, centre = found.test, centre_of(found)
    paths = {t.direction: about(t, centre, test.radius_mm) for t in test.turns}
    division = division_um(max(float(np.abs(r).max()) for _, r in paths.values()))
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    left = figure.add_subplot(1, 2, 1, projection="polar")
    right = figure.add_subplot(1, 2, 2)
    polar(left, paths, division, test)
    for direction, (angle, deviation) in paths.items():
        degrees = np.mod(np.degrees(angle) + 1e-9, 360.0)
        order = np.argsort(degrees, kind="stable")
        right.plot(degrees[order], deviation[order], color=COLOURS[direction], linewidth=1.0, label=WORDS[direction])
    for reversal in (0, 90, 180, 270, 360):
        right.axvline(reversal, color="0.8", linewidth=0.6, zorder=0)
    right.axhline(0.0, color="0.6", linewidth=0.6, zorder=0)
    right.set(xlim=(0, 360), xticks=range(0, 361, 45), xlabel="angle (degrees)", ylabel="radial deviation (µm)")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    feed = "" if test.feed_mm_min is None else f", {test.feed_mm_min:g} mm/min"
    figure.suptitle(
        f"radius {test.radius_mm:g} mm{feed}, axes {test.axes[0]}{test.axes[1]}, {SOURCES[test.source]}\n"
        "deviations from the nominal radius, about the least-squares centre",
        fontsize="small",
    )
    return figure


SCHEMA_VERSION = 1

QUANTITY_COLUMNS = ("quantity", "", "um")
WITH_BAR_COLUMNS = ("quantity", "", "true path um", "ball bar um")
REVERSAL_COLUMNS = ("reversal", "direction", "step um", "peak um", "lasts deg", "lasts ms")
FAULT_COLUMNS = ("fault", "size um", "±", "draws um", "share %", "which is")
WITHOUT_TEXT = "its text was not at hand: public abstracts and summaries were followed"
UNITS = {
    "ppm": ("", "ppm"),
    "urad": ("", "urad"),
    "ms": ("", "ms"),
    "lead_mm": ("lead ", "mm"),
    "rise_deg": ("rise ", "deg"),
    "decay_deg": ("decay ", "deg"),
    "period_deg": ("period ", "deg"),
    "zone_deg": ("within ", "deg"),
}
"""What a fault's further values are called, and their units."""


def um(value: float | None) -> str:
    """Micrometres to the nanometre, a dash for what there is not."""
    return NOTHING if value is None else f"{value:.3f}".replace("-0.000", "0.000")


def standard(edition: str) -> str:
    """The standard's name."""
    return f"ISO 230-4:{edition}"


def conditions(found: Evaluation) -> list[str]:
    """How the circle was made, a line each: without it no number of a circular test means anything."""
    test = found.test
    feed = "not given" if test.feed_mm_min is None else f"{test.feed_mm_min:g} mm/min"
    return [
        f"circle of {SOURCES[test.source]}" + (f" ({test.name})" if test.name else ""),
        f"radius {test.radius_mm:g} mm, feed {feed}, {test.directions}, axes {' and '.join(test.axes)}",
        f"start point at {test.start_deg:g} degrees; {test.sampling}",
    ]


def quantity_rows(found: Evaluation, bar: Evaluation | None = None) -> list[list[str]]:
    """The quantities of the edition; with what the bar reads beside them."""
    rows = [[n.name, n.symbol, um(n.value)] for n in found.named()]
    if bar is not None:
        for row, other in zip(rows, bar.named(), strict=True):
            row.append(um(other.value))
    return rows


def reversal_rows(found: Evaluation) -> list[list[str]]:
    """One row for each reversal."""
    rows = []
    for r in found.reversals:
        lasts = NOTHING if r.duration_deg is None else f"{r.duration_deg:.2f}"
        seconds = NOTHING if r.duration_s is None else f"{1000.0 * r.duration_s:.4g}"
        peak = um(r.height_um) if r.seen else NOTHING
        rows.append([f"{r.axis}{r.end}", r.direction.upper(), um(r.step_um), peak, lasts, seconds])
    return rows


def fault_rows(found: Evaluation, least_um: float = 0.0005) -> list[list[str]]:
    """The faults, what draws most first; those that draw nothing are left out."""
    ranked = found.diagnosis.ranked()
    total = sum(f.drawn_um for f in ranked) or 1.0
    rows = []
    for f in ranked:
        if f.um is not None and f.drawn_um < least_um:
            continue
        share = NOTHING if f.um is None else f"{100.0 * f.drawn_um / total:.0f}"
        drawn = NOTHING if f.um is None else um(f.drawn_um)
        rows.append([f.name, um(f.um), um(f.uncertainty_um), drawn, share, _more(f.more)])
    return rows


def _more(values: dict[str, float]) -> str:
    return ", ".join(f"{UNITS[k][0]}{v:.4g} {UNITS[k][1]}" for k, v in values.items() if k in UNITS)


def sentences(found: Evaluation) -> list[str]:
    """The result in words, a line each."""
    d = found.diagnosis
    most = next((f for f in d.ranked() if f.um is not None), None)
    said = []
    if most is not None and most.drawn_um > 0.0:
        said.append(f"{most.name} draws most: {um(most.drawn_um)} um of the circle's deviations, peak to peak")
    said.append(f"no signature explains {um(d.left_rms_um)} um rms, {um(d.left_peak_um)} um at most")
    said.append(f"condition number of the signatures: {d.condition:.3g}; ± is the scatter of the fit alone, one sigma")
    said.append(f"names and quantities of {standard(found.edition)}; {WITHOUT_TEXT}")
    return said


def summary(found: Evaluation, bar: Evaluation | None = None) -> dict[str, Any]:
    """The result as the one JSON object that ``leadscrew ballbar --json`` prints."""
    return {
        "schema_version": SCHEMA_VERSION, "kind": "leadscrew ballbar", "subject": found.test.name,
        "standard": standard(found.edition), "standard_at_hand": False, **found.as_dict(),
        "bar": None if bar is None else bar.as_dict(), "sentences": sentences(found),
    }  # fmt: skip


def write(found: Evaluation, folder: str | Path, bar: Evaluation | None = None) -> None:
    """Writes ``report.html``, ``ballbar.json`` and ``ballbar.png``, complete or not at all.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as beside:
        drawn = picture(found)
        drawn.savefig(beside / "ballbar.png", dpi=130, metadata={"Software": None})
        text = json.dumps(strict(summary(found, bar)), indent=1, allow_nan=False)
        (beside / "ballbar.json").write_text(text + "\n", encoding="utf-8")
        (beside / "report.html").write_text(page(found, drawn, bar), encoding="utf-8")


def page(found: Evaluation, drawn: Figure, bar: Evaluation | None = None) -> str:
    """A page that opens anywhere, offline."""
    title = f"Circular test: {found.test.name}" if found.test.name else "Circular test"
    before = [*conditions(found), *(f"note: {n}" for n in found.notes())]
    columns = QUANTITY_COLUMNS if bar is None else WITH_BAR_COLUMNS
    parts = [
        *html.paragraphs(before),
        html.picture(drawn, "ballbar", "polar plot of the radial deviations"),
        html.table(standard(found.edition), columns, quantity_rows(found, bar)),
        *([] if bar is None else html.paragraphs([f"ball bar: {bar.test.sampling}"])),
        html.table("Faults, by what they draw", FAULT_COLUMNS, fault_rows(found)),
        *html.paragraphs(sentences(found)),
    ]
    if found.reversals:
        parts.append(html.table("Reversals", REVERSAL_COLUMNS, reversal_rows(found)))
    return html.page(title, parts)
