"""Following errors for reading: tables, sentences, JSON, CSV, a picture, a page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.analysis.following import ALL, Followed, Following, Told
from leadscrew.figures.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from leadscrew.figures.table import NOTHING, finite, fixed, unit
from leadscrew.report import page as html
from leadscrew.report.report import Report, TextTable, head
from leadscrew.util import escape
from leadscrew.util.atomic import atomic_folder
from leadscrew.util.strict_json import strict

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure


NUMBERS = ("rows", "moving", "max", "rms", "mean forward", "mean backward", "step", "lag (ms)", "±", "Kv (1/s)",
           "shift (ms)", "±", "in order")  # fmt: skip
"""Lags are from the rows ``moving``, shifts from those ``in order``, with their neighbours in one stretch."""
CSV_COLUMNS = (
    "log", "axis", "phase", "unit", "rows", "moving", "max", "rms", "mean_forward", "mean_backward", "rounding_step",
    "top_speed", "lag_ms", "lag_low_ms", "lag_high_ms", "gain_per_s", "gain_low_per_s", "gain_high_per_s", "shift_ms",
    "shift_low_ms", "shift_high_ms", "shift_rows", "note",
)  # fmt: skip


def _told(told: Told, scale: float) -> tuple[str, str]:
    """A value to the decimals that its interval deserves, and half of the interval."""
    half = scale * told.half
    if not np.isfinite(half):
        return NOTHING, NOTHING
    decimals = max(0, 1 - int(np.floor(np.log10(half)))) if half > 0.0 else 3
    return fixed(scale * told.value, decimals), fixed(half, decimals)


def _named(found: Following) -> bool:
    return any(row.unit for row in found.each)


def _values(row: Followed) -> list[str]:
    lag, half = _told(row.lag, 1e3)
    shift, wide = _told(row.shift, 1e3)
    return [
        finite(row.rows), finite(row.moving), finite(row.worst, 3), finite(row.rms, 3), finite(row.mean_forward, 3),
        finite(row.mean_backward, 3), finite(row.step, 3), lag, half, _told(row.gain, 1.0)[0], shift, wide,
        finite(row.shift.rows or None),
    ]  # fmt: skip


def phase_table(found: Following) -> TextTable:
    """Axis and phase, all logs together."""
    return _table(found, "phase", [(row.axis, row.phase, row) for row in found.together], "By axis and phase")


def log_table(found: Following) -> TextTable:
    """Log and axis, all phases together."""
    rows = [(row.axis, Path(row.source).name, row) for row in found.each if row.phase == ALL]
    return _table(found, "log", rows, "By log and axis")


def _table(found: Following, second: str, rows: list[tuple[str, str, Followed]], title: str) -> TextTable:
    named = _named(found)
    return TextTable(
        ("axis", second, *(["unit"] if named else []), *NUMBERS),
        [[axis, what, *([unit(row.unit) or NOTHING] if named else []), *_values(row)] for axis, what, row in rows],
        [False, False, *([False] if named else []), *[True] * len(NUMBERS)],
        title=title,
    )


def odd_table(found: Following) -> TextTable:
    """All that is odd about the logs."""
    rows = [[Path(s).name, f.kind, f.sentence] for s, seen in found.findings.items() for f in seen]
    return TextTable.words(("log", "kind", "what"), rows, title="What is odd about the logs")


def odd(found: Following) -> list[str]:
    """What is odd about the logs, a line a kind: in how many, and the first of them in full."""
    kinds: dict[str, list[tuple[str, str]]] = {}
    for source, findings in found.findings.items():
        for finding in findings:
            kinds.setdefault(finding.kind, []).append((Path(source).name, finding.sentence))
    lines = []
    for kind, seen in kinds.items():
        logs = len({source for source, _ in seen})
        more = f" ({logs} logs have such a note)" if logs > 1 else ""
        lines.append(f"{kind}{more}: {seen[0][0]}: {seen[0][1]}")
    return lines


def sentences(found: Following) -> list[str]:
    """What the numbers mean and what they cannot say."""
    logs, of = len(found.findings), "" if _named(found) else " in the unit of the log"
    lines = [
        f"{logs} log{'s' * (logs > 1)}, a row every {found.period:g} s; error = command - actual{of}; "
        "lag is the slope of error against commanded speed over the rows that move, Kv its inverse, shift the lag of "
        "the velocities over rows in order",
        f"what happens within {found.period:g} s is not in the log: a peak of error as an axis speeds up or reverses "
        "may be larger than max",
    ]
    if any(row.lag.why.startswith("one way") for row in found.together):
        one = sorted({row.axis for row in found.together if row.lag.why.startswith("one way") and row.phase == ALL})
        if one:
            lines.append(f"{', '.join(one)} moved one way only: an offset of the position would count as lag")
    common = _common(found)
    return lines + ([common] if common else [])


def _common(found: Following) -> str:
    """Whether one lag fits all axes: then a delay of the control or of its log, not the gains of the axes."""
    lags = [row.lag for row in found.together if row.phase == ALL and np.isfinite(row.lag.half)]
    if len(lags) < 2:
        return ""
    low, high = max(x.low for x in lags), min(x.high for x in lags)
    if not 0.0 < low <= high:
        return ""
    return (
        f"one lag of {1e3 * low:.3g} to {1e3 * high:.3g} ms lies in the intervals of all {len(lags)} axes: actual "
        "values that are logged that much later would do the same, so Kv is a lower bound of the loops'"
    )


def summary(found: Following) -> dict[str, Any]:
    """The one JSON object of ``leadscrew following-error --json``."""
    return {
        **head("following-error"), "period_s": found.period,
        "logs": list(found.findings), "together": [r.as_dict() for r in found.together],
        "each": [r.as_dict() for r in found.each],
        "findings": {s: [f._asdict() for f in seen] for s, seen in found.findings.items()},
        "sentences": sentences(found),
    }  # fmt: skip


def report_of(found: Following, each: bool = False) -> Report:
    """The report of ``leadscrew following-error``; ``each``: also a table of every log."""
    return Report(
        summary(found),
        parts=[phase_table(found), *([log_table(found)] if each else []), *odd(found), *sentences(found)],
        figure=lambda: picture(found),
        csv=lambda: csv_text(found),
        page=lambda folder: write(found, folder, picture(found)),
    )


def csv_text(found: Following) -> str:
    """All rows, of all logs together and of each."""
    import csv
    import io

    held = io.StringIO()
    out = csv.writer(held, lineterminator="\n")
    out.writerow(CSV_COLUMNS)
    together = found.together if len(found.findings) > 1 else []
    for r in (*together, *found.each):
        lag, gain, shift = (
            ["" if not np.isfinite(x) else f"{s * x:.6g}" for x in t[:3]]
            for s, t in ((1e3, r.lag), (1.0, r.gain), (1e3, r.shift))
        )
        numbers = [r.worst, r.rms, r.mean_forward, r.mean_backward, r.step, r.top_speed]
        plain = ["" if not np.isfinite(x) else f"{x:.6g}" for x in numbers]
        out.writerow([r.source, r.axis, r.phase, r.unit, r.rows, r.moving, *plain, *lag, *gain, *shift, r.shift.rows,
                      r.lag.why])  # fmt: skip
    return held.getvalue()


def write(found: Following, folder: str | Path, figure: Figure) -> None:
    """Writes ``report.html``, ``following_error.json``, ``.csv`` and ``.png``; complete, or not at all.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with atomic_folder(folder) as place:
        figure.savefig(place / "following_error.png", dpi=130, metadata={"Software": None})
        text = json.dumps(strict(summary(found)), indent=1, allow_nan=False)
        (place / "following_error.json").write_text(text + "\n", encoding="utf-8")
        (place / "following_error.csv").write_text(csv_text(found), encoding="utf-8")
        (place / "report.html").write_text(page(found, figure), encoding="utf-8")


def page(found: Following, figure: Figure) -> str:
    """One HTML page with the picture inside."""
    parts = [
        *html.paragraphs(sentences(found)),
        html.picture(figure, "following", "lag and error by axis and phase"),
        html.table(phase_table(found)),
        html.table(log_table(found)),
        html.table(odd_table(found)),
    ]
    return html.page("Following error", parts)


COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)


def picture(found: Following, title: str = "") -> Figure:
    """Left the lag of each axis in each phase, right its errors; positions in the unit of the log."""
    from leadscrew.figures.figure import Figure

    axes_names = list(dict.fromkeys(r.axis for r in found.together))
    phases = list(dict.fromkeys(r.phase for r in found.together))
    figure = Figure(figsize=(10.0, 1.6 + 0.36 * max(len(phases), 4)), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for k, name in enumerate(axes_names):
        rows = [r for r in found.together if r.axis == name]
        at = np.array([phases.index(r.phase) for r in rows]) + 0.7 * ((k + 0.5) / len(axes_names) - 0.5)
        colour = COLOURS[k % len(COLOURS)]
        lags = 1e3 * np.array([r.lag.value for r in rows])
        halves = 1e3 * np.array([r.lag.half for r in rows])
        told = np.isfinite(halves)
        left.errorbar(lags[told], at[told], xerr=halves[told], fmt="o", markersize=3.5, capsize=2, color=colour,
                      label=name)  # fmt: skip
        right.plot([r.rms for r in rows], at, "o", markersize=4, color=colour, label=f"{name}, rms")
        right.plot([r.worst for r in rows], at, "|", markersize=8, color=colour, label=f"{name}, max")
    left.set_yticks(range(len(phases)), phases)
    left.invert_yaxis()
    left.set(xlabel="lag from error at speed, 95 % (ms)")
    spread = [1e3 * x for r in found.together for x in (r.lag.low, r.lag.high) if np.isfinite(x)]
    if spread:
        low, high = np.percentile(spread, [5, 95])
        left.set_xlim(min(0.0, low - 0.2 * (high - low)), high + 0.4 * (high - low) + 1e-9)
    units = sorted({r.unit for r in found.together if r.unit})
    right.set(xscale="symlog", xlabel=f"error ({', '.join(units)})" if units else "error, unit of the log")
    smallest = min((r.rms for r in found.together if r.rms > 0.0), default=1.0)
    right.set_xscale("symlog", linthresh=0.5 * smallest)
    right.set_xlim(0.0, 1.5 * max((r.worst for r in found.together), default=1.0) or 1.0)
    for ax in (left, right):
        ax.grid(color="0.92", linewidth=0.6)
        ax.set_axisbelow(True)
    if title:
        figure.suptitle(escape.figure(title), fontsize="medium")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=2 * len(axes_names), frameon=False, fontsize="small"
    )
    return figure
