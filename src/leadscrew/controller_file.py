"""A controller with its parameters in a file, as ``leadscrew tune`` writes it; a name wherever a controller is named.

::

    schema_version = 1
    kind = "controller"
    study = "vud_lathe"
    controller = "corrected.vud_beta_e"       # of the study, of the catalogue, path/file.py:NAME, or a fuzzy system

    [set]                                     # parameters of the controller, as --set has them without "controller."
    output_gain = 2.1

    [tuning]                                  # where they come from; nothing of it changes the controller

Paths are looked for beside the file.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew import reading, userfile
from leadscrew.escape import toml_key, toml_string
from leadscrew.kernel.errors import CodeNotTrusted, DataError, LeadscrewError
from leadscrew.kernel.sheet import checked_replace, nearest
from leadscrew.newfile import save

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.studies.study import Study

SCHEMA_VERSION = 1
KIND = "controller"
KEYS = ("schema_version", "kind", "study", "controller", "set", "tuning")


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
        return toml({**head, "set": dict(self.parameters), "tuning": dict(self.tuning)})


def read(path: str | Path) -> ControllerFile:
    """The contents of a controller file.

    Raises:
        DataError: no such file, bad TOML, an unknown key or a value of the wrong type; names file and key.
    """
    where = Path(path).expanduser()
    return validated(table_of(where), where)


def table_of(where: Path) -> dict[str, Any]:
    """A TOML file as it is.

    Raises:
        DataError: no such file, or bad TOML.
    """
    return reading.toml(where)


def validated(table: Mapping[str, Any], where: Path) -> ControllerFile:
    """The controller file that a TOML table describes.

    Raises:
        DataError: names file and key of what is wrong.
    """
    if table.get("kind") != KIND:
        said = f"its kind is {table['kind']!r}" if "kind" in table else "it has no kind"
        raise DataError(f"{where}: is not a controller file: {said}, expected kind = {KIND!r}")
    for key in table:
        if key not in KEYS:
            raise DataError(f"{where}: there is no key {key!r}{nearest(key, list(KEYS))}")
    for key, kind, expected in (
        ("schema_version", int, "1"), ("study", str, "a name"), ("controller", str, "a name"), ("set", dict, "a table"),
        ("tuning", dict, "a table"),
    ):  # fmt: skip
        if key not in table:
            if kind is dict:
                continue
            raise DataError(f"{where}: the key {key!r} is missing")
        value = table[key]
        if not isinstance(value, kind) or value == "" or isinstance(value, bool):
            raise DataError(f"{where}: {key} = {value!r}: expected {expected}")
    if table["schema_version"] != SCHEMA_VERSION:
        raise DataError(f"{where}: schema_version = {table['schema_version']!r}: expected {SCHEMA_VERSION}")
    if table["controller"].endswith(".toml"):
        raise DataError(f"{where}: controller = {table['controller']!r}: a controller file names no other one")
    return ControllerFile(
        userfile.from_file(table["study"], where), userfile.from_file(table["controller"], where),
        dict(flat(table.get("set", {}))), table.get("tuning", {}),
    )  # fmt: skip


def block(path: str | Path, study: Study | None = None) -> Block:
    """The controller of a file with its parameters, for a study; for the file's own unless given.

    Raises:
        DataError: the file is malformed, or its parameters do not fit the controller; names file and key.
        CodeNotTrusted: it names Python that may not run.
    """
    from leadscrew import catalogue, experiment

    found = read(path)
    try:
        base = experiment.controller(study or catalogue.study(found.study), found.controller)
        params = checked_replace(base.params, found.parameters, where="[set]")
    except CodeNotTrusted:
        raise
    except LeadscrewError as error:
        raise DataError(f"{path}: {error}") from error
    return replace(base, params=params)


def flat(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Dotted keys and values of nested tables."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        found += flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) else [(f"{prefix}{key}", value)]
    return found


# ---- writing
def write(path: str | Path, file: ControllerFile) -> None:
    """Writes a controller file, whole or not at all.

    Raises:
        DataError: it cannot be written.
    """
    save(file.text(), path)


def write_experiment(path: str | Path, table: Mapping[str, Any]) -> None:
    """Writes an experiment file, whole or not at all.

    Raises:
        DataError: it cannot be written.
    """
    save(toml({"schema_version": 1, **table}), path)


WHOLE = (("files",), ("columns",), ("units",))
"""Tables whose keys are names of files or columns: a dot in them is no nesting."""


def toml(table: Mapping[str, Any]) -> str:
    """A table as TOML; what is None is left out. ``controller.kp`` is a key of nested tables, except in :data:`WHOLE`.

    Raises:
        ValueRefused: a text that is not Unicode.
    """
    return "\n".join(_lines(table, ())).strip() + "\n"


def _lines(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    lines, below = [], []
    for key, value in table.items():
        if isinstance(value, Mapping):
            if value:
                below += ["", f"[{'.'.join(map(toml_key, (*path, key)))}]", *_lines(value, (*path, key))]
        elif value is not None:
            lines.append(f"{toml_key(key, dotted=path[-1:] not in WHOLE)} = {_value(value)}")
    return lines + below


def _value(value: Any) -> str:
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
    return repr(value)
