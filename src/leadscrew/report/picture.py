"""A picture as a file."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from leadscrew.util.atomic import atomic_write

if TYPE_CHECKING:
    from leadscrew.figures.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
"""Formats of a picture."""


def save(figure: Figure, path: Path) -> None:
    """Writes a picture in the format of its suffix; the same figure gives the same file.

    Raises:
        DataError: it cannot be written.
    """
    from matplotlib import rc_context

    kind = path.suffix.casefold().removeprefix(".")
    dates: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind, {})
    drawn = io.BytesIO()
    with rc_context({"svg.hashsalt": path.stem, "pdf.fonttype": 42}):
        figure.savefig(drawn, format=kind, dpi=200, metadata=dates)
    atomic_write(drawn.getvalue(), path)
