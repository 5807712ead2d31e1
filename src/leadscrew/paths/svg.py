"""Paths of an SVG drawing, through svgelements, which resolves ``use``, styles, groups and the view box.

Read are ``path``, ``rect``, ``circle``, ``ellipse``, ``line``, ``polyline`` and ``polygon``, whatever their stroke or
fill. Their geometry is taken before the transform and mapped by us: an arc under a skew stays exact, as the arc of an
ellipse. Not read: text, images, what is hidden, what only serves to clip, mask, mark or fill. Sizes follow ``width``,
``height`` and ``viewBox``, 96 px to the inch; ``unit`` says what a px is where the file names no physical unit. The
y-axis is turned upwards, with the lower edge of the page at 0. What cannot be read is refused, not cut in part.

What an SVG drawing must keep for all of it to be cut; looked at before svgelements, which passes over what it cannot
read.

Path data, points, transforms and lengths are held against the grammar of SVG. Percentages become numbers. What ``use``
draws is counted before it is drawn: a few lines can ask for more shapes than there is memory. Of style sheets only what
moves, shapes or hides is kept: svgelements takes time as the square of the rest.
"""

from __future__ import annotations

import io
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path as File
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from leadscrew.kernel.parameters import nearest
from leadscrew.paths.curve import Curve
from leadscrew.paths.drawing import UNITS_MM, Drawing, Piece, drawing, left_out
from leadscrew.paths.segments import Bezier, EllipseArc, Line, circular
from leadscrew.util import reading
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

NOT_DRAWN = ("symbol", "marker", "mask", "pattern", "clipPath", "filter", "linearGradient", "radialGradient")
DEEPEST = 200
"""Elements inside elements, ``use`` followed."""
MOST_USED = 100_000
"""Elements drawn through ``use``."""
PX = {
    "": 1.0,
    "px": 1.0,
    "in": 96.0,
    "cm": 96.0 / 2.54,
    "mm": 96.0 / 25.4,
    "q": 24.0 / 25.4,
    "pt": 96.0 / 72.0,
    "pc": 16.0,
}
"""Units of length in px."""
LENGTHS = "a number with px, in, cm, mm, Q, pt, pc, % or no unit"
NUMBER = r"(?>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
SIZE = re.compile(rf"\s*({NUMBER})\s*([a-z%]*)\s*", re.IGNORECASE)
COMMANDS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
"""How many numbers each command of path data takes at a time."""
_BETWEEN = r"(?>\s*,?\s*)"
_SETS = {c: re.compile(_BETWEEN.join([NUMBER] * n)) for c, n in COMMANDS.items() if c not in "AZ"}
_SETS["A"] = re.compile(_BETWEEN.join([NUMBER] * 3 + ["[01]"] * 2 + [NUMBER] * 2))
_COMMA = re.compile(r"\s*,?\s*")
_SPACE = re.compile(r"\s*")
_POINTS = re.compile(rf"\s*(?:{NUMBER}{_BETWEEN}{NUMBER}{_BETWEEN})*")
TRANSFORMS = {
    **{"matrix": (6,), "translate": (1, 2), "scale": (1, 2), "rotate": (1, 3), "skewx": (1,), "skewy": (1,)},
    **{"translatex": (1,), "translatey": (1,), "scalex": (1,), "scaley": (1,)},
}
"""How many numbers each takes."""
_TRANSFORM = re.compile(r"\s*,?\s*([a-z]+)\s*\(([^()]*)\)\s*", re.IGNORECASE)
_PARAMETER = rf"{NUMBER}(?:deg|grad|rad|turn)?"
_PARAMETERS = re.compile(rf"\s*(?:{_PARAMETER}{_BETWEEN})*", re.IGNORECASE)
ACROSS, DOWN = ("x", "cx", "x1", "x2", "width", "rx"), ("y", "cy", "y1", "y2", "height", "ry")
MEASURED = {
    "circle": ("cx", "cy", "r"),
    "ellipse": ("cx", "cy", "rx", "ry"),
    "line": ("x1", "y1", "x2", "y2"),
    "rect": ("x", "y", "width", "height", "rx", "ry"),
    "svg": ("x", "y", "width", "height"),
    "use": ("x", "y", "width", "height"),
}
"""Lengths of each element."""


MOST_TRANSFORMS = 1000
STYLED = {
    *("display", "visibility", "transform", "d", "points"),
    *(key for keys in MEASURED.values() for key in keys),
}
"""Properties by which a style sheet changes what is cut."""
MOST_STYLE = 20_000
"""Characters of a style sheet, without the rest, for all its selectors."""


class _Page(NamedTuple):
    """What percentages are of."""

    width: float
    height: float


def tag(element: Element) -> str:
    """The name of an element without its namespace."""
    return element.tag.rsplit("}", 1)[-1] if isinstance(element.tag, str) else ""


def check(root: Element, width: float, height: float) -> list[str]:
    """Notes on what is left out; percentages of the page (``width``, ``height``; nan where not known) made numbers.

    Raises:
        DataError: something that cannot be read, elements too deep, or too many through ``use``.
    """
    reading.check_curves("its elements", sum(1 for _ in root.iter()))
    _depth(root)
    for element in root.iter():
        if tag(element) == "style":
            element.text = style_sheet(element.text or "")
        elif "class" in element.attrib:
            element.set("class", " ".join(dict.fromkeys(element.get("class", "").split())))
    for element, page in _drawn(root, _Page(width, height)):
        kind = tag(element)
        if kind == "path":
            if element.get("d") is None:
                element.set("d", "")
            elif fault := data_fault(element.get("d", "")):
                raise DataError(f"{_called(element)}: {fault}")
        elif kind in ("polyline", "polygon"):
            _check_points(element)
        _check_transform(element)
        for key in MEASURED.get(kind, ()) if element is not root else ():
            _length(element, key, page)
    return _used(root)


def style_sheet(text: str) -> str:
    """The rules of a style sheet that change what is cut, each with something in it.

    Raises:
        DataError: they are too long.
    """
    first, *comments = text.split("/*")
    text = re.sub("//.*", "", first + "".join(c.partition("*/")[2] for c in comments))
    rules, size = [], 0
    for rule in text.split("}")[:-1]:
        names, _, body = rule.partition("{")
        selectors = dict.fromkeys(s for name in names.split(",") if (s := name.strip()))
        kept = ";".join(d for d in body.split(";") if d.partition(":")[0].strip() in STYLED)
        if selectors and kept:
            size += len(selectors) * len(kept)
            rules.append(f"{','.join(selectors)}{{{kept}}}")
        if size > MOST_STYLE:
            raise DataError(f"<style>: its rules are more than {MOST_STYLE} characters long; save it as plain SVG")
    return "\n".join(rules)


def data_fault(data: str) -> str:
    """Why path data cannot be read, with the place; empty where they can."""
    if data.strip() in ("", "none"):
        return ""
    place = _SPACE.match(data).end()  # type: ignore[union-attr]
    first = True
    while place < len(data):
        command = data[place].upper()
        if command not in COMMANDS or (first and command != "M"):
            known = "M to begin with" if first else f"one of {' '.join(COMMANDS)}"
            return f"its data cannot be read at {data[place : place + 16]!r} (character {place + 1}): expected {known}"
        first = False
        place = _SPACE.match(data, place + 1).end()  # type: ignore[union-attr]
        if command == "Z":
            continue
        numbers, found = _SETS[command], False
        while (match := numbers.match(data, place)) is not None:
            found = True
            end = match.end()
            place = _COMMA.match(data, end).end()  # type: ignore[union-attr]
        if found and (place == len(data) or data[place].isalpha()):
            # What stands between the last number and the next command may be space, no comma.
            place = _SPACE.match(data, end).end()  # type: ignore[union-attr]
        if not found or (place < len(data) and not data[place].isalpha()):
            return (
                f"its data cannot be read at {data[place : place + 16]!r} (character {place + 1}): "
                f"{command} takes {COMMANDS[command]} number{'s' if COMMANDS[command] > 1 else ''} at a time"
            )
    return ""


def _check_points(element: Element) -> None:
    text = element.get("points", "")
    place = _POINTS.match(text).end()  # type: ignore[union-attr]
    if place < len(text):
        raise DataError(
            f"{_called(element)}: its points cannot be read at {text[place : place + 16]!r} (character {place + 1}): "
            "expected pairs of numbers"
        )


def _check_transform(element: Element) -> None:
    text = element.get("transform", "")
    place = len(text) if text.strip() == "none" else 0
    if text.count("(") > MOST_TRANSFORMS:
        raise DataError(f"{_called(element)}: more than {MOST_TRANSFORMS} transforms of one element")
    while place < len(text):
        found = _TRANSFORM.match(text, place)
        counts = TRANSFORMS.get(found[1].lower(), ()) if found and _PARAMETERS.fullmatch(found[2]) else ()
        if found is None or len(re.findall(_PARAMETER, found[2], re.IGNORECASE)) not in counts:
            raise DataError(
                f"{_called(element)}: transform={_short(text)} cannot be read; expected matrix(a b c d e f), "
                "translate(x y), scale(x y), rotate(deg x y), skewX(deg) or skewY(deg)"
            )
        place = found.end()


def _length(element: Element, key: str, page: _Page) -> None:
    """Holds a length against the units known; a percentage becomes a number."""
    text = element.get(key, "").strip()
    if text in ("", "auto"):
        return
    found = SIZE.fullmatch(text)
    unit = found[2].lower() if found else ""
    if found is None or (unit not in PX and unit != "%"):
        raise DataError(f"{_called(element)}: {key}={_short(text)} cannot be read: expected {LENGTHS}")
    if unit == "%":
        whole = page.width if key in ACROSS else page.height if key in DOWN else _diagonal(page)
        if math.isnan(whole):
            raise DataError(f"{_called(element)}: {key}={text!r}: the page has no size that a percentage could be of")
        element.set(key, repr(0.01 * float(found[1]) * whole))
    elif unit:
        element.set(key, repr(float(found[1]) * PX[unit]))
    if key in ("width", "height", "r") and float(found[1]) < 0.0:
        raise DataError(f"{_called(element)}: {key}={text!r}: expected no less than 0")


def _diagonal(page: _Page) -> float:
    return math.sqrt(0.5 * (page.width**2 + page.height**2))


def _drawn(root: Element, page: _Page) -> Iterator[tuple[Element, _Page]]:
    """The elements that may be drawn, each with the page it lies on."""
    waiting = [(root, page)]
    while waiting:
        element, page = waiting.pop()
        kind = tag(element)
        yield element, page
        if element is not root and kind in ("svg", "symbol"):
            page = _inner(element, page)
        for child in element:
            if tag(child) not in NOT_DRAWN or tag(child) == "symbol":
                waiting.append((child, page))


def _inner(element: Element, page: _Page) -> _Page:
    """What percentages inside an ``svg`` or a ``symbol`` are of."""
    box = re.findall(NUMBER, element.get("viewBox", ""))
    if len(box) == 4:
        return _Page(float(box[2]), float(box[3]))
    sizes = []
    for key, whole in zip(("width", "height"), page, strict=True):
        found = SIZE.fullmatch(element.get(key, ""))
        sizes.append(float(found[1]) * PX.get(found[2].lower(), math.nan) if found else whole)
    return _Page(*sizes)


def _depth(root: Element) -> None:
    waiting = [(root, 1)]
    while waiting:
        element, deep = waiting.pop()
        if deep > DEEPEST:
            raise _too_deep(element)
        waiting += [(child, deep + 1) for child in element]


def _too_deep(element: Element) -> DataError:
    return DataError(f"{_called(element)} lies more than {DEEPEST} elements deep")


def _used(root: Element) -> list[str]:
    """Counts what ``use`` draws; notes on those that draw nothing."""
    places = {name: e for e in root.iter() if (name := e.get("id"))}
    counts: dict[Element, tuple[int, int]] = {}
    gone: Counter[str] = Counter()

    def counted(element: Element, above: tuple[Element, ...]) -> tuple[int, int]:
        """Elements drawn through ``use`` below this one, and how deep they lie."""
        if element in counts:
            return counts[element]
        if len(above) > 2 * DEEPEST:
            raise _too_deep(element)
        drawn, deep = 0, 0
        below = (*above, element)
        for child in element:
            more, down = counted(child, below)
            drawn, deep = drawn + more, max(deep, down)
            if drawn > MOST_USED:
                raise DataError(f"{_called(element)}: draws more than {MOST_USED} elements through <use>")
        if tag(element) == "use":
            target = places.get(_target(element)[1:])
            if target is None:
                gone[_target(element)] += 1
            elif target in below:
                raise DataError(f"{_called(element)} refers to itself")
            else:
                more, down = counted(target, below)
                drawn, deep = drawn + more + sum(1 for _ in target.iter()), max(deep, down)
        if drawn > MOST_USED:
            raise DataError(f"{_called(element)}: draws more than {MOST_USED} elements through <use>")
        if deep + 1 > DEEPEST:
            raise _too_deep(element)
        counts[element] = (drawn, deep + 1)
        return counts[element]

    counted(root, ())
    notes = []
    outside = sorted(name for name in gone if not name.startswith("#") and name)
    if outside:
        notes.append(f"<use> of another file, not cut: {_listed(outside)}")
    missing = sorted(name or "nothing" for name in gone if name.startswith("#") or not name)
    if missing:
        notes.append(f"<use> of what the file does not have, not cut: {_listed(missing)}")
    return notes


def _target(element: Element) -> str:
    return element.get("href", element.get("{http://www.w3.org/1999/xlink}href", ""))


def _listed(names: list[str]) -> str:
    shown = ", ".join(_short(n)[1:-1] for n in names[:3])
    return shown + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _called(element: Element) -> str:
    name = element.get("id")
    return f"<{tag(element)}>" + (f" {_short(name)}" if name else "")


def _short(text: str) -> str:
    return repr(text if len(text) <= 40 else f"{text[:37]}...")


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
    if tag(root) != "svg":
        raise DataError(f"{file} is no SVG: its first element is <{tag(root)}>")
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
    notes = left_out(Counter(t for e in root.iter() if (t := tag(e)) in NOT_CUT)) + broken
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
        if tag(parent) == "defs":
            continue
        for k, child in enumerate(list(parent)):
            if tag(child) in NOT_DRAWN:
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
