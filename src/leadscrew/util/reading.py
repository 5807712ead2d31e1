"""Files from elsewhere, read within bounds: the size is checked first, settings nest little, numbers fit 64 bits.

===========  ======  ========================================================================
kind         most    of
===========  ======  ========================================================================
SETTINGS     8 MB    TOML: experiment, controller, machine, session and HAL files
OBJECT       32 MB   JSON: the manifest of a run, an export or a report; networks, fits
POINTS       20 MB   measured points: positioning, ball bar, cutting force, cut lines, rules
PROGRAM      50 MB   G-code, drawings
===========  ======  ========================================================================

A log may have 2 GB, 300 MB as text (that takes some ten times as much memory), 50 million cells and 10,000 columns; a
drawing 100,000 lines and arcs, a program 100,000 lines of text; a fuzzy system 2 MB and 50,000 lines.
:data:`VARIABLE`, or ``leadscrew --file-limits``, multiplies all of them, and the memory and time of
:mod:`leadscrew.util.separate_process`.
"""

from __future__ import annotations

import codecs
import json
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from leadscrew.util.errors import DataError, ValueRefused

VARIABLE = "LEADSCREW_FILE_LIMITS"
LARGEST_FACTOR = 1000.0
SETTINGS, OBJECT, POINTS, PROGRAM = 8_000_000, 32_000_000, 20_000_000, 50_000_000
LOG, LOG_TEXT, CELLS, COLUMNS, CURVES = 2_000_000_000, 300_000_000, 50_000_000, 10_000, 100_000
DEEPEST = 64
"""Tables inside tables, lists inside lists."""

_DECLARED = re.compile(rb"""(?:\xef\xbb\xbf)?<\?xml\s[^>]{0,80}?encoding\s*=\s*["']([\w.:-]{1,40})["']""", re.ASCII)
_DOTTED = re.compile(
    rf"""(?<![\w-])(?:(?:"[^"\n]*+"|'[^'\n]*+'|[\w-]++)[ \t]*+\.[ \t]*+){{{DEEPEST}}}"""  # keys of a TOML file
)


def factor() -> float:
    """By what the user multiplies all limits; 1 unless said.

    Raises:
        ValueRefused: what is said is no number from 1 to 1000.
    """
    said = os.environ.get(VARIABLE, "1")
    try:
        found = float(said)
    except ValueError:
        found = 0.0
    if not 1.0 <= found <= LARGEST_FACTOR:
        raise ValueRefused(f"{VARIABLE} = {said!r}: expected a number from 1 to {LARGEST_FACTOR:g}")
    return found


def how_to_raise(needed: int) -> str:
    """What to do to read ``needed`` times as much."""
    return f"raise the limits with leadscrew --file-limits {needed} (in Python: {VARIABLE}={needed})"


def check(path: Path, size: float, most: float, what: str, instead: str = "") -> None:
    """Passes where ``size`` bytes are within the limit.

    Raises:
        DataError: they are not; says by how much to raise the limits, and what to do ``instead``.
    """
    if size > (limit := most * factor()):
        needed = int(-(-size // most))
        raise DataError(
            f"{path}: {_bytes(size)}; {what} up to {_bytes(limit)} are read: {instead}{how_to_raise(needed)}"
        )


def check_log(path: Path, most: float = LOG, what: str = "logs") -> None:
    """Passes where a file is there, not empty, and small enough to be a log.

    Raises:
        DataError: it is not.
    """
    try:
        size = path.stat().st_size
    except OSError as problem:
        raise DataError(f"{path}: cannot be read ({problem.strerror or problem})") from None
    except ValueError as problem:
        raise DataError(f"{str(path)!r}: is no name of a file ({problem})") from None
    check(path, size, most, what, "cut it into parts, or ")
    if size == 0:
        raise DataError(f"{path}: is empty")


def check_cells(source: str, rows: int, columns: int) -> None:
    """Passes where a table is small enough.

    Raises:
        DataError: more than :data:`CELLS` cells.
    """
    if rows * columns > (most := CELLS * factor()):
        needed = int(-(-rows * columns // CELLS))
        raise DataError(
            f"{source}: {rows} rows of {columns} columns are {rows * columns / 1e6:.0f} million cells; up to "
            f"{most / 1e6:.0f} million are read: cut it into parts, keep fewer columns, or {how_to_raise(needed)}"
        )


def check_columns(source: str, columns: int) -> None:
    """Passes where a table is not too wide.

    Raises:
        DataError: more than :data:`COLUMNS` columns.
    """
    check_count(source, columns, COLUMNS, "columns", "keep fewer")


def check_curves(source: str, curves: int) -> None:
    """Passes where a drawing, or a program, is not too long.

    Raises:
        DataError: more than :data:`CURVES` lines, arcs and curves.
    """
    check_count(source, curves, CURVES, "lines", "cut it into parts")


def check_count(source: str, count: int, most: int, what: str, instead: str) -> None:
    """Passes where there are no more than ``most`` of something.

    Raises:
        DataError: there are.
    """
    if count > (limit := most * factor()):
        needed = -(-count // most)
        raise DataError(
            f"{source}: more than {limit:,.0f} {what}; no more are read: {instead}, or {how_to_raise(needed)}"
        )


def _bytes(count: float) -> str:
    unit, size = next(((u, s) for u, s in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)) if count >= s), ("bytes", 1.0))
    return f"{count / size:.4g} {unit}"


def data(path: Path, most: float, what: str) -> bytes:
    """All bytes of a file.

    Raises:
        DataError: it cannot be read, or holds more than ``most`` bytes.
    """
    try:
        with path.open("rb") as file:
            check(path, os.fstat(file.fileno()).st_size, most, what)
            held = file.read(int(most * factor()) + 1)
    except OSError as problem:
        raise DataError(f"{path}: cannot be read ({problem.strerror or problem})") from None
    except ValueError as problem:  # such as a name with a character 0
        if isinstance(problem, DataError | ValueRefused):
            raise
        raise DataError(f"{str(path)!r}: is no name of a file ({problem})") from None
    check(path, len(held), most, what)
    return held


def decoded(held: bytes) -> tuple[str, str]:
    """A text, and a sentence where it is Latin-1 by guess alone.

    The encoding is UTF-16 by its byte order mark, else the one that an XML declaration names and that fits, else UTF-8,
    else Latin-1.

    Raises:
        UnicodeDecodeError: UTF-16 that is broken.
    """
    if held.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return held.decode("utf-16"), ""
    declared = _DECLARED.match(held)
    with suppress(LookupError, UnicodeError):
        if declared and declared[0].decode(declared[1].decode()) == declared[0].decode():
            return held.decode(declared[1].decode()).removeprefix("\ufeff"), ""
    try:
        return held.decode("utf-8-sig"), ""
    except UnicodeDecodeError:
        return held.decode("latin-1"), "is not UTF-8: read as Latin-1"


def text(path: Path, most: float, what: str) -> str:
    r"""The text of a file without a byte order mark; its lines end with ``\n``.

    Raises:
        DataError: as :func:`data`, or it is not UTF-8.
    """
    held = data(path, most, what)
    try:
        return held.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as problem:
        raise DataError(f"{path}: is not UTF-8 text (byte {problem.start})") from problem


def toml(path: Path) -> dict[str, Any]:
    """What a TOML file holds.

    Raises:
        DataError: as :func:`text`; it is no TOML, nests too deep, or has a whole number beyond 64 bits.
    """
    if not path.exists():
        raise DataError(f"there is no file {str(path)!r}")
    return toml_of(text(path, SETTINGS, "settings"), str(path))


def toml_of(held: str, source: str) -> dict[str, Any]:
    """What a TOML text holds; see :func:`toml`."""
    import tomllib

    if _DOTTED.search(held):  # tomllib needs memory as the square of the parts of a key
        raise DataError(f"{source}: cannot be read as TOML: a key of more than {DEEPEST} parts")
    try:
        return dict(_sound(tomllib.loads(held)))
    except (ValueError, RecursionError, OverflowError) as problem:
        raise DataError(f"{source}: cannot be read as TOML: {_said(problem)}") from None


def json_object(path: Path) -> dict[str, Any]:
    """The object that a JSON file holds.

    Raises:
        DataError: as :func:`text`; it is no JSON or no object, nests too deep, or has a whole number beyond 64 bits.
    """
    found = json_of(text(path, OBJECT, "JSON files"), str(path))
    if not isinstance(found, dict):
        raise DataError(f"{path}: holds no JSON object")
    return found


def json_of(held: str, source: str) -> Any:
    """What a JSON text holds.

    Raises:
        DataError: as :func:`json_object`.
    """
    try:
        return _sound(json.loads(held, parse_int=_int))
    except (ValueError, RecursionError, OverflowError) as problem:
        raise DataError(f"{source}: is not JSON ({_said(problem)})") from None


def _said(problem: Exception) -> str:
    return "nested too deep" if isinstance(problem, RecursionError) else str(problem)


def _int(digits: str) -> int:
    if len(digits) > 20:
        raise ValueError(f"a whole number of {len(digits)} digits")
    return int(digits)


def _sound(found: Any) -> Any:
    """The value, where all in it can be computed with and printed."""
    level: list[Any] = [found]
    for _ in range(DEEPEST + 1):
        below: list[Any] = []
        for item in level:
            if isinstance(item, dict):
                below += item.keys()
                below += item.values()
            elif isinstance(item, list):
                below += item
            elif isinstance(item, str):
                item.encode()  # half of a character, \ud800 in JSON, fails here
            elif isinstance(item, int) and not -(2**63) <= item < 2**64:
                raise ValueError("a whole number beyond 64 bits")
        if not below:
            return found
        level = below
    raise ValueError(f"nested deeper than {DEEPEST} levels")
