"""The terms of ``.fcl`` files: points, numbers, the names of fuzzylite and those of jFuzzyLogic."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from leadscrew.fuzzy.formats.place import Source, plain
from leadscrew.fuzzy.formats.vocabulary import FLL_SHAPES, NO_SHAPE, class_term, class_text
from leadscrew.fuzzy.rules_text import Cursor, Token, read_number
from leadscrew.fuzzy.system import Term
from leadscrew.kernel.sheet import nearest

POINTS = "points"
_HEIGHTS = {"ramp": (0.0, 1.0), "triangle": (0.0, 1.0, 0.0), "trapezoid": (0.0, 1.0, 1.0, 0.0)}
"""The shapes that are written as points, by the heights of their points."""
_JFUZZY: dict[str, tuple[str, int]] = {
    "trian": ("triangle", 3),
    "trape": ("trapezoid", 4),
    "gauss": ("gaussian", 2),
    "gauss2": ("gaussian_product", 4),
    "gbell": ("bell", 3),
    "sigm": ("sigmoid", 2),
    "dsigm": ("sigmoid_difference", 4),
    "cosine": ("cosine", 2),
    "singletons": ("singleton", 2),
}


@dataclass(frozen=True)
class Given:
    """A term as it stands in the file; ``kind`` is empty for a mere number."""

    name: str
    at: Token
    kind: str
    numbers: tuple[float, ...]


def given_term(cursor: Cursor) -> Given:
    """The term after the word TERM."""
    name = cursor.take()
    if not name.is_name or not name.text[:1].replace("_", "a").isalnum():
        cursor.fail("the name of a term", name)
    cursor.expect(":=")
    at = cursor.token
    kind, numbers = "", []
    if at.text == "(":
        kind = POINTS
    elif read_number(at.text) is None:
        kind = cursor.take().text
        if kind in NO_SHAPE or kind.casefold() == "function":
            cursor.refuse(f"a {kind} is {NO_SHAPE.get(kind, NO_SHAPE['Function'])}", at)
    if kind == POINTS or kind.casefold() == "singletons":
        numbers = _points(cursor)
    else:
        while (number := read_number(cursor.token.text)) is not None:
            numbers.append(number)
            cursor.take()
    if cursor.token.text != ";":
        cursor.fail("a number or ';'" if kind != POINTS else "'(' or ';'")
    cursor.take()
    return Given(name.text, at, kind, tuple(numbers))


def _points(cursor: Cursor) -> list[float]:
    numbers: list[float] = []
    while cursor.skip("("):
        for end in (",", ")"):
            number = read_number(cursor.token.text)
            if number is None:
                cursor.fail("a number")
            numbers.append(number)
            cursor.take()
            cursor.expect(end)
    return numbers


def term_of(source: Source, given: Given, weighted: bool, inputs: int) -> Term:
    """The term that is meant; of an output whose defuzzifier is ``weighted``, a number is a constant."""
    name, kind, numbers, at = given.name, given.kind, list(given.numbers), given.at
    with source.at(at.line, at.column):
        if not kind:
            if len(numbers) != 1:
                source.fail(at.line, at.column, f"expected one number, found {len(numbers)}")
            return Term(name, "constant" if weighted else "singleton", tuple(numbers))
        if kind == POINTS:
            return _polyline(name, numbers)
        if kind not in FLL_SHAPES and kind.casefold() in _JFUZZY:
            return _of_jfuzzylogic(source, given, kind.casefold(), numbers)
        if kind not in FLL_SHAPES and (same := [k for k in FLL_SHAPES if k.casefold() == kind.casefold()]):
            kind = same[0]
        if kind not in FLL_SHAPES:
            hint = nearest(kind, [*FLL_SHAPES, *_JFUZZY])
            source.fail(at.line, at.column, f"expected a shape{hint}, found {kind!r}")
        if kind == "Linear" and len(numbers) != inputs + 1:
            wanted = f"{inputs + 1} numbers (one for each input and a constant)"
            source.fail(at.line, at.column, f"expected {wanted}, found {len(numbers)}")
        return class_term(name, kind, numbers)


def _polyline(name: str, numbers: list[float]) -> Term:
    """Points as the shape that they are: a ramp, a triangle, a trapezoid, or a polyline."""
    xs, ys = tuple(numbers[::2]), tuple(numbers[1::2])
    if all(a < b for a, b in itertools.pairwise(xs)):
        if ys == (1.0, 0.0):
            return Term(name, "ramp", (xs[1], xs[0]))
        for shape, heights in _HEIGHTS.items():
            if ys == heights:
                return Term(name, shape, xs)
    return Term(name, "discrete", tuple(numbers))


def _of_jfuzzylogic(source: Source, given: Given, kind: str, numbers: list[float]) -> Term:
    shape, count = _JFUZZY[kind]
    if len(numbers) != count:
        what = "one point: more singletons than one are no shape here" if kind == "singletons" else f"{count} numbers"
        source.fail(given.at.line, given.at.column, f"expected {what}, found {len(numbers)} numbers")
    height = 1.0
    if kind == "gbell":
        numbers = [numbers[2], numbers[0], numbers[1]]
    elif kind == "sigm":
        numbers = [numbers[1], numbers[0]]
    elif kind == "dsigm":
        numbers = [numbers[1], numbers[0], numbers[2], numbers[3]]
    elif kind == "cosine":
        numbers = [numbers[1], 2.0 * numbers[0]]
    elif kind == "singletons":
        numbers, height = [numbers[0]], numbers[1]
    return Term(given.name, shape, tuple(numbers), height)


def term_text(term: Term) -> str:
    """A term as it is written: a number, points where they say it all, else fuzzylite's name and numbers."""
    xs = term.parameters
    if term.shape in ("constant", "singleton"):
        return plain(xs[0])
    if term.shape == "discrete" and term.height == 1.0:
        return _point_text(xs[::2], xs[1::2])
    ends, ys = xs, _HEIGHTS.get(term.shape, ())
    if term.shape == "ramp" and xs[1] < xs[0]:
        ends, ys = xs[::-1], (1.0, 0.0)
    rising = all(-1e300 < a < b < 1e300 for a, b in itertools.pairwise(ends))
    return _point_text(ends, ys) if ys and rising and term.height == 1.0 else class_text(term)


def _point_text(xs: tuple[float, ...], ys: tuple[float, ...]) -> str:
    return " ".join(f"({plain(x)}, {plain(y)})" for x, y in zip(xs, ys, strict=True))
