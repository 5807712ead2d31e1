"""Presets: the parameters of a machine under a name, in one JSON file each, read with suspicion."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from leadscrew.file_schema import Table, validated
from leadscrew.kernel.parameters import nearest
from leadscrew.panel import strict_json
from leadscrew.panel.strict_json import plain
from leadscrew.util import atomic
from leadscrew.util.errors import DataError, NameUnknown

MOST_BYTES = 256_000
MOST_FILES = 500
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,63}\Z")
"""Names of presets and sessions; no slash, and no leading point."""


class PresetTable(Table):
    """The file."""

    schema_version: Literal[1]
    study: str
    controller: str
    values: dict[str, Any]


@dataclass(frozen=True)
class Preset:
    """Values by dotted key, of one study under one controller."""

    study: str
    controller: str
    values: Mapping[str, Any]


def names(folder: Path) -> list[str]:
    """The presets of a folder, by name."""
    found = folder.glob("*.json") if folder.is_dir() else ()
    return sorted(p.stem for p in found if NAME.match(p.stem) and p.is_file() and not p.is_symlink())


def save(preset: Preset, folder: Path, name: str) -> Path:
    """Writes a preset whole; one of that name is replaced.

    Raises:
        DataError: a name that is not allowed, a full folder, or it cannot be written.
    """
    path = _place(folder, name)
    if not path.exists() and len(names(folder)) >= MOST_FILES:
        raise DataError(f"{folder} holds {MOST_FILES} presets, the most that it may; delete some of them first")
    text = json.dumps({"schema_version": 1, **plain(asdict(preset))}, indent=1, allow_nan=False)
    atomic.atomic_write(f"{text}\n", path)
    return path


def load(folder: Path, name: str) -> Preset:
    """The preset of that name. Keys and values are checked by the machine when it is set.

    Raises:
        NameUnknown: there is none.
        DataError: the file cannot be read, or is no preset; says why.
    """
    path = _there(folder, name)
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise DataError(f"{path.name} cannot be read: {error.strerror or error}") from None
    if len(data) > MOST_BYTES:
        raise DataError(f"{path.name} has more than {MOST_BYTES} bytes, the most that a preset may have")
    try:
        table = strict_json.loads(data.decode("utf-8"))
    except ValueError as error:
        raise DataError(f"{path.name} is no preset: {error}") from None
    read = validated(PresetTable, table, path.name)
    return Preset(read.study, read.controller, read.values)


def delete(folder: Path, name: str) -> None:
    """Removes a preset.

    Raises:
        NameUnknown: there is none.
        DataError: it cannot be removed.
    """
    path = _there(folder, name)
    try:
        path.unlink()
    except OSError as error:
        raise DataError(f"{path.name} cannot be removed: {error.strerror or error}") from None


def _there(folder: Path, name: str) -> Path:
    path = _place(folder, name)
    if name not in names(folder):
        raise NameUnknown(f"there is no preset {name!r}{nearest(name, names(folder))}")
    return path


def _place(folder: Path, name: str) -> Path:
    if not NAME.match(name) or ".." in name:
        raise DataError(f"name = {name[:80]!r}: allowed are 1 to 64 letters, digits, blanks and _ . -, no two points")
    path = folder / f"{name}.json"
    if path.is_symlink():
        raise DataError(f"{path.name} is a link; choose another name")
    return path


__all__ = ["NAME", "Preset", "delete", "load", "names", "save"]
