"""The report of a study as one HTML file that opens anywhere, offline: figures and style are inside."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from leadscrew.escape import visible
from leadscrew.report import tables

if TYPE_CHECKING:
    from jinja2 import Template
    from matplotlib.figure import Figure

    from leadscrew.studies.study import Picture, Study, StudyResult

LARGEST_SVG = 600_000
"""Bytes; a figure with more points than that is embedded as a picture of 160 dots an inch."""


def embedded(figure: Figure, name: str) -> str:
    """A figure as the ``src`` of an image; the same figure gives the same text."""
    from matplotlib import rc_context

    buffer = io.BytesIO()
    with rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    kind = "svg+xml"
    if buffer.tell() > LARGEST_SVG:
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=160)
        kind = "png"
    return f"data:image/{kind};base64,{base64.b64encode(buffer.getvalue()).decode('ascii')}"


def template(name: str, **filters: Callable[..., str]) -> Template:
    """A template of pages; every value in it is escaped for HTML."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("leadscrew.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, finalize=lambda value: visible(value) if type(value) is str else value,
    )  # fmt: skip
    environment.filters |= filters
    return environment.get_template(name)


def render(
    study: Study,
    result: StudyResult,
    *,
    manifest: Mapping[str, Any],
    folders: Mapping[str, str],
    pictures: Sequence[Picture] = (),
) -> str:
    """The page. ``folders`` are the run folders beside it, by the key of the run."""
    drawn = [(p.name, p.caption, embedded(p.draw(), p.name)) for p in pictures]
    topics = [
        (title, [[(c, tables.three_columns(c), tables.target(c), tables.met(c)) for c in part]
                 for part in tables.of_the_paper(claims)])
        for title, claims in result.by_topic()
    ]  # fmt: skip
    runs = [
        (key, folders[key], run.duration, run.diverged, tables.metric_rows(run))
        for key, run in result.runs.items()
        if key in folders
    ]
    return template("report.html.j2", number=tables.number).render(
        study=study, result=result, topics=topics, tally=tables.tally(result.claims),
        missed=tables.missed(result.claims), pictures=drawn, runs=runs, manifest=manifest,
    )  # fmt: skip
