"""The door for a measured positioning test: a CSV file with one line for each approach of a target.

    target_mm,direction,run,deviation_um
    12.5,+,1,0.8
    ...

- ``target_mm`` (or ``target``, in mm; ``target_in``): the commanded position.
- ``direction``: of the approach; ``+``, ``up``, ``forward`` or ``1``, and ``-``, ``down``, ``reverse`` or ``-1``.
- ``run``: a whole number; every target needs the same runs in every direction that was measured.
- ``deviation_um`` (or ``_mm``, ``_in``): position reached minus target; or ``position_mm`` (``_um``, ``_in``), the
  position reached, from which the target is taken here.

Order does not matter, other columns are ignored, and lines that start with ``#`` are skipped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from statistics import NormalDist

import numpy as np

from leadscrew.analysis.positioning import Positioning, positioning
from leadscrew.csvlines import number, read_lines
from leadscrew.kernel.errors import DataError
from leadscrew.kernel.sheet import nearest

UM = {"um": 1.0, "mm": 1000.0, "in": 25400.0}
TARGETS = {"target": "mm", "target_mm": "mm", "target_in": "in"}
VALUES = {f"{what}_{unit}": (what, unit) for what in ("deviation", "position") for unit in UM}
UP, DOWN = ("+", "up", "forward", "1", "+1"), ("-", "−", "down", "reverse", "-1")
FARTHEST_UM = 1e5
"""A deviation of 100 mm is no deviation: the unit is wrong, or positions stand where deviations should."""

Approach = tuple[float, bool, int]
"""Target in mm, whether in positive direction, run."""


def read_positioning(path: str | Path) -> Positioning:
    """The test in a file, evaluated.

    Raises:
        DataError: what is wrong with the file, by row (as an editor counts lines) and column; an approach twice or
            missing; fewer than two runs or two targets.
    """
    path = Path(path)
    lines = read_lines(path, "target_mm, direction, run, deviation_um")
    row, header = lines[0]
    target = _column(path, row, header, TARGETS)
    value = _column(path, row, header, VALUES)
    places = {n: _place(path, row, header, n) for n in ("direction", "run")}
    found: dict[Approach, tuple[int, float]] = {}
    for row, cells in lines[1:]:
        if len(cells) != len(header):
            raise DataError(f"{path}, row {row}: {len(cells)} cells where the header has {len(header)}")
        at = number(path, row, target, cells[header.index(target)]) * UM[TARGETS[target]] / 1000.0
        upwards = _direction(path, row, cells[places["direction"]])
        run = _run(path, row, cells[places["run"]])
        what, unit = VALUES[value]
        measured = number(path, row, value, cells[header.index(value)]) * UM[unit]
        deviation = round(measured - (1000.0 * at if what == "position" else 0.0), 9)
        if abs(deviation) > FARTHEST_UM:
            raise DataError(
                f"{path}, row {row}, column {value!r}: a deviation of {deviation / 1000.0:g} mm from the target "
                f"{at:g} mm; expected at most {FARTHEST_UM / 1000.0:g} mm: is the unit right?"
            )
        key = (at, upwards, run)
        if key in found:
            raise DataError(f"{path}, row {row}: {_said(*key)} stands in row {found[key][0]} already")
        found[key] = (row, deviation)
    return _evaluated(path, {key: deviation for key, (_, deviation) in found.items()})


def _evaluated(path: Path, found: dict[Approach, float]) -> Positioning:
    targets, ways, runs = (sorted({key[i] for key in found}) for i in range(3))
    missing = [(t, w, r) for t in targets for w in ways for r in runs if (t, w, r) not in found]
    if missing:
        more = f", and {len(missing) - 1} more" if len(missing) > 1 else ""
        raise DataError(
            f"{path}: {_said(float(missing[0][0]), bool(missing[0][1]), int(missing[0][2]))} is missing{more}; every "
            "target needs every run in each direction"
        )
    if len(runs) < 2:
        raise DataError(f"{path}: one run; repeatability needs at least 2, and the standard asks for 5")
    if len(targets) < 2:
        raise DataError(f"{path}: one target; expected at least 2, and the standard asks for 5 or more")
    grids = {w: np.array([[found[float(t), bool(w), int(r)] for r in runs] for t in targets]) for w in ways}
    return positioning(targets, grids.get(True), grids.get(False))


def _said(target: float, upwards: bool, run: int) -> str:
    return f"target {target:g} mm, direction {'+' if upwards else '-'}, run {run}"


def _column(path: Path, row: int, header: list[str], known: Mapping[str, object]) -> str:
    """The one column of the header that is known."""
    found = [name for name in header if name in known]
    if not found and any(";" in name or "\t" in name for name in header):
        raise DataError(
            f"{path}, row {row}: {','.join(header)!r} is not separated by commas; expected commas, and dots in numbers"
        )
    if not found:
        near = next((f"; {name!r} is not one of them" for name in header if name.split("_")[0] in str(known)), "")
        raise DataError(
            f"{path}, row {row}: expected a column {', '.join(list(known)[:-1])} or {list(known)[-1]}{near}"
        )
    if len(found) > 1:
        raise DataError(f"{path}, row {row}: the columns {' and '.join(map(repr, found))} say the same; keep one")
    return found[0]


def _place(path: Path, row: int, header: list[str], name: str) -> int:
    if header.count(name) != 1:
        how = f"appears {header.count(name)} times" if name in header else f"is missing{nearest(name, header)}"
        raise DataError(f"{path}, row {row}: the column {name!r} {how}")
    return header.index(name)


def _direction(path: Path, row: int, cell: str) -> bool:
    word = cell.lower()
    if word not in UP and word not in DOWN:
        raise DataError(
            f"{path}, row {row}, column 'direction': {cell!r} is no direction; expected +, up, forward or 1, or -, "
            "down, reverse or -1"
        )
    return word in UP


def _run(path: Path, row: int, cell: str) -> int:
    if not (cell.isascii() and cell.isdigit()) or len(cell) > 9:
        raise DataError(f"{path}, row {row}, column 'run': {cell!r} is not a whole number from 0 on")
    return int(cell)


EXAMPLE_MM = (11.3, 62.8, 118.1, 164.9, 222.6, 271.4, 329.7, 376.2, 431.5)


def example() -> str:
    """A made test as a file: nothing of it was measured, and its first lines say how it was made."""
    head = (
        "# A made example, not a measurement: a screw of 10 mm lead and 450 mm travel.\n"
        "# deviation = 0.02 um/mm * target + 1.5 um * sin(2 pi target / 10 mm) -+ 2.1 um in direction +/-\n"
        "#   + 0.002 um/mm * target * run (the screw warms) + scatter of 0.5 um; rounded to 0.1 um.\n"
        "target_mm,direction,run,deviation_um\n"
    )
    lines, count = [], 0
    for run in range(1, 6):
        for sign in (1, -1):
            for target in EXAMPLE_MM[::sign]:
                count += 1
                scatter = NormalDist(0.0, 0.5).inv_cdf((0.5 + 0.6180339887498949 * count) % 1.0)
                deviation = 0.02 * target + 1.5 * math.sin(0.2 * math.pi * target) - 2.1 * sign
                deviation += 0.002 * target * run + scatter
                lines.append(f"{target:g},{'+' if sign > 0 else '-'},{run},{deviation:.1f}\n")
    return head + "".join(lines)
