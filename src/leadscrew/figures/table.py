"""A table of results, and how its numbers and units are written: one form for terminal, HTML, Markdown and JSON."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from leadscrew.util.escape import html

NOTHING = "–"
"""What stands where there is no value."""

UNITS = {
    "N m": "N·m",
    "N m/A": "N·m/A",
    "N m/rad": "N·m/rad",
    "N m s/rad": "N·m·s/rad",
    "N s": "N·s",
    "N s/m": "N·s/m",
    "kg m^2": "kg·m²",
    "rad/(s V)": "rad/(s·V)",
    "ohm": "Ω",
    "1": "",
}
"""Units as the field prints them, by how they are written in ASCII; a pure number (``1``) has none."""

_MICRO = re.compile(r"\bu(?=(m|rad|s|V|N)\b)")
_POWERS = {"^2": "²", "^3": "³"}
_UNIT_OF_HEADER = re.compile(r"\(([^()]*(?:\([^()]*\))?)\)$")


def unit(text: str) -> str:
    """A unit for the eye: by :data:`UNITS`, else with µ for micro and with raised powers."""
    if text in UNITS:
        return UNITS[text]
    text = _MICRO.sub("µ", text)
    for plain, raised in _POWERS.items():
        text = text.replace(plain, raised)
    return text


def header(text: str) -> str:
    """The head of a column, ``name (unit)``, for the eye."""

    def shown(match: re.Match[str]) -> str:
        return f"({unit(match[1])})" if unit(match[1]) else ""

    return _UNIT_OF_HEADER.sub(shown, text).rstrip()


def number(value: Any, digits: int = 4) -> str:
    """A value in ``digits`` significant digits: 0.2518, 37,222, 1.2e-07; texts stay, a dash for what does not exist.

    Of an array only its shape; infinity reads *never*.
    """
    if value is None or isinstance(value, bool | str) or _shape(value):
        return _word(value)
    if math.isnan(value):
        return NOTHING
    if math.isinf(value):
        return "never" if value > 0 else "−∞"
    size = abs(value)
    if value == int(value) and size < 1e15:
        text = f"{int(value):,}"
    elif size >= 10.0 ** (digits - 1):
        text = f"{value:,.0f}"
    else:
        text = f"{value:.{digits}g}" if size >= 1e-4 else f"{value:.{max(2, digits - 2)}g}"
    return text.replace("-", "−", 1) if text.startswith("-") else text


def finite(value: float | None, digits: int = 4) -> str:
    """A value of which infinity says nothing, as of an interval that has no end: a dash for it."""
    return number(value if value is not None and math.isfinite(value) else None, digits)


def as_typed(value: Any) -> str:
    """The value of a parameter as one types it, ``--set KEY=-1.5e+06``: six digits, ASCII; as :func:`number` else."""
    if value is None or isinstance(value, bool | str) or _shape(value):
        return _word(value)
    return NOTHING if math.isnan(value) else f"{value:.6g}"


def fixed(value: float | None, decimals: int) -> str:
    """A value with that many decimals, whatever its size: a column of readings; a dash for what does not exist."""
    if value is None or not math.isfinite(value):
        return NOTHING
    text = f"{value:,.{decimals}f}"
    return text.replace("-", "−" if text.strip("-0.,") else "", 1)


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"array of {_shape(value)}" if _shape(value) else value or NOTHING


def _shape(value: Any) -> str:
    if isinstance(value, list | tuple):
        return str(len(value))
    return " × ".join(map(str, getattr(value, "shape", ())))


@dataclass(frozen=True)
class Table:
    """Rows by their label, each with one value a column.

    Args:
        label: head of the column of labels.
        columns: heads of the others, ``name (unit)`` with the unit in ASCII (``um``).
        rows: values by label: numbers, texts, or None where there is none; infinity reads *never*.
        digits: significant digits of the numbers.

    Raises:
        ValueError: a row with more or fewer values than columns.
    """

    label: str
    columns: tuple[str, ...]
    rows: Mapping[str, tuple[Any, ...]]
    digits: int = 4

    def __post_init__(self) -> None:
        for name, values in self.rows.items():
            if len(values) != len(self.columns):
                raise ValueError(f"row {name!r}: {len(values)} values for {len(self.columns)} columns")

    def heads(self) -> list[str]:
        """The heads of all columns for the eye."""
        return [header(text) for text in (self.label, *self.columns)]

    def cells(self) -> list[list[str]]:
        """The rows for the eye, the label first."""
        return [[name, *(number(value, self.digits) for value in values)] for name, values in self.rows.items()]

    def numeric(self) -> list[bool]:
        """Of every column, the label's included, whether its values are numbers: those stand to the right."""
        columns = [[row[k] for row in self.rows.values()] for k in range(len(self.columns))]
        return [False, *(all(not isinstance(v, str) or v in ("yes", "no") for v in column) for column in columns)]

    def _repr_html_(self) -> str:
        heads = "".join(f"<th>{html(text)}</th>" for text in self.heads())
        rows = "".join(f"<tr>{''.join(f'<td>{html(cell)}</td>' for cell in row)}</tr>" for row in self.cells())
        return f"<table><tr>{heads}</tr>{rows}</table>"

    def as_dict(self) -> dict[str, Any]:
        """The table for JSON: columns as they were given, and values by row."""
        return {"label": self.label, "columns": list(self.columns), "rows": {k: list(v) for k, v in self.rows.items()}}
