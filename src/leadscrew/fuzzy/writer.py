"""Writes the step of a fuzzy system: plain source in the step subset, one line a rule, nothing looked up at run time.

``degrees`` gives what every output's rules come to, one number a term where rules of the same term may be put
together, else one a rule. ``NAME_value`` makes a number of an output's degrees. ``infer`` is both.
"""

from __future__ import annotations

from leadscrew.escape import python_docstring
from leadscrew.fuzzy.circuit import Share
from leadscrew.fuzzy.system import INTEGRAL, Output
from leadscrew.fuzzy.text import Lines
from leadscrew.fuzzy.writer_outputs import OutputsWriter


class Writer(OutputsWriter):
    """Writes one system."""

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
