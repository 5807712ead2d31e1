"""Tables of text: CSV, TSV, semicolons, bars or white space between the cells, with a point or a comma as decimal sign.

What stands in the file decides, not its suffix. Lines that start with ``#``, ``%`` or ``//`` are comments; a sampling
period that one of them names is used. Without a header the columns are called c1, c2 and so on.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from leadscrew import reading
from leadscrew.kernel.errors import DataError
from leadscrew.logs import cells as cell
from leadscrew.logs.hal import recorder
from leadscrew.logs.header import named
from leadscrew.logs.sniff import COMMENTS, WHITE, Form, Line, decimal_commas, rows, sniff
from leadscrew.logs.table import Table
from leadscrew.reading import LOG_TEXT, check_cells, check_log

_CHUNK = 20_000
_PERIOD = re.compile(
    r"\b(?:sampling|sample)[ _]*(?:period|time|interval)\b\D{0,12}?([-+.\deE]+)\s*(ns(?:ec)?|us|ms|s(?:ec)?)\b", re.I
)
_WORDS_ARE_WRONG = 0.5
"""Share of numbers in a column from which on a word in it is a broken cell, not a column of words."""


def read_text(path: Path) -> Table:
    """The table of a text file.

    Raises:
        DataError: it cannot be read, is too large, is no table, or a cell or a row is broken: file, row and column.
    """
    check_log(path, LOG_TEXT, "logs of text")
    text, notes = _decoded(path)
    return table_of(text, str(path), notes)


def table_of(text: str, source: str, notes: Sequence[str] = ()) -> Table:
    """The table of a text.

    Raises:
        DataError: as :func:`read_text`.
    """
    comments, lines, blank = _lines(text)
    said = list(notes)
    if not lines:
        raise DataError(f"{source}: is empty; expected a table of numbers")
    lines, lost_after, form_name = recorder(lines, comments)
    form = sniff(lines, comments)
    if form is None:
        raise DataError(f"{source}: is no table of numbers: no delimiter makes rows of equal length of its lines")
    if form.delimiter == ",":
        form = _with_commas(form, lines, comments, source, said)
    body = lines[form.first :]
    if form.cells == 1:
        body, blank = _with_blanks(body, blank, source), []
    reading.check_columns(source, form.cells)
    check_cells(source, len(body), form.cells)
    body = _whole(body, form, source, said)
    names, units, remarks = named(form.header or [""] * form.cells, form.units)
    said += remarks if form.header else ["has no header: columns are called c1, c2, ..."]
    if form.above:
        said.append(f"{len(form.above)} lines above the header are left out, the first of them {form.above[0][:60]!r}")
    columns, texts = _columns(body, form, names, source)
    file_rows = np.array([n for n, _ in body])
    period = next((p for p in map(_period, (*comments, *form.above)) if p), None)
    kept = {n: u for n, u in units.items() if n in columns}
    return Table(
        columns, kept, texts, source, said, period=period, form=form_name or _form_name(form), file_rows=file_rows,
        lost=tuple(int(np.searchsorted(file_rows, row)) for row in lost_after),
        blank=tuple(sorted({int(np.searchsorted(file_rows, rows.start)) for rows in blank} - {0, len(file_rows)})),
    )  # fmt: skip


def _decoded(path: Path) -> tuple[str, list[str]]:
    held = reading.data(path, LOG_TEXT, "logs of text")
    try:
        text, note = reading.decoded(held)
    except UnicodeDecodeError as problem:
        raise DataError(f"{path}: is not UTF-16 text (byte {problem.start})") from None
    if (at := text.find("\0", 0, 4096)) >= 0:
        raise DataError(f"{path}: is no text (byte {at} is 0) and no kind of file that is known by it")
    return text, [note] if note else []


def _with_commas(form: Form, lines: Sequence[Line], comments: Sequence[str], source: str, said: list[str]) -> Form:
    """The form of lines with commas, which may be decimal signs.

    Raises:
        DataError: a comma may be either, or is both.
    """
    if form.above and 2 * (form.above[-1].count(",") + 1) == form.cells > 2:
        raise DataError(
            f"{source}: the header {form.above[-1][:60]!r} has {form.cells // 2} names, the rows have {form.cells} "
            "cells; decimal commas need semicolons or tabs between the cells"
        )
    if form.cells != 2 or (shown := decimal_commas([text for _, text in lines], form)) is None:
        return form
    line, sure = shown
    if not sure:
        raise DataError(
            f"{source}: {line!r} may be one number with a decimal comma or two whole numbers: write a header line with "
            "one name, or with two names and a comma between them"
        )
    said.append(f"{line!r} is read as one number with a decimal comma; two columns need a header with two names")
    one = sniff(lines, comments, (";",))
    assert one is not None
    return one


def _with_blanks(body: Sequence[Line], blank: Sequence[range], source: str) -> list[Line]:
    """The rows of one column, with the empty lines between them, each a missing value."""
    between = [rows for rows in blank if rows.start > body[0][0]]
    check_cells(source, len(body) + sum(map(len, between)), 1)
    return sorted([*body, *((row, "nan") for rows in between for row in rows)])


def _lines(text: str) -> tuple[list[str], list[Line], list[range]]:
    """Comments without their sign, the lines that are neither comments nor empty, and the empty ones between others."""
    comments, lines, blank = [], [], []
    last = 0
    for row, ended in enumerate(io.StringIO(text.replace("\r\r\n", "\n"), newline=None), start=1):
        line = ended.removesuffix("\n")
        stripped = line.strip()
        if not stripped:
            continue
        if stripped.startswith(COMMENTS):
            comments.append(stripped.lstrip("#%/").strip())
        else:
            lines.append((row, line))
        if row > last + 1:
            blank.append(range(last + 1, row))
        last = row
    return comments, lines, blank


def _period(comment: str) -> float | None:
    found = _PERIOD.search(comment)
    if found is None:
        return None
    value = cell.number(found[1])
    seconds = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "s": 1.0}[found[2][0].casefold()]
    return value * seconds if value is not None and 0.0 < value < 1e15 else None


def _whole(body: list[Line], form: Form, source: str, said: list[str]) -> list[Line]:
    """The rows without a last one that was cut off while it was written."""
    try:
        short = len(body) > 1 and len(next(rows([body[-1][1]], form.delimiter), [])) < form.cells
    except csv.Error:
        short = len(body) > 1
    if short:
        said.append(f"row {body[-1][0]} is cut off, as by a recorder that was stopped: it is left out")
        return body[:-1]
    return body


def _columns(
    body: list[Line], form: Form, names: list[str], source: str
) -> tuple[dict[str, np.ndarray], dict[str, list[str]]]:
    """Numbers and texts by name, read in parts so that the cells' texts need not all be kept."""
    parts: list[list[np.ndarray]] = [[] for _ in names]
    wrong: list[list[np.ndarray]] = [[] for _ in names]
    words: list[list[str]] = [[] for _ in names]
    for start in range(0, len(body), _CHUNK):
        chunk = _cut(body[start : start + _CHUNK], form, source)
        for at, column in enumerate(zip(*chunk, strict=True)):
            values, bad = cell.numbers(column, form.decimal)
            parts[at].append(values)
            wrong[at].append(bad)
            if bad.any() or words[at]:
                words[at] += [""] * (start - len(words[at])) + [c.strip() for c in column]
    columns, texts = {}, {}
    for at, name in enumerate(names):
        values, bad = np.concatenate(parts[at]), np.concatenate(wrong[at])
        if not bad.any():
            columns[name] = values
        elif np.isfinite(values).sum() >= _WORDS_ARE_WRONG * len(values):
            k = int(np.argmax(bad))
            raise DataError(
                f"{source}, row {body[k][0]}, column {name!r}: {_shown(words[at][k])} is not a number; correct it, or "
                "leave the cell empty"
            )
        else:
            texts[name] = _texts(words[at], body, form, at)
    return columns, texts


def _texts(words: list[str], body: list[Line], form: Form, at: int) -> list[str]:
    """All cells of a column of words, those too of parts in which all were numbers."""
    first = next((k for k, w in enumerate(words) if w), 0)
    if first < _CHUNK:
        return words
    early = [row[at].strip() for row in rows([t for _, t in body[:first]], form.delimiter)]
    return early + words[first:]


def _cut(lines: list[Line], form: Form, source: str) -> list[list[str]]:
    """Cells of some rows, each of the table's width."""
    reader = rows([text for _, text in lines], form.delimiter)
    found: list[list[str]] = []
    try:
        for row in reader:
            if len(row) == form.cells + 1 and not row[-1].strip():
                row = row[:-1]
            if len(row) != form.cells:
                where = lines[len(found)][0]
                raise DataError(f"{source}, row {where}: {len(row)} cells where the table has {form.cells}")
            found.append(row)
    except csv.Error as problem:
        raise DataError(f"{source}, row {lines[min(len(found), len(lines) - 1)][0]}: {problem}") from None
    if len(found) != len(lines):
        raise DataError(f"{source}, row {lines[len(found)][0]}: a cell with a line break in its quotes is not read")
    return found


def _shown(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:37] + "...")


def _form_name(form: Form) -> str:
    between = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", WHITE: "white space"}[form.delimiter]
    if form.cells == 1:
        between = "one column"
    return f"text, {between}" + (", decimal comma" if form.decimal == "," else "")
