"""Rules and sets of a fuzzy system with its numbers of now: of fuzzy sliding mode, or of a system's own file."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from leadscrew.fuzzy.engine import Engine
from leadscrew.fuzzy.explanation import explain
from leadscrew.fuzzy.shapes import STRAIGHT, membership_function, prepared
from leadscrew.fuzzy.system import INTEGRAL, Term, Variable
from leadscrew.fuzzy.tables import tuned_terms
from leadscrew.fuzzy.views import Acting, Quantity, rules_view, sets_view

SAMPLES = 41
"""Points of a set without straight sides."""


class Set(NamedTuple):
    """A set as it is drawn, and its membership function."""

    name: str
    points: list[list[float]]
    degree: Callable[[float], float]


def drawn(term: Term, low: float, high: float) -> Set:
    """A set over a universe: its corners, or points along it where its sides are not straight."""
    mu = membership_function(term)
    if term.shape in STRAIGHT:
        a, b, c, d = prepared(term.shape, term.parameters)[:4]
        corners = [(a, 0.0), (b, term.height), (c, term.height), (d, 0.0)]
        inner = [[x, y] for x, y in corners if low < x < high]
        points = [[low, mu(low)], *inner, [high, mu(high)]]
    else:
        xs = [low + (high - low) * k / (SAMPLES - 1) for k in range(SAMPLES)]
        points = [[x, mu(x)] for x in xs]
    return Set(term.name, points, mu)


class Rules:
    """The views of one system with the numbers that it has now."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.tables: Any = None
        self.variables: list[tuple[Variable, list[Set]]]

    def prepare(self, tables: Any) -> None:
        """Takes the numbers of the parameters; the work is done where they are others than before."""
        if tables is self.tables:
            return
        self.tables = tables
        self.engine = replace(self.engine, numbers=tables)
        terms = tuned_terms(self.engine.circuit, tables)
        self.variables = [
            (v, [drawn(terms[v.name, t.name], v.low, v.high) for t in v.terms]) for v in self.engine.system.inputs
        ]

    def look(
        self, values: Sequence[float], scales: Sequence[float], units: Sequence[str], outputs: list[Any], note: str = ""
    ) -> dict[str, Any]:
        """The views at a point in the system's own units; a quantity is ``scale`` times that."""
        result = explain(self.engine, {v.name: x for (v, _), x in zip(self.variables, values, strict=True)})
        inputs = [
            self._input(*pair, float(x), scale, unit)
            for pair, x, scale, unit in zip(self.variables, values, scales, units, strict=True)
        ]
        mean = self.engine.system.outputs[0].defuzzifier not in INTEGRAL
        acting = []
        for rule in result.rules:
            share = rule.shares[0] if rule.shares else None
            part = share.part if share is not None and math.isfinite(share.part) else 0.0
            value = share.value if share is not None and mean else None
            acting.append(Acting(rule.number, rule.text, part, rule.strength, value))
        results = [(name, y, "") for name, y in result.outputs.items()]
        return {
            "rules": rules_view(inputs, [*results, *outputs], acting, result.total, note),
            "sets": sets_view(inputs),
        }

    def _input(self, variable: Variable, sets: list[Set], x: float, scale: float, unit: str) -> Quantity:
        ends = sorted((variable.low * scale, variable.high * scale))
        inside = min(max(x, variable.low), variable.high) if variable.lock_range else x
        points = [[[px * scale, py] for px, py in (s.points if scale > 0.0 else s.points[::-1])] for s in sets]
        return Quantity(
            variable.name, x * scale, unit, ends[0], ends[1], ends[0], ends[1], scale, [s.name for s in sets], points,
            [s.degree(inside) for s in sets],
        )  # fmt: skip
