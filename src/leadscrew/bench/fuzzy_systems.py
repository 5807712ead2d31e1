"""The fuzzy systems of the bench: 49 rules of the usual kind in two forms, and 540 rules with three inputs."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from leadscrew.fuzzy.build import constants, triangles
from leadscrew.fuzzy.system import And, Input, Is, Output, Rule, RuleBlock, System

LABELS = ("NB", "NM", "NS", "ZE", "PS", "PM", "PB")
END = 4.0 / 3.0
"""The output's universe ends where its outer sets do."""


def mamdani(integration: str = "exact", resolution: int = 100) -> System:
    """Error and change, minimum and maximum, centroid; consequent of rule i, j: clip(i + j - 3, 0, 6)."""
    sets = triangles(LABELS, -1.0, 1.0, shoulders=False)
    e, de = Input("e", -1.0, 1.0, sets), Input("de", -1.0, 1.0, sets)
    u = Output("u", -END, END, sets, integration=integration, resolution=resolution)
    rules = tuple(
        Rule(And(Is("e", a), Is("de", b)), (Is("u", LABELS[min(6, max(0, i + j - 3))]),))
        for (i, a), (j, b) in itertools.product(enumerate(LABELS), enumerate(LABELS))
    )
    return System("mamdani49", (e, de), (u,), (RuleBlock(rules),))


def sugeno() -> System:
    """The same rules with the product, and the mean of constants."""
    made = mamdani()
    values = dict(zip(LABELS, np.linspace(-1.0, 1.0, 7).tolist(), strict=True))
    u = Output("u", -1.0, 1.0, constants(values), aggregation=None, defuzzifier="weighted_average")
    block = replace(made.blocks[0], conjunction="algebraic_product", implication=None)
    return System("sugeno49", made.inputs, (u,), (block,))


def large(integration: str = "midpoint") -> System:
    """A full rule base of 9 x 10 x 6 = 540 rules, minimum and maximum, centroid."""
    counts, name = (9, 10, 6), "abc"
    inputs = tuple(
        Input(x, -1.0, 1.0, triangles([f"{x}{k}" for k in range(n)], -1.0, 1.0))
        for x, n in zip(name, counts, strict=True)
    )
    u = Output("u", -1.25, 1.25, triangles([f"u{k}" for k in range(9)], -1.0, 1.0, shoulders=False))
    rules = tuple(
        Rule(
            And(And(Is("a", f"a{i}"), Is("b", f"b{j}")), Is("c", f"c{k}")),
            (Is("u", f"u{round((i + j + k) * 8 / 22)}"),),
        )
        for i, j, k in itertools.product(*map(range, counts))
    )
    return System("full540", inputs, (replace(u, integration=integration),), (RuleBlock(rules),))
