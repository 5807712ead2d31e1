"""Rules and sets of a controller that was made of a fuzzy system: fuzzy sliding mode, or a system's own file."""

from __future__ import annotations

import math
import types
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from leadscrew.fuzzy.block import Memory
from leadscrew.fuzzy.engine import Engine
from leadscrew.fuzzy.explanation import explain
from leadscrew.fuzzy.shapes import STRAIGHT, membership_function, prepared
from leadscrew.fuzzy.system import INTEGRAL, Term, Variable
from leadscrew.fuzzy.tables import tuned_terms
from leadscrew.kernel.block import Block
from leadscrew.kernel.layout import copied
from leadscrew.operate.explain.shown import Acting, Now, Quantity, rules_view, sets_view

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

    def __init__(self, made: Engine) -> None:
        self.made = made
        self.tables: Any = None
        self.variables: list[tuple[Variable, list[Set]]]

    def prepare(self, tables: Any) -> None:
        """Takes the numbers of the parameters; the work is done where they are others than before."""
        if tables is self.tables:
            return
        self.tables = tables
        self.made = replace(self.made, numbers=tables)
        terms = tuned_terms(self.made.circuit, tables)
        self.variables = [
            (v, [drawn(terms[v.name, t.name], v.low, v.high) for t in v.terms]) for v in self.made.system.inputs
        ]

    def look(
        self, values: Sequence[float], scales: Sequence[float], units: Sequence[str], outputs: list[Any], note: str = ""
    ) -> dict[str, Any]:
        """The views at a point in the system's own units; a quantity is ``scale`` times that."""
        found = explain(self.made, {v.name: x for (v, _), x in zip(self.variables, values, strict=True)})
        inputs = [
            self._input(*pair, float(x), scale, unit)
            for pair, x, scale, unit in zip(self.variables, values, scales, units, strict=True)
        ]
        mean = self.made.system.outputs[0].defuzzifier not in INTEGRAL
        acting = []
        for rule in found.rules:
            share = rule.shares[0] if rule.shares else None
            part = share.part if share is not None and math.isfinite(share.part) else 0.0
            value = share.value if share is not None and mean else None
            acting.append(Acting(rule.number, rule.text, part, rule.strength, value))
        said = [(name, y, "") for name, y in found.outputs.items()]
        return {
            "rules": rules_view(inputs, [*said, *outputs], acting, found.total, note),
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


class FromSystem:
    """The explanation of a controller made by :func:`leadscrew.fuzzy.controller` or read from a system's file.

    Its inputs are not kept in its state, so they are those of the period that comes: the step is taken once more, in
    plain Python, with what the loop would give it, and what it hands to the system is noted.
    """

    views = ("rules", "sets")

    def __init__(self, block: Block, made: Engine) -> None:
        self.block, self.rules = block, Rules(made)
        self.params: Any = None
        self.plan: Any = None
        self.handed: list[float] = []
        infer = made.infer
        many = len(made.system.inputs)

        def noted(plan: Any, *values: float) -> Any:
            self.handed = [float(x) for x in values[:many]]
            return infer(plan, *values)

        own = {**block.step.__globals__, "infer": noted}
        self.step: Any = types.FunctionType(block.step.__code__, own)

    def look(self, now: Now) -> dict[str, Any]:
        """The views ``rules`` and ``sets``, of the period that comes."""
        p = now.params
        if p is not self.params:
            self.params, self.plan = p, replace(self.block, params=p).prepare(p, now.dt)  # type: ignore[misc]
            self.rules.prepare(p.tables)
        try:
            coming = now.live.advance_preview()
        except IndexError:  # the loop is lost in the period that comes: it gives no signals
            return {}
        _, output = self.step(self.plan, copied(now.state), coming["command"], coming["feedback"], now.dt)
        ones = [1.0] * len(self.handed)
        outputs = [("output", float(output), self.block.unit)]
        return self.rules.look(self.handed, ones, [v.unit for v, _ in self.rules.variables], outputs)


def explained(block: Block, made: Engine | None) -> FromSystem | None:
    """The explanation of a controller that is a fuzzy system; None of any other."""
    return FromSystem(block, made) if made is not None and isinstance(block.state, Memory) else None
