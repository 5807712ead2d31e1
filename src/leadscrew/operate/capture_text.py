"""What a capture says of itself besides its rows, as one line of JSON, and back."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew import reading
from leadscrew.kernel.errors import DataError, ValueRefused
from leadscrew.operate.capture import Capture, check

MOST_TEXT = 4_000_000
"""Characters of what a capture says of itself."""


def said_of(capture: Capture, variables: Sequence[str] | None = None) -> str:
    """All but the rows, as a line of ASCII."""
    held = {
        "schema_version": 1, "name": capture.name, "columns": list(capture.columns), "units": dict(capture.units),
        "period_s": capture.period_s, "first_period": capture.first_period, "trigger_row": capture.trigger_row,
        "rows": len(capture.rows), "about": capture.about, **({"variables": list(variables)} if variables else {}),
    }  # fmt: skip
    return json.dumps(_plain(held), allow_nan=False)


def _plain(value: Any) -> Any:
    """A value that JSON can hold: arrays as lists, numbers that are not finite by name, others as their text."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(float(value))
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


def heard(path: Path, text: str) -> dict[str, Any]:
    """What the line of JSON says, each part of it of its type."""
    if len(text) > MOST_TEXT:
        raise DataError(f"{path}: says {len(text) / 1e6:.0f} MB of itself besides its rows; up to 4 MB are read")
    said = reading.json_of(text, f"{path}: what is said of the capture")
    kinds = {
        "name": str, "columns": list, "units": dict, "period_s": float | int, "first_period": int, "trigger_row": int,
        "rows": int, "about": dict,
    }  # fmt: skip
    wrong = [k for k, kind in kinds.items() if not isinstance(said, dict) or not isinstance(said.get(k), kind)]
    if not wrong and (said.get("schema_version") != 1 or not all(isinstance(c, str) for c in said["columns"])):
        wrong = ["schema_version" if said.get("schema_version") != 1 else "columns"]
    if wrong:
        raise DataError(f"{path}: what is said of the capture has no sound {wrong[0]}; this version reads version 1")
    return said


def capture_of(path: Path, said: dict[str, Any], columns: Sequence[np.ndarray]) -> Capture:
    n, period = said["rows"], said["period_s"]
    if any(c.shape != (n,) or c.dtype != np.float64 for c in columns) or len(columns) != len(said["columns"]):
        raise DataError(f"{path}: its columns are not those that it says: {len(said['columns'])} of {n} numbers")
    if not 0.0 < period < math.inf or not 0 <= said["trigger_row"] < n:
        raise DataError(
            f"{path}: a period of {period!r} s and row {said['trigger_row']} of {n} as trigger fit no capture"
        )
    units = {str(k): str(v) for k, v in said["units"].items()}
    capture = Capture(
        said["name"], tuple(said["columns"]), units, float(period), said["first_period"], said["trigger_row"],
        np.column_stack(columns), said["about"],
    )  # fmt: skip
    try:
        check(capture)
    except ValueRefused as problem:
        raise DataError(f"{path}: {problem}") from None
    return capture
