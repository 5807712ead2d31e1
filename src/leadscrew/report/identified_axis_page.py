"""The report folder of an identified axis: page, pictures, JSON, and the machine file."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from leadscrew.newfolder import appearing
from leadscrew.report import identified_axis as tables
from leadscrew.report import page as html
from leadscrew.report.identified_axis_picture import pictures
from leadscrew.report.identified_axis_words import notes, sentences
from leadscrew.report.strict import strict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from leadscrew.identify.axis.result import AxisFit

MACHINE = "axis.toml"


def write(
    fit: AxisFit, folder: str | Path, machine: Callable[[Path], object] | None = None, findings: Sequence[str] = ()
) -> None:
    """Writes ``report.html``, ``axis.json``, the pictures as PNG, and the machine file ``axis.toml`` by ``machine``.

    Complete, or not at all.

    Args:
        fit: what was found.
        folder: new, or empty.
        machine: writes the machine file to the path that it is given; none is written without.
        findings: what the check of the log said, for the page.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    with appearing(folder) as place:
        if machine is not None:
            machine(place / MACHINE)
        drawn = pictures(fit)
        for name, (_, figure) in drawn.items():
            figure.savefig(place / f"{name}.png", dpi=120, metadata={"Software": None})
        found = strict({**tables.summary(fit), "findings": list(findings)})
        (place / "axis.json").write_text(json.dumps(found, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        page = page_of(fit, drawn, findings, machine is not None)
        (place / "report.html").write_text(page, encoding="utf-8", newline="\n")


def page_of(
    fit: AxisFit, drawn: dict[str, tuple[str, Figure]], findings: Sequence[str] = (), with_machine: bool = False
) -> str:
    """The page as one HTML file, pictures inside."""
    title = f"Identified axis: {Path(fit.source).name}"
    parts = [
        *html.paragraphs(sentences(fit)),
        html.bullets("Notes", notes(fit, findings)),
        html.bullets("What to measure next", fit.advice),
        html.table("Parameters", tables.PARAMETER_COLUMNS, tables.parameter_rows(fit), tables.NUMBERS),
        '<p class="quiet">Intervals are of 95 %. A parameter that is fixed or given has none.</p>',
        html.table("Errors by part of the log", tables.SCORE_COLUMNS, tables.score_rows(fit), tables.NUMBERS),
        '<p class="quiet">Position: simulated from the drive alone, from the measured state at the start of the part. '
        "Force: what inverse dynamics leaves. White: share of its autocorrelations within the bounds of white noise, "
        "95 % for noise alone.</p>",
        *(html.picture(figure, name, caption, caption) for name, (caption, figure) in drawn.items()),
    ]
    if fit.compared:
        parts.append(html.table("Models compared", *tables.compared_table(fit), right=tables.NUMBERS))
    if len(fit.correlation) > 1:
        parts.append(html.table("Correlation of the estimates", *tables.correlation_table(fit), right=tables.NUMBERS))
    parts.append(html.table("The log", tables.RECORD_COLUMNS, tables.record_rows(fit), tables.NUMBERS))
    if with_machine:
        parts.append(f"<p><code>{MACHINE}</code>, beside this page, is the axis as a machine file: a name wherever a "
                     "study is named.</p>")  # fmt: skip
    return html.page(title, parts)
