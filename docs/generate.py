"""Writes the generated pages: each study from its own run, and the data sheets of all blocks from the catalogue.

    python docs/generate.py            writes docs/studies/generated and docs/reference/generated

Nothing is computed here: claims, figures and notes come from the study, sheets from the blocks. Where the variable
``LEADSCREW_STUDY_PAGES`` is ``keep``, pages that exist stay: in CI the tests have written them of the evaluation that
they judge. A study whose page does not exist is evaluated.
"""

from __future__ import annotations

import csv
import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from leadscrew import catalogue, resolve
from leadscrew.figures import formats
from leadscrew.figures.table import as_typed
from leadscrew.kernel.parameters import entries
from leadscrew.report.report import Picture, Section, StudyReport, TextTable
from leadscrew.report.study import report_of
from leadscrew.studies.results import Results, evaluate
from leadscrew.study_data import Study
from leadscrew.util import escape


def kept() -> bool:
    """Whether pages of studies stay as they are, and none is evaluated."""
    return os.environ.get("LEADSCREW_STUDY_PAGES") == "keep"


def cell(value: object) -> str:
    """A value inside a table of Markdown."""
    text = as_typed(value).replace("\n", " ").replace("<", "&lt;")
    return re.sub(r"([|*_])", r"\\\1", text)


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [" | ".join(head), " | ".join("---" for _ in head), *(" | ".join(map(cell, row)) for row in rows)]
    return "\n".join(f"| {line} |" for line in lines)


def items_table(study: Study) -> str:
    """Every equation, table, figure and experiment of the paper, with what covers it."""
    with (study.folder / "paper_items.csv").open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    return table(head, rows)


# ---- a report as Markdown
def text_cell(text: str) -> str:
    """A cell whose text may hold code in backticks."""
    clean = escape.markdown_doc(text, cell=True)
    parts = re.split("(`[^`]*`)", clean)
    return "".join(part if part.startswith("`") else re.sub(r"(?<!\\)([*_~$])", r"\\\1", part) for part in parts)


def text_table(shown: TextTable) -> str:
    """A table of a report; what is small below a first cell follows it after a line break."""
    below = shown.below or [""] * len(shown.rows)
    lines = [" | ".join(map(text_cell, shown.heads)), " | ".join("---:" if n else "---" for n in shown.numeric)]
    for row, small in zip(shown.rows, below, strict=True):
        first = text_cell(row[0]) + (f"<br><small>{text_cell(small)}</small>" if small else "")
        lines.append(" | ".join([first, *map(text_cell, row[1:])]))
    return "\n".join(f"| {line} |" for line in lines)


def figure(study: str, shown: Picture, folder: Path) -> str:
    """A figure, drawn into ``folder``."""
    file = f"{study}_{shown.name}.svg"
    shown.draw().savefig(folder / file, metadata={"Date": None})
    return f":::{{figure}} {file}\n{escape.markdown_doc(shown.caption)}\n:::"


def section(shown: Section, study: str, folder: Path, level: int = 2) -> Iterator[str]:
    """A section of a report, and those below it."""
    yield f"{'#' * level} {shown.title}"
    yield from map(escape.markdown_doc, shown.paragraphs)
    yield from map(text_table, shown.tables)
    if shown.conclusion:
        yield f"**{escape.markdown_doc(shown.conclusion)}**"
    for picture in shown.pictures:
        yield figure(study, picture, folder)
    for below in shown.sections:
        yield from section(below, study, folder, level + 1)


def report_parts(report: StudyReport, folder: Path) -> Iterator[str]:
    """Conclusion, key figure, key claims, and the sections but that of the runs, which only a report has."""
    yield escape.markdown_doc(" ".join(report.conclusion))
    if report.key_picture is not None:
        yield figure(report.name, report.key_picture, folder)
    if report.key_table is not None:
        yield from (f"## {report.key_title}", text_table(report.key_table))
    yield ", ".join(f"{n} {verdict}" for verdict, n in report.counts.items()) + "."
    for shown in report.sections:
        if shown.anchor != "runs":
            yield from section(shown, report.name, folder)


def study_page(study: Study, folder: Path, result: Results) -> str:
    """The page of a study; its figures go to ``folder``."""
    parts = [
        f"# {study.title}",
        f"{study.paper}",
        study.summary,
        f"```console\n$ leadscrew run {study.name}\n$ leadscrew list {study.name}\n```",
        *report_parts(report_of(result), folder),
    ]
    parts += ["## Controllers", table(["name", "block", "what it is"], (
        (name, block.name, formats.first_line(block.doc)) for name, block in study.controllers.items()
    ))]  # fmt: skip
    parts += ["## Scenarios", table(["name", "seconds", "what it asks"], (
        (s.name, s.duration_s, s.doc) for s in study.scenarios.values()
    ))]  # fmt: skip
    parts += ["## The paper, item by item", items_table(study)]
    return "\n\n".join(filter(None, parts)) + "\n"


def blocks_page() -> str:
    """The data sheets of all blocks that have a name."""
    parts = [
        "# Blocks by name",
        "What `leadscrew list` shows: every block, its parameters, units, defaults and ranges.",
    ]
    found = [(name, resolve.block(name)) for name in catalogue.BLOCKS]
    for kind in dict.fromkeys(block.kind for _, block in found):
        parts.append(f"## {kind.capitalize()}s")
        for name, block in found:
            if block.kind != kind:
                continue
            module = catalogue.BLOCKS[name].split(":")[0]
            parts += [f"### {name}", f"{formats.first_line(block.doc)} In `{module}`."]
            rows = [(e.key, e.default, e.unit, e.range, e.doc) for e in entries(block.params)]
            if rows:
                parts.append(table(["parameter", "default", "unit", "range", "meaning"], rows))
    return "\n\n".join(parts) + "\n"


def write(file: Path, text: str) -> None:
    """Writes a page unless it stands there already, so that Sphinx need not read it again."""
    file.parent.mkdir(parents=True, exist_ok=True)
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        beside = file.with_suffix(".partial")
        beside.write_text(text, encoding="utf-8", newline="\n")
        beside.replace(file)


def everything(docs: Path) -> None:
    """All generated pages."""
    write(docs / "reference" / "generated" / "blocks_by_name.md", blocks_page())
    for name in catalogue.STUDIES:
        if not (kept() and page_of(docs, name).exists()):
            study = resolve.study(name)
            write_study(docs, study, evaluate(study))


def page_of(docs: Path, name: str) -> Path:
    """Where the page of a study lies."""
    return docs / "studies" / "generated" / f"{name}.md"


def write_study(docs: Path, study: Study, result: Results) -> None:
    """The page of a study, of an evaluation of it; the page itself comes last."""
    page = page_of(docs, study.name)
    page.parent.mkdir(parents=True, exist_ok=True)
    write(page, study_page(study, page.parent, result))


if __name__ == "__main__":
    everything(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
