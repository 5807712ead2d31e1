"""Logs that are wrong, made from one that is right, and what a user must get from a command that reads one."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path

import numpy as np

HEADER = ("time_s", "force_N", "position_m", "command_m")
MASS, VISCOUS, COULOMB = 40.0, 120.0, 15.0
ROW = 2000
"""Row of data, counted from 0, that single faults are put into; line ROW + 2 of the file."""


def right(seconds: float = 6.0, period: float = 1e-3) -> np.ndarray:
    """Columns of :data:`HEADER`: moves as sums of sines, the force by inverse dynamics, position to 0.1 um."""
    t = np.arange(round(seconds / period)) * period
    parts = [(0.05, 1.0), (0.02, 2.7), (0.006, 5.3)]
    x = sum(a * (1.0 - np.cos(w * t)) for a, w in parts)
    v = sum(a * w * np.sin(w * t) for a, w in parts)
    acceleration = sum(a * w * w * np.cos(w * t) for a, w in parts)
    force = MASS * acceleration + VISCOUS * v + COULOMB * np.sign(v)
    noise = 1e-7 * np.random.default_rng(1).standard_normal(len(t))
    return np.column_stack([t, np.round(force, 3), np.round(x + noise, 7), np.round(x + 1e-4, 7)])


def text(rows: np.ndarray, header: Iterable[str] = HEADER) -> str:
    """As CSV."""
    return "\n".join([",".join(header), *(",".join(f"{v:.10g}" for v in row) for row in rows)]) + "\n"


@lru_cache(maxsize=1)
def right_text() -> str:
    """The right log as CSV."""
    return text(right())


def cell(column: int, word: str) -> str:
    """The right log with one cell replaced."""
    lines = right_text().splitlines()
    cells = lines[ROW + 1].split(",")
    cells[column] = word
    lines[ROW + 1] = ",".join(cells)
    return "\n".join(lines) + "\n"


def _changed(change: Callable[[np.ndarray], None]) -> str:
    rows = right()
    change(rows)
    return text(rows)


def _scaled(column: int, factor: float) -> str:
    def change(rows: np.ndarray) -> None:
        rows[:, column] *= factor
        if column == 2:
            rows[:, 3] *= factor

    return _changed(change)


def _swapped(rows: np.ndarray) -> None:
    rows[:, [1, 2]] = rows[:, [2, 1]]


def _jump(rows: np.ndarray) -> None:
    rows[ROW:, 2] += 0.004


def _spike(rows: np.ndarray) -> None:
    rows[ROW, 2] += 0.004


def _still(rows: np.ndarray) -> None:
    rows[:, 1], rows[:, 3] = 3.0 + 0.01 * np.sin(rows[:, 0]), 0.05
    rows[:, 2] = 0.05 + 1e-7 * (np.arange(len(rows)) % 2)


def _back(rows: np.ndarray) -> None:
    rows[ROW, 0] = rows[ROW - 3, 0]


def _gap(rows: np.ndarray) -> None:
    rows[ROW:, 0] += 2.0


def _clipped(rows: np.ndarray) -> None:
    rows[:, 1] = np.clip(rows[:, 1], -12.0, 12.0)


def _held(rows: np.ndarray) -> None:
    rows[:, 1] = 5.0


def _turned(rows: np.ndarray) -> None:
    rows[:, 1] *= -1.0


LOGS: dict[str, Callable[[], str | bytes]] = {
    "position in mm under a header in m": lambda: _scaled(2, 1000.0),
    "position in km under a header in m": lambda: _scaled(2, 1e-3),
    "time in ms under a header in s": lambda: _scaled(0, 1000.0),
    "force in kN under a header in N": lambda: _scaled(1, 1e-3),
    "force and position swapped": lambda: _changed(_swapped),
    "force with the other sign": lambda: _changed(_turned),
    "standstill": lambda: _changed(_still),
    "two rows": lambda: text(right()[:2]),
    "zeros": lambda: text(np.zeros((3000, 4))),
    "zeros but for the time": lambda: text(np.column_stack([right()[:, 0], np.zeros((6000, 3))])),
    "a jump of the encoder": lambda: _changed(_jump),
    "a spike of the encoder": lambda: _changed(_spike),
    "a clipped drive": lambda: _changed(_clipped),
    "a constant drive": lambda: _changed(_held),
    "NaN in a cell": lambda: cell(2, "nan"),
    "an empty cell": lambda: cell(1, ""),
    "a word in a column of numbers": lambda: cell(2, "broken"),
    "1e400 in a cell": lambda: cell(1, "1e400"),
    "inf in a cell": lambda: cell(1, "inf"),
    "an empty file": lambda: "",
    "a header alone": lambda: ",".join(HEADER) + "\n",
    "bytes that are no text": lambda: bytes(range(256)) * 40,
    "two columns of one name": lambda: text(right(), ("time_s", "force_N", "position_m", "position_m")),
    "a time that steps back": lambda: _changed(_back),
    "a time that falls": lambda: text(right()[::-1]),
    "a gap of two seconds": lambda: _changed(_gap),
    "a row that is too short": lambda: _short(),
    "no columns of those names": lambda: text(right(), ("a", "b", "c", "d")),
}
"""What is wrong, and the file."""
FLAGGED = {"a clipped drive", "a spike of the encoder", "force in kN under a header in N"}
"""Of these a command may go on, if it says so."""


def _short() -> str:
    lines = right_text().splitlines()
    lines[ROW + 1] = lines[ROW + 1].rsplit(",", 2)[0]
    return "\n".join(lines) + "\n"


def write(folder: Path, name: str) -> Path:
    """The log of that name, as a file."""
    made = LOGS[name]()
    path = folder / "log.csv"
    path.write_bytes(made if isinstance(made, bytes) else made.encode())
    return path


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def listing(folder: Path) -> dict[str, str]:
    """Every file below with its hash: to see that nothing was written or changed."""
    return {str(p.relative_to(folder)): digest(p) for p in sorted(folder.rglob("*")) if p.is_file()}
