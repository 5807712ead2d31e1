"""The shapes of fuzzy markup language."""

from __future__ import annotations

import math

from leadscrew.fuzzy.system import Term
from leadscrew.kernel.errors import ValueRefused

SHAPES = {
    "rightlinearshape": 2,
    "leftlinearshape": 2,
    "pishape": 2,
    "triangularshape": 3,
    "gaussianshape": 2,
    "rightgaussianshape": 2,
    "leftgaussianshape": 2,
    "trapezoidshape": 4,
    "trapezoidalshape": 4,
    "singletonshape": 1,
    "rectangularshape": 2,
    "zshape": 2,
    "sshape": 2,
    "pointsetshape": 0,
    "pointsetmonotonicshape": 0,
}
"""Names of elements in small letters, and how many parameters each has."""
_SAME = {
    "triangularshape": "triangle",
    "gaussianshape": "gaussian",
    "trapezoidshape": "trapezoid",
    "trapezoidalshape": "trapezoid",
    "singletonshape": "singleton",
    "rectangularshape": "rectangle",
    "zshape": "z_shape",
    "sshape": "s_shape",
    "pointsetshape": "discrete",
    "pointsetmonotonicshape": "discrete",
}


def term_of(name: str, key: str, numbers: list[float], right_rises: bool) -> tuple[Term, str]:
    """A term, and a sentence where programs do not agree on what is meant.

    Raises:
        ValueRefused: the numbers do not fit; or it is a piShape of the older FML.
    """
    if key in _SAME:
        return Term(name, _SAME[key], tuple(numbers)), ""
    a, b = numbers
    if key == "pishape":
        if not right_rises:
            raise ValueRefused(f"term {name}: programs do not agree on what the two numbers of a piShape are")
        return (
            Term(name, "pi_shape", (a, b, b, b + abs(b - a))),
            "a piShape rises from its first number to its second and falls as it rose (as JFML does it)",
        )
    rises = key.startswith("right") == right_rises
    note = (
        "left and right: a right set is one at the right (IEEE 1855 as JFML does it)"
        if right_rises
        else "left and right name the flank: a right set falls (FML before the standard)"
    )
    if key.endswith("linearshape"):
        return Term(name, "ramp", (a, b) if rises else (b, a)), note
    ends = (a, b, math.inf, b) if rises else (-math.inf, b, a, b)
    return Term(name, "gaussian_product", ends), note
