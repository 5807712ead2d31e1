"""The door for force tables: one row for each cut, with feed, depth of cut and main cutting force.

    feed (mm/rev);depth (mm);force (N)
    0,104;1,0;212,6

- CSV with commas, semicolons or tabs, or Parquet by its suffix; lines that start with ``#`` are skipped.
- Decimal points, or decimal commas throughout (between semicolons or tabs, or in quotes).
- Columns are known by usual names (``feed``, ``f``, ``ap``, ``depth``, ``Fc``, ``F``, ``main force``, ...), units by
  the header; both can be told. Feed force, passive force, cutting speed and spindle speed are read where they stand.
- A feed in mm/min needs the spindle speed: the laws are about the feed per revolution.
- A row that repeats another in every number is the same cut, and counts once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from leadscrew.analysis.cutting_force import USUAL_KC, specific_force
from leadscrew.csvlines import number
from leadscrew.identify.cutting_force_lines import Lines, read_cells
from leadscrew.identify.cutting_force_words import (
    FORCE_UNITS,
    FORCES,
    LENGTHS,
    NAMES,
    NEEDED,
    PER_MINUTE,
    UNITS,
    Word,
    parted,
    understood,
    unit_of,
)
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.kernel.sheet import nearest

POSSIBLE = {"feed": (0.001, 10.0), "depth": (0.005, 50.0), "force": (0.5, 50000.0)}
"""What a row in turning may have, mm and N: what is guessed when a unit is wrong."""


@dataclass(frozen=True)
class ForceTable:
    """Cuts with their main cutting force."""

    feed: np.ndarray
    """Per revolution, mm."""
    depth: np.ndarray
    """Of cut, mm."""
    force: np.ndarray
    """Main cutting force, N."""
    rows: tuple[int, ...]
    """Row of each cut in the file, as an editor counts; from 1 where there is no file."""
    others: Mapping[str, np.ndarray]
    """What else stands there: ``feed_force``, ``passive_force`` (N), ``speed`` (m/min), ``spindle`` (1/min)."""
    repeated: tuple[tuple[int, int], ...] = ()
    """Rows left out because they repeat a row, and which."""
    columns: Mapping[str, str] = field(default_factory=dict)
    """Header of each quantity, with the unit it was read in."""


def read_force_table(
    path: str | Path,
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    spindle_rpm: float | None = None,
    usual_kc: tuple[float, float] = USUAL_KC,
) -> ForceTable:
    """The cuts of a file.

    Args:
        path: CSV (``,``, ``;`` or tab) or Parquet.
        columns: header by quantity (``feed``, ``depth``, ``force``, ``feed_force``, ``passive_force``, ``speed``,
            ``spindle``), where the file calls it otherwise.
        units: unit by quantity, where the header says none or a wrong one.
        spindle_rpm: for a feed in mm/min, where no column has it.
        usual_kc: specific cutting force in N/mm^2 that a row may have; outside of it a unit is taken to be wrong.

    Raises:
        DataError: what is wrong with the file, by row and column.
        ValueRefused: no such quantity or unit.
    """
    path = Path(path)
    columns, units = dict(columns or {}), dict(units or {})
    for what in (columns, units):
        for quantity in what:
            if quantity not in NAMES:
                raise ValueRefused(f"{quantity} = {what[quantity]!r}: allowed are {', '.join(NAMES)}")
    lines = read_cells(path)
    header_row, header = lines[0]
    places = {q: _place(path, header_row, header, q, columns.get(q)) for q in NAMES}
    said = {q: _unit(path, header[at], q, units.get(q)) for q, at in places.items() if at is not None}
    rows = tuple(row for row, _ in lines[1:])
    found = {q: _column(path, lines, at, q) * UNITS[q][said[q]] for q, at in places.items() if at is not None}
    if said["feed"] in (PER_MINUTE, "mm_min", "mm_per_min"):
        if "spindle" not in found and spindle_rpm is None:
            raise DataError(
                f"{path}: the feed is in mm/min, and no column says the spindle speed; the laws are about the feed per "
                "revolution: give --spindle-rpm"
            )
        found["feed"] = found["feed"] / (found["spindle"] if "spindle" in found else float(spindle_rpm or 0.0))
    _check_specific_force(path, rows, found, usual_kc)
    keep, repeated = _distinct(rows, found)
    shown = {q: f"{parted(header[at])[0]} ({said[q]})" for q, at in places.items() if at is not None}
    chosen = {q: x[keep] for q, x in found.items()}
    return ForceTable(
        chosen.pop("feed"), chosen.pop("depth"), chosen.pop("force"), tuple(rows[i] for i in keep), chosen, repeated,
        shown,
    )  # fmt: skip


def _place(path: Path, row: int, header: list[str], quantity: str, asked: str | None) -> int | None:
    """Where a quantity stands; ``None`` for one that does not and need not."""
    if asked is not None:
        found = [i for i, name in enumerate(header) if asked in (name, parted(name)[0])]
        if not found:
            raise DataError(f"{path}, row {row}: the column {asked!r} is missing{nearest(asked, header)}")
    else:
        words = [understood(name) for name in header]
        found = [i for i, word in enumerate(words) if word is not None and word.quantity == quantity]
        if not found and quantity in NEEDED:
            there = ", ".join(map(repr, header))
            raise DataError(
                f"{path}, row {row}: no column is the {quantity} (there are {there}); name it with --column "
                f"{quantity}=HEADER"
            )
    if len(found) > 1:
        names = " and ".join(repr(header[i]) for i in found)
        raise DataError(
            f"{path}, row {row}: the columns {names} are both the {quantity}; keep one, or name it with --column "
            f"{quantity}=HEADER"
        )
    return found[0] if found else None


def _unit(path: Path, header: str, quantity: str, asked: str | None) -> str:
    if asked is not None:
        unit = unit_of(quantity, asked)
        if unit is None:
            raise ValueRefused(f"unit of {quantity} = {asked!r}: allowed are {_units(quantity)}")
        return unit
    word = understood(header)
    text = (word or Word(quantity, parted(header)[1])).unit
    if not text:
        return next(iter(UNITS[quantity]))
    unit = unit_of(quantity, text)
    if unit is None:
        raise DataError(
            f"{path}: the column {header!r} is in {text!r}, which is no unit of the {quantity}; known are "
            f"{_units(quantity)}: give --unit {quantity}=UNIT"
        )
    return unit


def _units(quantity: str) -> str:
    return ", ".join(unit for unit in UNITS[quantity] if "_" not in unit and unit.isascii())


def _column(path: Path, lines: Lines, at: int, quantity: str) -> np.ndarray:
    name = lines[0][1][at]
    cells = [(row, cells[at]) for row, cells in lines[1:]]
    comma = next((row for row, cell in cells if "," in cell), None)
    point = next((row for row, cell in cells if "." in cell), None)
    if comma is not None and point is not None:
        raise DataError(
            f"{path}, column {name!r}: a decimal comma in row {comma} and a decimal point in row {point}; expected one "
            "of the two throughout"
        )
    values = np.array([number(path, row, name, cell.replace(",", ".")) for row, cell in cells])
    for (row, cell), value in zip(cells, values, strict=True):
        if not value > 0.0:
            more = "; a row without a cut tells nothing, leave it out" if value == 0.0 and quantity in FORCES else ""
            raise DataError(f"{path}, row {row}, column {name!r}: {cell} is not above 0{more}")
    return values


def _check_specific_force(
    path: Path, rows: tuple[int, ...], found: Mapping[str, np.ndarray], usual: tuple[float, float]
) -> None:
    low, high = usual
    kc = specific_force(found["force"], found["feed"], found["depth"])
    outside = np.flatnonzero(~((kc >= low) & (kc <= high)))
    if not len(outside):
        return
    i = int(outside[0])
    whole = len(outside) > len(kc) / 2
    tried = [(q, u, LENGTHS[u], 1.0 / LENGTHS[u]) for q in ("depth", "feed") for u in ("m", "um", "in")]
    tried += [("force", u, by, by) for u, by in FORCE_UNITS.items() if u != "N"]
    guesses = [
        f"{q}={u}" for q, u, by, kc_by in tried
        if low <= kc_by * float(np.median(kc)) <= high
        and POSSIBLE[q][0] <= by * float(np.median(found[q])) <= POSSIBLE[q][1]
    ]  # fmt: skip
    if whole:
        hint = f": if a unit is wrong, give --unit {' or '.join(guesses)}" if guesses else ": a unit is wrong"
    else:
        rest = np.delete(kc, outside)
        hint = f", and the other rows have {rest.min():.4g} to {rest.max():.4g}: is that row in other units?"
    raise DataError(
        f"{path}, row {rows[i]}: {found['force'][i]:.4g} N at {found['feed'][i]:.4g} mm/rev and "
        f"{found['depth'][i]:.4g} mm is a specific cutting force of {kc[i]:.4g} N/mm2; metals have {low:g} to {high:g}"
        f"{hint}; another range with --usual-kc LOW,HIGH"
    )


def _distinct(rows: tuple[int, ...], found: Mapping[str, np.ndarray]) -> tuple[list[int], tuple[tuple[int, int], ...]]:
    first: dict[tuple[float, ...], int] = {}
    keep, repeated = [], []
    for i, row in enumerate(rows):
        key = tuple(float(x[i]) for x in found.values())
        if key in first:
            repeated.append((row, first[key]))
        else:
            first[key] = row
            keep.append(i)
    return keep, tuple(repeated)
