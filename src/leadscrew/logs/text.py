"""Tables of text: CSV, TSV, semicolons, bars or white space between the cells, with a point or a comma as decimal sign.

What stands in the file decides, not its suffix. Lines that start with ``#``, ``%`` or ``//`` are comments; a sampling
period that one of them names is used. Without a header the columns are called c1, c2 and so on.

What LinuxCNC's recorders write, as lines of a plain table.

The oscilloscope ``halscope`` of LinuxCNC 2.9 writes a comment ``# Sampling period is 1000000 ns`` and a table with
semicolons; older ones wrote ``Sampling period is 1000000 nSec`` and rows of ``name +value name +value``. ``halsampler``
writes bare rows with white space between the cells, and ``overrun`` on a line of its own where samples were lost.
Source: LinuxCNC, src/hal/utils/scope_files.c; halsampler(1).
"""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew.logs.header import named, unit_row
from leadscrew.logs.table import Table
from leadscrew.util import reading
from leadscrew.util.errors import DataError
from leadscrew.util.reading import LOG_TEXT, check_cells, check_log

MISSING = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "?", "1.#qnan", "-1.#ind", "-nan"})
"""What stands where there is no value, in lower case."""

_TRUTH = {"true": 1.0, "false": 0.0}


def number(cell: str, decimal: str = ".") -> float | None:
    """The number of a cell; NaN where it is missing; None where it is a word."""
    text = cell.strip()
    if text.casefold() in MISSING:
        return float("nan")
    if decimal == ",":
        if "." in text:
            return None
        text = text.replace(",", ".", 1)
    if "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return _TRUTH.get(text.casefold())


def is_number(cell: str, decimal: str = ".") -> bool:
    """Whether the cell holds one, and is not empty."""
    value = number(cell, decimal)
    return value is not None and bool(cell.strip()) and value == value


def numbers(cells: Sequence[str], decimal: str) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of cells, NaN where there is none, and which of them are words."""
    joined = " ".join(cells)
    try:
        if "_" in joined or (decimal == "," and "." in joined):
            raise ValueError  # Python reads 1_000 as a number; a point is no decimal sign here.
        plain = cells if decimal == "." else [c.replace(",", ".", 1) for c in cells]
        return np.array([float(c) for c in plain]), np.zeros(len(cells), dtype=bool)
    except ValueError:
        read = [number(c, decimal) for c in cells]
        return np.array([np.nan if v is None else v for v in read], dtype=float), np.array([v is None for v in read])


Line = tuple[int, str]
"""Row in the file from 1, and its text."""

COMMENTS = ("#", "%", "//")

WHITE = " "
"""Stands for any white space between cells."""

_DELIMITERS = (",", ";", "\t", "|", WHITE)
_LOOKED_AT = 200
_PAIR = re.compile(r"([-+]?\d+),(\d+)")
_COUNTED = 20
"""Rows from which on a first number that rises evenly counts them."""
_GLUED = re.compile(r"\S+(?:[ \t]*[\[(][^\])]{0,60}[\])])?")


class Form(NamedTuple):
    """What was found."""

    delimiter: str
    decimal: str
    cells: int
    """In a row."""
    first: int
    """Which of the lines is the first row of data."""
    header: tuple[str, ...]
    """Empty where there is none."""
    units: tuple[str, ...]
    """The row of units below the header."""
    above: tuple[str, ...]
    """Lines above the header that are no part of the table."""


def split(line: str, delimiter: str) -> list[str]:
    """The cells of one line, stripped, without what a delimiter at the end of the line leaves.

    Raises:
        csv.Error: quotes that do not fit.
    """
    return [cell.strip() for cell in next(rows([line], delimiter), [])]


def rows(lines: Sequence[str], delimiter: str) -> Iterator[list[str]]:
    """The cells of every line."""
    if delimiter == WHITE:
        return (line.split() for line in lines)
    return csv.reader(lines, delimiter=delimiter, strict=True, skipinitialspace=True)


def sniff(lines: Sequence[Line], comments: Sequence[str], delimiters: Sequence[str] = _DELIMITERS) -> Form | None:
    """The form of a table; None where the lines are no table with at least one column of numbers."""
    looked = [text for _, text in lines[:_LOOKED_AT]]
    tail = [text for _, text in lines[-_LOOKED_AT // 4 :]]
    best: tuple[float, str, str, int] | None = None
    for delimiter in delimiters:
        for decimal in (".", ",") if delimiter != "," else (".",):
            score, width = _score(looked + tail, delimiter, decimal)
            if score > 0.0 and (best is None or score > best[0] * (1.0 + 1e-9)):
                best = score, delimiter, decimal, width
    return None if best is None else _form(looked, comments, *best[1:])


def decimal_commas(lines: Sequence[str], form: Form) -> tuple[str, bool] | None:
    """Whether rows such as ``1,5`` are numbers with a decimal comma: one of them, and whether that is certain.

    None where they are two columns: a header with two names, a line of another form, a second number that no decimal
    places look like (``2,10`` beside ``2,7``), or a first one that counts the rows.
    """
    pairs = [_PAIR.fullmatch(line.strip()) for line in lines[form.first :]]
    if form.header or not all(pairs):
        return None
    whole, places = [p[1] for p in pairs if p], [p[2] for p in pairs if p]
    sure = next((k for k, (w, d) in enumerate(zip(whole, places, strict=True)) if d[0] == "0" != d or w == "-0"), None)
    if sure is not None:
        return lines[form.first + sure].strip(), True
    if len({*map(len, places)}) > 1 and any(d.endswith("0") for d in places):
        return None
    if len(set(places)) > 1 and len(pairs) >= _COUNTED and len({int(b) - int(a) for a, b in pairwise(whole)}) == 1:
        return None
    return lines[form.first].strip(), len(set(places)) == 1 or bool(form.above)


def _score(lines: Sequence[str], delimiter: str, decimal: str) -> tuple[float, int]:
    """How well the lines fit: share of rows of the usual width, times share of numbers, and a little for more cells."""
    cut = [c for line in lines if (c := _cells_of(line, delimiter)) is not None and any(c)]
    if not cut:
        return 0.0, 0
    width = Counter(len(c) for c in cut).most_common(1)[0][0]
    fits = [c for c in cut if len(c) == width]
    count = sum(is_number(x, decimal) for c in fits for x in c)
    filled = sum(bool(x) for c in fits for x in c)
    share = count / max(filled, 1)
    return len(fits) / len(lines) * share * (1.0 + 1e-3 * min(width, 100)), width


def _cells_of(line: str, delimiter: str) -> list[str] | None:
    try:
        return without_end(split(line, delimiter), delimiter)
    except csv.Error:
        return None


def without_end(cells: list[str], delimiter: str) -> list[str]:
    """Cells without one empty one behind a delimiter at the end of the line."""
    return cells[:-1] if len(cells) > 1 and delimiter != WHITE and not cells[-1] else cells


def _form(lines: Sequence[str], comments: Sequence[str], delimiter: str, decimal: str, width: int) -> Form:
    # Full width, the cell behind the last delimiter included: an empty last cell may also be a missing value.
    cut = [_cells(line, delimiter) for line in lines]
    width = max((len(c) for c in cut if len(c) >= width), key=[len(c) for c in cut].count, default=width)
    if width > 1 and delimiter != WHITE and all(not c[-1] for c in cut if len(c) == width):
        width -= 1
    numeric = [sum(is_number(x, decimal) for x in c) for c in cut]
    usual = Counter(n for n, c in zip(numeric, cut, strict=True) if len(c) >= width and n).most_common(1)
    enough = max(1, (usual[0][0] if usual else 1) // 2)
    first = next((k for k, n in enumerate(numeric) if n >= enough and len(cut[k]) >= width), 0)
    while first > 0 and len(cut[first - 1]) >= width and _is_data(cut[first - 1][:width], decimal):
        first -= 1
    header, units, above = _heads(lines, cut, comments, delimiter, width, first)
    return Form(delimiter, decimal, width, first, header, units, above)


def _is_data(cells: Sequence[str], decimal: str) -> bool:
    """Whether a row above the first usual one is data with most of it missing: no word, and a number or NaN."""
    held = [number(x, decimal) for x in cells]
    return None not in held and any(v == v or "nan" in x.casefold() for v, x in zip(held, cells, strict=True))


def _heads(
    lines: Sequence[str], cut: Sequence[list[str]], comments: Sequence[str], delimiter: str, width: int, first: int
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Header, units, and what stands above them."""
    at = first - 1
    units: tuple[str, ...] = ()
    if at >= 1 and len(cut[at]) >= width and unit_row(cut[at][:width]) and _names(lines[at - 1], delimiter, width):
        units = tuple(cut[at][:width])
        at -= 1
    if at >= 0 and (names := _names(lines[at], delimiter, width)):
        return names, units, tuple(lines[:at])
    for text in reversed(comments):
        # numpy.savetxt and gnuplot write the header as a comment.
        if names := _names(text, delimiter, width):
            return names, units, tuple(lines[:first])
    return (), units, tuple(lines[:first])


def _names(line: str, delimiter: str, width: int) -> tuple[str, ...]:
    """The cells of a header of that many columns; empty where the line is none."""
    tries = [_cells(line, delimiter)]
    if delimiter == WHITE:
        tries += [re.split(r"\t+", line.strip()), re.split(r"\s{2,}", line.strip()), _GLUED.findall(line)]
    for cells in tries:
        cells = [c.strip() for c in cells]
        if len(cells) == width + 1 and not cells[-1]:
            cells = cells[:-1]
        if len(cells) == width and any(cells) and sum(is_number(c) for c in cells) * 2 < width:
            return tuple(cells)
    return ()


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        return split(line, delimiter)
    except csv.Error:
        return []


_CHANNEL_VALUE = re.compile(r"(\S+) ([-+]\d+\.\d+)(?: |$)")


def recorder(lines: list[Line], comments: list[str]) -> tuple[list[Line], list[int], str]:
    """Lines as a plain table, rows of the file at which samples were lost, and which recorder it was."""
    lost = [row for row, text in lines if text.strip() == "overrun"]
    if lost:
        lines = [line for line in lines if line[1].strip() != "overrun"]
        return lines, lost, "LinuxCNC halsampler"
    if not lines[0][1].startswith("Sampling period is ") or len(lines) < 2:
        scope = any(c.startswith("Sampling period is ") and c.endswith(" ns") for c in comments[:1])
        return lines, [], "LinuxCNC halscope" if scope else ""
    comments.append(lines[0][1].strip())
    pairs = [(row, _CHANNEL_VALUE.findall(text)) for row, text in lines[1:]]
    names = [name for name, _ in pairs[0][1]]
    body = [(row, ";".join(value for _, value in found)) for row, found in pairs]
    return [(lines[0][0], ";".join(names)), *body], [], "LinuxCNC halscope"


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
    value = number(found[1])
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
            values, bad = numbers(column, form.decimal)
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
