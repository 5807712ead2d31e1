"""The membership functions, each for a parameter vector and a value: plain steps, so they run on every engine.

With ``x`` the value and the parameters in the order of :data:`leadscrew.fuzzy.system.SHAPES` (the formulas are those
of the field, with the conventions that fuzzylite and MATLAB share at edges and for infinite ends):

===================  ===========================================================================================
triangle a b c       rises from a to b, falls to c; an infinite a or c makes a shoulder
trapezoid a b c d    rises from a to b, one up to c, falls to d; likewise
ramp s e             from 0 at s to 1 at e, falling where e < s
rectangle s e        1 from s to e
binary s d           1 from s on where d is positive, up to s where it is negative
gaussian m d         exp(-(x - m)^2 / (2 d^2))
gaussian_product     a left flank of one gaussian below its mean, a right flank of another above its mean
bell c w s           1 / (1 + |(x - c)/w|^(2 s))
sigmoid i s          1 / (1 + exp(-s (x - i)))
sigmoid_difference   |left rising sigmoid - right one, at slope falling|
sigmoid_product      product of the two
s_shape s e          two parabolas that rise from s to e;  z_shape s e: 1 - s_shape
pi_shape             s_shape times z_shape
cosine c w           (1 + cos(2 pi (x - c)/w)) / 2 within w/2 of c
spike c w            exp(-|10 (x - c)/w|)
concave i e          (e - i)/(2 e - i - x) below e where i <= e, mirrored where i > e; 1 beyond
singleton v          1 at v
===================  ===========================================================================================

Each is multiplied by the term's height. ``discrete`` is a polyline; it lives in a table of its own.
"""

from __future__ import annotations

from leadscrew.kernel.portable import cos, exp

TRIANGLE, TRAPEZOID, RAMP, RECTANGLE, BINARY, GAUSSIAN, GAUSSIAN_PRODUCT, BELL, SIGMOID = range(9)
SIGMOID_DIFFERENCE, SIGMOID_PRODUCT, S_SHAPE, Z_SHAPE, PI_SHAPE, COSINE, SPIKE, CONCAVE, SINGLETON = range(9, 18)
DISCRETE, CONSTANT, LINEAR = range(18, 21)
CODES = {
    "triangle": TRIANGLE,
    "trapezoid": TRAPEZOID,
    "ramp": RAMP,
    "rectangle": RECTANGLE,
    "binary": BINARY,
    "gaussian": GAUSSIAN,
    "gaussian_product": GAUSSIAN_PRODUCT,
    "bell": BELL,
    "sigmoid": SIGMOID,
    "sigmoid_difference": SIGMOID_DIFFERENCE,
    "sigmoid_product": SIGMOID_PRODUCT,
    "s_shape": S_SHAPE,
    "z_shape": Z_SHAPE,
    "pi_shape": PI_SHAPE,
    "cosine": COSINE,
    "spike": SPIKE,
    "concave": CONCAVE,
    "singleton": SINGLETON,
    "discrete": DISCRETE,
    "constant": CONSTANT,
    "linear": LINEAR,
}
"""The number by which a step knows a shape."""
FARTHEST = 1.7976931348623157e308


def rising(x, a, b):
    """From 0 at ``a`` to 1 at ``b``; 1 everywhere where ``a`` is minus infinity."""
    inside = 1.0 if a < -FARTHEST else (x - a) / (b - a)
    return 0.0 if x < a else (1.0 if x >= b else inside)


def falling(x, c, d):
    """From 1 at ``c`` to 0 at ``d``; 1 everywhere where ``d`` is infinite."""
    inside = 1.0 if d > FARTHEST else (d - x) / (d - c)
    return 0.0 if x > d else (1.0 if x <= c else inside)


def s_shape(x, start, end):
    """Two parabolas from 0 at ``start`` to 1 at ``end``."""
    t = (x - start) / (end - start)
    low = 2.0 * t * t
    high = 1.0 - 2.0 * (1.0 - t) * (1.0 - t)
    return 0.0 if x <= start else (1.0 if x >= end else (low if t <= 0.5 else high))


def sigmoid(x, inflection, slope):
    """The logistic curve."""
    return 1.0 / (1.0 + exp(-slope * (x - inflection)))


def flank(x, mean, deviation):
    """A gaussian."""
    t = (x - mean) / deviation
    return exp(-0.5 * t * t)


def membership(code, a, b, c, d, x):
    """The membership of ``x`` in a set of a shape, before its height; NaN of NaN."""
    mu = 0.0
    if code == TRIANGLE:
        mu = min(rising(x, a, b), falling(x, b, c))
    elif code == TRAPEZOID:
        mu = min(rising(x, a, b), falling(x, c, d))
    elif code == RAMP:
        mu = rising(x, a, b) if a < b else (falling(x, b, a) if b < a else 0.0)
    elif code == RECTANGLE:
        mu = 1.0 if a <= x and x <= b else 0.0
    elif code == BINARY:
        mu = 1.0 if (b > 0.0 and x >= a) or (b < 0.0 and x <= a) else 0.0
    elif code == GAUSSIAN:
        mu = flank(x, a, b)
    elif code == GAUSSIAN_PRODUCT:
        mu = (flank(x, a, b) if x < a else 1.0) * (flank(x, c, d) if x > c else 1.0)
    elif code == BELL:
        mu = 1.0 / (1.0 + abs((x - a) / b) ** (2.0 * c))
    elif code == SIGMOID:
        mu = sigmoid(x, a, b)
    elif code == SIGMOID_DIFFERENCE:
        mu = abs(sigmoid(x, a, b) - sigmoid(x, d, c))
    elif code == SIGMOID_PRODUCT:
        mu = sigmoid(x, a, b) * sigmoid(x, d, c)
    elif code == S_SHAPE:
        mu = s_shape(x, a, b)
    elif code == Z_SHAPE:
        mu = 1.0 - s_shape(x, a, b)
    elif code == PI_SHAPE:
        mu = s_shape(x, a, b) * (1.0 - s_shape(x, c, d))
    elif code == COSINE:
        mu = 0.5 * (1.0 + cos(6.283185307179586 / b * (x - a))) if abs(x - a) <= 0.5 * b else 0.0
    elif code == SPIKE:
        mu = exp(-abs(10.0 / b * (x - a)))
    elif code == CONCAVE:
        below = (b - a) / (2.0 * b - a - x)
        above = (a - b) / (a - 2.0 * b + x)
        mu = (below if x < b else 1.0) if a <= b else (above if x > b else 1.0)
    elif code == SINGLETON:
        mu = 1.0 if x == a else 0.0
    return mu if x == x else x
