"""Drawings from files, by suffix: SVG, DXF, G-code."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as File

from leadscrew.paths.drawing import Drawing, unit_named
from leadscrew.paths.path import JOIN_MM
from leadscrew.paths.suffixes import SUFFIXES
from leadscrew.util.errors import DataError, ValueRefused


def read_drawing(
    file: str | File, unit: str | None = None, tolerance: float = JOIN_MM, layers: Sequence[str] = (), axis: str = ""
) -> Drawing:
    """The paths of a file, in mm.

    ``unit`` (``mm``, ``cm``, ``m``, ``in`` or ``inch``, ``px``) is used where the file does not say it: see each
    reader. ``tolerance`` is the largest gap, in mm, that is closed. ``layers`` names those to read (SVG and DXF; none:
    all). ``axis`` is the letter of the tangential axis of a G-code program (none: the one of A, B, C that it has).

    Raises:
        DataError: no such file, a suffix not known, a file that cannot be read, or nothing to cut in it.
        NameUnknown: a layer that is not there.
        ValueRefused: a unit not known, a tolerance that is not positive, or layers of G-code.
    """
    where = File(file).expanduser()
    unit = unit_named(unit)
    if not 0.0 < tolerance < 1e3:
        raise ValueRefused(f"tolerance = {tolerance:g} mm: expected above 0 and below 1000")
    if where.suffix.lower() not in SUFFIXES:
        raise DataError(f"{where}: a drawing is expected to end in {', '.join(SUFFIXES)}")
    if where.is_dir():
        raise DataError(f"{str(where)!r} is a folder, not a file")
    if not where.is_file():
        raise DataError(f"there is no file {str(where)!r}")
    try:
        if where.suffix.lower() == ".svg":
            from leadscrew.paths.svg import read_svg

            return read_svg(where, unit, tolerance, layers)
        if where.suffix.lower() == ".dxf":
            from leadscrew.paths.dxf import read_dxf

            return read_dxf(where, unit, tolerance, layers)
        if layers:
            raise ValueRefused(f"layers = {list(layers)}: G-code has no layers")
        from leadscrew.paths.gcode import read_gcode

        return read_gcode(where, unit, axis)
    except OSError as error:
        raise DataError(f"{where} cannot be read: {error.strerror or error}") from None
