"""The folder of ``leadscrew simulate --out``: signals, the units that its blocks say, and which signal is what."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from leadscrew import reading
from leadscrew.kernel.errors import DataError, LeadscrewError
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
    if isinstance(known, dict) and isinstance(unit := next((known[s] for s in slots if known.get(s)), None), str):
        return _derived(signal, unit)
    blocks = said.get("blocks")
    parameters = said.get("parameters")
    per_si = parameters.get("plant.per_si") if isinstance(parameters, dict) else None
    unit = (
        next((u for s in slots if (u := _of_block(blocks.get(s), s)) is not None and u), "")
        if isinstance(blocks, dict)
        else ""
    )
    if slots[0] == "plant" and isinstance(per_si, int | float) and per_si > 0.0 and unit == "mm":
        unit = "mm" if per_si == 1000.0 else f"{1.0 / per_si:.17g} m"
    return _derived(signal, unit)


def _derived(signal: str, unit: str) -> str:
    """The unit of a signal that is derived from one in ``unit``."""
    if signal.endswith((".velocity", ".acceleration")) and unit:
        return f"{unit}/s" if signal.endswith(".velocity") else f"{unit}/s2"
    return unit


def _of_block(name: Any, slot: str) -> str | None:
    from leadscrew import catalogue

    if not isinstance(name, str) or name not in catalogue.block_names():  # a name of a file would run its Python
        return None
    try:
        block = catalogue.block(name)
        return block.unit if block.kind == slot else None
    except LeadscrewError:
        return None
