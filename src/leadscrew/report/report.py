"""A report: the result of a command in words, tables, figures and data. Terminal, HTML, Markdown and JSON print it.

Texts may hold code in backticks, and nothing else that a printer has to understand.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from leadscrew.figures.table import NOTHING, Table

if TYPE_CHECKING:
    from rich.text import Text

    from leadscrew.figures.figure import Figure

KIND = "leadscrew report"
"""``kind`` in the JSON of a study's report."""


def head(command: str, version: int = 1) -> dict[str, Any]:
    """What the JSON of a command begins with: the version of its keys, and whose it is."""
    return {"schema_version": version, "kind": f"leadscrew {command}"}


_NUMBER = re.compile(r"[+±−-]?[\d,]*\.?\d+(e[+-]?\d+)?( of [\d,]+)?( ?[^\s\d][^\s,]*)?")
"""A number, alone, with its unit, or with what it is a part of."""


@dataclass(frozen=True)
class TextTable:
    """A table ready to print: its cells are texts.

    Args:
        heads: heads of the columns.
        rows: the cells of each row.
        numeric: which columns hold numbers; those stand to the right. By default those of numbers alone, the first of
            them excepted where it holds a name.
        title: a heading on a page; a terminal prints none.
        below: for each row a small text below its first cell, as an id; or none at all. Where there are such, the last
            column holds notes: a terminal writes both below the row.
        ids: for each row the anchor that a page gives it; or none at all.
        verdict: the column that holds verdicts; -1: none.
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: Sequence[bool] = ()
    below: Sequence[str] = ()
    ids: Sequence[str] = ()
    verdict: int = -1
    title: str = ""

    def __post_init__(self) -> None:
        if len(self.numeric) != len(self.heads):
            columns = [[row[k] for row in self.rows] for k in range(len(self.heads))]
            object.__setattr__(self, "numeric", [_numbers(column) for column in columns])

    @classmethod
    def of(cls, table: Table) -> TextTable:
        """The table of an experiment."""
        return cls(table.heads(), table.cells(), table.numeric())

    @classmethod
    def words(cls, heads: Sequence[str], rows: Sequence[Sequence[str]], title: str = "") -> TextTable:
        """A table without a column of numbers."""
        return cls(heads, rows, [False] * len(heads), title=title)


def _numbers(cells: Sequence[str]) -> bool:
    """Whether a column holds numbers: every cell that is not empty, and one at least."""
    filled = [cell for cell in cells if cell not in ("", NOTHING)]
    return bool(filled) and all(_NUMBER.fullmatch(cell) or cell == "never" for cell in filled)


@dataclass(frozen=True)
class Picture:
    """A figure, drawn when a page asks for it."""

    name: str
    caption: str
    draw: Callable[[], Figure]


@dataclass(frozen=True)
class Section:
    """A heading, and what stands below it: paragraphs, tables, figures, a conclusion, sections of its own."""

    title: str
    paragraphs: Sequence[str] = ()
    tables: Sequence[TextTable] = ()
    pictures: Sequence[Picture] = ()
    conclusion: str = ""
    sections: Sequence[Section] = ()
    anchor: str = ""


class KeyNumber(NamedTuple):
    """One of the numbers on a report's card: ``0.2331 µm``, and what it is."""

    value: str
    what: str


@dataclass(frozen=True)
class StudyReport:
    """The result of a study: what its page shows, and a terminal in short."""

    name: str
    title: str
    citation: str = ""
    conclusion: Sequence[str] = ()
    """What follows, in about three sentences; stands above everything else."""
    key_table: TextTable | None = None
    key_title: str = "Key claims"
    key_picture: Picture | None = None
    key_numbers: Sequence[KeyNumber] = ()
    lines: Sequence[str] = ()
    """What a terminal prints below the key table, one line each."""
    sections: Sequence[Section] = ()
    counts: Mapping[str, int] = field(default_factory=dict)
    """How many claims have each verdict."""
    notes: Sequence[str] = ()
    missed: Sequence[str] = ()
    """Numbers that are not the expected ones, a sentence each."""
    data: Mapping[str, Any] = field(default_factory=dict)
    """The result for JSON."""
    command: str = ""
    """The command that makes it again."""
    kind: str = KIND

    def pictures(self) -> Iterator[Picture]:
        """All pictures, the key picture first."""

        def below(sections: Sequence[Section]) -> Iterator[Picture]:
            for section in sections:
                yield from section.pictures
                yield from below(section.sections)

        if self.key_picture is not None:
            yield self.key_picture
        yield from below(self.sections)


class Lines(list[str]):
    """Lines of a text that has its own form: equations, a program, a docstring; only a long line is wrapped."""


class Verbatim(list[str]):
    """Lines for a program or to be copied: never wrapped."""


Part = str | TextTable | Lines | Verbatim | Callable[[int], Iterable["Text"]]
"""A sentence, a table, lines of a text, or what makes lines for a number of columns."""


class File(NamedTuple):
    """A file or folder that a command was asked to write."""

    key: str
    """Its key in JSON."""
    path: Path | None
    """None where it was not asked for."""
    what: str
    """What is in it, and what it is good for."""
    write: Callable[[Path], object] | None = None
    """Writes it; without, the command has written it."""


@dataclass(frozen=True)
class Report:
    """The result of a command.

    Args:
        data: for JSON; see :func:`head`.
        parts: what a terminal prints, in that order.
        verdict: one sentence; below the parts, or on stderr where the command fails.
        notes: what a reader should know besides; on stderr, each behind ``leadscrew: note:``.
        files: what is written.
        page: writes the folder of the report, with a page.
        figure: draws the picture.
        csv: makes the table of all rows.
        code: exit code.
    """

    data: Mapping[str, Any]
    parts: Sequence[Part] = ()
    verdict: str = ""
    notes: Sequence[str] = ()
    files: Sequence[File] = ()
    page: Callable[[Path], object] | None = None
    figure: Callable[[], Figure] | None = None
    csv: Callable[[], str] | None = None
    code: int = 0
