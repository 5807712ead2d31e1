"""Any log file as a table: what is in it decides how it is read, its suffix only where that says nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from leadscrew.logs.header import split
from leadscrew.logs.table import Table
from leadscrew.util import parquet, reading
from leadscrew.util.errors import DataError, entry_point
from leadscrew.util.reading import check_log


@entry_point
def read_table(path: str | Path) -> Table:
    """What a log file holds: text, Parquet, MATLAB, or the folder of ``leadscrew simulate --out``.

    Text is CSV, TSV, semicolons or white space, with or without a header, with a decimal point or comma; LinuxCNC's
    halscope and halsampler are known. The file is only read.

    Raises:
        DataError: it cannot be read, is too large, holds no rows, or is broken: file, row and column.
    """
    from leadscrew.logs.mat import read_mat
    from leadscrew.logs.text import read_text

    where = Path(path)
    try:
        folder = where.is_dir()
    except ValueError as problem:
        raise DataError(f"{str(path)!r}: is no name of a file ({problem})") from None
    if folder or where.name == MANIFEST:
        table = read_run(where)
    else:
        check_log(where)
        kind = _kind(where)
        table = {"parquet": read_parquet, "mat": read_mat, "text": read_text}[kind](where)
    if not table.rows:
        raise DataError(f"{where}: has columns but no rows of data")
    return table


def _kind(path: Path) -> str:
    try:
        with path.open("rb") as file:
            head = file.read(128)
    except OSError as problem:
        raise DataError(f"{path}: cannot be read ({problem.strerror or problem})") from None
    if head.startswith(b"PAR1"):
        return "parquet"
    if head.startswith(b"MATLAB ") or path.suffix.casefold() == ".mat":
        return "mat"
    return "parquet" if path.suffix.casefold() in (".parquet", ".pq") else "text"


def read_parquet(path: Path) -> Table:
    """The table of a Parquet file.

    Raises:
        DataError: it cannot be read, or is too large.
    """
    held = parquet.read(path)
    units = {name: unit for name in held.numbers if (unit := held.units.get(name) or split(name)[1])}
    notes = [f"left out, being neither numbers nor words: {', '.join(held.other)}"] if held.other else []
    return Table(held.numbers, units, held.texts, str(path), notes, form="Parquet")


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
