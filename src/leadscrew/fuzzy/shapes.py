"""The membership functions: how each shape is prepared, once, and what a step computes from the prepared numbers.

With ``x`` the value and the parameters in the order of :data:`leadscrew.fuzzy.system.SHAPES` (the formulas are those
of the field, with the conventions that fuzzylite and MATLAB share at edges and for infinite ends):

===================  ===========================================================================================
triangle a b c       rises from a to b, falls to c; an infinite a or c makes a shoulder
trapezoid a b c d    rises from a to b, one up to c, falls to d; likewise
ramp s e             from 0 at s to 1 at e, falling where e < s, 0 everywhere where they are equal
rectangle s e        1 from s to e
binary s d           1 from s on where d is positive, up to s where it is negative
gaussian m d         exp(-(x - m)^2 / (2 d^2))
gaussian_product     a left flank of one gaussian below its mean, a right flank of another above its mean
bell c w s           1 / (1 + abs((x - c)/w)^(2 s))
sigmoid i s          1 / (1 + exp(-s (x - i)))
sigmoid_difference   abs(left rising sigmoid - right one, at slope falling)
sigmoid_product      product of the two
s_shape s e          two parabolas that rise from s to e;  z_shape s e: 1 - s_shape
pi_shape             s_shape times z_shape
cosine c w           (1 + cos(2 pi (x - c)/w)) / 2 within w/2 of c
spike c w            exp(-abs(10 (x - c)/w))
concave i e          (e - i)/(2 e - i - x) below e where i <= e, above e where i > e; 1 beyond
singleton v          1 at v
discrete             a polyline, level before its first and after its last point
===================  ===========================================================================================

Each is multiplied by the term's height. The five shapes with straight sides are one function, ``straight``: from 0 at
its first number to 1 at the second, 1 up to the third, down to 0 at the fourth; then one over each width.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from leadscrew.fuzzy.system import Term
from leadscrew.kernel.guards import unguarded
from leadscrew.kernel.portable import cos, exp, pow
from leadscrew.util.errors import ValueRefused

NUMBERS = 6
"""How many prepared numbers a term has."""
STRAIGHT = ("triangle", "trapezoid", "ramp", "rectangle", "binary")


# ---- what a step computes
def side(start, inverse, end, x):
    """From 0 at ``start`` to 1 at ``end``; ``inverse`` is one over the width. Exactly 0 and 1 there and beyond."""
    inside = (x - start) * inverse
    above = inside if inside > 0.0 else 0.0
    return 1.0 if x >= end else (above if above < 1.0 else 1.0)


def straight(a, b, c, d, left, right, x):
    """Rises from ``a`` to ``b`` (``left`` is one over the width), falls from ``c`` to ``d``; upright where equal."""
    rising = 0.0 if x < a else (1.0 if x >= b else (x - a) * left)
    falling = 0.0 if x > d else (1.0 if x <= c else (d - x) * right)
    return rising if rising < falling else falling


def flank(mean, inverse, x):
    """A gaussian; ``inverse`` is one over its deviation."""
    t = (x - mean) * inverse
    return exp(-0.5 * t * t)


def two_flanks(first, first_inverse, second, second_inverse, x):
    """One gaussian below its mean times another above its mean."""
    left = flank(first, first_inverse, x) if x < first else 1.0
    right = flank(second, second_inverse, x) if x > second else 1.0
    return left * right


def bell(centre, inverse, power, x):
    """The generalised bell; ``power`` is twice its slope."""
    return 1.0 / (1.0 + pow(abs((x - centre) * inverse), power))


def sigmoid(inflection, slope, x):
    """The logistic curve."""
    return 1.0 / (1.0 + exp(-slope * (x - inflection)))


def sigmoid_difference(left, rising, falling, right, x):
    """The difference of two sigmoids, without its sign."""
    return abs(sigmoid(left, rising, x) - sigmoid(right, falling, x))


def sigmoid_product(left, rising, falling, right, x):
    """The product of two sigmoids."""
    return sigmoid(left, rising, x) * sigmoid(right, falling, x)


def s_shape(start, end, inverse, x):
    """Two parabolas from 0 at ``start`` to 1 at ``end``."""
    t = (x - start) * inverse
    low = 2.0 * t * t
    high = 1.0 - 2.0 * (1.0 - t) * (1.0 - t)
    return 0.0 if x <= start else (1.0 if x >= end else (low if t <= 0.5 else high))


def z_shape(start, end, inverse, x):
    """Two parabolas from 1 at ``start`` to 0 at ``end``."""
    return 1.0 - s_shape(start, end, inverse, x)


def pi_shape(bottom_left, top_left, top_right, bottom_right, left, right, x):
    """Rises as an s, falls as a z."""
    return s_shape(bottom_left, top_left, left, x) * (1.0 - s_shape(top_right, bottom_right, right, x))


def cosine(low, high, centre, scale, x):
    """One period of a cosine around ``centre``, from ``low`` to ``high``."""
    inside = 0.5 * (1.0 + cos(scale * (x - centre)))
    return 0.0 if x < low or x > high else inside


def spike(centre, scale, x):
    """Falls exponentially on both sides of ``centre``."""
    return exp(-abs((x - centre) * scale))


def concave(inflection, end, x):
    """A hyperbola that reaches 1 at ``end``."""
    under = 2.0 * end - inflection - x
    part = (end - inflection) / (under if under != 0.0 else 1.0)
    before = x < end if inflection <= end else x > end
    return part if before else 1.0


def singleton(value, x):
    """1 at ``value``."""
    return 1.0 if x == value else 0.0


@unguarded
def polyline(points, first, end, x):
    """Through the rows ``first`` to ``end`` of ``points``: x, y, and the slope up to there."""
    y = points[first, 1]
    for i in range(first + 1, end):
        inside = points[i - 1, 1] + (x - points[i - 1, 0]) * points[i, 2]
        y = points[i, 1] if x >= points[i, 0] else (inside if x > points[i - 1, 0] else y)
    return y


# ---- how a shape is prepared
def _over(width: float) -> float:
    """One over a width; 0 where the side is upright or endless, where it is not used."""
    return 1.0 / width if 0.0 < width < math.inf else 0.0


def _sides(a: float, b: float, c: float, d: float) -> tuple[float, ...]:
    b, c = (a if a == -math.inf else b), (d if d == math.inf else c)
    return a, b, c, d, _over(b - a), _over(d - c)


def _ramp(start: float, end: float) -> tuple[float, ...]:
    if start == end:
        return _sides(math.inf, math.inf, -math.inf, -math.inf)
    return _sides(start, end, math.inf, math.inf) if start < end else _sides(-math.inf, -math.inf, end, start)


def _binary(start: float, direction: float) -> tuple[float, ...]:
    if direction == 0.0:
        return _ramp(0.0, 0.0)
    return _sides(start, start, math.inf, math.inf) if direction > 0.0 else _sides(-math.inf, -math.inf, start, start)


def _inverse(value: float, what: str) -> float:
    if value == 0.0:
        raise ValueRefused(f"{what} = 0: allowed is any number but zero")
    return 1.0 / value


def _cosine(centre: float, width: float) -> tuple[float, ...]:
    half = 0.5 * width
    return centre - half, centre + half, centre, 2.0 * math.pi * _inverse(width, "width")


PREPARED: dict[str, tuple[Callable[..., float], Callable[..., tuple[float, ...]]]] = {
    "triangle": (straight, lambda a, b, c: _sides(a, b, b, c)),
    "trapezoid": (straight, _sides),
    "ramp": (straight, _ramp),
    "rectangle": (straight, lambda a, b: _sides(a, a, b, b)),
    "binary": (straight, _binary),
    "gaussian": (flank, lambda m, d: (m, _inverse(d, "deviation"))),
    "gaussian_product": (
        two_flanks,
        lambda a, d, b, e: (a, _inverse(d, "deviation_a"), b, _inverse(e, "deviation_b")),
    ),
    "bell": (bell, lambda c, w, s: (c, _inverse(w, "width"), 2.0 * s)),
    "sigmoid": (sigmoid, lambda i, s: (i, s)),
    "sigmoid_difference": (sigmoid_difference, lambda *p: p),
    "sigmoid_product": (sigmoid_product, lambda *p: p),
    "s_shape": (s_shape, lambda s, e: (s, e, _over(e - s))),
    "z_shape": (z_shape, lambda s, e: (s, e, _over(e - s))),
    "pi_shape": (pi_shape, lambda a, b, c, d: (a, b, c, d, _over(b - a), _over(d - c))),
    "cosine": (cosine, _cosine),
    "spike": (spike, lambda c, w: (c, 10.0 * _inverse(w, "width"))),
    "concave": (concave, lambda i, e: (i, e)),
    "singleton": (singleton, lambda v: (v,)),
}
"""The step of a shape and what makes its numbers; a discrete set and the consequents of Takagi and Sugeno apart."""


def prepared(shape: str, parameters: Sequence[float]) -> tuple[float, ...]:
    """The numbers that a shape's step takes before ``x``.

    Raises:
        ValueRefused: a width or deviation of zero.
    """
    try:
        return PREPARED[shape][1](*parameters)
    except ValueRefused as error:
        raise ValueRefused(f"a {shape} with {error}") from None


def membership_function(term: Term) -> Callable[[float], float]:
    """A term's membership function, in plain Python; NaN of NaN."""
    if term.shape == "discrete":
        rows, count = polyline_rows(term.parameters), len(term.parameters) // 2
        return lambda x: term.height * float(polyline(rows, 0, count, float(x))) if x == x else math.nan
    function, numbers = PREPARED[term.shape][0], prepared(term.shape, term.parameters)
    return lambda x: term.height * function(*numbers, float(x)) if x == x else math.nan


def membership(term: Term, x: float) -> float:
    """The membership of ``x`` in a term, in plain Python; NaN of NaN."""
    return membership_function(term)(x)


def polyline_rows(parameters: Any) -> Any:
    """The points of a discrete set with the slope that leads to each."""
    import numpy as np

    xy = np.array(parameters, dtype=float).reshape(-1, 2)
    slopes = np.zeros(len(xy))
    width = np.diff(xy[:, 0])
    np.divide(np.diff(xy[:, 1]), width, out=slopes[1:], where=width > 0.0)
    return np.column_stack([xy, slopes])
