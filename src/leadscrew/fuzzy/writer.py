"""Writes the step of a fuzzy system: plain source in the step subset, one line a rule, nothing looked up at run time.

``degrees`` gives what every output's rules come to, one number a term where rules of the same term may be put
together, else one a rule. ``NAME_value`` makes a number of an output's degrees. ``infer`` is both.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadscrew.fuzzy import activations, exact_centroid, inference, norms, shapes
from leadscrew.fuzzy.circuit import Activation, Circuit, Prop, Share
from leadscrew.fuzzy.defuzzifiers import INTEGRALS, INVERSES
from leadscrew.fuzzy.inference import Axis, RuleBase
from leadscrew.fuzzy.system import INTEGRAL, Output, System
from leadscrew.fuzzy.tables import FIRST, HEIGHT, HIGH, LOW, PAD, PEAK, SECOND, is_exact, is_integral, nodes, places
from leadscrew.util.errors import ValueRefused
from leadscrew.util.escape import one_line, python_docstring


def identifiers(names: Sequence[str], taken: Iterable[str] = ()) -> dict[str, str]:
    """A Python name for each name, alike where that can be; cut to 60 characters: LLVM has a limit."""
    used, found = set(taken), {}
    for name in names:
        stem = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")[:60] or "value"
        stem = f"v_{stem}" if stem[0].isdigit() or keyword.iskeyword(stem) else stem
        made, n = stem, 1
        while made in used:
            n += 1
            made = f"{stem}_{n}"
        used.add(made)
        found[name] = made
    return found


def tree(parts: Sequence[str], join: str) -> str:
    """Parts joined two by two, so that no chain is longer than it must be; ``join`` holds ``{0}`` and ``{1}``."""
    if len(parts) == 1:
        return parts[0]
    half = len(parts) // 2
    return join.format(tree(parts[:half], join), tree(parts[half:], join))


def total(parts: Sequence[str]) -> str:
    """The sum of the parts."""
    return tree(parts, "({0} + {1})").removeprefix("(").removesuffix(")") if len(parts) > 1 else parts[0]


class Lines:
    """Statements of a function."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.count = 0

    def put(self, line: str, depth: int = 1) -> None:
        """One line."""
        self.lines.append("    " * depth + line)

    def name(self, stem: str, value: str) -> str:
        """A new local that holds a value."""
        self.count += 1
        made = f"{stem}{self.count}"
        self.put(f"{made} = {value}")
        return made

    def largest(self, parts: Sequence[str], stem: str = "most") -> str:
        """The largest of the parts, as a local."""
        if len(parts) == 1:
            return parts[0]
        half = len(parts) // 2
        a, b = self.largest(parts[:half], stem), self.largest(parts[half:], stem)
        return self.name(stem, f"{a} if {a} > {b} else {b}")


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


class Writer:
    """Writes one system: what its rules come to, then its outputs, then ``infer``."""

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

    # ---- outputs
    def arguments(self, output: Output) -> list[str]:
        """What an output's function takes."""
        given = [f"g{i}" for i in range(self.width(output))]
        return [*self.inputs, *given, *(["last"] if output.lock_previous else [])]

    def value(self, output: Output) -> list[str]:
        """The function that makes a number of an output's degrees."""
        to, groups = Lines(), self.groups[output.name]
        name = self.names[output.name]
        lines = [f"def {name}_value({', '.join(['p', *self.arguments(output)])}):"]
        lines.append(f'    """{python_docstring(output.name)}: {output.defuzzifier.replace("_", " ")}."""')
        default = repr(output.default) if output.default == output.default else "NAN"
        if output.name in self.tabled:
            y, best = self.interpolated(to, output)
        elif not groups:
            y, best = default, "0.0"
        else:
            g = [f"g{i}" for i in range(len(groups))]
            y, best = (
                self.closed_form(to, output)
                if is_exact(output)
                else self.integral(to, output)
                if is_integral(output)
                else self.weighting(to, output, g)
            )
        if self.marked(output):
            best = f"g{len(groups)}"
        if output.lock_previous:
            to.put(f"held = last if last == last else {default}")
            default = "held"
        to.put(f"y = {y} if {best} > 0.0 else {default}")
        if output.lock_range:
            to.put(f"y = min(max(y, {output.low!r}), {output.high!r})")
        used = [self.names[n] for n in self.circuit.used]
        test = " and ".join(f"{n} == {n}" for n in used)
        to.put(f"return y if {test} else NAN" if test else "return y")
        return [*lines, *to.lines]

    def interpolated(self, to: Lines, output: Output) -> tuple[str, str]:
        """The active rules of a table."""
        self.clipped(to)
        self.space |= {"Axis": Axis, "RuleBase": RuleBase}
        axes = [f"Axis(p.centres_{i}, p.over_{i})" for i in range(len(self.inputs))]
        values = f"p.table_{self.names[output.name]}"
        for i, made in enumerate(axes):
            to.put(f"axis_{i} = {made}")
        given = [f"axis_{i}" for i in range(len(axes))]
        if len(axes) == 2:
            step, given = self.use(inference.bilinear), [f"RuleBase({', '.join([*given, values])})"]
        else:
            step, given = self.use(inference.linear if len(axes) == 1 else inference.trilinear), [*given, values]
        inside = [f"not ({x} <= p.feet_{i}[0] or {x} >= p.feet_{i}[1])" for i, x in enumerate(self.inputs)]
        to.put(f"fires = 1.0 if {' and '.join(inside)} else 0.0")
        return f"{step}({', '.join([*given, *self.inputs])})", "fires"

    def integral(self, to: Lines, output: Output) -> tuple[str, str]:
        """The aggregated set at the nodes, and its number."""
        groups, name = self.groups[output.name], self.names[output.name]
        count = len(nodes(output))
        size = count + -count % PAD
        best = to.largest([f"g{i}" for i in range(len(groups))])
        rows = f"ROWS_{name}"
        self.space[rows] = np.array([self.row(output, g.term) for g in groups], dtype=np.int64)
        to.put(f"g = np.empty({len(groups)})")
        for i in range(len(groups)):
            to.put(f"g[{i}] = g{i}")
        to.put(f"mu = np.empty({size})")
        to.put(f"for i in range({size}):")
        to.put("mu[i] = 0.0", 2)
        start = 0
        while start < len(groups):
            implication = groups[start].implication
            end = next((i for i in range(start, len(groups)) if groups[i].implication != implication), len(groups))
            to.put(f"for r in range({start}, {end}):")
            to.put("d = g[r]", 2)
            to.put("if d > 0.0:", 2)
            to.put(f"row = {rows}[r]", 3)
            to.put(f"for i in range({size}):", 3)
            to.put(f"c = {self.use(norms.T[str(implication)])}(p.sets_{name}[row, i], d)", 4)
            # plus 0.0: a value that is stored where it was read becomes a masked store, which takes twice the time
            to.put(f"mu[i] = {self.use(norms.S[str(output.aggregation)])}(c, mu[i] + 0.0)", 4)
            start = end
        step = self.use(INTEGRALS[output.defuzzifier, output.integration])
        to.put(f"y = {step}(mu, p.nodes_{name}, {count}, {output.low!r}, {output.high!r})")
        return "y", best

    def closed_form(self, to: Lines, output: Output) -> tuple[str, str]:
        """The exact centroid."""
        groups, name = self.groups[output.name], self.names[output.name]
        best = to.largest([f"g{i}" for i in range(len(groups))])
        if len({g.implication for g in groups}) > 1:
            raise ValueRefused(f"output {output.name}: integration exact needs one implication for all its rules")
        cut = groups[0].implication == "minimum"
        if output.name in self.cut:
            return self.partitioned(to, output, cut), best
        rows = f"ROWS_{name}"
        self.space[rows] = np.array([self.row(output, g.term) for g in groups], dtype=np.int64)
        to.put(f"g = np.empty({len(groups)})")
        for i in range(len(groups)):
            to.put(f"g[{i}] = g{i}")
        lines = f"p.breaks_{name}, p.left_{name}, p.right_{name}"
        to.put(f"area, moment = {self.use(exact_centroid.along)}({lines}, {rows}, g, {int(cut)})")
        return "moment / area", best

    def partitioned(self, to: Lines, output: Output, cut: bool) -> str:
        """The exact centroid over a partition."""
        name = self.names[output.name]
        by_row = {self.row(output, g.term): f"g{i}" for i, g in enumerate(self.groups[output.name])}
        degree, areas, moments, shared, leaning = {}, [], [], [], []
        sets, between = f"p.sets_{name}", f"p.between_{name}"
        count = len(output.terms)
        for row, g in sorted(by_row.items()):
            degree[row] = h = to.name("h", f"{g} if {g} < 1.0 else 1.0") if cut else g
            area = to.name("area", f"{self.use(exact_centroid.cut_area)}({h})" if cut else f"0.5 * {h}")
            side = f"{self.use(exact_centroid.cut_moment)}({h})" if cut else f"{h} * 0.16666666666666666"
            areas.append(f"{sets}[{row}, 0] * {area}")
            moments += [f"{sets}[{row}, 1] * {area}", f"{sets}[{row}, 2] * {side}"]
            if row in (0, count - 1):
                areas.append(f"{sets}[{row}, 3] * {h}")
                moments.append(f"{sets}[{row}, 4] * {h}")
        for k in range(count - 1):
            if k not in degree or k + 1 not in degree:
                continue
            pair = f"{degree[k]}, {degree[k + 1]}"
            if cut:
                both = to.name("both", f"{self.use(exact_centroid.shared_cut)}({pair})")
                leaning.append(f"{between}[{k}, 1] * {both}")
            else:
                both = to.name("both", f"{self.use(exact_centroid.shared_scaled)}({pair})")
                centre = f"{self.use(exact_centroid.centre_scaled)}({pair})"
                leaning.append(f"{both} * ({between}[{k}, 0] * {between}[{k}, 2] + {between}[{k}, 3] * {centre})")
            shared.append(f"{between}[{k}, 0] * {both}")
        less = f" - ({total(shared)})" if shared else ""
        to.put(f"area = {total(areas)}{less}")
        to.put(f"moment = {total(moments)}{f' - ({total(leaning)})' if leaning else ''}")
        return "moment / area"

    def weighting(self, to: Lines, output: Output, g: list[str]) -> tuple[str, str]:
        """The weighted average or sum of what the rules conclude."""
        groups = self.groups[output.name]
        values: dict[Any, str] = {}
        parts = []
        if any(output.term(x.term).shape == "linear" for x in groups):
            self.clipped(to)
        for i, group in enumerate(groups):
            key = i if self.inverts(output) else group.term
            if key not in values:
                values[key] = to.name("z", self.conclusion(output, group.term, g[i]))
            parts.append(f"{g[i]} * {values[key]}")
        weight = to.name("weight", total(g))
        sum_ = to.name("sum", total(parts))
        if output.defuzzifier == "weighted_sum":
            return sum_, weight
        over = weight if self.marked(output) else f"({weight} if {weight} > 0.0 else 1.0)"
        return f"{sum_} / {over}", weight

    def conclusion(self, output: Output, name: str, w: str) -> str:
        """What a term stands for in a weighted average."""
        term, variable = output.term(name), output.name
        if term.shape in ("constant", "singleton"):
            return self.term(variable, name, FIRST)
        if term.shape == "linear":
            line, count = self.places[variable, name].first, len(self.inputs)
            parts = [f"p.linear[{line}, {i}] * {x}" for i, x in enumerate(self.inputs)]
            return total([*parts, f"p.linear[{line}, {count}]"])
        if output.defuzzifier == "height":
            return self.term(variable, name, PEAK)
        if term.shape in INVERSES:
            of = f"{w} / {self.term(variable, name, HEIGHT)}" if (variable, name) in self.tall else w
            return f"{self.use(INVERSES[term.shape])}({self.columns(variable, name, FIRST, SECOND, LOW, HIGH)}, {of})"
        return self.membership(variable, name, term.shape, w)

    # ---- all of it
    def infer(self) -> list[str]:
        """The step."""
        last = [self.last(o) for o in self.live if o.lock_previous]
        lines = [f"def infer({', '.join(['p', *self.inputs, *last])}):"]
        about = f"The outputs {', '.join(o.name for o in self.system.outputs)} of {self.system.name}."
        lines.append(f'    """{python_docstring(about)}"""')
        groups = [f"{self.names[o.name]}_g{i}" for o in self.live for i in range(self.width(o))]
        if groups:
            lines.append(f"    {', '.join(groups)} = degrees({', '.join(['p', *self.inputs])})")
        given = []
        for output in self.system.outputs:
            name = self.names[output.name]
            if not output.enabled:
                given.append("NAN")
                continue
            mine = [f"{name}_g{i}" for i in range(self.width(output))]
            more = [self.last(output)] if output.lock_previous else []
            lines.append(f"    {name} = {name}_value({', '.join(['p', *self.inputs, *mine, *more])})")
            given.append(name)
        return [*lines, f"    return {', '.join(given)}"]

    def last(self, output: Output) -> str:
        """The name of an output's last value."""
        return f"last_{self.names[output.name]}"

    def firing(self) -> list[str]:
        """A function for plain Python that gives the degrees of all rules and what each says about each output."""
        to = Lines()
        self.clipped(to)
        rules = self.rules(to)
        shares: list[str] = []
        for output in self.live:
            for share in self.circuit.shares[output.name]:
                shares.append(self.spoken(to, output, share, rules[share.firing]))
        head = [f"def firing({', '.join(['p', *self.inputs])}):"]
        head.append('    """Degrees of the rules; degree and conclusion of their shares."""')
        return [*head, *to.lines, f"    return [{', '.join(rules)}], [{', '.join(shares)}]"]

    def asked(self) -> list[str]:
        """A function for plain Python that gives the membership of every proposition."""
        to = Lines()
        self.clipped(to)
        values = self.propositions(to)
        head = [f"def asked({', '.join(['p', *self.inputs])}):", '    """Memberships of the propositions."""']
        return [*head, *to.lines, f"    return [{', '.join(values[p] for p in self.circuit.props)}]"]

    def spoken(self, to: Lines, output: Output, share: Share, degree: str) -> str:
        """Degree and value of one share."""
        w = to.name("h", self.concluded(degree, share.hedges))
        if output.defuzzifier in INTEGRAL:
            return f"({w}, NAN)"
        return f"({w}, {to.name('z', self.conclusion(output, share.term, w))})"
