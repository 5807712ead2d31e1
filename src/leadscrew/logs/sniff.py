"""How a text table is written: what stands between its cells, its decimal sign, where its header and its rows begin."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from leadscrew.logs.cells import is_number, number
from leadscrew.logs.header import unit_row

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
    cut = [c for line in lines if (c := _cut(line, delimiter)) is not None and any(c)]
    if not cut:
        return 0.0, 0
    width = Counter(len(c) for c in cut).most_common(1)[0][0]
    fits = [c for c in cut if len(c) == width]
    count = sum(is_number(x, decimal) for c in fits for x in c)
    filled = sum(bool(x) for c in fits for x in c)
    share = count / max(filled, 1)
    return len(fits) / len(lines) * share * (1.0 + 1e-3 * min(width, 100)), width


def _cut(line: str, delimiter: str) -> list[str] | None:
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
