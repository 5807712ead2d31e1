"""Small systems that several tests use."""

import itertools
from dataclasses import replace

import numpy as np

from leadscrew.fuzzy.system import And, Input, Is, Output, Rule, RuleBlock, System, Term

LABELS = ("NB", "NM", "NS", "ZE", "PS", "PM", "PB")


def triangles(labels, low, high):
    """An even partition whose outer sets reach beyond their ends."""
    c = np.linspace(low, high, len(labels))
    w = c[1] - c[0]
    return tuple(Term(n, "triangle", (float(x - w), float(x), float(x + w))) for n, x in zip(labels, c, strict=True))


def full_rules(first, second, consequent):
    """A rule for every combination of two inputs' terms."""
    pairs = itertools.product(range(len(first.terms)), range(len(second.terms)))
    return tuple(
        Rule(
            And(Is(first.name, first.terms[i].name), Is(second.name, second.terms[j].name)),
            (Is("u", consequent(i, j)),),
        )
        for i, j in pairs
    )


def mamdani(**output) -> System:
    """49 rules, minimum and maximum, centroid."""
    e, de = (Input(n, -1.0, 1.0, triangles(LABELS, -1.0, 1.0)) for n in ("e", "de"))
    u = Output("u", -4.0 / 3.0, 4.0 / 3.0, triangles(LABELS, -1.0, 1.0), **output)
    rules = full_rules(e, de, lambda i, j: LABELS[max(0, min(6, i + j - 3))])
    return System("mamdani49", (e, de), (u,), (RuleBlock(rules),))


def sugeno(**output) -> System:
    """The same rules, product and the mean of constants."""
    made = mamdani()
    constants = tuple(Term(n, "constant", (float(x),)) for n, x in zip(LABELS, np.linspace(-1, 1, 7), strict=True))
    given = {"defuzzifier": "weighted_average", "aggregation": None, **output}
    u = Output("u", -1.0, 1.0, constants, **given)
    block = replace(made.blocks[0], conjunction="algebraic_product", implication=None)
    return System("sugeno49", made.inputs, (u,), (block,))


def with_output(system: System, **changes) -> System:
    """The system with changes to all its outputs."""
    return replace(system, outputs=tuple(replace(o, **changes) for o in system.outputs))


def with_block(system: System, **changes) -> System:
    """The system with changes to all its rule blocks."""
    return replace(system, blocks=tuple(replace(b, **changes) for b in system.blocks))
