"""Writes what the rules of a fuzzy system come to: memberships, norms, activations, one number a term or rule."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.escape import one_line
from leadscrew.fuzzy import activations, norms, shapes
from leadscrew.fuzzy.circuit import Activation, Circuit, Prop
from leadscrew.fuzzy.system import INTEGRAL, Output, System
from leadscrew.fuzzy.tables import HEIGHT, places
from leadscrew.fuzzy.text import Lines, identifiers, total

RESERVED = (
    "p",
    "np",
    "g",
    "mu",
    "r",
    "d",
    "i",
    "row",
    "c",
    "y",
    "best",
    "sound",
    "plan",
    "Plan",
    "infer",
    "degrees",
    "firing",
    "asked",
    "fires",
    "held",
    "last",
    "area",
    "moment",
    "NAN",
)


@dataclass
class Group:
    """Degrees that are one number: those of a term, or of one rule."""

    output: str
    term: str
    implication: str | None
    parts: list[str] = field(default_factory=list)


def variable_names(system: System) -> dict[str, str]:
    """What the variables of a system are called in the text."""
    return identifiers([v.name for v in (*system.inputs, *system.outputs)], RESERVED)


class RulesWriter:
    """Writes what the rules come to."""

    def __init__(
        self,
        circuit: Circuit,
        weighted: bool,
        tall: frozenset[tuple[str, str]],
        cut: frozenset[str],
        tabled: frozenset[str],
    ) -> None:
        self.circuit, self.system = circuit, circuit.system
        self.weighted, self.tall, self.cut, self.tabled = weighted, tall, cut, tabled
        self.places = places(circuit)
        names = variable_names(self.system)
        self.inputs = [names[v.name] for v in self.system.inputs]
        self.names = names
        self.space: dict[str, Any] = {"np": np, "NAN": float("nan")}
        self.groups: dict[str, list[Group]] = {}
        self.live = [o for o in self.system.outputs if o.enabled]

    # ---- helpers
    def use(self, function: Any) -> str:
        """The name of a function in the text."""
        self.space[function.__name__] = function
        return str(function.__name__)

    def term(self, variable: str, name: str, column: int) -> str:
        """A prepared number of a term."""
        return f"p.terms[{self.places[variable, name].row}, {column}]"

    def columns(self, variable: str, name: str, *wanted: int) -> str:
        """Prepared numbers of a term as arguments."""
        return ", ".join(self.term(variable, name, c) for c in wanted)

    def clipped(self, to: Lines) -> None:
        """Inputs held in their universe where they are locked to it."""
        for variable, name in zip(self.system.inputs, self.inputs, strict=True):
            if variable.lock_range:
                to.put(f"{name} = min(max({name}, {variable.low!r}), {variable.high!r})")

    # ---- memberships
    def memberships(self, to: Lines) -> dict[tuple[str, str], str]:
        """The membership of each input in each of its terms that a rule asks for."""
        found: dict[tuple[str, str], str] = {}
        wanted = {(p.variable, p.term) for p in self.circuit.props if p.term}
        for at, variable in enumerate(self.system.inputs):
            asked = [t for t in variable.terms if (variable.name, t.name) in wanted]
            if not asked or not variable.enabled:
                continue
            x = self.names[variable.name]
            to.put(f"# {one_line(variable.name)}: {one_line(', '.join(t.name for t in asked))}")
            if variable.name in self.cut:
                step, cut = self.use(shapes.side), f"p.cuts_{at}"
                sides = [
                    to.name("u", f"{step}({cut}[0, {k}], {cut}[1, {k}], {cut}[2, {k}], {x})")
                    for k in range(len(variable.terms) + 1)
                ]
                for k, t in enumerate(variable.terms):
                    if t in asked:
                        found[variable.name, t.name] = to.name("m", f"{sides[k]} - {sides[k + 1]}")
                continue
            for t in asked:
                found[variable.name, t.name] = to.name("m", self.membership(variable.name, t.name, t.shape, x))
        return found

    def membership(self, variable: str, name: str, shape: str, x: str) -> str:
        """The membership of ``x`` in a term."""
        if shape == "discrete":
            place = self.places[variable, name]
            made = f"{self.use(shapes.polyline)}(p.points, {place.first}, {place.end}, {x})"
        else:
            function = shapes.PREPARED[shape][0]
            count = function.__code__.co_argcount - 1
            made = f"{self.use(function)}({self.columns(variable, name, *range(count))}, {x})"
        return f"{self.term(variable, name, HEIGHT)} * {made}" if (variable, name) in self.tall else made

    def hedged(self, value: str, hedges: tuple[str, ...]) -> str:
        """A value under hedges, the last one first."""
        for hedge in reversed(hedges):
            value = "1.0" if hedge == "any" else f"{self.use(norms.HEDGES[hedge])}({value})"
        return value

    def concluded(self, degree: str, hedges: tuple[str, ...]) -> str:
        """The degree of a rule under the hedges of what it concludes; 0 where the rule does not fire."""
        made = self.hedged(degree, hedges)
        return f"{made} if {degree} > 0.0 else 0.0" if {"not", "any"} & set(hedges) else made

    def marked(self, output: Output) -> bool:
        """Whether a rule may fire and its share of an output be 0 all the same, which has to be told apart."""
        return output.name not in self.tabled and any(share.hedges for share in self.circuit.shares[output.name])

    # ---- rules
    def propositions(self, to: Lines) -> dict[Prop | int, str]:
        """The membership of each proposition."""
        disabled = {v.name for v in self.system.inputs if not v.enabled}
        values: dict[Prop | int, str] = {}
        sets = self.memberships(to)
        for prop in self.circuit.props:
            plain = "1.0" if not prop.term else sets.get((prop.variable, prop.term), "0.0")
            made = "0.0" if prop.variable in disabled else self.hedged(plain, prop.hedges)
            values[prop] = made if made.isidentifier() else to.name("q", made)
        return values

    def rules(self, to: Lines) -> list[str]:
        """The degree of each rule, activation applied."""
        values = self.propositions(to)
        for number, node in enumerate(self.circuit.nodes):
            a, b = values[node.left], values[node.right]
            if node.norm in ("minimum", "maximum"):
                made = f"{a} if {a} {'<' if node.conjunction else '>'} {b} else {b}"
            elif node.norm == "algebraic_product":
                made = f"{a} * {b}"
            else:
                made = f"{self.use((norms.T if node.conjunction else norms.S)[node.norm])}({a}, {b})"
            values[number] = to.name("n", made)
        found = []
        for firing in self.circuit.firings:
            root = values[firing.root]
            found.append(to.name("w", f"p.weights[{firing.number}] * {root}") if self.weighted else root)
        for activation in self.circuit.activations:
            if activation.method != "general":
                self.activated(to, activation, found)
        return found

    def activated(self, to: Lines, how: Activation, found: list[str]) -> None:
        """Puts the degrees of a block's rules through its activation."""
        size = how.end - how.first
        degrees, fired = to.name("degrees", f"np.zeros({size})"), to.name("fired", f"np.zeros({size})")
        for i in range(size):
            to.put(f"{degrees}[{i}] = {found[how.first + i]}")
        method = activations.THRESHOLDS[how.comparison] if how.comparison else activations.METHODS[how.method]
        to.put(f"{self.use(method)}({degrees}, {fired}, {how.count}, {how.threshold!r})")
        for i in range(size):
            found[how.first + i] = to.name("w", f"{fired}[{i}]")

    def grouped(self, output: Output, degrees: list[str]) -> list[Group]:
        """What an output's rules come to; in the order of the rules, or of their terms where that is the same."""
        alone = output.aggregation != "maximum" if output.defuzzifier in INTEGRAL else self.inverts(output)
        found: dict[Any, Group] = {}
        for at, share in enumerate(self.circuit.shares[output.name]):
            implication = share.implication if output.defuzzifier in INTEGRAL else None
            key = at if alone else (share.term, implication)
            group = found.setdefault(key, Group(output.name, share.term, implication))
            group.parts.append(self.concluded(degrees[share.firing], share.hedges))
        order = list(found.values())
        return order if alone else sorted(order, key=lambda g: (g.implication or "", self.row(output, g.term)))

    def inverts(self, output: Output) -> bool:
        """Whether a weighted output has terms whose value depends on the degree."""
        used = {s.term for s in self.circuit.shares[output.name]}
        plain = ("constant", "linear", "singleton")
        return output.defuzzifier != "height" and any(t.shape not in plain for t in output.terms if t.name in used)

    @staticmethod
    def row(output: Output, term: str) -> int:
        """The place of a term among an output's terms."""
        return [t.name for t in output.terms].index(term)

    def degrees(self) -> list[str]:
        """The function ``degrees``; also sets what the outputs get."""
        to = Lines()
        self.clipped(to)
        rules = self.rules(to) if any(o.name not in self.tabled for o in self.live) else []
        given = []
        for output in self.live:
            if output.name in self.tabled:
                self.groups[output.name] = []
                continue
            self.groups[output.name] = groups = self.grouped(output, rules)
            if groups:
                to.put(f"# {one_line(output.name)}")
            for group in groups:
                named = [p if p.isidentifier() else to.name("h", p) for p in group.parts]
                if output.defuzzifier in INTEGRAL:
                    given.append(to.largest(named))
                else:
                    given.append(to.name("s", total(named)) if len(named) > 1 else named[0])
            if self.marked(output):
                given.append(to.largest([rules[s.firing] for s in self.circuit.shares[output.name]]))
        made = [f"def degrees(p, {', '.join(self.inputs)}):"]
        made.append('    """What the rules come to, output by output."""')
        return [*made, *to.lines, f"    return {', '.join(given) or '0.0'}"]

    def width(self, output: Output) -> int:
        """How many degrees an output takes."""
        return len(self.groups[output.name]) + self.marked(output)
