"""Accuracy and repeatability of positioning a linear axis, with the quantities of ISO 230-2 (edition of 2014).

An axis goes to each of ``m`` target positions ``n`` times from each of two directions; a deviation is the position that
it reached minus the target. With ``+`` for the approach in positive direction and ``-`` for the other:

| quantity | equation |
|---|---|
| mean unidirectional deviation at a target | ``x+_i = 1/n sum_j x+_ij`` |
| mean bidirectional deviation at a target | ``x_i = (x+_i + x-_i) / 2`` |
| reversal value at a target | ``B_i = x+_i - x-_i`` |
| estimator of the repeatability at a target | ``s+_i = sqrt(1/(n-1) sum_j (x+_ij - x+_i)^2)`` |
| unidirectional repeatability at a target | ``R+_i = 4 s+_i`` |
| bidirectional repeatability at a target | ``R_i = max(2 s+_i + 2 s-_i + abs(B_i), R+_i, R-_i)`` |
| reversal value of the axis, and its mean | ``B = max abs(B_i)``, ``1/m sum_i B_i`` |
| repeatability of the axis | ``R+ = max R+_i``, ``R = max R_i`` |
| systematic error, unidirectional | ``E+ = max x+_i - min x+_i`` |
| systematic error, bidirectional | ``E = max(x+_i, x-_i) - min(x+_i, x-_i)`` |
| mean bidirectional error | ``M = max x_i - min x_i`` |
| accuracy, unidirectional | ``A+ = max(x+_i + 2 s+_i) - min(x+_i - 2 s+_i)`` |
| accuracy, bidirectional | the same over both directions at once |

The text of the standard was not at hand: the equations are its well-known ones, written down from general knowledge.
The uncertainty of the measurement itself, which the standard asks to be stated beside each number, is not estimated.

The door for a measured positioning test: a CSV file with one line for each approach of a target.

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
from dataclasses import dataclass, fields
from pathlib import Path
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from leadscrew.kernel.parameters import nearest
from leadscrew.util.csv_lines import number, read_lines
from leadscrew.util.errors import DataError, ValueRefused

RUNS, TARGETS, TARGETS_PER_METRE, LONGEST_MM = 5, 5, 5, 2000.0
"""What the standard asks for: runs in each direction, targets, targets a metre; and up to which travel it does."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OneWay:
    """Results of one direction, in um; arrays have one value for each target."""

    mean: Array
    """Mean unidirectional deviation."""
    s: Array
    """Estimator of the unidirectional repeatability, with n - 1."""
    repeatability_at: Array
    repeatability: float
    systematic: float
    accuracy: float


@dataclass(frozen=True)
class BothWays:
    """Results of both directions together, in um; arrays have one value for each target."""

    mean: Array
    """Mean bidirectional deviation."""
    reversal_at: Array
    """Signed: positive where the axis ends further in positive direction when it came from below."""
    repeatability_at: Array
    reversal: float
    """Largest absolute reversal value."""
    mean_reversal: float
    repeatability: float
    systematic: float
    mean_error: float
    accuracy: float


@dataclass(frozen=True)
class Positioning:
    """A positioning test, evaluated. What was not measured is ``None``."""

    targets_mm: Array
    """Rising."""
    up_um: Array | None
    """Deviations, one row for each target, one column for each run, approached in positive direction."""
    down_um: Array | None
    up: OneWay | None
    down: OneWay | None
    both: BothWays | None

    @property
    def runs(self) -> int:
        """How often each target was approached from a direction."""
        found = self.up_um if self.up_um is not None else self.down_um
        return 0 if found is None else int(found.shape[1])

    @property
    def travel_mm(self) -> float:
        """From the first target to the last."""
        return float(self.targets_mm[-1] - self.targets_mm[0])

    def notes(self) -> list[str]:
        """Where the test falls short of what the standard asks for, a sentence each."""
        found = []
        if self.runs < RUNS:
            found.append(f"{self.runs} runs in each direction where the standard asks for {RUNS}")
        count = len(self.targets_mm)
        if count < TARGETS:
            found.append(f"{count} targets where the standard asks for at least {TARGETS}")
        elif self.travel_mm > LONGEST_MM:
            found.append(
                f"a travel of {self.travel_mm:g} mm: above {LONGEST_MM:g} mm the standard has a scheme of its own"
            )
        elif count < TARGETS_PER_METRE * self.travel_mm / 1000.0:
            found.append(f"{count} targets on {self.travel_mm:g} mm where the standard asks for 5 a metre")
        if count > 2 and np.ptp(np.diff(self.targets_mm)) < 1e-6 * self.travel_mm:
            found.append("targets at equal distances: an error that repeats with the pitch of the screw may not show")
        if self.both is None:
            found.append("one direction only: no reversal value, no bidirectional accuracy, repeatability or error")
        return found

    def compensated(self) -> Positioning:
        """The same test with the mean deviation of each direction taken out: what a perfect table would leave."""
        found = [
            None if x is None or way is None else x - way.mean[:, None]
            for x, way in ((self.up_um, self.up), (self.down_um, self.down))
        ]
        return positioning(self.targets_mm, *found)

    def as_dict(self) -> dict[str, Any]:
        """Everything for JSON; lengths in um unless the key says mm."""
        ways = {"up": self.up, "down": self.down, "bidirectional": self.both}
        return {
            "targets_mm": self.targets_mm.tolist(),
            "runs": self.runs,
            "deviations_um": {
                "up": None if self.up_um is None else self.up_um.tolist(),
                "down": None if self.down_um is None else self.down_um.tolist(),
            },
            **{name: None if way is None else _plain(way) for name, way in ways.items()},
        }


def positioning(targets_mm: Any, up_um: Any = None, down_um: Any = None) -> Positioning:
    """The quantities of ISO 230-2 from deviations.

    Args:
        targets_mm: ``m`` rising target positions.
        up_um: ``m x n`` deviations (position reached minus target) after approaches in positive direction, or nothing.
        down_um: the same after approaches in negative direction, or nothing.

    Raises:
        ValueRefused: no direction at all, fewer than two targets or two runs, shapes that do not fit, targets that do
            not rise, or a value that is not finite.
    """
    targets = np.array(targets_mm, dtype=np.float64)
    if targets.ndim != 1 or targets.size < 2 or not np.all(np.isfinite(targets)) or np.any(np.diff(targets) <= 0):
        raise ValueRefused(f"targets_mm = {targets_mm!r}: expected two or more finite numbers that rise")
    if up_um is None and down_um is None:
        raise ValueRefused("a positioning test needs the deviations of at least one direction")
    up = None if up_um is None else _deviations("up_um", up_um, targets.size)
    down = None if down_um is None else _deviations("down_um", down_um, targets.size)
    if up is not None and down is not None and up.shape != down.shape:
        raise ValueRefused(f"down_um has {down.shape[1]} runs where up_um has {up.shape[1]}; expected the same number")
    forth = None if up is None else _one_way(up)
    back = None if down is None else _one_way(down)
    both = None if forth is None or back is None else _both_ways(forth, back)
    return Positioning(targets, up, down, forth, back, both)


class Correction(NamedTuple):
    """What to add to a commanded position so that the axis ends on it, by direction of the move; all in one unit."""

    nominal: Array
    """Rising positions."""
    forward: Array
    reverse: Array

    def at(self, position: float | Array, upwards: bool) -> Array:
        """The correction at a position: linear between the points, constant beyond the ends."""
        return np.asarray(np.interp(position, self.nominal, self.forward if upwards else self.reverse))


def correction(test: Positioning) -> Correction:
    """The mean deviation of each direction with its sign turned, in mm.

    Raises:
        ValueRefused: a test of one direction.
    """
    if test.up is None or test.down is None:
        raise ValueRefused(
            "a screw compensation needs both directions, and the test has one: each is corrected with its own values"
        )
    return Correction(test.targets_mm, -0.001 * test.up.mean, -0.001 * test.down.mean)


def _deviations(name: str, given: Any, targets: int) -> Array:
    found = np.array(given, dtype=np.float64)
    if found.ndim != 2 or found.shape[0] != targets or found.shape[1] < 2:
        raise ValueRefused(f"{name} has the shape {found.shape}; expected {targets} targets by 2 or more runs")
    if not np.all(np.isfinite(found)):
        raise ValueRefused(f"{name} holds a value that is not finite; expected deviations in um")
    return found


def _one_way(x: Array) -> OneWay:
    mean, s = x.mean(axis=1), x.std(axis=1, ddof=1)
    return OneWay(mean, s, 4.0 * s, float(4.0 * s.max()), float(np.ptp(mean)), _accuracy(mean, s))


def _both_ways(up: OneWay, down: OneWay) -> BothWays:
    mean, reversal = 0.5 * (up.mean + down.mean), up.mean - down.mean
    spread = 2.0 * up.s + 2.0 * down.s + np.abs(reversal)
    at = np.maximum(spread, np.maximum(up.repeatability_at, down.repeatability_at))
    means, s = np.concatenate([up.mean, down.mean]), np.concatenate([up.s, down.s])
    return BothWays(
        mean, reversal, at, float(np.abs(reversal).max()), float(reversal.mean()), float(at.max()),
        float(np.ptp(means)), float(np.ptp(mean)), _accuracy(means, s),
    )  # fmt: skip


def _accuracy(mean: Array, s: Array) -> float:
    return float((mean + 2.0 * s).max() - (mean - 2.0 * s).min())


def _plain(way: OneWay | BothWays) -> dict[str, Any]:
    found = {f.name: getattr(way, f.name) for f in fields(way)}
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in found.items()}


UM = {"um": 1.0, "mm": 1000.0, "in": 25400.0}
TARGET_COLUMNS = {"target": "mm", "target_mm": "mm", "target_in": "in"}
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
    target = _column(path, row, header, TARGET_COLUMNS)
    value = _column(path, row, header, VALUES)
    places = {n: _place(path, row, header, n) for n in ("direction", "run")}
    found: dict[Approach, tuple[int, float]] = {}
    for row, cells in lines[1:]:
        if len(cells) != len(header):
            raise DataError(f"{path}, row {row}: {len(cells)} cells where the header has {len(header)}")
        at = number(path, row, target, cells[header.index(target)]) * UM[TARGET_COLUMNS[target]] / 1000.0
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
        "# A synthetic example, not a measurement: a screw of 10 mm lead and 450 mm travel.\n"
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
