"""Cells of text tables as numbers: decimal point or comma, empty cells and the words that stand for them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

MISSING = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "?", "1.#qnan", "-1.#ind", "-nan"})
"""What stands where there is no value, in lower case."""

_TRUTH = {"true": 1.0, "false": 0.0}


def number(cell: str, decimal: str = ".") -> float | None:
    """The number of a cell; NaN where it is missing; None where it is a word."""
    text = cell.strip()
    if text.casefold() in MISSING:
        return float("nan")
    if decimal == ",":
        if "." in text:
            return None
        text = text.replace(",", ".", 1)
    if "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return _TRUTH.get(text.casefold())


def is_number(cell: str, decimal: str = ".") -> bool:
    """Whether the cell holds one, and is not empty."""
    value = number(cell, decimal)
    return value is not None and bool(cell.strip()) and value == value


def numbers(cells: Sequence[str], decimal: str) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of cells, NaN where there is none, and which of them are words."""
    joined = " ".join(cells)
    try:
        if "_" in joined or (decimal == "," and "." in joined):
            raise ValueError  # Python reads 1_000 as a number; a point is no decimal sign here.
        plain = cells if decimal == "." else [c.replace(",", ".", 1) for c in cells]
        return np.array([float(c) for c in plain]), np.zeros(len(cells), dtype=bool)
    except ValueError:
        read = [number(c, decimal) for c in cells]
        return np.array([np.nan if v is None else v for v in read], dtype=float), np.array([v is None for v in read])
