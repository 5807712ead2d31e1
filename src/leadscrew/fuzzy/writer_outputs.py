"""Writes how the outputs of a fuzzy system are made of what its rules come to."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadscrew.escape import python_docstring
from leadscrew.fuzzy import active, exact_centroid, norms
from leadscrew.fuzzy.defuzzifiers import INTEGRALS, INVERSES
from leadscrew.fuzzy.inference import Axis, RuleBase
from leadscrew.fuzzy.system import Output
from leadscrew.fuzzy.tables import FIRST, HEIGHT, HIGH, LOW, PAD, PEAK, SECOND, is_exact, is_integral, nodes
from leadscrew.fuzzy.text import Lines, total
from leadscrew.fuzzy.writer_rules import RulesWriter
from leadscrew.kernel.errors import ValueRefused


class OutputsWriter(RulesWriter):
    """Writes the functions of the outputs."""

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
            step, given = self.use(active.bilinear), [f"RuleBase({', '.join([*given, values])})"]
        else:
            step, given = self.use(active.linear if len(axes) == 1 else active.trilinear), [*given, values]
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
