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

from leadscrew.analysis.circular.diagnosis import GAINED, LOST
from leadscrew.analysis.circular.evaluation import Evaluation
from leadscrew.analysis.circular.paths import SOURCES, Circle
from leadscrew.analysis.circular.quantities import about
from leadscrew.figures.ballbar import COLOURS, WORDS, division_um, polar
from leadscrew.figures.table import fixed, number
from leadscrew.report import page as html
from leadscrew.report.report import Report, TextTable, head
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


WITHOUT_TEXT = "its text was not at hand: public abstracts and summaries were followed"
UNITS = {
    "ppm": ("", "ppm"),
    "urad": ("", "µrad"),
    "ms": ("", "ms"),
    "lead_mm": ("lead ", "mm"),
    "rise_deg": ("rise ", "°"),
    "decay_deg": ("decay ", "°"),
    "period_deg": ("period ", "°"),
    "zone_deg": ("within ", "°"),
    "part_percent": ("", "% of it"),
    "gain_1_s": ("as at a velocity gain of ", "1/s"),
}
"""What a fault's further values are called, and their units."""


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


def quantity_table(found: Evaluation, bar: Evaluation | None = None) -> TextTable:
    """The quantities of the edition; with what the bar reads beside them."""
    rows = [[n.name, n.symbol, fixed(n.value, 3)] for n in found.named()]
    title = standard(found.edition)
    if bar is None:
        return TextTable(("quantity", "", "µm"), rows, title=title)
    rows = [[*row, fixed(other.value, 3)] for row, other in zip(rows, bar.named(), strict=True)]
    return TextTable(("quantity", "", "true path (µm)", "ball bar (µm)"), rows, title=title)


def reversal_table(found: Evaluation) -> TextTable:
    """One row for each reversal."""
    rows = []
    for r in found.reversals:
        seconds = None if r.duration_s is None else 1000.0 * r.duration_s
        peak = r.height_um if r.seen else None
        rows.append([f"{r.axis}{r.end}", r.direction.upper(), fixed(r.step_um, 3), fixed(peak, 3),
                     fixed(r.duration_deg, 2), number(seconds)])  # fmt: skip
    heads = ("reversal", "direction", "step (µm)", "peak (µm)", "lasts (°)", "lasts (ms)")
    return TextTable(heads, rows, title="Reversals")


def fault_table(found: Evaluation, least_um: float = 0.0005) -> TextTable:
    """The faults, what draws most first; those that draw nothing are left out."""
    ranked = found.diagnosis.ranked()
    total = sum(f.drawn_um for f in ranked) or 1.0
    rows = []
    for f in ranked:
        if f.um is not None and f.drawn_um < least_um:
            continue
        known = f.um is not None
        share, drawn = (100.0 * f.drawn_um / total, f.drawn_um) if known else (None, None)
        rows.append([f.name, fixed(f.um, 3), fixed(f.uncertainty_um, 3), fixed(drawn, 3), fixed(share, 0),
                     _more(f.more)])  # fmt: skip
    heads = ("fault", "size (µm)", "±", "draws (µm)", "share (%)", "which is")
    return TextTable(heads, rows, [False, *[True] * 4, False], title="Faults, by what they draw")


def _more(values: dict[str, float]) -> str:
    return ", ".join(f"{UNITS[k][0]}{number(v)} {UNITS[k][1]}" for k, v in values.items() if k in UNITS)


def sentences(found: Evaluation) -> list[str]:
    """The result in words, a line each."""
    d = found.diagnosis
    most = next((f for f in d.ranked() if f.um is not None), None)
    lines = []
    if most is not None and most.name in (LOST, GAINED):
        lines.append(f"{most.name}: {fixed(most.drawn_um, 3)} µm; the scale errors are what the axes differ by")
    elif most is not None and most.drawn_um > 0.0:
        lines.append(f"{most.name} draws most: {fixed(most.drawn_um, 3)} µm of the circle's deviations, peak to peak")
    lines.append(f"no signature explains {fixed(d.left_rms_um, 3)} µm rms, {fixed(d.left_peak_um, 3)} µm at most")
    lines.append(f"condition number of the signatures: {d.condition:.3g}; ± is the scatter of the fit alone, one sigma")
    lines.append(f"names and quantities of {standard(found.edition)}; {WITHOUT_TEXT}")
    return lines


def summary(found: Evaluation, bar: Evaluation | None = None) -> dict[str, Any]:
    """The result as the one JSON object that ``leadscrew ballbar --json`` prints."""
    return {
        **head("ballbar"), "subject": found.test.name,
        "standard": standard(found.edition), "standard_at_hand": False, **found.as_dict(),
        "bar": None if bar is None else bar.as_dict(), "sentences": sentences(found),
    }  # fmt: skip


def report_of(found: Evaluation, bar: Evaluation | None = None) -> Report:
    """The report of ``leadscrew ballbar``."""
    read = [] if bar is None else [f"ball bar: {bar.test.sampling}"]
    return Report(
        summary(found, bar),
        parts=[
            *conditions(found), *read, quantity_table(found, bar), fault_table(found),
            *([reversal_table(found)] if found.reversals else []), *sentences(found),
        ],
        notes=found.notes(),
        page=lambda folder: write(found, folder, bar),
    )  # fmt: skip


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
    parts = [
        *html.paragraphs(before),
        html.picture(drawn, "ballbar", "polar plot of the radial deviations"),
        html.table(quantity_table(found, bar)),
        *([] if bar is None else html.paragraphs([f"ball bar: {bar.test.sampling}"])),
        html.table(fault_table(found)),
        *html.paragraphs(sentences(found)),
    ]
    if found.reversals:
        parts.append(html.table(reversal_table(found)))
    return html.page(title, parts)
