"""Numbers worked by hand, so that nothing rests on another fuzzy program alone: activations, ends of sums, overlaps."""

import numpy as np
import pytest

from leadscrew.fuzzy import Input, Is, Output, Rule, RuleBlock, System, Term, activations, compiled
from leadscrew.fuzzy.engine import engine

DEGREES = (0.2, 0.5, 0.5, 0.0, 0.9)


@pytest.mark.parametrize(
    ("method", "count", "threshold", "fired"),
    [
        ("first", 2, 0.3, (0, 0.5, 0.5, 0, 0)),
        ("first", 2, 0.5, (0, 0.5, 0.5, 0, 0)),
        ("first", 9, 0.0, DEGREES),
        ("first", 0, 0.0, (0, 0, 0, 0, 0)),
        ("last", 2, 0.3, (0, 0, 0.5, 0, 0.9)),
        ("last", 9, 0.5, (0, 0.5, 0.5, 0, 0.9)),
        ("highest", 2, 0.0, (0, 0.5, 0, 0, 0.9)),
        ("lowest", 2, 0.0, (0.2, 0.5, 0, 0, 0)),
        ("highest", 3, 0.0, (0, 0.5, 0.5, 0, 0.9)),
        ("highest", 9, 0.0, DEGREES),
        ("lowest", 9, 0.0, DEGREES),
        ("proportional", 0, 0.0, tuple(d / 2.1 for d in DEGREES)),
    ],
)
def test_activations(method, count, threshold, fired):
    out = np.zeros(5)
    activations.METHODS[method](np.array(DEGREES), out, count, threshold)
    assert out == pytest.approx(fired, abs=1e-15)


@pytest.mark.parametrize(
    ("comparison", "fired"),
    [
        ("<", (0.2, 0, 0, 0, 0)),
        ("<=", (0.2, 0.5, 0.5, 0, 0)),
        ("==", (0, 0.5, 0.5, 0, 0)),
        ("!=", (0.2, 0, 0, 0, 0.9)),
        (">=", (0, 0.5, 0.5, 0, 0.9)),
        (">", (0, 0, 0, 0, 0.9)),
    ],
)
def test_thresholds(comparison, fired):
    out = np.zeros(5)
    activations.THRESHOLDS[comparison](np.array(DEGREES), out, 0, 0.5)
    assert tuple(out) == fired


def with_degrees(output: Output, implication: str, *degrees: float) -> System:
    """A system whose n-th output set has the n-th degree, whatever the input."""
    level = tuple(Term(f"d{i}", "discrete", (0.0, d, 1.0, d)) for i, d in enumerate(degrees))
    rules = tuple(
        Rule(Is("x", a.name), (Is("u", b.name),)) for a, b in zip(level, output.terms[: len(level)], strict=True)
    )
    return System("levels", (Input("x", 0.0, 1.0, level),), (output,), (RuleBlock(rules, implication=implication),))


RISING = (Term("up", "ramp", (0.0, 2.0)),)


@pytest.mark.parametrize(("integration", "expected"), [("trapezoid", 1.5), ("midpoint", 1.25), ("exact", 4.0 / 3.0)])
def test_the_ends_of_a_sum(integration, expected):
    # nodes 0, 1, 2 with weights 1/2, 1, 1/2; cells with the middles 0.5 and 1.5; the centre of a triangle
    output = Output("u", 0.0, 2.0, RISING, integration=integration, resolution=2)
    assert compiled(with_degrees(output, "minimum", 1.0)).scalar(0.5) == pytest.approx(expected, abs=1e-14)


PEAKS = (Term("N", "triangle", (-1.0, 0.0, 1.0)), Term("P", "triangle", (0.0, 1.0, 2.0)))


@pytest.mark.slow
@pytest.mark.parametrize("implication", ["minimum", "algebraic_product"])
@pytest.mark.parametrize("degrees", [(0.8, 0.7), (1.0, 1.0), (0.9, 0.2), (0.3, 0.6), (0.5, 0.5)])
def test_two_neighbours_of_any_degrees(implication, degrees):
    system = with_degrees(Output("u", -1.0, 2.0, PEAKS, integration="exact"), implication, *degrees)
    assert "u" in engine(system).traits.cut
    x = np.linspace(-1.0, 2.0, 600_001)
    sets = [np.maximum(0.0, 1.0 - np.abs(x - peak)) for peak in (0.0, 1.0)]
    made = [np.minimum(d, mu) if implication == "minimum" else d * mu for d, mu in zip(degrees, sets, strict=True)]
    best = np.maximum(*made)
    assert compiled(system).scalar(0.5) == pytest.approx(float((x * best).sum() / best.sum()), abs=1e-9)
