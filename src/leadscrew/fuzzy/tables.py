"""The numbers of a fuzzy system: as they may be tuned, and prepared for its step."""

from __future__ import annotations

import itertools
import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.fuzzy.circuit import CONSEQUENTS, Circuit
from leadscrew.fuzzy.exact_centroid import prepare_partition
from leadscrew.fuzzy.shapes import NUMBERS, PREPARED, membership, membership_function, polyline_rows, prepared
from leadscrew.fuzzy.system import INTEGRAL, Output, Term
from leadscrew.kernel.parameters import Doc
from leadscrew.util.errors import ValueRefused

HEIGHT, FIRST, SECOND, PEAK = NUMBERS, NUMBERS + 1, NUMBERS + 2, NUMBERS + 3
"""Columns of a prepared term after those of its shape: height, its first two parameters, its peak."""
LOW, HIGH = NUMBERS + 4, NUMBERS + 5
"""And its universe."""
FAR = 1.7976931348623157e308
"""The largest double, which stands for infinity among parameters, as these must be finite."""
PAD = 4
"""Nodes of integration are padded to a multiple of this."""
TIGHT = 1e-12
"""How far the feet of a partition may lie from the neighbours' peaks, as a part of the distance."""


class Tables(NamedTuple):
    """The numbers of a system that may be tuned."""

    terms: Annotated[np.ndarray, Doc("one row a term, inputs' first: its parameters (up to four) and its height")]
    points: Annotated[np.ndarray, Doc("x and y of the discrete terms, one after the other")]
    linear: Annotated[np.ndarray, Doc("coefficients of the linear terms, the constant last")]
    weights: Annotated[np.ndarray, Doc("one a rule")]


def tables(made: Circuit) -> Tables:
    """The numbers as the system has them.

    Raises:
        ValueRefused: a linear term with more coefficients than there are inputs.
    """
    system = made.system
    width = len(system.inputs) + 1
    rows: list[list[float]] = []
    points: list[float] = []
    linear: list[list[float]] = []
    for variable, term in made.all_terms():
        rows.append([*[*(term.parameters if term.shape not in ("discrete", "linear") else ()), *[0.0] * 4][:4]])
        rows[-1].append(term.height)
        if term.shape == "discrete":
            points += term.parameters
        if term.shape == "linear":
            if len(term.parameters) > width:
                raise ValueRefused(
                    f"term {term.name} of {variable.name}: {len(term.parameters)} coefficients for {width - 1} inputs "
                    "and a constant"
                )
            # fewer numbers than inputs and a constant: the inputs that are not named count nothing
            given = term.parameters
            linear.append([*given, *[0.0] * (width - len(given))])
    return Tables(
        np.clip(rows, -FAR, FAR),
        np.array(points or [0.0, 0.0]).reshape(-1, 2),
        np.array(linear or [[0.0] * width]),
        np.array([rule.weight for rule in system.rules]),
    )


class Place(NamedTuple):
    """Where the numbers of a term lie."""

    row: int
    first: int
    """First row of ``points`` or row of ``linear``."""
    end: int


def places(made: Circuit) -> dict[tuple[str, str], Place]:
    """Where the numbers of each term lie, by variable and term."""
    found = {}
    at = line = 0
    for row, (variable, term) in enumerate(made.all_terms()):
        if term.shape == "discrete":
            count = len(term.parameters) // 2
            found[variable.name, term.name] = Place(row, at, at + count)
            at += count
        elif term.shape == "linear":
            found[variable.name, term.name] = Place(row, line, line + 1)
            line += 1
        else:
            found[variable.name, term.name] = Place(row, 0, 0)
    return found


def tuned_terms(made: Circuit, numbers: Tables) -> dict[tuple[str, str], Term]:
    """The terms with the numbers of some tables."""
    found = {}
    where = places(made)
    for variable, term in made.all_terms():
        place = where[variable.name, term.name]
        row = numbers.terms[place.row]
        if term.shape == "discrete":
            parameters = numbers.points[place.first : place.end].ravel().tolist()
        elif term.shape == "linear":
            parameters = numbers.linear[place.first].tolist()
        else:
            parameters = [
                math.copysign(math.inf, v) if abs(v) == FAR else v for v in row[: len(term.parameters)].tolist()
            ]
        found[variable.name, term.name] = Term(term.name, term.shape, tuple(parameters), float(row[4]))
    return found


def nodes(output: Output) -> np.ndarray:
    """Where an output's set is looked at."""
    n, width = output.resolution, output.high - output.low
    if output.integration == "midpoint":
        return np.array([output.low + (i + 0.5) * (width / n) for i in range(n)])
    return np.array([output.low + width * (i / n) for i in range(n + 1)])


def padded(values: np.ndarray, fill: float) -> np.ndarray:
    """Values up to a multiple of :data:`PAD`."""
    more = -values.shape[-1] % PAD
    pad = [(0, 0)] * (values.ndim - 1) + [(0, more)]
    return np.pad(values, pad, constant_values=fill)


def peak(term: Term, low: float, high: float) -> float:
    """Where a set is highest inside a universe: the middle of its plateau."""
    if term.shape in ("constant", "singleton", "bell", "gaussian", "cosine", "spike"):
        return term.parameters[0]
    if term.shape == "linear":
        return math.nan
    xs = np.linspace(low, high, 2001)
    if term.shape in ("sigmoid", "sigmoid_difference", "sigmoid_product"):
        start = end = float(xs[np.argmax([membership(term, x) for x in xs])])
    else:
        start, end = _plateau(term)
    return 0.5 * (min(max(start, low), high) + min(max(end, low), high))


def _plateau(term: Term) -> tuple[float, float]:
    p, shape = term.parameters, term.shape
    if shape in ("triangle", "trapezoid", "ramp", "rectangle", "binary"):
        numbers = prepared(shape, p)
        return numbers[1], numbers[2]
    if shape == "gaussian_product":
        return min(p[0], p[2]), max(p[0], p[2])
    if shape == "s_shape":
        return p[1], math.inf
    if shape == "z_shape":
        return -math.inf, p[0]
    if shape == "pi_shape":
        return p[1], p[2]
    if shape == "concave":
        return (p[1], math.inf) if p[0] <= p[1] else (-math.inf, p[1])
    top = max(p[1::2])
    xs = [x for x, y in zip(p[::2], p[1::2], strict=True) if y == top]
    return xs[0], xs[-1]


def cuts(terms: list[Term]) -> np.ndarray | None:
    """The sides of a triangular partition of unity, if the terms are one: start, one over the width, end.

    The first and the last side are those of the outer sets towards the outside; a shoulder has one that is far away.
    """
    straight = [t for t in terms if t.shape in ("triangle", "trapezoid", "ramp") and t.height == 1.0]
    if len(straight) != len(terms) or len(terms) < 2:
        return None
    rows = [prepared(t.shape, t.parameters) for t in straight]
    starts, widths = [rows[0][0]], [rows[0][4]]
    ends = [rows[0][1]]
    for left, right in itertools.pairwise(rows):
        width = right[1] - left[2]
        if not (0.0 < width < math.inf and abs(left[3] - right[1]) <= TIGHT * width >= abs(right[0] - left[2])):
            return None
        starts.append(left[2])
        widths.append(1.0 / width)
        ends.append(right[1])
    if any(r[1] != r[2] for r in rows[1:-1]):
        return None
    if any(not r[0] <= r[1] <= r[2] <= r[3] for r in rows):
        return None
    starts.append(rows[-1][2])
    widths.append(rows[-1][5])
    ends.append(rows[-1][3])
    for i in (0, -1):
        if math.isinf(starts[i]):
            widths[i], ends[i] = 1.0, -math.inf if i == 0 else math.nan
    return np.array([starts, widths, ends]) if 0.0 not in widths else None


def prepare_terms(made: Circuit, numbers: Tables) -> np.ndarray:
    """One prepared row a term."""
    out = np.zeros((len(numbers.terms), NUMBERS + 6))
    where, terms = places(made), tuned_terms(made, numbers)
    for variable, term in made.all_terms():
        now = terms[variable.name, term.name]
        row = out[where[variable.name, term.name].row]
        if now.shape in PREPARED:
            shape = prepared(now.shape, now.parameters)
            row[: len(shape)] = shape
        row[HEIGHT] = now.height
        if now.shape not in ("discrete", "linear"):
            row[FIRST : FIRST + 2] = [*now.parameters[:2], 0.0][:2]
        row[LOW], row[HIGH] = variable.low, variable.high
        if isinstance(variable, Output) and math.isfinite(variable.high - variable.low):
            row[PEAK] = peak(now, variable.low, variable.high)
    return out


def prepare_points(made: Circuit, numbers: Tables) -> np.ndarray:
    """The points of the discrete terms with the slope that leads to each."""
    out = np.zeros((len(numbers.points), 3))
    for (variable, name), place in places(made).items():
        if made.system.variable(variable).term(name).shape == "discrete":
            out[place.first : place.end] = polyline_rows(numbers.points[place.first : place.end].ravel())
    return out


def prepare_sets(made: Circuit, numbers: Tables, output: Output) -> tuple[np.ndarray, np.ndarray]:
    """The nodes of an integral output and the memberships of its terms there."""
    x, terms, rows = nodes(output), tuned_terms(made, numbers), []
    for t in output.terms:
        mu = (lambda _: 0.0) if t.shape in CONSEQUENTS else membership_function(terms[output.name, t.name])
        rows.append([mu(v) for v in x.tolist()])
    return padded(x, float(x[-1])), padded(np.array(rows), 0.0)


def partition_of(made: Circuit, numbers: Tables, output: Output) -> tuple[np.ndarray, np.ndarray] | None:
    """The numbers of an exact output whose terms are a partition that just fills its universe."""
    terms = tuned_terms(made, numbers)
    sides = cuts([terms[output.name, t.name] for t in output.terms])
    return None if sides is None else prepare_partition(output, sides)


def is_integral(output: Output) -> bool:
    """Whether an output is defuzzified by an integral over nodes."""
    return output.defuzzifier in INTEGRAL and not is_exact(output)


def is_exact(output: Output) -> bool:
    """Whether an output is defuzzified in closed form."""
    return output.defuzzifier in INTEGRAL and output.integration == "exact"
