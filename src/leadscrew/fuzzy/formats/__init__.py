"""Fuzzy systems in files: MATLAB ``.fis``, fuzzylite ``.fll``, IEC 61131-7 ``.fcl``, IEEE 1855 ``.xml`` (read only).

What a format cannot express is said: a reader puts sentences into ``System.notes``; a writer refuses what would change
outputs and returns sentences on the rest. Tables of a system's values are written by :mod:`.fld`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from leadscrew.fuzzy.formats import fcl, fis, fld, fll, fml
from leadscrew.fuzzy.formats.place import load
from leadscrew.fuzzy.system import System
from leadscrew.kernel.parameters import nearest
from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused, entry_point

__all__ = ["READ", "WRITTEN", "dumps", "fld", "loads", "read", "write"]

READ: dict[str, Callable[..., System]] = {"fis": fis.loads, "fll": fll.loads, "fcl": fcl.loads, "fml": fml.loads}
"""The formats that are read."""
WRITTEN: dict[str, Callable[[System, list[str] | None], str]] = {"fis": fis.dumps, "fll": fll.dumps, "fcl": fcl.dumps}
"""The formats that are written."""
_SUFFIXES = {".fis": "fis", ".fll": "fll", ".fcl": "fcl", ".fml": "fml", ".xml": "fml"}
_BEGINNINGS = {
    "fml": r"\s*<",
    "fis": r"(?:\s*[%#][^\n]*\n)*\s*\[\s*(?i:system)",
    "fll": r"(?:\s*#[^\n]*\n)*\s*Engine\s*:",
    "fcl": r"(?is).*\bfunction_block\b",
}


@entry_point
def read(path: str | Path, leave_out_unknown: bool = False) -> System:
    """The system in a file; its format follows from the suffix, and from its beginning where the suffix is another.

    ``leave_out_unknown`` leaves out rules that name a variable or term that does not exist, and says so in the notes.

    Raises:
        DataError: it cannot be read, or is broken: ``FILE:line:column`` and what was expected.
    """
    text, note = load(path)
    format = _SUFFIXES.get(Path(path).suffix.casefold()) or _by_content(text[:100_000])
    if format is None:
        raise DataError(f"{path}:1:1: expected a fuzzy system in one of the formats {', '.join(READ)}")
    system = loads(text, format, str(path), leave_out_unknown=leave_out_unknown)
    return replace(system, notes=(note, *system.notes)) if note else system


def loads(text: str, format: str, name: str = "text", **options: Any) -> System:
    """The system of a text in one of the formats of :data:`READ`; errors speak of it as ``name``.

    Raises:
        NameUnknown: there is no such format.
        DataError: the text is broken: ``name:line:column`` and what was expected.
    """
    if format not in READ:
        raise NameUnknown(f"no format {format!r} is read{nearest(format, list(READ))}")
    return READ[format](text, name, **options)


@entry_point
def write(system: System, path: str | Path) -> tuple[str, ...]:
    """Writes a system to a file, whose suffix is the format; gives sentences on what could not be said and changes no
    output.

    Raises:
        ValueRefused: the format cannot express the system (says what), or is not written.
        DataError: the file cannot be written.
    """
    suffix = Path(path).suffix.casefold()
    if suffix.removeprefix(".") not in WRITTEN:
        raise ValueRefused(f"{path}: {suffix or 'no suffix'}: systems are written as .{', .'.join(WRITTEN)}")
    notes: list[str] = []
    atomic_write(dumps(system, suffix.removeprefix("."), notes), path)
    return tuple(notes)


def dumps(system: System, format: str, notes: list[str] | None = None) -> str:
    """A system as text in one of the formats of :data:`WRITTEN`; ``notes`` collects what could not be said and changes
    no output.

    Raises:
        NameUnknown: there is no such format.
        ValueRefused: the format cannot express the system; says what.
    """
    if format not in WRITTEN:
        raise NameUnknown(f"no format {format!r} is written{nearest(format, list(WRITTEN))}")
    return WRITTEN[format](system, notes)


def _by_content(text: str) -> str | None:
    return next((format for format, beginning in _BEGINNINGS.items() if re.match(beginning, text)), None)
