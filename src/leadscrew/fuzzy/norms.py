"""T-norms, S-norms and hedges: plain steps, so they run on every engine.

T-norms (a and b): minimum; a b; max(0, a + b - 1); drastic (the smaller where the other is 1, else 0);
Einstein a b / (2 - (a + b - a b)); Hamacher a b / (a + b - a b); nilpotent (the smaller where a + b > 1, else 0).

S-norms: maximum; a + b - a b; min(1, a + b); drastic (the larger where the other is 0, else 1); Einstein
(a + b)/(1 + a b); Hamacher (a + b - 2 a b)/(1 - a b); nilpotent (the larger where a + b < 1, else 1); normalized
(a + b)/max(1, a + b); unbounded a + b.

Hedges: any 1; not 1 - x; very x^2; somewhat sqrt(x); extremely 2 x^2 up to 1/2, 1 - 2 (1 - x)^2 above; seldom
sqrt(x/2) up to 1/2, 1 - sqrt((1 - x)/2) above.
"""

from __future__ import annotations

from collections.abc import Callable

from leadscrew.kernel.portable import sqrt


def smaller(a, b):
    """The minimum."""
    return a if a < b else b


def algebraic_product(a, b):
    """The product."""
    return a * b


def bounded_difference(a, b):
    """What the sum has over one."""
    return max(0.0, a + b - 1.0)


def drastic_product(a, b):
    """The smaller where the larger is 1, else 0."""
    return min(a, b) if max(a, b) == 1.0 else 0.0


def einstein_product(a, b):
    """Einstein's product."""
    return a * b / (2.0 - (a + b - a * b))


def hamacher_product(a, b):
    """Hamacher's product; 0 where both are 0."""
    under = a + b - a * b
    return a * b / (under if under != 0.0 else 1.0)


def nilpotent_minimum(a, b):
    """The smaller where the sum is above 1, else 0."""
    return min(a, b) if a + b > 1.0 else 0.0


def larger(a, b):
    """The maximum."""
    return a if a > b else b


def algebraic_sum(a, b):
    """The probabilistic sum."""
    return a + b - a * b


def bounded_sum(a, b):
    """The sum, at most 1."""
    return min(1.0, a + b)


def drastic_sum(a, b):
    """The larger where the smaller is 0, else 1."""
    return max(a, b) if min(a, b) == 0.0 else 1.0


def einstein_sum(a, b):
    """Einstein's sum."""
    return (a + b) / (1.0 + a * b)


def hamacher_sum(a, b):
    """Hamacher's sum; 1 where both are 1. Written in what is missing to 1, so that nothing cancels there."""
    part = a * (1.0 - b)
    under = (1.0 - a) + part
    return (part + b * (1.0 - a)) / under if under != 0.0 else 1.0


def nilpotent_maximum(a, b):
    """The larger where the sum is below 1, else 1."""
    return max(a, b) if a + b < 1.0 else 1.0


def normalized_sum(a, b):
    """The sum over what it has above 1."""
    return (a + b) / max(1.0, a + b)


def unbounded_sum(a, b):
    """The sum."""
    return a + b


def any_(x):
    """Always 1."""
    return 1.0


def extremely(x):
    """Drawn apart at one half."""
    return 2.0 * x * x if x <= 0.5 else 1.0 - 2.0 * (1.0 - x) * (1.0 - x)


def not_(x):
    """The complement."""
    return 1.0 - x


def seldom(x):
    """Drawn towards one half."""
    low, high = sqrt(0.5 * x), 1.0 - sqrt(max(0.0, 0.5 * (1.0 - x)))
    return low if x <= 0.5 else high


def somewhat(x):
    """The square root."""
    return sqrt(x)


def very(x):
    """The square."""
    return x * x


T: dict[str, Callable[..., float]] = {
    "minimum": smaller,
    "algebraic_product": algebraic_product,
    "bounded_difference": bounded_difference,
    "drastic_product": drastic_product,
    "einstein_product": einstein_product,
    "hamacher_product": hamacher_product,
    "nilpotent_minimum": nilpotent_minimum,
}
S: dict[str, Callable[..., float]] = {
    "maximum": larger,
    "algebraic_sum": algebraic_sum,
    "bounded_sum": bounded_sum,
    "drastic_sum": drastic_sum,
    "einstein_sum": einstein_sum,
    "hamacher_sum": hamacher_sum,
    "nilpotent_maximum": nilpotent_maximum,
    "normalized_sum": normalized_sum,
    "unbounded_sum": unbounded_sum,
}
HEDGES: dict[str, Callable[..., float]] = {
    "any": any_,
    "extremely": extremely,
    "not": not_,
    "seldom": seldom,
    "somewhat": somewhat,
    "very": very,
}
