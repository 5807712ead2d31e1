"""What a format cannot express: refused where it changes outputs, noted where it does not."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NoReturn, TypeVar

from leadscrew.fuzzy.formats.place import Source
from leadscrew.fuzzy.rules_text import RESERVED
from leadscrew.fuzzy.system import INTEGRAL, And, Antecedent, Is, Or, Output, Rule, RuleBlock, System, Variable
from leadscrew.util.errors import ValueRefused

V = TypeVar("V", bound=Variable)
_COMMENT = re.compile(
    r"\s*(?:#|%|//)\s*leadscrew: integration of (.+): (exact|midpoint|trapezoid), resolution ([0-9]{1,6})\s*"
)


class Saying:
    """The writing of one file: what it refuses and what it notes."""

    def __init__(self, format: str) -> None:
        self.format = format
        self.notes: list[str] = []

    def refuse(self, what: str) -> NoReturn:
        """Raises ValueRefused: the format cannot express this."""
        raise ValueRefused(f"a .{self.format} file cannot express {what}")

    def note(self, sentence: str) -> None:
        """Keeps a sentence on what was left out or changed without an effect on outputs."""
        self.notes.append(sentence)

    def without_disabled_rules(self, system: System) -> System:
        """The system without the rules that are switched off, which no format has."""
        off = sum(not rule.enabled for rule in system.rules)
        if not off:
            return system
        self.note(f"{off} {'rule' if off == 1 else 'rules'} switched off: not written")
        blocks = tuple(replace(b, rules=tuple(r for r in b.rules if r.enabled)) for b in system.blocks)
        return replace(system, blocks=blocks)

    def units_and_docs(self, system: System, docs: bool) -> None:
        """Notes the units, and the descriptions where the format has none."""
        variables = (*system.inputs, *system.outputs)
        if with_unit := [f"{v.name} in {v.unit}" for v in variables if v.unit]:
            self.note(f"units are not written: {', '.join(with_unit)}")
        if docs and (system.doc or any(v.doc for v in variables)):
            self.note("descriptions are not written")

    def integration(self, system: System, rule: str, resolution: int | None) -> list[str]:
        """The comments that keep the rules of integration that differ from the one a reader of the format takes."""
        comments = []
        for output in system.outputs:
            same = output.integration == rule and resolution in (None, output.resolution)
            if output.defuzzifier in INTEGRAL and not same:
                comments.append(
                    f"leadscrew: integration of {output.name}: {output.integration}, resolution {output.resolution}"
                )
                self.note(
                    f"output {output.name}: its rule of integration ({output.integration}, {output.resolution}) stands "
                    "in a comment that Leadscrew reads; other programs take their own"
                )
        return comments

    def named(self, system: System, plain: str) -> System:
        """The system with names that match a pattern and are no keywords; renaming changes no output."""
        names: dict[str, str] = {}
        terms: dict[tuple[str, str], str] = {}
        for variable in (*system.inputs, *system.outputs):
            names[variable.name] = self._rename(variable.name, names.values(), plain, "variable")
            taken: list[str] = []
            for term in variable.terms:
                new = self._rename(term.name, taken, plain, f"{variable.name}, term")
                taken.append(new)
                terms[variable.name, term.name] = new
        if all(k == v for k, v in names.items()) and all(k[1] == v for k, v in terms.items()):
            return system

        def proposition(there: Is) -> Is:
            return replace(
                there, variable=names[there.variable], term=terms.get((there.variable, there.term), there.term)
            )

        def renamed(v: V) -> V:
            known = tuple(replace(t, name=terms[v.name, t.name]) for t in v.terms)
            return replace(v, name=names[v.name], terms=known)

        def rule(r: Rule) -> Rule:
            then = tuple(proposition(c) for c in r.consequents)
            return replace(r, antecedent=mapped(r.antecedent, proposition), consequents=then)

        return replace(
            system,
            inputs=tuple(renamed(v) for v in system.inputs),
            outputs=tuple(renamed(v) for v in system.outputs),
            blocks=tuple(replace(b, rules=tuple(rule(r) for r in b.rules)) for b in system.blocks),
        )

    def _rename(self, name: str, taken: Iterable[str], plain: str, what: str) -> str:
        taken = list(taken)
        new = name
        if not re.fullmatch(plain, name) or name.casefold() in RESERVED:
            new = re.sub(r"\W", "_", name, flags=re.ASCII) or "unnamed"
            new = new if re.fullmatch(plain, new) and new.casefold() not in RESERVED else f"{new}_"
            new = new if re.fullmatch(plain, new) else f"_{new}"
        while new in taken:
            new += "_"
        if new != name:
            self.note(f"{what} {name!r} is called {new} in the file")
        return new


def mapped(node: Antecedent, change: Callable[[Is], Is]) -> Antecedent:
    """An antecedent with every proposition changed."""
    if isinstance(node, Is):
        return change(node)
    left, right = mapped(node.left, change), mapped(node.right, change)
    return And(left, right) if isinstance(node, And) else Or(left, right)


def uses(block: RuleBlock, kind: type) -> bool:
    """Some rule of a block has an ``and`` (or an ``or``)."""
    todo: list[Antecedent] = [rule.antecedent for rule in block.rules]
    while todo:
        node = todo.pop()
        if isinstance(node, kind):
            return True
        if not isinstance(node, Is):
            todo += [node.left, node.right]
    return False


def integrated(source: Source, outputs: list[Output]) -> list[Output]:
    """Outputs with the rules of integration that comments of the file name.

    Raises:
        DataError: such a comment names no output.
    """
    for number, line in enumerate(source.lines, start=1):
        match = _COMMENT.fullmatch(line) if "leadscrew:" in line else None
        if match is None:
            continue
        at = next((k for k, output in enumerate(outputs) if output.name == match[1]), None)
        if at is None:
            source.fail(number, match.start(1) + 1, f"there is no output {match[1]!r}")
        with source.at(number, match.start(2) + 1):
            outputs[at] = replace(outputs[at], integration=match[2], resolution=int(match[3]))
    return outputs
