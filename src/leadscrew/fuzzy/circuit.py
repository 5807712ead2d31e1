"""A fuzzy system as a circuit: what has to be computed, each thing once, in an order in which it can be.

Propositions (``variable is hedges term``) that occur more than once are computed once, and so are the ANDs and ORs of
the same two: a full rule base over three inputs has as many propositions as it has terms, not as it has rules.
Rules and blocks that are disabled are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from leadscrew.fuzzy.shapes import STRAIGHT
from leadscrew.fuzzy.system import INTEGRAL, And, Antecedent, Input, Is, Output, Rule, RuleBlock, System, Term
from leadscrew.util.errors import ValueRefused

COMPARISONS = ("<", "<=", "==", "!=", ">=", ">")
CONSEQUENTS = ("constant", "linear")
"""Shapes that are consequents of Takagi-Sugeno rules, not sets."""


@dataclass(frozen=True)
class Prop:
    """``variable is hedges term``."""

    variable: str
    term: str
    """Empty under ``any``."""
    hedges: tuple[str, ...]


@dataclass(frozen=True)
class Node:
    """Two values under a norm; a value is a :class:`Prop` or the number of an earlier node."""

    norm: str
    conjunction: bool
    left: Prop | int
    right: Prop | int


@dataclass(frozen=True)
class Firing:
    """One enabled rule."""

    number: int
    """Its place among all rules of the system."""
    rule: Rule
    block: int
    root: Prop | int


@dataclass(frozen=True)
class Share:
    """What one rule says about one output."""

    firing: int
    """Its place among the firings."""
    term: str
    hedges: tuple[str, ...]
    implication: str | None


@dataclass(frozen=True)
class Activation:
    """How the rules of a block fire."""

    method: str
    first: int
    end: int
    count: int = 0
    threshold: float = 0.0
    comparison: str = ""


@dataclass
class Circuit:
    """The structure of a system."""

    system: System
    props: list[Prop] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)
    firings: list[Firing] = field(default_factory=list)
    activations: list[Activation] = field(default_factory=list)
    shares: dict[str, list[Share]] = field(default_factory=dict)
    """By output, in the order of the rules."""

    @staticmethod
    def proposition(there: Is) -> Prop:
        """The proposition of a rule."""
        return Prop(there.variable, "" if "any" in there.hedges else there.term, there.hedges)

    @property
    def used(self) -> list[str]:
        """The enabled inputs that an output depends on, in order."""
        asked = {p.variable for p in self.props if "any" not in p.hedges}
        linear = any(t.shape == "linear" for o in self.system.outputs for t in o.terms)
        return [v.name for v in self.system.inputs if (v.enabled and v.name in asked) or linear]

    def all_terms(self) -> Iterator[tuple[Input | Output, Term]]:
        """Every term of every variable, inputs first."""
        everything: list[Input | Output] = [*self.system.inputs, *self.system.outputs]
        for variable in everything:
            for term in variable.terms:
                yield variable, term


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueRefused(f"{where}: {text!r} is not a number") from None


def _activation(block: RuleBlock, first: int, end: int) -> Activation:
    given, name = block.activation_parameters, block.activation
    where = f"rule block {block.name}: activation {name}"
    if name == "threshold":
        if len(given) != 2 or given[0] not in COMPARISONS:
            raise ValueRefused(f"{where}: needs a comparison ({', '.join(COMPARISONS)}) and a value, not {given}")
        return Activation(name, first, end, 0, _number(given[1], where), given[0])
    if name in ("first", "last", "highest", "lowest"):
        count = int(_number(given[0], where)) if given else 1
        return Activation(name, first, end, count, _number(given[1], where) if len(given) > 1 else 0.0)
    return Activation(name, first, end)


class _Builder:
    def __init__(self, system: System) -> None:
        self.system = system
        self.outputs = {v.name: v for v in system.outputs}
        self.made = Circuit(system, shares={v.name: [] for v in system.outputs})
        self.props: dict[Prop, None] = {}
        self.nodes: dict[Node, int] = {}

    def prop(self, there: Is) -> Prop:
        if there.variable in self.outputs:
            raise ValueRefused(
                f"system {self.system.name}: a rule asks whether the output {there.variable} is {there.term}; "
                "antecedents may name inputs only"
            )
        if there.term and self.system.variable(there.variable).term(there.term).shape in CONSEQUENTS:
            raise ValueRefused(
                f"system {self.system.name}: a rule asks whether {there.variable} is {there.term}, which is no set"
            )
        made = self.made.proposition(there)
        self.props[made] = None
        return made

    def value(self, node: Antecedent, block: RuleBlock) -> Prop | int:
        if isinstance(node, Is):
            return self.prop(node)
        both = isinstance(node, And)
        norm = block.conjunction if both else block.disjunction
        if norm is None:
            what = "conjunction" if both else "disjunction"
            raise ValueRefused(f"rule block {block.name}: a rule needs a {what}, and the block has none")
        made = Node(norm, both, self.value(node.left, block), self.value(node.right, block))
        return self.nodes.setdefault(made, len(self.nodes))

    def share(self, block: RuleBlock, there: Is) -> None:
        output = self.outputs[there.variable]
        implication = block.implication
        if output.defuzzifier in INTEGRAL:
            if not math.isfinite(output.high - output.low):
                raise ValueRefused(
                    f"output {output.name}: the defuzzifier {output.defuzzifier} needs a finite universe"
                )
            if output.aggregation is None:
                raise ValueRefused(f"output {output.name}: the defuzzifier {output.defuzzifier} needs an aggregation")
            if implication is None:
                raise ValueRefused(
                    f"rule block {block.name}: the defuzzifier {output.defuzzifier} of {output.name} needs an "
                    "implication, and the block has none"
                )
            if output.term(there.term).shape in CONSEQUENTS:
                raise ValueRefused(
                    f"output {output.name}: the defuzzifier {output.defuzzifier} needs sets, and {there.term} is "
                    f"{output.term(there.term).shape}; use weighted_average"
                )
            self.exact(output, output.term(there.term).shape, implication)
        self.made.shares[output.name].append(Share(len(self.made.firings) - 1, there.term, there.hedges, implication))

    @staticmethod
    def exact(output: Output, shape: str, implication: str) -> None:
        """Refuses what has no closed form."""
        if output.integration != "exact":
            return
        where, instead = f"output {output.name}: integration exact", "use midpoint or trapezoid with a resolution"
        if output.defuzzifier != "centroid":
            raise ValueRefused(f"{where} is there for the centroid, not for {output.defuzzifier}; {instead}")
        if output.aggregation != "maximum" or implication not in ("minimum", "algebraic_product"):
            raise ValueRefused(
                f"{where} needs the aggregation maximum and the implication minimum or algebraic_product, not "
                f"{output.aggregation} and {implication}; {instead}"
            )
        if shape not in (*STRAIGHT, "discrete"):
            raise ValueRefused(f"{where} needs sets with straight sides, not a {shape}; {instead}")

    def build(self) -> Circuit:
        made, number = self.made, -1
        for at, block in enumerate(self.system.blocks):
            first = len(made.firings)
            for rule in block.rules:
                number += 1
                if not (block.enabled and rule.enabled):
                    continue
                made.firings.append(Firing(number, rule, at, self.value(rule.antecedent, block)))
                for there in rule.consequents:
                    self.share(block, there)
            if len(made.firings) > first:
                made.activations.append(_activation(block, first, len(made.firings)))
        made.props, made.nodes = list(self.props), list(self.nodes)
        return made


def circuit(system: System) -> Circuit:
    """The structure of a system.

    Raises:
        ValueRefused: something that cannot be evaluated; says what.
    """
    if not system.inputs or not system.outputs or not system.rules:
        raise ValueRefused(f"system {system.name}: it needs inputs, outputs and rules to be evaluated")
    return _Builder(system).build()
