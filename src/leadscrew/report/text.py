"""A report on a terminal: tables as wide as it is, lines broken between words, numbers to the right."""

from __future__ import annotations

import os
import re
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from leadscrew.report.report import File, Lines, Part, Report, Section, StudyReport, TextTable, Verbatim
from leadscrew.util.escape import visible

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


NAME = 24
"""Columns that a name in the first column keeps, where it has more words than that."""
PROSE = (20, 12)
"""Columns that prose in the others keeps, if that is less than half of it; the second where a table is tight."""
MOST_ROWS = 2000
"""Of a table that is printed."""


def console() -> Console:
    """Standard output."""

    class Quiet(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError(32, "Broken pipe")

    return Quiet(soft_wrap=False, highlight=False, markup=False, emoji=False)


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
def clean(text: str) -> str:
    """A text in one line, without the marks of code; control characters are shown, not sent."""
    return " ".join(visible(text.replace("`", "")).split())


def wrapped(text: str, columns: int, indent: str = "") -> list[str]:
    """A paragraph in lines; no word is cut: one that is wider than a line stands alone in its own."""
    return _lines(clean(text), columns, indent)


def cut(text: str, columns: int) -> str:
    """The text in one line; where it does not fit it ends after a whole word with an ellipsis."""
    line = clean(text)
    if cell_len(line) <= columns:
        return line
    return textwrap.shorten(line, columns, placeholder=" …", break_on_hyphens=False)


def _lines(cell: str, columns: int, indent: str = "") -> list[str]:
    rule = textwrap.TextWrapper(
        max(1, columns), subsequent_indent=indent, break_on_hyphens=False, break_long_words=False
    )
    return rule.wrap(cell) or [""]


def _widest(texts: Iterable[str]) -> int:
    return max(map(cell_len, texts), default=1)


def long_line(line: str, columns: int) -> list[str]:
    """A line of a text as it is; one that is too long is wrapped, below its last column where it has some."""
    if cell_len(line) <= columns:
        return [line]
    start = len(line) - len(line.lstrip()) + len(GAP)
    column = max((gap.end() for gap in re.finditer(r"(?<=\S) {2,}(?=\S)", line)), default=start)
    indent = " " * (column if column <= 0.7 * columns else start)
    rule = textwrap.TextWrapper(
        columns, subsequent_indent=indent, break_on_hyphens=False, break_long_words=False, replace_whitespace=False
    )
    return rule.wrap(line)


# ---- tables
def table_lines(table: TextTable, columns: int, one_line_each: bool = False) -> list[Text]:
    """The table: heads, a rule, rows.

    Cells wrap between words; a table that is too wide even so is printed in blocks of columns, each with the first
    column. ``one_line_each``: what does not fit in the first column is cut, not wrapped.
    """
    table = replace(table, heads=[clean(head) for head in table.heads])
    if table.below:
        return _with_notes(table, columns)
    texts = [[clean(cell) for cell in row] for row in table.rows]
    if one_line_each:
        texts = [[SHORT.get(c, c) if k == table.verdict else c for k, c in enumerate(row)] for row in texts]
        size = [max(map(_two_lines, column)) for column in zip(table.heads, *texts, strict=True)]
        if 0 <= table.verdict < len(size):
            size[table.verdict] = _widest(row[table.verdict] for row in texts)
        size[0] = max(12, columns - sum(size[1:]) - len(GAP) * (len(size) - 1))
        texts = [[cut(row[0], size[0]), *row[1:]] for row in texts]
        return _block(replace(table, rows=texts), size)
    hidden = len(texts) - MOST_ROWS
    whole = replace(table, rows=texts[:MOST_ROWS])
    whole = _only(whole, [k for k, column in enumerate(_columns(whole)) if any(column)])
    lines: list[Text] = []
    for block in _blocks(whole, columns) if whole.heads else ():
        lines += [Text(""), *_block(block, _sizes(block, columns))] if lines else _block(block, _sizes(block, columns))
    return lines if hidden <= 0 else [*lines, Text(f"... and {hidden} more rows: --json has all")]


def _columns(table: TextTable) -> list[tuple[str, ...]]:
    return list(zip(table.heads, *table.rows, strict=True))


def _narrowest(table: TextTable, columns: int) -> list[int]:
    """How narrow each column may become: numbers not at all, words to the longest, prose to some words more."""

    def narrowest(k: int, column: Sequence[str], prose: int) -> int:
        word = _widest(word for text in column for word in text.split())
        if table.numeric[k]:
            return max(word, _widest(column[1:]))
        return max(word, min(NAME, _widest(column)) if k == 0 else min(prose, -(-_widest(column) // 2)))

    for prose in PROSE:
        least = [narrowest(k, column, prose) for k, column in enumerate(_columns(table))]
        if _total(least) <= columns:
            break
    return least


def _total(sizes: Sequence[int]) -> int:
    return sum(sizes) + len(GAP) * (len(sizes) - 1)


def _blocks(table: TextTable, columns: int) -> Iterator[TextTable]:
    """The table in as few parts as it needs, about as wide each; the names before the numbers stand in all of them."""
    least = _narrowest(table, columns)
    names = list(table.numeric).index(True) if True in table.numeric else 1
    names = names if names > 0 and _total(least[:names]) <= columns // 2 else 1
    if _total(least) <= columns or len(least) < names + 2:
        yield table
        return
    few = len(_groups(least, columns, names))
    room = next(w for w in range(min(columns, max(least)), columns + 1) if len(_groups(least, w, names)) == few)
    yield from (_only(table, group) for group in _groups(least, room, names))


def _only(table: TextTable, columns: Sequence[int]) -> TextTable:
    """The table with these columns alone."""
    return TextTable(
        [table.heads[k] for k in columns],
        [[row[k] for k in columns] for row in table.rows],
        [table.numeric[k] for k in columns],
        verdict=columns.index(table.verdict) if table.verdict in columns else -1,
    )


def _groups(least: Sequence[int], columns: int, names: int) -> list[list[int]]:
    """Columns that fit beside one another, each group with the columns of names and another one at least."""
    groups = [list(range(names))]
    for k in range(names, len(least)):
        if len(groups[-1]) > names and _total([least[j] for j in (*groups[-1], k)]) > columns:
            groups.append(list(range(names)))
        groups[-1].append(k)
    return groups


def _sizes(table: TextTable, columns: int) -> list[int]:
    """How wide each column is: all that hold words give way in proportion, down to :func:`_narrowest`."""
    wide, least = [_widest(column) for column in _columns(table)], _narrowest(table, columns)
    got = list(wide)
    while _total(got) > columns:
        some = [k for k in range(len(got)) if got[k] > least[k]]
        if not some:
            break
        got[max(some, key=lambda k: (got[k] / wide[k], got[k]))] -= 1
    return got


def _block(table: TextTable, size: Sequence[int]) -> list[Text]:
    return [
        *_row(table.heads, size, table, head=True),
        Text(GAP.join("─" * w for w in size)),
        *chain.from_iterable(_row(row, size, table) for row in table.rows),
    ]


def _two_lines(cell: str) -> int:
    """The least width at which a text takes two lines at most, and no word is cut."""
    least = max((cell_len(word) for word in cell.split()), default=1)
    return next(w for w in range(least, max(least, cell_len(cell)) + 1) if len(_lines(cell, w)) <= 2)


def _with_notes(table: TextTable, columns: int) -> list[Text]:
    """The table without its last column: notes, and what is small below first cells, follow each row."""
    texts = [[clean(cell) for cell in row[:-1]] for row in table.rows]
    short = TextTable(table.heads[:-1], texts, table.numeric[:-1], verdict=table.verdict)
    if len(list(_blocks(short, columns))) > 1:
        return table_lines(replace(table, below=()), columns)
    size = _sizes(short, columns)
    lines = _block(replace(short, rows=[]), size)
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
    return STYLES.get(full, "") if column == table.verdict else "bold red" if cell == "NO" else ""


# ---- a command's report
def steps(*parts: tuple[str, Iterable[str]]) -> Callable[[int], Iterator[Text]]:
    """Numbered steps: a name each, and what was done in it, indented; only what is too long for a line is wrapped."""

    def lines(columns: int) -> Iterator[Text]:
        for n, (name, body) in enumerate(parts, start=1):
            yield from ([Text("")] if n > 1 else [])
            yield Text(f"{n}. {name}")
            for line in body:
                yield from (Text(f"   {x}".rstrip()) for x in long_line(line, columns - 3))

    return lines


def printed(report: Report, columns: int) -> Iterator[Text]:
    """The parts of a report, its verdict where it is a good one, and its files, a line each."""
    before: Part | None = None
    for part in [*report.parts, *([report.verdict] if report.verdict and not report.code else [])]:
        if before is not None and not (isinstance(before, str) and isinstance(part, str)):
            yield Text("")
        yield from _part(part, columns)
        before = part
    said = [line for file in report.files if file.path is not None for line in _file(file, columns)]
    yield from ([Text("")] if said and before is not None else [])
    yield from said


def _part(part: Part, columns: int) -> Iterable[Text]:
    if isinstance(part, TextTable):
        return table_lines(part, columns)
    if isinstance(part, str):
        return map(Text, wrapped(part, columns, GAP))
    if isinstance(part, Lines):
        return (Text(x) for line in part for x in long_line(line, columns))
    return map(Text, part) if isinstance(part, Verbatim) else part(columns)


def _file(file: File, columns: int) -> Iterable[Text]:
    """A path, which is never cut, and what is there."""
    rule = textwrap.TextWrapper(
        columns, initial_indent=f"{clean(str(file.path))}: ", subsequent_indent=GAP, break_on_hyphens=False,
        break_long_words=False,
    )  # fmt: skip
    return map(Text, rule.wrap(clean(file.what)))


# ---- a study's report
def summary(report: StudyReport, columns: int) -> list[Text]:
    """Title, conclusion, key claims and a line an experiment; 40 lines at most where there are 100 columns."""
    lines = _summary(report, columns, brief=False)
    if columns < PIPED or len(lines) <= SCREEN - 3:
        return lines
    return _summary(report, columns, brief=True)


def _summary(report: StudyReport, columns: int, brief: bool) -> list[Text]:
    lines = [Text(t, "bold") for t in wrapped(report.title, columns)]
    lines += map(Text, shortened(report.conclusion, columns, 6 if brief else None))
    if report.key_table is not None:
        lines += [Text(""), *table_lines(report.key_table, columns, one_line_each=brief)]
    below = (
        [cut(t, columns) for t in report.lines]
        if brief
        else [x for t in report.lines for x in wrapped(t, columns, "  ")]
    )
    most = max(2, SCREEN - 4 - len(lines) - min(3, len(report.missed)))
    if brief and len(below) > most:
        below = [*below[: most - 1], f"... and {len(below) - most + 1} more tables: --all prints them"]
    lines += [Text(""), *map(Text, below)] if below else []
    room = max(2, SCREEN - 3 - len(lines)) if brief else None
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


def whole(report: StudyReport, columns: int) -> list[Text]:
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


def show(lines: Iterable[Text]) -> None:
    """Prints lines on standard output, in colour where it is a terminal, without blanks at their ends."""
    out = console()
    if not out.is_terminal:
        sys.stdout.write("".join(f"{line.plain.rstrip()}\n" for line in lines))
        sys.stdout.flush()
        return
    for line in lines:
        out.print(line, soft_wrap=True)
