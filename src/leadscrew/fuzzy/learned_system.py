"""Learned rules as a system: triangular partitions with shoulders, the product, the mean of the output's centres.

    y = sum_r w_r D_r c_r / sum_r w_r D_r,    D_r = product of the memberships of rule r

with ``c_r`` the centre of the set that the rule concludes and ``w_r = 1``, or the strength of the rule. Outside a
universe an input counts as its end. Where every cell has a rule, all weights are 1 and there are up to three inputs,
only the rules around the point are evaluated (:mod:`leadscrew.fuzzy.active`). A cell without a rule adds nothing; where
no rule fires the output is ``default``.

Which rules are data and which were filled in stands in :attr:`System.doc` by number, and in :attr:`System.notes` one by
one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from typing import Literal

from leadscrew.fuzzy.fill import Completed, complete
from leadscrew.fuzzy.learning import LearnedRules
from leadscrew.fuzzy.learning_report import runs
from leadscrew.fuzzy.rules_text import rule_text
from leadscrew.fuzzy.system import And, Antecedent, Is, Output, Rule, RuleBlock, System
from leadscrew.kernel.errors import ValueRefused

Weights = Literal["none", "strength"]
Conclude = Literal["centres", "sets"]


def to_system(
    rules: LearnedRules | Completed,
    name: str = "learned",
    *,
    units: Mapping[str, str] | None = None,
    weights: Weights = "none",
    conclude: Conclude = "centres",
    default: float = math.nan,
) -> System:
    """The system of learned rules, or of a table after completion.

    ``units``: by the name of a variable. ``weights="strength"`` weighs rules by their strength; a rule that was filled
    in then counts as little as the weakest rule from data. ``conclude="centres"`` makes the consequents constants
    (zero-order Takagi-Sugeno, every format has it); ``"sets"`` keeps them sets, put together by their peaks (height).

    Raises:
        ValueRefused: no rule at all, an unknown choice, or two sets of a variable with the same label.
    """
    for what, value, known in (
        ("weights", weights, ("none", "strength")),
        ("conclude", conclude, ("centres", "sets")),
    ):
        if value not in known:
            raise ValueRefused(f"{what} = {value!r}: allowed are {', '.join(known)}")
    table = rules if isinstance(rules, Completed) else complete(rules)
    learned = table.learned
    if not table.outputs:
        raise ValueRefused("no rule was learned: a system needs at least one")
    unit = dict(units or {})
    *ins, out = learned.names
    inputs = tuple(p.as_input(n, unit.get(n, "")) for n, p in zip(ins, learned.inputs, strict=True))
    made = tuple(_rule(table, at, weights) for at in table.outputs)
    sources = _sources(table, weights)
    return System(
        name, inputs, (_output(learned, out, unit.get(out, ""), conclude, default),),
        (RuleBlock(made, conjunction="algebraic_product", implication=None),),
        f"{len(made)} of {learned.total} rules: {sources}", _notes(table, made),
    )  # fmt: skip


def _rule(table: Completed, at: tuple[int, ...], weights: Weights) -> Rule:
    learned = table.learned
    *ins, out = learned.names
    asked: list[Antecedent] = [Is(n, label) for n, label in zip(ins, learned.labels(at), strict=True)]
    then = (Is(out, learned.output.labels[table.outputs[at]]),)
    if weights == "none":
        return Rule(reduce(And, asked), then)
    strengths = {a: cell.winner.strength for a, cell in learned.cells.items()}
    from_data = table.sources[at] == "data"
    return Rule(reduce(And, asked), then, min(1.0, strengths[at] if from_data else min(strengths.values())))


def _output(learned: LearnedRules, name: str, unit: str, conclude: Conclude, default: float) -> Output:
    made = learned.output.as_output(name, unit, default=default)
    if conclude == "centres":
        return made
    return replace(made, terms=learned.output.terms(), aggregation="maximum", defuzzifier="height")


def _sources(table: Completed, weights: Weights) -> str:
    by_source: dict[str, list[int]] = {}
    for number, at in enumerate(table.outputs, start=1):
        by_source.setdefault(table.sources[at], []).append(number)
    parts = [
        f"{runs(numbers)} {'from data (Wang and Mendel)' if source == 'data' else f'filled by {source}'}"
        for source, numbers in sorted(by_source.items(), key=lambda item: (item[0] != "data", item[0]))
    ]
    weighed = "; weights are strengths, of filled rules the least" if weights == "strength" else ""
    return "; ".join(parts) + weighed


def _notes(table: Completed, made: tuple[Rule, ...]) -> tuple[str, ...]:
    notes = []
    for number, (at, rule) in enumerate(zip(table.outputs, made, strict=True), start=1):
        text = rule_text(rule, str)
        if table.sources[at] == "data":
            cell = table.learned.cells[at]
            said = f"data, strength {cell.winner.strength:.3f}, {cell.winner.count} of {cell.count} samples"
        else:
            said = f"{table.sources[at]}, not data"
        notes.append(f"rule {number} ({text}): {said}")
    if table.missing:
        notes.append(f"{table.missing} cells have no rule")
    return tuple(notes)
