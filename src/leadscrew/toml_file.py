"""Files in TOML: read within the limits of :mod:`leadscrew.util.reading`, written whole or not at all.

Written here and not by ``tomli-w``, which has no dotted keys (``friction.forward.coulomb`` stands in ``[set]`` as it
does behind ``--set``) and sets every list on lines of its own, an interval on four and a table of numbers on hundreds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from leadscrew.util import reading
from leadscrew.util.atomic import atomic_write
from leadscrew.util.escape import toml_key, toml_string

WHOLE = (("files",), ("columns",), ("units",))
"""Tables whose keys are names of files or columns: a dot in them is no nesting."""


def read(path: str | Path) -> dict[str, Any]:
    """The table of a file.

    Raises:
        DataError: no such file, or bad TOML.
    """
    return reading.toml(Path(path).expanduser())


def flat(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """Dotted keys and values of nested tables."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        found += flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) else [(f"{prefix}{key}", value)]
    return found


def write(path: str | Path, table: Mapping[str, Any]) -> None:
    """Writes a table.

    Raises:
        DataError: it cannot be written.
        ValueRefused: a text that is not Unicode.
    """
    atomic_write(text(table), path)


def text(table: Mapping[str, Any]) -> str:
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
