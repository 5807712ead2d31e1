"""Logs for the tests of the design: the paper's Table 1 with something done to it, and moves worked out by hand."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import leadscrew

TABLE_1 = Path(leadscrew.__file__).parent / "studies" / "vud_lathe" / "data" / "table1.csv"
COLUMNS = ("k", "r", "e", "ec", "rho")


def rows() -> list[dict[str, str]]:
    with TABLE_1.open(newline="") as file:
        return list(csv.DictReader(file))


def write(path: Path, wanted, columns=COLUMNS) -> Path:
    lines = [",".join(columns), *(",".join(str(r[c]) for c in columns) for r in wanted)]
    path.write_text("\n".join(lines) + "\n")
    return path


def swapped(first: str, second: str, only: str | None = None) -> list[dict[str, str]]:
    """Table 1, or one of its moves, with two columns under each other's name."""
    return [{**r, first: r[second], second: r[first]} for r in rows() if only in (None, r["r"])]


def glide(target: float, step: float = 0.01, seconds: float = 2.0, pole: float = 4.0):
    """Signals of a move whose error falls as ``target exp(-pole t)``, under the duty that does it at 400 mm/s."""
    found = []
    for n in range(round(seconds / step) + 1):
        error = target * math.exp(-pole * n * step)
        found.append({"time": n * step, "command": target, "feedback": target - error, "output": -pole * error / 400.0})
    return found
