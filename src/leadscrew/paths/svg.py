"""Paths of an SVG drawing, through svgelements, which resolves ``use``, styles, groups and the view box.

Read are ``path``, ``rect``, ``circle``, ``ellipse``, ``line``, ``polyline`` and ``polygon``, whatever their stroke or
fill. Their geometry is taken before the transform and mapped by us: an arc under a skew stays exact, as the arc of an
ellipse. Not read: text, images, what is hidden, what only serves to clip, mask, mark or fill. Sizes follow ``width``,
``height`` and ``viewBox``, 96 px to the inch; ``unit`` says what a px is where the file names no physical unit. The
y-axis is turned upwards, with the lower edge of the page at 0. What cannot be read is refused, not cut in part: see
:mod:`leadscrew.paths.svg_checks`.
"""

from __future__ import annotations

import io
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path as File
from typing import Any
from xml.etree import ElementTree

import numpy as np

from leadscrew import reading
from leadscrew.kernel.errors import DataError, NameUnknown, ValueRefused
from leadscrew.kernel.sheet import nearest
from leadscrew.paths.arcs import circular
from leadscrew.paths.curve import Curve
from leadscrew.paths.drawing import UNITS_MM, Drawing, Piece, drawing, left_out
from leadscrew.paths.segments import Bezier, EllipseArc, Line
from leadscrew.paths.svg_checks import LENGTHS, NOT_DRAWN, PX, SIZE, check
from leadscrew.paths.svg_checks import tag as _tag

SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
LAYER = "leadscrew-layer"
MOST = 20_000_000
"""Bytes of a drawing: svgelements is slow."""
NOT_CUT = ("text", "image", "foreignObject")
HIDES = re.compile(rb"display\s*[:=]\s*[\"']?\s*none", re.IGNORECASE)


def read_svg(file: File, unit: str | None, tolerance: float, layers: Sequence[str] = ()) -> Drawing:
    """The paths of an SVG file; see :func:`leadscrew.paths.read.read_drawing`."""
    try:
        root = ElementTree.fromstring(reading.data(file, MOST, "SVG drawings"))
    except DataError:
        raise
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # LookupError: an unknown encoding
        raise DataError(f"{file} is no SVG: {error}") from None
    if _tag(root) != "svg":
        raise DataError(f"{file} is no SVG: its first element is <{_tag(root)}>")
    if root.tag == "svg":
        for element in root.iter():
            if isinstance(element.tag, str) and not element.tag.startswith("{"):
                element.tag = SVG + element.tag
    present = _prepare(root)
    for layer in layers:
        if layer not in present:
            raise NameUnknown(f"{file} has no layer {layer!r}{nearest(layer, present)}")
    said = next((u for key in ("width", "height") if (u := _size(root, key, file)[1]) not in ("", "px", "%")), None)
    view, page, box = _view(root, file)
    try:
        broken = check(root, *box)
    except DataError as refused:
        raise DataError(f"{file}: {refused}") from None
    shapes, hidden = _shapes(root, file)
    notes = left_out(Counter(t for e in root.iter() if (t := _tag(e)) in NOT_CUT)) + broken
    if hidden:
        notes.append(f"hidden, not cut: {hidden}")
    if said is not None and unit is not None and unit != said:
        notes.append(f"the file gives its size in {said}: the unit {unit} is not used")
    if said is None and unit is None:
        notes.append("the file names no physical unit: taken as 96 px an inch")
    size = UNITS_MM["px" if said is not None or unit is None else unit]
    machine = np.array([[size, 0.0, 0.0], [0.0, -size, size * page]]) @ view
    pieces, segments = [], 0
    try:
        for shape in shapes:
            layer = str(shape.values.get(LAYER, ""))
            if layers and layer not in layers:
                continue
            reading.check_curves(str(file), segments := segments + len(shape.segments(transformed=False)))
            pieces += [
                Piece([c.transformed(machine @ _matrix(shape)) for c in curves], layer, _name(shape))
                for curves in subpaths(shape.segments(transformed=False))
            ]
    except (ValueRefused, OverflowError) as refused:
        raise DataError(f"{file}: {refused}") from None
    return drawing(pieces, said or unit or "px", str(file), notes, tolerance)


def subpaths(segments: Any) -> Iterator[list[Curve]]:
    """The curves of each subpath, from the segments of svgelements as drawn (y downwards, before the transform)."""
    import svgelements as svg

    curves: list[Curve] = []
    for s in segments:
        if isinstance(s, svg.Move):
            if curves:
                yield curves
            curves = []
        elif isinstance(s, svg.Line | svg.Close):
            back = isinstance(s, svg.Close) and s.start == s.end
            if s.start is not None and s.end is not None and not back:
                curves.append(Line(_xy(s.start), _xy(s.end)))
            if isinstance(s, svg.Close):
                if curves:
                    yield curves
                curves = []
        elif isinstance(s, svg.QuadraticBezier):
            curves.append(Bezier.quadratic(_xy(s.start), _xy(s.control), _xy(s.end)))
        elif isinstance(s, svg.CubicBezier):
            curves.append(Bezier(np.array([_xy(s.start), _xy(s.control1), _xy(s.control2), _xy(s.end)])))
        elif isinstance(s, svg.Arc):
            curves.append(_arc(s))
    if curves:
        yield curves


def _arc(s: Any) -> Curve:
    centre, start = np.array(_xy(s.center)), np.array(_xy(s.start))
    first, second = np.array(_xy(s.prx)) - centre, np.array(_xy(s.pry)) - centre
    if abs(first[0] * second[1] - first[1] * second[0]) == 0.0:
        # SVG: an arc without a radius is a line.
        return Line(_xy(s.start), _xy(s.end))
    cosine, sine = np.linalg.solve(np.column_stack((first, second)), start - centre)
    angle, sweep = math.atan2(sine, cosine), float(s.sweep)
    return circular(EllipseArc(_pair(centre), _pair(first), _pair(second), angle, sweep))


def _size(root: ElementTree.Element, key: str, file: File) -> tuple[float, str]:
    """A length of the root in px and its unit; nan and ``%`` where the page has none."""
    text = root.get(key, "").strip()
    if text in ("", "auto"):
        return math.nan, "%"
    found = SIZE.fullmatch(text)
    unit = found[2].lower() if found else ""
    if found is None or (unit not in PX and unit != "%"):
        raise DataError(f"{file}: {key}={_short(text)} is no length that is understood: expected {LENGTHS}")
    if not 0.0 < float(found[1]) < math.inf:
        raise DataError(f"{file}: {key}={_short(text)}: the size of a page is expected above 0")
    return (math.nan, "%") if unit == "%" else (float(found[1]) * PX[unit], unit)


def _short(text: str) -> str:
    return repr(text if len(text) <= 40 else f"{text[:37]}...")


def _view(root: ElementTree.Element, file: File) -> tuple[Any, float, tuple[float, float]]:
    """The map from the coordinates of the drawing to px (3 x 3), the page's height in px, its size in the drawing.

    The view box is taken off the root: svgelements would round its scale.
    """
    (width, _), (height, _) = _size(root, "width", file), _size(root, "height", file)
    text, fit = root.attrib.pop("viewBox", None), root.attrib.pop("preserveAspectRatio", "xMidYMid meet")
    for key in ("width", "height"):
        root.attrib.pop(key, None)
    if text is None:
        return np.eye(3), 0.0 if math.isnan(height) else height, (width, height)
    try:
        x, y, wide, high = (float(v) for v in text.replace(",", " ").split())
    except ValueError:
        raise DataError(f"{file}: viewBox={text!r}: expected four numbers") from None
    if not (wide > 0.0 and high > 0.0 and math.isfinite(x + y + wide + high)):
        raise DataError(f"{file}: viewBox={text!r}: expected a width and a height above 0")
    if math.isnan(width) and math.isnan(height):
        width, height = wide, high
    width = height * wide / high if math.isnan(width) else width
    height = width * high / wide if math.isnan(height) else height
    sx, sy = width / wide, height / high
    if "none" not in fit:
        sx = sy = max(sx, sy) if "slice" in fit else min(sx, sy)
    share = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
    across = next((v for k, v in share.items() if f"x{k}" in fit), 0.5) * (width - sx * wide)
    down = next((v for k, v in share.items() if f"Y{k}" in fit), 0.5) * (height - sy * high)
    return np.array([[sx, 0.0, across - sx * x], [0.0, sy, down - sy * y], [0.0, 0.0, 1.0]]), height, (wide, high)


def _shapes(root: ElementTree.Element, file: File) -> tuple[list[Any], int]:
    """The shapes that are seen, and how many are hidden."""
    import svgelements as svg

    text = ElementTree.tostring(root)
    found: list[list[Any]] = []
    # The second time for what is hidden, to count it.
    for everything in (False, True) if HIDES.search(text) else (False,):
        try:
            whole = svg.SVG.parse(
                io.BytesIO(text), reify=False, ppi=96.0, parse_display_none=everything, on_error="raise"
            )
        except RecursionError:
            raise DataError(f"{file}: its elements lie too deep in one another") from None
        except Exception as error:
            # svgelements raises what its parts raise: the message is all there is.
            why = f"{type(error).__name__}: {error}".rstrip(": ")
            raise DataError(f"{file} cannot be read ({why}): save it as plain SVG") from None
        found.append([e for e in whole.elements() if isinstance(e, svg.Shape)] if isinstance(whole, svg.SVG) else [])
    seen = [e for e in found[0] if str(e.values.get("visibility", "")) not in ("hidden", "collapse")]
    return seen, len(found[-1]) - len(seen)


def _prepare(root: ElementTree.Element) -> list[str]:
    """Marks the layers, puts what is only referred to into ``defs``; the names of the layers."""
    layers = []
    for element in root.iter():
        if element.get(f"{INKSCAPE}groupmode") == "layer":
            name = element.get(f"{INKSCAPE}label") or element.get("id") or "layer"
            element.set(LAYER, name)
            layers.append(name)
    for parent in list(root.iter()):
        if _tag(parent) == "defs":
            continue
        for k, child in enumerate(list(parent)):
            if _tag(child) in NOT_DRAWN:
                shelf = ElementTree.Element(f"{SVG}defs")
                shelf.append(child)
                parent[k] = shelf
    return layers


def _name(shape: Any) -> str:
    return str(shape.id) if shape.id is not None else ""


def _matrix(shape: Any) -> Any:
    m = shape.transform
    rows = [[m.a, m.c, m.e], [m.b, m.d, m.f], [0.0, 0.0, 1.0]]
    return np.array([[float(v) for v in row] for row in rows])


def _xy(p: Any) -> tuple[float, float]:
    return float(p.x), float(p.y)


def _pair(p: Any) -> tuple[float, float]:
    return float(p[0]), float(p[1])
