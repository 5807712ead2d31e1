"""A report: what a command found, in words, tables and figures. Pure data; terminal, HTML, Markdown and JSON print it.

Texts may hold code in backticks, and nothing else that a printer has to understand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from leadscrew.figures.table import Table

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

KIND = "leadscrew report"
"""``kind`` in the JSON of a report."""


@dataclass(frozen=True)
class TextTable:
    """A table ready to print: its cells are texts.

    Args:
        heads: heads of the columns.
        rows: the cells of each row.
        numeric: which columns hold numbers; those stand to the right.
        below: for each row a small text below its first cell, as an id; or none at all. Where there are such, the last
            column holds notes: a terminal writes both below the row.
        ids: for each row the anchor that a page gives it; or none at all.
        verdict: the column that holds verdicts; -1: none.
    """

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: Sequence[bool]
    below: Sequence[str] = ()
    ids: Sequence[str] = ()
    verdict: int = -1

    @classmethod
    def of(cls, table: Table) -> TextTable:
        """The table of an experiment."""
        return cls(table.heads(), table.cells(), table.numeric())

    @classmethod
    def words(cls, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> TextTable:
        """A table without a column of numbers."""
        return cls(heads, rows, [False] * len(heads))


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
class Report:
    """The result of a command."""

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
