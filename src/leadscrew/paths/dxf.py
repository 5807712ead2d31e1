"""Paths of a DXF drawing, through ezdxf: the model space, seen from above.

Read are ``LINE``, ``ARC``, ``CIRCLE``, ``ELLIPSE``, ``LWPOLYLINE`` and ``POLYLINE`` (bulges are arcs), ``SPLINE``
(control points with knots and weights, or fit points), and ``INSERT``: blocks are taken apart with their transforms. An
extrusion direction of -Z mirrors; an entity in another plane is noted and left out, as is every other kind and what
lies on a layer that is off or frozen. The Z of points is not used. Units are those of ``$INSUNITS``; a file without is
refused unless the unit is given, and a unit that is given takes precedence. An entity that cannot be read is refused by
kind and handle.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path as File
from typing import Any

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.paths.curve import Curve
from leadscrew.paths.drawing import UNITS_MM, Drawing, Piece, drawing, left_out
from leadscrew.paths.segments import Arc, EllipseArc, Line, Spline, circular
from leadscrew.util import reading
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

INSUNITS = {
    **{1: ("in", 25.4), 2: ("ft", 304.8), 4: ("mm", 1.0), 5: ("cm", 10.0), 6: ("m", 1000.0), 8: ("microinch", 2.54e-5)},
    **{9: ("mil", 0.0254), 10: ("yd", 914.4), 13: ("um", 1e-3), 14: ("dm", 100.0)},
}
"""``$INSUNITS``: name and size in mm."""
DEEPEST = 32
"""Blocks inside blocks."""
MOST_INSERTED = 100_000
"""Entities of blocks, wherever they are put."""
BINARY = b"AutoCAD Binary DXF"
IN_PLANE = 1e-9
SPLINE_FRAME = 16
"""Flag of a vertex that is only the frame of a spline."""


def read_dxf(file: File, unit: str | None, tolerance: float, layers: Sequence[str] = ()) -> Drawing:
    """The paths of a DXF file; see :func:`leadscrew.paths.read.read_drawing`."""
    document = _document(file)
    notes: list[str] = []
    code = int(document.header.get("$INSUNITS", 0)) if _says_unit(file) else None
    if unit is not None:
        name, size = unit, UNITS_MM[unit]
        if code in INSUNITS and INSUNITS[code][1] != size:
            notes.append(f"the file is in {INSUNITS[code][0]}, read as {unit} as asked")
    elif code in INSUNITS:
        name, size = INSUNITS[code]
    else:
        raise DataError(
            f"{file} does not say its unit ({'it has no $INSUNITS' if code is None else f'$INSUNITS is {code}'}): "
            "give it, as --unit mm or unit='mm' in Python"
        )
    present = sorted({_layer(e) for e in document.modelspace()})
    for layer in layers:
        if layer not in present:
            raise NameUnknown(f"{file} has no layer {layer!r}{nearest(layer, present)}")
    hidden = {t.dxf.name for t in document.layers if t.is_off() or t.is_frozen()}
    reader = _Reader(hidden, size)
    pieces: list[Piece] = []
    curves = 0
    try:
        for entity in document.modelspace():
            if not layers or _layer(entity) in layers:
                more = list(reader.pieces(entity, "0"))
                reading.check_curves(str(file), curves := curves + sum(len(p.curves) for p in more))
                pieces += more
    except ValueRefused as refused:
        raise DataError(f"{file}: {refused}") from None
    notes += left_out(reader.other) + left_out(reader.tilted, "not in the XY plane, not cut")
    notes += left_out(reader.hidden, "hidden, not cut")
    return drawing(pieces, name, str(file), notes, tolerance)


def _document(file: File) -> Any:
    import ezdxf
    from ezdxf import recover

    reading.check(file, file.stat().st_size, reading.PROGRAM, "drawings")
    try:
        return ezdxf.readfile(file)
    except Exception as error:
        # ezdxf raises OSError without a number for a file that is no DXF, and of a broken one what its parts raise.
        if isinstance(error, OSError) and error.errno is not None:
            raise
    try:
        return recover.readfile(file)[0]
    except Exception as error:
        # The recovery of a broken file raises what its parts raise.
        raise DataError(f"{file} is no DXF that can be read: {error}") from None


def _says_unit(file: File) -> bool:
    """Whether ``$INSUNITS`` stands in the file: ezdxf makes up a header where there is none, in metres."""
    data = reading.data(file, reading.PROGRAM, "drawings")
    if data.startswith(BINARY):
        return b"$INSUNITS\0" in data
    return re.search(rb"(?:^|\n)[ \t]*9[ \t]*\r?\n[ \t]*\$INSUNITS\b", data) is not None


def _layer(entity: Any) -> str:
    """The layer of an entity; 0 where its kind has none, as of a broken file."""
    return str(entity.dxf.get("layer", "0")) if entity.dxf.is_supported("layer") else "0"


class _Reader:
    """Entities as pieces, and a count of what is not one."""

    def __init__(self, hidden: set[str], size: float) -> None:
        self.off = hidden
        self.scale = np.array([[size, 0.0, 0.0], [0.0, size, 0.0]])
        self.other: Counter[str] = Counter()
        self.tilted: Counter[str] = Counter()
        self.hidden: Counter[str] = Counter()
        self.inserted = 0

    def pieces(self, entity: Any, layer: str, depth: int = 0) -> Iterator[Piece]:
        """The pieces of an entity; ``layer`` is that of the block reference it stands in."""
        kind = entity.dxftype()
        if not entity.dxf.is_supported("layer"):  # no graphic at all, in a broken file
            self.other[kind] += 1
            return
        own = layer if depth and _layer(entity) == "0" else _layer(entity)
        if own in self.off or entity.dxf.get("invisible", 0):
            self.hidden[kind] += 1
        elif kind == "INSERT":
            if depth >= DEEPEST:
                raise ValueRefused(f"block {entity.dxf.name!r} lies more than {DEEPEST} blocks deep")
            for inner in self._inside(entity):
                yield from self.pieces(inner, own, depth + 1)
        elif kind not in KINDS or (kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)):
            self.other[kind] += 1
        elif (curves := self._curves(entity, kind)) is None:
            self.tilted[kind] += 1
        elif curves:
            yield Piece(curves, own)

    def _inside(self, entity: Any) -> Iterator[Any]:
        """The entities of a block, where it is put."""
        if entity.mcount > MOST_INSERTED:
            raise _too_many()
        for single in entity.multi_insert() if entity.mcount > 1 else (entity,):
            try:
                found = list(single.virtual_entities(skipped_entity_callback=self._skipped))
            except Exception as error:
                raise _unreadable(entity, error) from None
            self.inserted += len(found)
            if self.inserted > MOST_INSERTED:
                raise _too_many()
            yield from found

    def _curves(self, entity: Any, kind: str) -> list[Curve] | None:
        try:
            curves = KINDS[kind](entity)
            return None if curves is None else [c.transformed(self.scale) for c in curves]
        except Exception as error:
            # A broken entity raises what the parts of ezdxf raise.
            raise _unreadable(entity, error) from None

    def _skipped(self, entity: Any, reason: str) -> None:
        self.other[entity.dxftype()] += 1


def _too_many() -> ValueRefused:
    return ValueRefused(f"its blocks draw more than {MOST_INSERTED} entities")


def _unreadable(entity: Any, error: Exception) -> ValueRefused:
    return ValueRefused(f"{entity.dxftype()} {entity.dxf.handle or 'of a block'} cannot be read: {error}")


def _plane(entity: Any) -> Any:
    """The map from the entity's own coordinates to the drawing's (2 x 3); none where its plane is tilted."""
    x, y, z = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    if math.hypot(x, y) > IN_PLANE * abs(z):
        return None
    return np.array([[math.copysign(1.0, z), 0.0, 0.0], [0.0, 1.0, 0.0]])


def _line(entity: Any) -> list[Curve]:
    return [Line(_xy(entity.dxf.start), _xy(entity.dxf.end))]


def _circle(entity: Any) -> list[Curve] | None:
    plane = _plane(entity)
    if plane is None:
        return None
    radius = abs(float(entity.dxf.radius))
    angle, sweep = 0.0, 2.0 * math.pi
    if entity.dxftype() == "ARC":
        angle = math.radians(entity.dxf.start_angle)
        sweep = math.radians((entity.dxf.end_angle - entity.dxf.start_angle) % 360.0) or sweep
    if radius == 0.0:
        centre = _xy(entity.dxf.center)
        return [Line(centre, centre)]
    return [Arc(_xy(entity.dxf.center), radius, angle, sweep).transformed(plane)]


def _ellipse(entity: Any) -> list[Curve] | None:
    # Centre and axes are in the drawing's coordinates.
    if _plane(entity) is None:
        return None
    first = entity.dxf.start_param
    sweep = (entity.dxf.end_param - first) % (2.0 * math.pi)
    if sweep < 1e-9:
        sweep = 2.0 * math.pi
    if math.hypot(*_xy(entity.dxf.major_axis)) == 0.0:
        centre = _xy(entity.dxf.center)
        return [Line(centre, centre)]
    centre, major, minor = (_xy(p) for p in (entity.dxf.center, entity.dxf.major_axis, entity.minor_axis))
    return [circular(EllipseArc(centre, major, minor, first, sweep))]


def _lwpolyline(entity: Any) -> list[Curve] | None:
    plane = _plane(entity)
    if plane is None:
        return None
    return [c.transformed(plane) for c in bulged(list(entity.get_points("xyb")), bool(entity.closed))]


def _polyline(entity: Any) -> list[Curve] | None:
    plane = _plane(entity) if entity.is_2d_polyline else np.eye(2, 3)
    if plane is None:
        return None
    rows = [
        (*_xy(v.dxf.location), float(v.dxf.get("bulge", 0.0)) if entity.is_2d_polyline else 0.0)
        for v in entity.vertices
        if not v.dxf.get("flags", 0) & SPLINE_FRAME
    ]
    return [c.transformed(plane) for c in bulged(rows, bool(entity.is_closed))]


def bulged(rows: Sequence[Sequence[float]], closed: bool) -> list[Curve]:
    """Lines and arcs through points ``(x, y, bulge)``; the bulge is ``tan(sweep / 4)`` of the arc that follows."""
    found: list[Curve] = []
    ends = [*rows[1:], rows[0]] if closed and rows else rows[1:]
    for (x, y, bulge), (ex, ey, _) in zip(rows, ends, strict=False):
        chord = math.hypot(ex - x, ey - y)
        if bulge == 0.0 or chord == 0.0:
            found.append(Line((x, y), (ex, ey)))
            continue
        # The centre lies on the chord's perpendicular bisector, at this share of the chord to the left.
        side = (1.0 / bulge - bulge) / 4.0
        centre = (0.5 * (x + ex) - side * (ey - y), 0.5 * (y + ey) + side * (ex - x))
        radius = chord * (1.0 + bulge * bulge) / (4.0 * abs(bulge))
        found.append(Arc(centre, radius, math.atan2(y - centre[1], x - centre[0]), 4.0 * math.atan(bulge)))
    return found


def _spline(entity: Any) -> list[Curve]:
    tool = entity.construction_tool()
    points = np.array([_xy(p) for p in tool.control_points])
    weights = np.array(tool.weights()) if len(tool.weights()) else None
    return [Spline(points, np.array(tool.knots()), int(tool.degree), weights)]


def _xy(p: Any) -> tuple[float, float]:
    return float(p[0]), float(p[1])


KINDS = {
    "LINE": _line,
    "ARC": _circle,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
}
