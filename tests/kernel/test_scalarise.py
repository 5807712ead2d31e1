"""NamedTuples taken apart: the same numbers, in fewer objects, also where something needs one whole."""

import ast
from typing import NamedTuple

import pytest

from leadscrew.kernel.scalarise import Scalariser, fields_of, without_dead

TEXT = """
class Point(NamedTuple):
    x: float
    y: float

class Line(NamedTuple):
    start: Point
    end: Point
    width: float

def length(line):
    return abs(line.end.x - line.start.x) + 10.0 * abs(line.end.y - line.start.y) + 100.0 * line.width

def turned(p):
    return Point(-p.y, p.x)

def whole(a, b):
    line = Line(Point(a, b), Point(b, a), 2.0)
    return length(line) + length(Line(line.end, turned(line.start), a))

def opaque(a, b):
    p = turned(Point(a, b))
    line = Line(turned(p), p, turned(p).x)
    return line.start.x + 10.0 * line.start.y + 100.0 * line.end.x + 1000.0 * line.width

def tangled(a, b):
    p = Point(a, b)
    for i in range(3):
        p = Point(p.y + i, p.x)
    p = Point(p.y, 4.0) if a > b else Point(p.x, p.y)
    q, r = a, b
    line = Line(p, Point(q, r), 1.0)
    line = Line(line.end, line.start, line.width)
    return line.start.x - 2.0 * line.end.x + 3.0 * line.end.y + p.x

def given_away(a, b):
    line = Line(Point(a, b), Point(b, a), 2.0)
    p = line.start
    unused = Point(a * 2.0, b)
    while b > 100.0:
        b = b - p.x
        p = Point(p.y, p.x)
    return length(line), p, line.end, Line(p, p, 0.0).end.y
"""
TREE = ast.parse(TEXT)
FUNCTIONS = {n.name: n for n in TREE.body if isinstance(n, ast.FunctionDef)}
CLASSES = fields_of([n for n in TREE.body if isinstance(n, ast.ClassDef)])


@pytest.mark.parametrize("name", ["whole", "opaque", "tangled", "given_away"])
@pytest.mark.parametrize(("a", "b"), [(1.0, 2.0), (5.0, -3.0), (60.0, 250.0)])
def test_a_function_gives_the_same_with_its_named_tuples_taken_apart(name, a, b):
    before: dict = {"NamedTuple": NamedTuple}
    exec(TEXT, before)
    node = ast.parse(ast.unparse(FUNCTIONS[name])).body[0]
    assert isinstance(node, ast.FunctionDef)
    apart = without_dead(Scalariser(CLASSES).function(node), {"Point", "Line", "abs"})
    after = dict(before)
    exec(compile(ast.fix_missing_locations(ast.Module([apart], [])), "apart", "exec"), after)
    assert after[name](a, b) == before[name](a, b)
    kept = {n.id for n in ast.walk(apart) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    assert "line" not in kept and not any(n.startswith("unused") for n in kept)
    assert ("p" in kept) == (name == "opaque")  # what a function returned that stayed a function stays whole
