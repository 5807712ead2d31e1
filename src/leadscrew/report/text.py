"""A report on a terminal: tables as wide as it is, lines broken between words, numbers to the right."""

from __future__ import annotations

import os
import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from leadscrew.report.report import Report, Section, TextTable
from leadscrew.util.escape import one_line

PIPED = 100
"""Columns where output does not go to a terminal and ``COLUMNS`` is not set."""
SCREEN = 40
"""Lines that the summary of a report may take where the terminal has :data:`PIPED` columns or more."""
GAP = "  "
SHORT = {"reproduced with a change": "with a change", "not testable here": "not testable"}
"""Verdicts where a summary has one line for each claim; everywhere else they stand in full."""

STYLES = {
    "reproduced": "green",
    "reproduced with a change": "blue",
    "fitted": "magenta",
    "not reproduced": "red",
    "not testable here": "dim",
}
"""Verdicts that a terminal shows in colour; the words themselves always stand there."""


WIDEST = 100_000
"""Columns where no terminal limits them: a row of a table is one line in a pipe."""


def console() -> Console:
    """Standard output."""

    class Quiet(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError(32, "Broken pipe")

    plain = not sys.stdout.isatty()
    return Quiet(width=WIDEST if plain else None, soft_wrap=False, highlight=False, markup=False, emoji=False)


def width() -> int:
    """Columns that a line may take: ``COLUMNS``, else those of the terminal, else :data:`PIPED`."""
    try:
        columns = int(os.environ.get("COLUMNS", ""))
    except ValueError:
        columns = 0
    if columns > 0:
        return max(20, columns)
    return Console().width if sys.stdout.isatty() else PIPED


# ---- lines
def wrapped(text: str, columns: int, indent: str = "") -> list[str]:
    """A paragraph in lines; only a word that is wider than a line is cut."""
    clean = one_line(text.replace("`", ""))
    return textwrap.wrap(clean, columns, subsequent_indent=indent, break_on_hyphens=False) or [""]


def cut(text: str, columns: int) -> str:
    """The text in one line; where it does not fit it ends after a whole word with an ellipsis."""
    clean = one_line(text.replace("`", ""))
    if cell_len(clean) <= columns:
        return clean
    return textwrap.shorten(clean, columns, placeholder=" …", break_on_hyphens=False)


def _lines(cell: str, columns: int) -> list[str]:
    return textwrap.wrap(cell, columns, break_on_hyphens=False) or [""]


def _longest(texts: Iterable[str]) -> int:
    return max(map(cell_len, texts), default=1)


def widths(heads: Sequence[str], rows: Sequence[Sequence[str]], columns: int) -> list[int]:
    """How wide each column of a table is: the widest give way first, down to their longest word.

    Where even the longest words do not fit, these are cut, down to an equal share of the line.
    """
    cells = list(zip(heads, *rows, strict=True))
    got = [_longest(column) for column in cells]
    words = [_longest(word for text in column for word in text.split()) for column in cells]
    left = columns - len(GAP) * (len(heads) - 1)
    share = max(1, left // len(heads))
    for least in (words, [min(word, share) for word in words]):
        while sum(got) > left:
            wide = [k for k in range(len(got)) if got[k] > least[k]]
            if not wide:
                break
            got[max(wide, key=lambda k: got[k])] -= 1
    return got


def _two_lines(cell: str) -> int:
    """The least width at which a text takes two lines at most, and no word is cut."""
    least = max((cell_len(word) for word in cell.split()), default=1)
    return next(w for w in range(least, max(least, cell_len(cell)) + 1) if len(_lines(cell, w)) <= 2)


def table_lines(table: TextTable, columns: int, one_line_each: bool = False) -> list[Text]:
    """The table: heads, a rule, rows; ``one_line_each``: what does not fit in the first column is cut, not wrapped."""
    if table.below:
        return _with_notes(table, columns)
    texts = [[one_line(cell.replace("`", "")) for cell in row] for row in table.rows]
    if one_line_each:
        texts = [[SHORT.get(c, c) if k == table.verdict else c for k, c in enumerate(row)] for row in texts]
        size = [max(map(_two_lines, column)) for column in zip(table.heads, *texts, strict=True)]
        if 0 <= table.verdict < len(size):
            size[table.verdict] = _longest(row[table.verdict] for row in texts)
        size[0] = max(12, columns - sum(size[1:]) - len(GAP) * (len(size) - 1))
        texts = [[cut(row[0], size[0]), *row[1:]] for row in texts]
    else:
        size = widths(table.heads, texts, columns)
    return [
        *_row(table.heads, size, table, head=True),
        Text(GAP.join("─" * w for w in size)),
        *chain.from_iterable(_row(row, size, table) for row in texts),
    ]


def _with_notes(table: TextTable, columns: int) -> list[Text]:
    """The table without its last column: notes, and what is small below first cells, follow each row."""
    short = TextTable(table.heads[:-1], [row[:-1] for row in table.rows], table.numeric[:-1], verdict=table.verdict)
    texts = [[one_line(cell.replace("`", "")) for cell in row] for row in short.rows]
    size = widths(short.heads, texts, columns)
    lines = [*_row(short.heads, size, short, head=True), Text(GAP.join("─" * w for w in size))]
    for whole_row, row, small in zip(table.rows, texts, table.below, strict=True):
        lines += _row(row, size, short)
        for part, style in ((small, "dim"), (whole_row[-1], "")):
            lines += [Text(f"{GAP}{line}", style) for line in wrapped(part, columns - len(GAP)) if line]
    return lines


def _row(cells: Sequence[str], size: Sequence[int], table: TextTable, head: bool = False) -> Iterator[Text]:
    parts = [_lines(cell, room) for cell, room in zip(cells, size, strict=True)]
    height = max(map(len, parts))
    if head:
        parts = [[""] * (height - len(p)) + p for p in parts]
    for at in range(height):
        line = Text()
        for k, (part, room) in enumerate(zip(parts, size, strict=True)):
            text = part[at] if at < len(part) else ""
            space = " " * max(0, room - cell_len(text))
            line.append(GAP if k else "")
            line.append(f"{space}{text}" if table.numeric[k] else f"{text}{space}", _style(cells[k], k, table, head))
        line.rstrip()
        yield line


def _style(cell: str, column: int, table: TextTable, head: bool) -> str:
    if head:
        return "bold"
    full = next((verdict for verdict, short in SHORT.items() if short == cell), cell)
    return STYLES.get(full, "") if column == table.verdict else ""


# ---- a report
def summary(report: Report, columns: int) -> list[Text]:
    """Title, conclusion, key claims and a line an experiment; 40 lines at most where there are 100 columns."""
    lines = _summary(report, columns, brief=False)
    if columns < PIPED or len(lines) <= SCREEN - 2:
        return lines
    return _summary(report, columns, brief=True)


def _summary(report: Report, columns: int, brief: bool) -> list[Text]:
    lines = [Text(t, "bold") for t in wrapped(report.title, columns)]
    lines += map(Text, shortened(report.conclusion, columns, 6 if brief else None))
    if report.key_table is not None:
        lines += [Text(""), *table_lines(report.key_table, columns, one_line_each=brief)]
    below = (
        [cut(t, columns) for t in report.lines]
        if brief
        else [x for t in report.lines for x in wrapped(t, columns, "  ")]
    )
    most = max(2, SCREEN - 3 - len(lines) - min(3, len(report.missed)))
    if brief and len(below) > most:
        below = [*below[: most - 1], f"... and {len(below) - most + 1} more tables: --all prints them"]
    lines += [Text(""), *map(Text, below)] if below else []
    room = max(2, SCREEN - 2 - len(lines)) if brief else None
    return [*lines, *(Text(t, "bold red") for t in limited(report.missed, columns, room))]


def shortened(sentences: Sequence[str], columns: int, most: int | None) -> list[str]:
    """The first sentence in lines, and those after it that fit into ``most`` lines with it."""
    shown = wrapped(sentences[0], columns) if sentences else []
    for count in range(2, len(sentences) + 1):
        longer = wrapped(" ".join(sentences[:count]), columns)
        if most is not None and len(longer) > most:
            break
        shown = longer
    return shown


def limited(missed: Sequence[str], columns: int, room: int | None = None) -> list[str]:
    """The numbers missed, wrapped, in ``room`` lines; the last then says how many more there are."""
    parts = [wrapped(t, columns, "  ") for t in missed]
    if room is None or sum(map(len, parts)) <= room:
        return list(chain.from_iterable(parts))
    shown: list[str] = []
    for at, part in enumerate(parts):
        if len(shown) + len(part) > room - 1:
            return [*shown, f"... and {len(parts) - at} more MISSED: --json has all"]
        shown += part
    return shown


def whole(report: Report, columns: int) -> list[Text]:
    """The summary, then every section that has tables."""
    lines = _summary(report, columns, brief=False)
    for section in report.sections:
        lines += _section(section, columns, "═")
    return lines


def _section(section: Section, columns: int, rule: str) -> Iterator[Text]:
    if not (section.tables or section.sections or section.paragraphs):
        return
    heading = wrapped(section.title, columns)
    yield from (Text(""), *(Text(t, "bold") for t in heading))
    yield Text(rule * min(columns, max(map(cell_len, heading))))
    for paragraph in section.paragraphs:
        yield from map(Text, wrapped(paragraph, columns))
    for table in section.tables:
        yield from (Text(""), *table_lines(table, columns))
    if section.conclusion:
        yield from (Text(""), *map(Text, wrapped(section.conclusion, columns)))
    for below in section.sections:
        yield from _section(below, columns, "─")


def ending(notes: Iterable[str], page: Path, wall_s: float, columns: int) -> Iterator[Text]:
    """The last lines: notes, then the path of the report, which is never broken, and the seconds."""
    for note in notes:
        yield from map(Text, wrapped(note, columns))
    seconds = f"   ({wall_s:.1f} s)"
    name = one_line(str(page))
    if cell_len(name) + len(seconds) <= columns:
        yield Text(name + seconds)
    else:
        yield from (Text(name), Text(seconds.strip()))


def show(lines: Iterable[Text]) -> None:
    """Prints lines on standard output, in colour where it is a terminal, without blanks at their ends."""
    out = console()
    if not out.is_terminal:
        sys.stdout.write("".join(f"{line.plain.rstrip()}\n" for line in lines))
        return
    for line in lines:
        out.print(line, soft_wrap=True)
