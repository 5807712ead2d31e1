"""Names of columns, and the units that stand in them: ``Position [mm]``, ``pos (mm)``, ``x_mm``, ``v / (m/s)``."""

from __future__ import annotations

import re
from collections.abc import Sequence

from leadscrew.logs.units import drive_in, known, length_in, plain, speed_in, time_in
from leadscrew.util.errors import ValueRefused

_BRACKETS = re.compile(
    r"^(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*+(?:\([^()]*+\)[^()]*+)?)\))\s*$"
)
_LONGEST = 300
"""Characters of a header with a unit."""
_SLASH = re.compile(r"^(?P<name>.*\S)(?:\s+/\s*|\s*/\s+|\s+in\s+)(?P<unit>\S.*)$")
_TAILS = (
    re.compile(r"^(?P<name>.*[^_])_(?P<unit>[^\W_]+_(?:s|min))$"),
    re.compile(r"^(?P<name>.*[^_])_(?P<unit>[^\W_]+)$"),
)
_TORQUES = ("Nm", "mNm", "kNm", "Nmm", "rpm")
"""Units that mean nothing else at the end of a name, and are written otherwise here."""


def split(header: str) -> tuple[str, str]:
    """Name and unit of a header; the unit is empty where it names none.

    What stands in square brackets is a unit whatever it is; in round ones, behind a slash and behind an underscore it
    is one where it is known.
    """
    text = header.strip()
    if len(text) > _LONGEST:
        return text, ""
    found = _BRACKETS.match(text)
    if found and found["square"] is not None and found["name"]:
        return found["name"].strip(), found["square"].strip()
    if found and found["round"] is not None and found["name"] and known(found["round"]):
        return found["name"].strip(), found["round"].strip()
    found = _SLASH.match(text)
    if found and known(found["unit"].strip().strip("()")):
        return found["name"].strip(), found["unit"].strip().strip("()")
    for tail in _TAILS:
        found = tail.match(text)
        unit = found["unit"].replace("_", "/") if found else ""
        if found and not unit.isdigit() and known(unit) and (unit == plain(unit) or unit in _TORQUES):
            return found["name"], unit
    return text, ""


def by_its_tail(header: str) -> bool:
    """Whether the unit is no more than the last syllable of the name, which may mean something else: ``tau_m``."""
    text, unit = header.strip(), split(header)[1]
    return bool(unit) and any(t.match(text) for t in _TAILS) and text[-1] not in "])" and "/" not in text


def bare(header: str) -> str:
    """The name without its unit."""
    return split(header)[0]


def named(cells: Sequence[str], units: Sequence[str] = ()) -> tuple[list[str], dict[str, str], list[str]]:
    """Names of columns, each once; units by name; and notes on what had no name or a name that was taken."""
    names: list[str] = []
    taken, given = set(), set(cells)
    counts: dict[str, int] = {}
    found: dict[str, str] = {}
    notes = []
    for at, cell in enumerate(cells):
        name = " ".join(cell.split()) or f"c{at + 1}"
        if name in taken:
            first, count = name, counts.get(name, 2)
            while (name := f"{first} ({count})") in taken or name in given:
                count += 1
            counts[first] = count + 1
            notes.append(f"column {at + 1} is a second {first!r}: called {name!r}")
        elif not cell.strip():
            notes.append(f"column {at + 1} has no name: called {name!r}")
        names.append(name)
        taken.add(name)
        unit = units[at].strip().strip("[]()").strip() if at < len(units) else ""
        unit = unit or split(name)[1]
        if unit:
            found[name] = unit
    return names, found, notes


def unit_row(cells: Sequence[str]) -> bool:
    """Whether a row below the header holds units: all of its cells known ones or empty, and one at least not empty."""
    filled = [c.strip() for c in cells if c.strip()]
    bracketed = [c for c in filled if len(c) > 1 and c[0] in "[(" and c[-1] in "])"]
    return bool(filled) and (
        len(bracketed) == len(filled) or all(known(c.strip("[]()").strip()) and not _digit(c) for c in filled)
    )


def _digit(cell: str) -> bool:
    return cell.strip()[:1].isdigit()


def named_unit(named: str, column: str, role: str) -> str:
    """The unit that a header names; empty where it is the end of a name (``tau_m``) and no unit of the role."""
    return named if named and (_fits(role, named) or not by_its_tail(column) or _counted(role, named)) else ""


def _counted(role: str, unit: str) -> bool:
    """A position in counts: their size must be told, and m would be wrong for sure."""
    return role in ("position", "command") and plain(unit) == "counts"


def _fits(role: str, unit: str) -> bool:
    try:
        sized(role, unit)
    except ValueRefused:
        return False
    return True


def sized(role: str, unit: str) -> tuple[str, float]:
    """What is kept for a unit, and its size in it."""
    if role == "time":
        return "s", time_in(unit)
    if role == "drive":
        return drive_in(unit)
    return speed_in(unit) if role == "velocity" else length_in(unit)
