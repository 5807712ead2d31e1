"""The workflow without a sensor, end to end: drawing, program, piece, scan, compensated program, next piece.

Everything goes through what a user has: the program is read back from its text before it is cut, and the cut line from
points with four decimals. Each piece has a texture of its own.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path as File
from typing import NamedTuple

import numpy as np

from leadscrew.paths.path import Path
from leadscrew.studies.sofnn_tangent.scenarios import LINES, MATERIAL_NAMES, shape

DATA = File(__file__).with_name("data")
TABLE = DATA / "workflow.csv"
DRAWINGS = ("leaf.svg", "petal.dxf")
"""An SVG with nested transforms, Bezier curves, an ellipse and a rounded rectangle; a DXF in inches with a spline in a
turned block and a slot of bulges."""
ALL_DRAWINGS = (*LINES, *DRAWINGS)
SEEDS = (11, 12, 13, 21, 22, 23, 24, 25, 26)
"""Runs of a case: each with textures and noise of its own."""
NOISE_MM = 0.05
PLACED = (40.0, -25.0, 12.0)
"""How a piece lay on the scanner: shift in mm, turn in deg."""
COLUMNS = ("drawing", "material", "scan", "seed", "first_deg", "second_deg", "third_deg", "largest_deg", "clipped_mm")


class Trip(NamedTuple):
    """Errors (deg rms) of pieces that follow each other, and what the last compensation did."""

    errors: tuple[float, ...]
    largest: float
    """Offset, deg."""
    clipped: float
    """Length at the limit, mm."""

    @property
    def ratio(self) -> float:
        """The second piece's error as a share of the first's."""
        return self.errors[1] / self.errors[0]


def paths_of(drawing: str) -> list[Path]:
    """The lines of a drawing: one of the study's by name, or a file."""
    if drawing in LINES:
        return [shape(drawing)]
    from leadscrew.paths.read import read_drawing
    from leadscrew.tangent.example import FILE

    return list(read_drawing(FILE if drawing == "leaf.svg" else DATA / drawing).paths)


def first_program(drawing: str) -> str:
    """The program without compensation."""
    from leadscrew.tangent.emit import program
    from leadscrew.tangent.settings import Settings
    from leadscrew.tangent.stroke import strokes_of

    return program(strokes_of(paths_of(drawing), Settings()), Settings())


def trip(drawing: str, material: str = "fabric", scan: str = "exact", seed: int = SEEDS[0], pieces: int = 2) -> Trip:
    """Pieces cut one after the other, each with the program that the last one's scan made.

    ``scan``: ``exact``; ``scanner``, with noise on a piece that lay elsewhere, aligned by two marks; ``shape``, the
    same aligned by its own shape.
    """
    from leadscrew.tangent import machine
    from leadscrew.tangent.compensate import compensated
    from leadscrew.tangent.emit import program
    from leadscrew.tangent.machine import Scan, marks_of, scanned
    from leadscrew.tangent.measurement import Trace
    from leadscrew.tangent.program import program_of

    text, errors = first_program(drawing), []
    largest = clipped = 0.0
    for k in range(pieces):
        read = program_of(text, drawing)
        cuts = machine.cut(read.strokes, read.settings, material, seed=100 * seed + k)
        errors.append(machine.rms(cuts))
        if k + 1 == pieces:
            break
        how = Scan() if scan == "exact" else Scan(NOISE_MM, *PLACED, seed=100 * seed + k)
        none = np.empty(0)
        traces = [
            Trace(n, np.round(x, 4), np.round(y, 4), none, none, False, drawing)
            for n, (x, y) in enumerate(scanned(cuts, how), start=1)
        ]
        marks = marks_of(read.strokes, how) if scan == "scanner" else ()
        align = {"exact": "none", "scanner": "marks", "shape": "shape"}[scan]
        found = compensated(read.strokes, read.settings, traces, align=align, marks=marks)
        largest, clipped = found.largest, sum(one.clipped_mm for one in found.learned)
        text = program(found.strokes, read.settings)
    return Trip(tuple(errors), largest, clipped)


def measured_table(drawings: Sequence[str] = ALL_DRAWINGS, seeds: Sequence[int] = SEEDS) -> list[list[str]]:
    """All drawings in all materials with each kind of scan, three pieces each: rows of ``data/workflow.csv``.

    Takes half a minute a seed on a busy core.
    """
    rows = []
    for drawing in drawings:
        for material in MATERIAL_NAMES:
            for scan in ("exact", "scanner", "shape"):
                for seed in seeds:
                    found = trip(drawing, material, scan, seed, 3)
                    numbers = (*found.errors, found.largest, found.clipped)
                    rows.append([drawing, material, scan, str(seed), *(f"{v:.4f}" for v in numbers)])
    return rows


def kept_table() -> dict[tuple[str, str, str], np.ndarray]:
    """``data/workflow.csv``: by drawing, material and scan, the numbers of each seed."""
    with TABLE.open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    found: dict[tuple[str, str, str], list[list[float]]] = {}
    for row in rows[1:]:
        found.setdefault((row[0], row[1], row[2]), []).append([float(v) for v in row[4:]])
    return {key: np.array(values) for key, values in found.items()}


def ratios(drawings: Sequence[str], materials: Sequence[str], scan: str) -> np.ndarray:
    """Second piece by first, mean over the seeds: array [drawing, material]."""
    table = kept_table()
    means = [[table[d, m, scan].mean(axis=0) for m in materials] for d in drawings]
    return np.array([[row[1] / row[0] for row in line] for line in means])


def each_ratio(drawings: Sequence[str], materials: Sequence[str], scan: str) -> np.ndarray:
    """Second piece by first, each run on its own: array [drawing, material, run]."""
    table = kept_table()
    return np.array([[table[d, m, scan][:, 1] / table[d, m, scan][:, 0] for m in materials] for d in drawings])


def main() -> None:
    """Makes ``data/workflow.csv``."""
    from leadscrew.util.atomic import atomic_write

    atomic_write("\n".join(",".join(r) for r in [list(COLUMNS), *measured_table()]) + "\n", TABLE)


if __name__ == "__main__":
    main()
