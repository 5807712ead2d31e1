"""A controller with its parameters in a file, as ``leadscrew tune`` writes it; a name wherever a controller is named.

::

    schema_version = 2
    kind = "controller"
    study = "vud_lathe"
    controller = "corrected.vud_beta_e"       # of the study, of the catalogue, path/file.py:NAME, or a fuzzy system

    [set]                                     # parameters of the controller, as --set has them without "controller."
    output_gain = 2.1

    [tuning]                                  # where they come from; nothing of it changes the controller

Paths are looked for beside the file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from leadscrew import legacy, names, toml_file
from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import DataError

SCHEMA_VERSION = legacy.CURRENT
KIND = "controller"


@dataclass(frozen=True)
class ControllerFile:
    """What stands in the file."""

    study: str
    controller: str
    """The one whose parameters these are."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """By their keys without ``controller.``."""
    tuning: Mapping[str, Any] = field(default_factory=dict)

    @property
    def changes(self) -> dict[str, Any]:
        """The parameters by dotted key."""
        return {f"controller.{k}": v for k, v in self.parameters.items()}

    def text(self) -> str:
        """The file."""
        head = {"schema_version": SCHEMA_VERSION, "kind": KIND, "study": self.study, "controller": self.controller}
        return toml_file.text({**head, "set": dict(self.parameters), "tuning": dict(self.tuning)})


def read(path: str | Path) -> ControllerFile:
    """The contents of a controller file.

    Raises:
        DataError: no such file, bad TOML, an unknown key or a value of the wrong type; names file and key.
    """
    where = Path(path).expanduser()
    return validated(toml_file.read(where), where)


def validated(table: Mapping[str, Any], where: Path) -> ControllerFile:
    """The controller file that a TOML table describes.

    Raises:
        DataError: names file and key of what is wrong.
    """
    from leadscrew import file_schema
    from leadscrew.experiment_file import ControllerTable

    if table.get("kind") != KIND:
        said = f"its kind is {table['kind']!r}" if "kind" in table else "it has no kind"
        raise DataError(f"{where}: is not a controller file: {said}, expected kind = {KIND!r}")
    read = file_schema.validated(ControllerTable, table, where)
    if names.is_toml(read.controller):
        raise DataError(f"{where}: controller = {read.controller!r}: a controller file names no other one")
    return ControllerFile(
        names.from_file(read.study, where), names.from_file(read.controller, where),
        legacy.completed(read.schema_version, read.controller, dict(toml_file.flat(read.changes))), read.tuning,
    )  # fmt: skip


def write(path: str | Path, file: ControllerFile) -> None:
    """Writes a controller file, whole or not at all.

    Raises:
        DataError: it cannot be written.
    """
    atomic_write(file.text(), path)
