"""The amplitudes of Table II as columns: five lines a spindle speed, in um."""

from __future__ import annotations

import csv
from pathlib import Path

TABLE_2 = Path(__file__).parent / "data" / "table2.csv"

with TABLE_2.open(newline="", encoding="utf-8") as _file:
    _ROWS = list(csv.DictReader(_file))


def _columns(name: str) -> dict[int, tuple[float, ...]]:
    speeds = sorted({int(row["spindle_rpm"]) for row in _ROWS})
    return {rpm: tuple(float(r[name]) for r in _ROWS if int(r["spindle_rpm"]) == rpm) for rpm in speeds}


PID_UM = _columns("pid_um")
"""By spindle speed in 1/min, in the order of the lines: about 2.1, 3.5, 4.9, 6.3, 7.7 Hz."""

NPID_UM = _columns("npid_um")
"""The same under NPID."""

PRINTED_PERCENT = _columns("printed_percent")
"""The printed error reduction, %."""
