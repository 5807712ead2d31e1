"""What a log file holds, as rows and sentences for people and as one object for programs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from leadscrew.logs.axis_file import Seen
from leadscrew.logs.measure import beyond_step, encoder_step
from leadscrew.logs.table import Table


class Column(NamedTuple):
    """One column of a file."""

    name: str
    unit: str
    """Empty where the file names none."""
    role: str
    """Empty where it has none."""
    kind: str
    """``numbers``, ``constant`` or ``words``."""
    low: float | None
    high: float | None
    step: float | None
    """Of the grid that its values lie on; None where they lie on none."""
    missing: int
    """Cells without a value."""
    words: tuple[str, ...] = ()
    """The first different ones."""


MOST_WORDS = 5


def columns_of(table: Table, roles: dict[str, str] | None = None) -> list[Column]:
    """Every column, with the role that it has."""
    role = {name: r for r, name in (roles or {}).items()}
    found = []
    for name, values in table.columns.items():
        real = values[np.isfinite(values)]
        low, high = (float(real.min()), float(real.max())) if len(real) else (None, None)
        kind = "constant" if low == high else "numbers"
        step = encoder_step(real) or None if kind == "numbers" else None
        missing = len(values) - len(real)
        found.append(Column(name, table.units.get(name, ""), role.get(name, ""), kind, low, high, step, missing))
    for name, cells in table.texts.items():
        words = tuple(dict.fromkeys(c for c in cells if c))
        found.append(
            Column(name, "", role.get(name, ""), "words", None, None, None, cells.count(""), words[: MOST_WORDS + 1])
        )
    return found


def sentences(seen: Seen) -> list[str]:
    """How the log is sampled and what was read of it; findings are apart."""
    log = seen.log
    if log is None:
        return []
    unit = log.unit.position
    command = ", command" if log.command is not None else ""
    velocity = ", velocity" if log.velocity is not None else ""
    step = f"steps of {log.encoder_step:.3g} {unit}" if log.encoder_step else "no steps"
    rounding = (
        "" if not log.encoder_step or beyond_step(log.noise, log.encoder_step) else " (the rounding to steps alone)"
    )
    own = "" if log.unit.drive in ("N", "N m") else ", its own unit in place of a force"
    return [
        f"{len(log.time)} samples every {log.period:.6g} s ({1.0 / log.period:.6g} Hz), from {log.time[0]:g} to "
        f"{log.time[-1]:g} s; position{command}{velocity} in {unit}, drive in {_drive(log.unit.drive)}{own}",
        f"position: {step}, noise {log.noise:.2g} {unit} rms{rounding}, travel {np.ptp(log.position):.4g} {unit}",
    ]


def _drive(unit: str) -> str:
    return "units of 1" if unit == "1" else unit


def as_dict(table: Table, seen: Seen | None) -> dict[str, Any]:
    """Everything for JSON."""
    log = None if seen is None else seen.log
    return {
        "file": table.source,
        "form": table.form,
        "rows": table.rows,
        "columns": [c._asdict() for c in columns_of(table, None if seen is None else seen.columns)],
        "constants": table.constants,
        "notes": table.notes,
        "roles": {} if seen is None else seen.columns,
        "units": {} if seen is None else seen.units,
        "log": None
        if log is None
        else {
            "samples": len(log.time), "period_s": log.period, "start_s": float(log.time[0]),
            "end_s": float(log.time[-1]), "position_unit": log.unit.position, "drive_unit": log.unit.drive,
            "encoder_step": log.encoder_step, "noise": log.noise,
            "noise_beyond_step": beyond_step(log.noise, log.encoder_step),
            "travel": [float(log.position.min()), float(log.position.max())],
        },
        "findings": [] if seen is None else [f._asdict() for f in seen.findings],
    }  # fmt: skip
