"""A fuzzy system as numbers: the tables that the evaluating step works through.

Propositions (``variable is hedges term``) that occur more than once are computed once, and so are the ANDs and ORs of
the same two: a full rule base over three inputs has as many propositions as it has terms, not as it has rules.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np

from leadscrew.fuzzy.norms import HEDGE_CODES, S_CODES, T_CODES
from leadscrew.fuzzy.shapes import CODES
from leadscrew.fuzzy.system import (
    ACTIVATIONS,
    DEFUZZIFIERS,
    INTEGRAL,
    RULES_OF_SUM,
    And,
    Antecedent,
    Input,
    Is,
    Output,
    RuleBlock,
    System,
)
from leadscrew.kernel.errors import ValueRefused
from leadscrew.kernel.sheet import Doc

OR = 16
"""Added to the code of a node's norm where it is a disjunction."""
COMPARISONS = ("<", "<=", "==", "!=", ">=", ">")


class Tables(NamedTuple):
    """The numbers of a system that may be tuned."""

    terms: Annotated[np.ndarray, Doc("one row a term: its parameters (up to four) and its height")]
    points: Annotated[np.ndarray, Doc("x and y of the discrete terms, one after the other")]
    linear: Annotated[np.ndarray, Doc("coefficients of the linear terms, the constant last")]
    weights: Annotated[np.ndarray, Doc("one a rule")]


@dataclass
class Circuit:
    """The structure of a system: what stays when its numbers are tuned."""

    system: System
    tables: Tables
    shapes: list[int]
    term_at: dict[tuple[str, str], int]
    props: list[tuple[int, int, int]] = field(default_factory=list)
    """Input, term, hedges (a digit each, base 8, the one to apply first lowest)."""
    nodes: list[tuple[int, int, int]] = field(default_factory=list)
    """Norm, and two values: propositions first, then nodes."""
    roots: list[int] = field(default_factory=list)
    consequents: list[tuple[int, int, int, int, int]] = field(default_factory=list)
    """Output, rule, term, hedges, implication (-1: none)."""
    blocks: list[tuple[int, int, int, int, float, int]] = field(default_factory=list)
    """First rule, end, activation, number of rules, threshold, comparison."""


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueRefused(f"{where}: {text!r} is not a number") from None


def _activation(block: RuleBlock) -> tuple[int, int, float, int]:
    """Activation, number of rules, threshold, comparison."""
    code, given = ACTIVATIONS.index(block.activation), block.activation_parameters
    where = f"rule block {block.name}: activation {block.activation}"
    if block.activation == "threshold":
        if len(given) != 2 or given[0] not in COMPARISONS:
            raise ValueRefused(f"{where}: needs a comparison ({', '.join(COMPARISONS)}) and a value, not {given}")
        return code, 0, _number(given[1], where), COMPARISONS.index(given[0])
    if block.activation in ("first", "last", "highest", "lowest"):
        count = int(_number(given[0], where)) if given else 1
        threshold = _number(given[1], where) if len(given) > 1 else 0.0
        return code, count, threshold, 0
    return code, 0, 0.0, 0


class _Builder:
    def __init__(self, system: System) -> None:
        self.system = system
        self.inputs = {v.name: i for i, v in enumerate(system.inputs)}
        self.outputs = {v.name: i for i, v in enumerate(system.outputs)}
        self.known: dict[Any, int] = {}
        self.props: dict[tuple[int, int, int], int] = {}
        self.later: list[tuple[int, Any, Any]] = []

    def tables(self) -> Circuit:
        terms: list[list[float]] = []
        points: list[tuple[float, float]] = []
        linear: list[list[float]] = []
        shapes: list[int] = []
        term_at: dict[tuple[str, str], int] = {}
        width = len(self.system.inputs) + 1
        variables: list[Input | Output] = [*self.system.inputs, *self.system.outputs]
        for variable in variables:
            for term in variable.terms:
                term_at[variable.name, term.name] = len(terms)
                shapes.append(CODES[term.shape])
                row = [*term.parameters[:4], 0.0, 0.0, 0.0, 0.0][:4]
                if term.shape == "discrete":
                    row = [float(len(points)), float(len(term.parameters) // 2), 0.0, 0.0]
                    points += list(zip(term.parameters[::2], term.parameters[1::2], strict=True))
                elif term.shape == "linear":
                    if len(term.parameters) > width:
                        raise ValueRefused(
                            f"term {term.name} of {variable.name}: {len(term.parameters)} coefficients for "
                            f"{width - 1} inputs and a constant"
                        )
                    row = [float(len(linear)), 0.0, 0.0, 0.0]
                    linear.append([*term.parameters, *[0.0] * (width - len(term.parameters))])
                terms.append([*row, term.height])
        weights = [r.weight if r.enabled and b.enabled else 0.0 for b in self.system.blocks for r in b.rules]
        made = Tables(
            np.array(terms or [[0.0] * 5]),
            np.array(points or [(0.0, 0.0)]),
            np.array(linear or [[0.0] * width]),
            np.array(weights or [0.0]),
        )
        return Circuit(self.system, made, shapes, term_at)

    def prop(self, there: Is) -> int:
        if there.variable in self.outputs:
            raise ValueRefused(
                f"system {self.system.name}: a rule asks whether the output {there.variable} is {there.term}; "
                "antecedents may name inputs only"
            )
        hedges = 0
        for hedge in there.hedges:
            hedges = hedges * 8 + HEDGE_CODES[hedge] + 1
        variable = self.system.variable(there.variable)
        term = 0 if not there.term else self.circuit.term_at[variable.name, there.term]
        key = (self.inputs[there.variable], term, hedges)
        return self.props.setdefault(key, len(self.props))

    def value(self, node: Antecedent, block: RuleBlock) -> Any:
        """A key for the value of an antecedent; the same for the same thing."""
        if isinstance(node, Is):
            return ("prop", self.prop(node))
        name = block.conjunction if isinstance(node, And) else block.disjunction
        if name is None:
            what = "conjunction" if isinstance(node, And) else "disjunction"
            raise ValueRefused(f"rule block {block.name}: a rule needs a {what}, and the block has none")
        code = T_CODES[name] if isinstance(node, And) else S_CODES[name] + OR
        key = (code, self.value(node.left, block), self.value(node.right, block))
        if key not in self.known:
            self.known[key] = len(self.later)
            self.later.append(key)
        return ("node", self.known[key])

    def build(self) -> Circuit:
        self.circuit = c = self.tables()
        roots = []
        for block in self.system.blocks:
            first = len(roots)
            for rule in block.rules:
                number = len(roots)
                roots.append(self.value(rule.antecedent, block))
                for there in rule.consequents:
                    hedges = 0
                    for hedge in there.hedges:
                        hedges = hedges * 8 + HEDGE_CODES[hedge] + 1
                    implication = -1 if block.implication is None else T_CODES[block.implication]
                    term = c.term_at[there.variable, there.term]
                    c.consequents.append((self.outputs[there.variable], number, term, hedges, implication))
            c.blocks.append((first, len(roots), *_activation(block)))
        c.props = list(self.props)

        def place(key: Any) -> int:
            return int(key[1]) if key[0] == "prop" else len(c.props) + int(key[1])

        c.nodes = [(code, place(left), place(right)) for code, left, right in self.later]
        c.roots = [place(root) for root in roots]
        c.consequents.sort(key=lambda x: x[0])
        return c


def circuit(system: System) -> Circuit:
    """The tables of a system.

    Raises:
        ValueRefused: something that cannot be evaluated; says what.
    """
    if not system.inputs or not system.outputs or not system.rules:
        raise ValueRefused(f"system {system.name}: it needs inputs, outputs and rules to be evaluated")
    return _Builder(system).build()


__all__ = ["DEFUZZIFIERS", "INTEGRAL", "OR", "RULES_OF_SUM", "Circuit", "Tables", "circuit"]
