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

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from leadscrew.analysis.cutting_force import USUAL_KC, specific_force
from leadscrew.kernel.parameters import nearest
from leadscrew.util import parquet, reading
from leadscrew.util.csv_lines import number
from leadscrew.util.errors import DataError, ValueRefused

PARQUET = (".parquet", ".pq")
"""Suffixes of Parquet files."""
NAMES = {
    "feed": ("feed", "feed_per_rev", "feed_per_revolution", "fn", "f_n", "fr", "f_r"),
    "depth": ("depth", "depth_of_cut", "ap", "a_p", "doc"),
    "force": ("force", "main_force", "cutting_force", "main_cutting_force", "tangential_force", "fc", "f_c"),
    "feed_force": ("feed_force", "axial_force", "ff", "f_f"),
    "passive_force": ("passive_force", "radial_force", "thrust_force", "fp", "f_p"),
    "speed": ("cutting_speed", "speed", "vc", "v_c"),
    "spindle": ("spindle", "spindle_speed", "rpm", "spindle_rpm"),
}
"""What a column may be called, in lower case and with underscores; ``f``, ``F`` and ``n`` go by their case."""
BY_CASE = {"f": "feed", "F": "force", "n": "spindle"}
NEEDED = ("feed", "depth", "force")
FORCES = ("force", "feed_force", "passive_force")

LENGTHS = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "μm": 1e-3, "cm": 10.0, "m": 1000.0, "in": 25.4, "inch": 25.4}
TURN = ("/rev", "/r", "_per_rev", "_rev", "/u", "/tr", "")
FORCE_UNITS = {"N": 1.0, "daN": 10.0, "kN": 1000.0, "kgf": 9.80665, "lbf": 4.4482216152605}
PER_MINUTE = "mm/min"
"""A feed that becomes one per revolution by the spindle speed."""
UNITS: dict[str, dict[str, float]] = {
    "feed": {f"{unit}{turn}": by for unit, by in LENGTHS.items() for turn in TURN}
    | dict.fromkeys((PER_MINUTE, "mm_min", "mm_per_min"), 1.0),
    "depth": LENGTHS,
    **dict.fromkeys(FORCES, FORCE_UNITS),
    "speed": {"m/min": 1.0, "m_min": 1.0, "m_per_min": 1.0, "m/s": 60.0, "ft/min": 0.3048, "sfm": 0.3048},
    "spindle": {"1/min": 1.0, "rpm": 1.0, "rev/min": 1.0, "min-1": 1.0, "rev/s": 60.0, "1/s": 60.0},
}
"""Into mm per revolution, mm, N, m/min and 1/min."""
OWN = {
    "feed": "mm/rev", "depth": "mm", "force": "N", "feed_force": "N", "passive_force": "N", "speed": "m/min",
    "spindle": "1/min",
}  # fmt: skip
"""The unit of a column that says none."""


class Word(NamedTuple):
    """What a header says."""

    quantity: str
    unit: str


def understood(header: str) -> Word | None:
    """Quantity and unit of a header such as ``feed (mm/rev)``, ``ap_mm`` or ``Fc [kN]``; ``None`` for another word."""
    name, said = parted(header)
    if name in BY_CASE:
        return _with_unit(BY_CASE[name], said)
    words = re.sub(r"[\s_-]+", "_", name).casefold().split("_")
    for split in range(len(words), 0, -1):
        quantity = _quantity("_".join(words[:split]))
        rest = "_".join(words[split:])
        if quantity is not None and (not rest or (not said and unit_of(quantity, rest) is not None)):
            return _with_unit(quantity, said or rest)
    return None


def parted(header: str) -> tuple[str, str]:
    """Name and unit where the unit stands in brackets at the end."""
    found = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]", header.strip())
    return (found[1], found[2].strip()) if found else (header.strip(), "")


def unit_of(quantity: str, text: str) -> str | None:
    """The unit of a quantity as it is written here, whatever the case; ``None`` for a unit that it does not have."""
    asked = text.replace(" ", "").casefold()
    return next((unit for unit in UNITS[quantity] if unit.casefold() == asked), None)


def _quantity(name: str) -> str | None:
    return next((quantity for quantity, names in NAMES.items() if name in names), None)


def _with_unit(quantity: str, text: str) -> Word:
    return Word(quantity, text or OWN[quantity])


Lines = list[tuple[int, list[str]]]


def read_cells(path: Path) -> Lines:
    """Row number (as an editor counts; of a Parquet file from 1) and cells of the header and of every row.

    Raises:
        DataError: it cannot be read, is empty, has no rows, or a row has not as many cells as the header.
    """
    return _parquet(path) if path.suffix.casefold() in PARQUET else _text(path)


def _text(path: Path) -> Lines:
    text = reading.text(path, reading.POINTS, "tables of points")
    kept = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not kept:
        raise DataError(f"{path}: is empty; expected a header line with feed, depth, force")
    if len(kept) == 1:
        raise DataError(f"{path}: has a header but no rows of data")
    first = kept[0][1]
    apart = next((sign for sign in ("\t", ";", ",") if sign in first), None)
    if apart is None:
        raise DataError(f"{path}, row {kept[0][0]}: {first!r} is one cell; expected commas, semicolons or tabs between")
    lines = []
    for n, line in kept:
        try:
            cells = next(csv.reader([line], delimiter=apart, strict=True))
        except csv.Error as problem:
            raise DataError(f"{path}, row {n}: {problem}") from None
        lines.append((n, [cell.strip() for cell in cells]))
        if len(cells) != len(lines[0][1]):
            hint = "; decimal commas need semicolons or tabs between the cells" if apart == "," else ""
            raise DataError(f"{path}, row {n}: {len(cells)} cells where the header has {len(lines[0][1])}{hint}")
    return lines


def _parquet(path: Path) -> Lines:
    held = parquet.read(path)
    if not held.rows:
        raise DataError(f"{path}: has columns but no rows of data")
    cells = [held.texts[n] if n in held.texts else [repr(v) for v in held.numbers[n].tolist()] for n in held.names]
    return [(0, held.names), *((n, list(row)) for n, row in enumerate(zip(*cells, strict=True), 1))]


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


EXAMPLE = """\
# Main cutting force in dry turning, about 1080 1/min: published facts, from mati-paredes/Turning-Cutting-Forces.
# Four feeds at a depth of 1 mm, four depths at a feed of 0.104 mm/rev; the cut at 0.104 mm/rev and 1 mm is in both.
# "feed" is what was set at the lathe, "measured feed" is length over time and spindle speed, as its authors took it.
# Their own fit, to the four feeds as measured: specific force 1609.5 N/mm2 at 1 mm, exponent 0.136, R2 0.932.
feed (mm/rev),measured feed (mm/rev),depth (mm),force (N)
0.104,0.098,1.0,212.6
0.187,0.176,1.0,371.1
0.299,0.303,1.0,569.0
0.416,0.401,1.0,725.6
0.104,0.102,0.25,65.5
0.104,0.100,0.5,120.2
0.104,0.098,1.0,212.6
0.104,0.101,1.25,268.2
"""
"""Eight facts of mati-paredes/Turning-Cutting-Forces; the same as ``examples/turning_forces.csv``."""
