"""The folder of ``leadscrew simulate --out``: signals, the units that its blocks say, and which signal is what."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from leadscrew import reading
from leadscrew.kernel.errors import DataError
from leadscrew.logs.parquet import read_parquet
from leadscrew.logs.table import Table

SIGNALS, MANIFEST = "signals.parquet", "run.json"


def read_run(folder: Path) -> Table:
    """The table of a run: drive is ``output``, position ``feedback``.

    Raises:
        DataError: it is no such folder, or broken.
    """
    folder = folder.parent if folder.name in (MANIFEST, SIGNALS) else folder
    if not (folder / SIGNALS).is_file():
        raise DataError(f"{folder}: is a folder without {SIGNALS}; expected one of leadscrew simulate --out, or a file")
    table = read_parquet(folder / SIGNALS)
    said = _manifest(folder)
    units = {name: unit for name in table.columns if (unit := _unit(name, said))}
    guess = {
        "time": "time", "drive": "output", "position": "feedback",
        "command": "command" if "command" in table.columns else "command.position",
    }  # fmt: skip
    return replace(
        table, units={**table.units, **units}, source=str(folder), form="leadscrew run",
        guess={role: name for role, name in guess.items() if name in table.columns},
    )  # fmt: skip


def _manifest(folder: Path) -> dict[str, Any]:
    return reading.json_object(folder / MANIFEST) if (folder / MANIFEST).is_file() else {}


def _unit(signal: str, said: dict[str, Any]) -> str:
    """The unit of a signal as far as the blocks of the run say it."""
    root = signal.split(".")[0]
    if root == "time":
        return "s"
    slots = {"output": ("controller",), "applied": ("controller",), "disturbance": ("disturbance",)}.get(
        root, ("plant", "sensor", "reference")
    )
    known = said.get("units")
    unit = next((known[s] for s in slots if known.get(s)), "") if isinstance(known, dict) else ""
    return _derived(signal, unit) if isinstance(unit, str) else ""


def _derived(signal: str, unit: str) -> str:
    """The unit of a signal that is derived from one in ``unit``."""
    if signal.endswith((".velocity", ".acceleration")) and unit:
        return f"{unit}/s" if signal.endswith(".velocity") else f"{unit}/s2"
    return unit
