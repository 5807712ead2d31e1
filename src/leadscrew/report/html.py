"""A report as one HTML file that opens anywhere, offline: figures and style are inside."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from leadscrew.util.escape import html as escaped
from leadscrew.util.escape import visible

if TYPE_CHECKING:
    from jinja2 import Template
    from markupsafe import Markup

    from leadscrew.figures.figure import Figure
    from leadscrew.report.drawing import Drawn
    from leadscrew.report.report import StudyReport

LARGEST_SVG = 600_000
"""Bytes; a figure with more points than that is embedded as a picture of 160 dots an inch."""


def embedded(figure: Figure, name: str) -> str:
    """A figure as the ``src`` of an image; the same figure gives the same text."""
    from matplotlib import rc_context

    buffer = io.BytesIO()
    layout = figure.get_layout_engine()
    if layout is not None:  # arranged here once: savefig would draw the whole figure for it, and then once more
        figure.set_dpi(72)
        layout.execute(figure)
        figure.set_layout_engine("none")
    with rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    kind = "svg+xml"
    if buffer.tell() > LARGEST_SVG:
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=160)
        kind = "png"
    return f"data:image/{kind};base64,{base64.b64encode(buffer.getvalue()).decode('ascii')}"


def template(name: str, **filters: Callable[..., Any]) -> Template:
    """A template of pages; every value in it is escaped for HTML."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("leadscrew.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, finalize=lambda value: visible(value) if type(value) is str else value,
    )  # fmt: skip
    environment.filters |= filters
    return environment.get_template(name)


PX_PER_INCH = 84
"""Width that a figure keeps on a narrow window: a text of 7 points is then 8 pixels high."""


def code(text: str) -> Markup:
    """A text, escaped; what stands in backticks is code."""
    from markupsafe import Markup

    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", escaped(text)))


def _without(report: StudyReport, figures: Mapping[str, Drawn]) -> StudyReport:
    """The report with the pictures that are drawn alone, and without a section that has nothing else."""
    sections = []
    for section in report.sections:
        left = replace(section, pictures=[p for p in section.pictures if p.name in figures])
        if not section.pictures or left.pictures or left.tables or left.sections or left.paragraphs:
            sections.append(left)
    key = report.key_picture
    return replace(report, sections=sections, key_picture=key if key is not None and key.name in figures else None)


def page(report: StudyReport, manifest: Mapping[str, Any], figures: Mapping[str, Drawn]) -> str:
    """The page of a report; pictures that are not in ``figures`` are left out."""
    from leadscrew.studies.claims import VERDICTS

    report = _without(report, figures)
    captions = {p.name: p.caption for p in report.pictures()}
    pictures = {
        name: {
            "name": name,
            "caption": caption,
            "source": figures[name].source,
            "least_px": round(PX_PER_INCH * figures[name].width_in),
            "own_px": round(96 * figures[name].width_in),
        }
        for name, caption in captions.items()
    }
    return template("study.html.j2", code=code).render(
        report=report, manifest=manifest, pictures=pictures, verdicts=list(VERDICTS)
    )
